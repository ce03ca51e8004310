#include "turgor/world/specimen.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "turgor/core/index.hpp"
#include "world/scene/bad_input.hpp"
#include "world/scene/name.hpp"

namespace turgor {
namespace {

bool at_least_zero(double x) {
  return std::isfinite(x) && x >= 0;
}

constexpr double kLatest = 1e12;  // time

Result<void> check(const SpringOptions& options) {
  if (!at_least_zero(options.stiffness) || !at_least_zero(options.viscosity) ||
      !at_least_zero(options.cutoff)) {
    return bad_input(fmt::format("a spring's constant {}, viscosity {} or cut-off {} is out of range",
                                 options.stiffness, options.viscosity, options.cutoff),
                     "All must be finite numbers of at least 0");
  }
  return {};
}

}  // namespace

double Twitch::scale_at(double time) const {
  const double t = time - start;
  const auto after = std::upper_bound(times.begin(), times.end(), t);
  if (after == times.begin()) return scales.front();
  if (after == times.end()) return scales.back();
  const auto i = static_cast<std::size_t>(after - times.begin());
  const double part = (t - times[i - 1]) / (times[i] - times[i - 1]);
  const double weight = 0.5 - 0.5 * std::cos(std::numbers::pi * part);
  return scales[i - 1] + (scales[i] - scales[i - 1]) * weight;
}

Result<void> validate(const Twitch& twitch) {
  if (twitch.times.empty() || twitch.times.size() != twitch.scales.size()) {
    return bad_input("a twitch needs pairs of time and scale", "Give them as t0 s0 t1 s1 …");
  }
  if (!(std::abs(twitch.start) <= kLatest))
    return bad_input("the start of the twitch is out of range", "Give a time");
  for (std::size_t i = 0; i < twitch.times.size(); ++i) {
    const bool ascends = i == 0 || twitch.times[i] > twitch.times[i - 1];
    if (!(std::abs(twitch.times[i]) <= kLatest) || !ascends) {
      return bad_input(
          fmt::format("time {} of the twitch, {}, does not come after the one before", i, twitch.times[i]),
          "Give times that rise");
    }
    if (!at_least_zero(twitch.scales[i])) {
      return bad_input(fmt::format("scale {} of the twitch is {}", i, twitch.scales[i]), "Give at least 0");
    }
  }
  return {};
}

Specimen::Specimen() {
  bodies_.emplace_back();  // samples made one by one
}

// ---- making ----

Result<SampleRef> Specimen::add_sample(const std::string& name, const Vec3& position, double mass,
                                       bool mobile) {
  if (std::find(names_.begin(), names_.end(), name) != names_.end()) {
    return bad_input(fmt::format("there is a point sample '{}' already", name), "Choose another name");
  }
  if (!is_within_reach(position))
    return bad_input("the place of the sample is out of range", "Give finite coordinates");
  if (!(std::isfinite(mass) && mass > 0))
    return bad_input(fmt::format("the mass is {}", mass), "Give a mass above 0");
  const auto where = static_cast<std::ptrdiff_t>(names_.size());
  state_.position.insert(state_.position.begin() + where, position);
  state_.velocity.insert(state_.velocity.begin() + where, Vec3{});
  names_.push_back(name);
  masses_.push_back(mass);
  mobile_.push_back(mobile);
  renumber();
  return SampleRef{0, static_cast<int>(where)};
}

Result<void> Specimen::add_shock(SampleRef a, SampleRef b, const SpringOptions& options) {
  TURGOR_CHECK(check(options));
  const double length = distance(position(a), position(b));
  if (a == b || !(length > 0))
    return bad_input("the two samples of a spring are one or lie at one place", "Choose two");
  shocks_.push_back({a, b, length, 1, options});
  forget_model();
  return {};
}

Result<int> Specimen::add_flesh(const std::string& name, Flesh flesh, double viscosity) {
  if (body_number(name) >= 0)
    return bad_input(fmt::format("there is a flesh '{}' already", name), "Choose another name");
  if (!at_least_zero(viscosity))
    return bad_input(fmt::format("the viscosity is {}", viscosity), "Give at least 0");
  TissueBody body;
  body.name = name;
  body.flesh = std::move(flesh);
  body.viscosity = viscosity;
  TURGOR_CHECK(rebuild(body));
  for (const FleshSample& sample : body.flesh.samples) state_.position.push_back(sample.rest);
  state_.velocity.resize(state_.position.size());
  bodies_.push_back(std::move(body));
  renumber();
  return static_cast<int>(bodies_.size()) - 1;
}

Result<void> Specimen::add_fibre(const std::string& muscle, SampleRef a, SampleRef b,
                                 const SpringOptions& options) {
  TURGOR_CHECK(check_name(muscle));  // its drawing bears it
  TURGOR_CHECK(check(options));
  const double length = distance(position(a), position(b));
  if (a == b || !(length > 0))
    return bad_input("the two ends of a fibre are one or lie at one place", "Choose two samples");
  auto found =
      std::find_if(muscles_.begin(), muscles_.end(), [&](const Muscle& m) { return m.name == muscle; });
  if (found == muscles_.end()) found = muscles_.insert(muscles_.end(), {muscle, {}, {}});
  found->fibres.push_back({a, b, length, 1, options});
  forget_model();
  return {};
}

Result<Muscle*> Specimen::require_muscle(const std::string& name) {
  const auto found =
      std::find_if(muscles_.begin(), muscles_.end(), [&](const Muscle& m) { return m.name == name; });
  if (found == muscles_.end())
    return bad_input(fmt::format("there is no muscle '{}'", name), "Make it with add_muscle first");
  return &*found;
}

Result<void> Specimen::set_twitch(const std::string& muscle, Twitch twitch) {
  TURGOR_CHECK(validate(twitch));
  TURGOR_TRY(Muscle* const found, require_muscle(muscle));
  found->twitch = std::move(twitch);
  return {};
}

Result<bool> Specimen::set_muscle(const std::string& muscle, std::optional<double> length,
                                  std::optional<double> scale) {
  for (const auto& value : {length, scale}) {
    if (value && !(std::isfinite(*value) && *value > 0))
      return bad_input(fmt::format("{} is no length or scale", *value), "Give a number above 0");
  }
  TURGOR_TRY(Muscle* const found, require_muscle(muscle));
  if (found->twitch) return false;
  for (Fibre& fibre : found->fibres) {
    if (length) fibre.scale = *length / fibre.original_length;
    if (scale) fibre.scale *= *scale;
    if (!std::isfinite(fibre.scale * fibre.original_length)) fibre.scale = 1;
  }
  return true;
}

Result<void> Specimen::add_collision(Collision collision) {
  TURGOR_CHECK(validate(collision.barrier));
  collisions_.push_back(std::move(collision));
  forget_model();
  return {};
}

Result<void> Specimen::reshape_collision(std::size_t i, const Barrier& shape, const ObjectTransform& placed) {
  Collision next = collisions_.at(i);
  next.barrier = shape;
  next.barrier.scale_mm = collisions_[i].barrier.scale_mm;
  next.barrier.stiffness_n = collisions_[i].barrier.stiffness_n;
  next.barrier.law = collisions_[i].barrier.law;
  next.barrier.clings = collisions_[i].barrier.clings;
  next.barrier.threshold_mm = collisions_[i].barrier.threshold_mm;
  next.barrier.reach_mm = collisions_[i].barrier.reach_mm;
  next.placed = placed;
  TURGOR_CHECK(validate(next.barrier));
  collisions_[i] = std::move(next);
  if (implicit_) TURGOR_CHECK(implicit_->set_barriers(barriers()));
  return stepper_ ? stepper_->set_barriers(barriers()) : Result<void>();
}

void Specimen::forget_collisions(const std::function<bool(const Collision&)>& which) {
  if (std::erase_if(collisions_, which) > 0) forget_model();
}

Result<void> Specimen::set_gravity(const Vec3& acceleration) {
  if (!is_within_reach(acceleration)) return bad_input("gravity is out of range", "Give finite numbers");
  gravity_ = acceleration;
  forget_model();
  return {};
}

Result<void> Specimen::set_damping(double damping) {
  if (!at_least_zero(damping)) return bad_input(fmt::format("the damping is {}", damping), "Give at least 0");
  damping_ = damping;
  forget_model();
  return {};
}

// ---- handles ----

int Specimen::hold(SampleRef sample) {
  const auto found = std::find(handles_.begin(), handles_.end(), std::optional(sample));
  if (found != handles_.end()) return static_cast<int>(found - handles_.begin());
  handles_.emplace_back(sample);
  return handle_count() - 1;
}

std::optional<SampleRef> Specimen::held(int handle) const {
  return handles_.at(at(handle));
}

// ---- looking ----

int Specimen::body_number(const std::string& name) const {
  for (std::size_t i = 1; i < bodies_.size(); ++i) {
    if (bodies_[i].name == name) return static_cast<int>(i);
  }
  return -1;
}

std::optional<SampleRef> Specimen::sample(const std::string& name) const {
  const auto found = std::find(names_.begin(), names_.end(), name);
  if (found == names_.end()) return std::nullopt;
  return SampleRef{0, static_cast<int>(found - names_.begin())};
}

Result<SampleRef> Specimen::nearest_sample(const Vec3& point) const {
  SampleRef best{-1, 0};
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t b = 1; b < bodies_.size(); ++b) {
    for (int i = 0; i < bodies_[b].count; ++i) {
      const SampleRef ref{static_cast<int>(b), i};
      const double away = squared_length(position(ref) - point);
      if (away < least) least = away, best = ref;
    }
  }
  if (best.body < 0) return bad_input("there is no tissue yet", "Build it with flesh_out or voxelize first");
  return best;
}

