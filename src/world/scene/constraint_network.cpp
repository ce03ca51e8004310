#include "turgor/world/constraint_network.hpp"

#include <algorithm>

namespace turgor {

std::size_t ConstraintNetwork::index_of(int number) const {
  const auto found = std::lower_bound(numbers_.begin(), numbers_.end(), number);
  const auto end = found == numbers_.end() || *found != number ? numbers_.end() : found;
  return static_cast<std::size_t>(end - numbers_.begin());
}

std::string ConstraintNetwork::add(Constraint constraint) {
  const auto taken = [this](const std::string& name) {
    return std::any_of(constraints_.begin(), constraints_.end(),
                       [&](const Constraint& other) { return other.name == name; });
  };
  if (constraint.name.empty() || taken(constraint.name)) {
    const std::string stem = constraint.name.empty() ? constraint.kind : constraint.name;
    int& suffix = last_suffix_[stem];
    do {
      constraint.name = stem + "." + std::to_string(++suffix);
    } while (taken(constraint.name));
  }
  const int number = next_number_++;
  for (const Node& trigger : constraint.triggers) {
    std::vector<int>& list = who_cares_[trigger];
    if (list.empty() || list.back() != number) list.push_back(number);
  }
  // Else constraints that add constraints could keep a frame from ending.
  if (serving_ >= 0) turn_of_[number] = -1;
  numbers_.push_back(number);
  constraints_.push_back(std::move(constraint));
  return constraints_.back().name;
}

bool ConstraintNetwork::remove(const std::string& name) {
  const auto found = std::find_if(constraints_.begin(), constraints_.end(),
                                  [&](const Constraint& c) { return c.name == name; });
  if (found == constraints_.end()) return false;
  const auto number = numbers_.begin() + (found - constraints_.begin());
  for (const Node& trigger : found->triggers) {
    const auto list = who_cares_.find(trigger);
    if (list == who_cares_.end()) continue;
    std::erase(list->second, *number);
    if (list->second.empty()) who_cares_.erase(list);
  }
  turn_of_.erase(*number);
  numbers_.erase(number);
  constraints_.erase(found);
  return true;
}

int ConstraintNetwork::remove_dependents(Node node) {
  const auto names = [node](const std::vector<Node>& nodes) {
    return std::find(nodes.begin(), nodes.end(), node) != nodes.end();
  };
  std::vector<std::string> gone;
  for (const Constraint& c : constraints_) {
    if (names(c.triggers) || names(c.changes)) gone.push_back(c.name);
  }
  for (const std::string& name : gone) remove(name);
  return static_cast<int>(gone.size());
}

void ConstraintNetwork::begin_frame() {
  // A constraint that begins frames would serve itself for ever.
  if (serving_ >= 0) return;
  turn_of_.clear();
  turns_.erase(turns_.begin(), turns_.begin() + static_cast<std::ptrdiff_t>(served_));
  for (std::size_t i = 0; i < turns_.size(); ++i) {
    turns_[i].cause = -1;
    turn_of_[turns_[i].constraint] = static_cast<int>(i);
  }
  served_ = 0;
  report_ = {};
}

void ConstraintNetwork::notify(Node node) {
  const auto list = who_cares_.find(node);
  if (list == who_cares_.end()) return;
  for (const int number : list->second) {
    const auto [entry, fresh] = turn_of_.try_emplace(number, static_cast<int>(turns_.size()));
    if (fresh) {
      turns_.push_back({number, constraints_[index_of(number)].name, serving_});
    } else {
      close_loop(entry->second);
    }
  }
}

void ConstraintNetwork::close_loop(int turn) {
  // Back along the causes of the change; where they do not lead to `turn`, it was merely served already.
  std::vector<int> chain;
  for (int at = serving_; at >= 0; at = turns_[static_cast<std::size_t>(at)].cause) {
    chain.push_back(at);
    if (at == turn) break;
  }
  if (chain.empty() || chain.back() != turn) return;
  std::string loop;
  for (auto at = chain.rbegin(); at != chain.rend(); ++at) {
    loop += turns_[static_cast<std::size_t>(*at)].name + " → ";
  }
  loop += turns_[static_cast<std::size_t>(turn)].name;
  if (std::find(report_.loops.begin(), report_.loops.end(), loop) == report_.loops.end()) {
    report_.loops.push_back(std::move(loop));
  }
}

void ConstraintNetwork::serve(const Turn& turn, Scene& scene) {
  const std::size_t index = index_of(turn.constraint);
  if (index == constraints_.size() || !constraints_[index].satisfy) return;
  ++report_.served;
  // Out of the list while it works, which it may change.
  auto satisfy = std::move(constraints_[index].satisfy);
  if (const auto done = satisfy(scene); !done) {
    Error error = done.error();
    error.where = error.where.empty() ? turn.name : turn.name + ": " + error.where;
    report_.failures.push_back(std::move(error));
  }
  const std::size_t now = index_of(turn.constraint);
  if (now < constraints_.size()) constraints_[now].satisfy = std::move(satisfy);
}

void ConstraintNetwork::renormalise(Scene& scene) {
  if (serving_ >= 0) return;
  while (served_ < turns_.size()) {
    serving_ = static_cast<int>(served_++);
    const Turn turn = turns_[static_cast<std::size_t>(serving_)];
    serve(turn, scene);
  }
  serving_ = -1;
}

}  // namespace turgor