bool Specimen::exists(SampleRef sample) const {
  return sample.body >= 0 && at(sample.body) < bodies_.size() && sample.number >= 0 &&
         sample.number < bodies_[at(sample.body)].count;
}

std::vector<Vec3> Specimen::positions_of(const TissueBody& body) const {
  const auto begin = state_.position.begin() + body.offset;
  return {begin, begin + body.count};
}

int Specimen::spring_count() const {
  std::size_t springs = shocks_.size();
  for (const TissueBody& body : bodies_) {
    springs += body.parts.network.springs.size();
    if (body.solid) springs += body.solid->elements.edges.size();
  }
  for (const Muscle& muscle : muscles_) springs += muscle.fibres.size();
  return static_cast<int>(springs);
}

double Specimen::tension(const Fibre& fibre) const {
  Spring spring;
  spring.rest_length_mm = rest_length(fibre);
  spring.stiffness_n = fibre.options.stiffness;
  spring.law = fibre.options.law;
  const double now = length(fibre);
  if (fibre.options.cutoff > 0 && now > fibre.options.cutoff) return 0;
  return respond(spring, now).tension;
}

// A fibre cannot shorten to nothing: its strain measure would have no bound.
double Specimen::rest_length(const Fibre& fibre) {
  constexpr double shortest = 1e-3;
  return fibre.original_length * std::max(fibre.scale, shortest);
}

void Specimen::renumber() {
  bodies_.front().count = static_cast<int>(names_.size());
  int offset = 0;
  for (std::size_t b = 0; b < bodies_.size(); ++b) {
    if (b > 0) bodies_[b].count = static_cast<int>(bodies_[b].samples());
    bodies_[b].offset = offset;
    offset += bodies_[b].count;
  }
  forget_model();
}

Result<void> Specimen::rebuild(TissueBody& body) {
  TURGOR_CHECK(validate(body.flesh));
  TURGOR_TRY(body.parts, make_network(body.flesh));
  return {};
}

}  // namespace turgor
