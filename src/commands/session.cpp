#include "turgor/commands/session.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "session_state.hpp"
#include "text.hpp"
#include "turgor/world/flesh_objects.hpp"
#include "turgor/world/solid_objects.hpp"
#include "values.hpp"

namespace turgor {
namespace {

const std::map<std::string_view, commands::SceneHandler>& handlers() {
  static const auto table = [] {
    std::map<std::string_view, commands::SceneHandler> all;
    for (const auto part :
         {commands::object_handlers(), commands::view_handlers(), commands::constraint_handlers(),
          commands::tissue_handlers(), commands::edit_handlers(), commands::solid_handlers(),
          commands::talk_handlers()}) {
      for (const commands::NamedHandler& h : part) all.emplace(h.name, h.handler);
    }
    return all;
  }();
  return table;
}

// ---- recording ----

// Frames that passed since the last line stand before the next one, so that a replay has every command in the
// frame in which it was.
void record(SessionState& s, std::string line) {
  if (s.frames_since > 0) s.recording.push_back(fmt::format("frame {}", s.frames_since));
  s.frames_since = 0;
  s.recording.push_back(std::move(line));
}

// `simulate` as far as it got since the last line, so that commands which came between stand between.
void record_simulation(SessionState& s) {
  if (!s.simulation || s.simulation->taken == 0) return;
  Simulation& run = *s.simulation;
  std::string line = fmt::format("simulate {} -dt {} -skip {} -resume", run.taken,
                                 commands::format_number(run.options.dt), run.skip);
  if (run.options.tolerance > 0)
    line += " -adaptive " + commands::format_number(run.options.tolerance);
  else if (run.options.implicit)
    line += " -implicit";
  else if (run.options.integrator == Integrator::heun)
    line += " -runge_kutta";
  else if (run.options.integrator == Integrator::verlet)
    line += " -verlet";
  record(s, std::move(line));
  run.taken = 0;
}

// ---- executing ----

void tell_constraints(SessionState& s) {
  const ConstraintReport& report = s.scene.constraints.report();
  for (const std::string& loop : report.loops) s.tell_once("constraints form a loop: " + loop);
  for (const Error& failure : report.failures) s.tell_once("a constraint failed: " + failure.message());
}

// The constraints take their turns after each command, so that a script does in one frame what lines at the
// console do in many.
void settle(SessionState& s) {
  s.scene.serve_constraints();
  tell_constraints(s);
  s.scene.constraints.begin_frame();
}

std::string question(const ScriptLine& line, const Parameter& parameter) {
  const std::string flag = parameter.positional ? "" : fmt::format("-{} ", parameter.name);
  return fmt::format("{}: {}{} ({})", line.words.front().text, flag, commands::value_label(parameter),
                     parameter.help);
}

void append_answer(SessionState& s, const ScriptLine& answer) {
  if (!s.asked->positional) {
    s.asking->words.push_back({fmt::format("-{}", s.asked->name), false, answer.words.front().place});
  }
  s.asking->words.insert(s.asking->words.end(), answer.words.begin(), answer.words.end());
}

Result<void> execute(SessionState& s, ScriptLine line) {
  if (s.asking) {
    append_answer(s, line);
    line = *std::move(s.asking);
    s.asking.reset();
  }
  const Parameter* missing = nullptr;
  const auto invocation = parse_line(line, scene_commands(), &missing);
  if (!invocation) {
    if (missing == nullptr || !s.options.interactive) return invocation.error();
    s.asked = missing;
    s.say(question(line, *missing));
    s.asking = std::move(line);
    return {};
  }
  const auto found = handlers().find(invocation->name());
  if (found == handlers().end()) {
    return Error{ErrorKind::internal, fmt::format("nothing carries out '{}'", invocation->name()), "",
                 "Report it"};
  }
  record_simulation(s);
  const auto done = found->second(s, *invocation);
  if (!done) return commands::told_at(invocation->place(), done.error());
  settle(s);
  if (commands::is_recorded(invocation->name())) record(s, invocation->text());
  return {};
}

Result<void> execute_all(SessionState& s) {
  while (!s.at_once.empty()) {
    ScriptLine line = std::move(s.at_once.front());
    s.at_once.pop_front();
    TURGOR_CHECK(execute(s, std::move(line)));
  }
  while (!s.waiting.empty() && !s.simulation && s.pause == 0) {
    TURGOR_CHECK(s.context.check());
    ScriptLine line = std::move(s.waiting.front());
    s.waiting.pop_front();
    TURGOR_CHECK(execute(s, std::move(line)));
  }
  return {};
}

// ---- devices ----

// Readings that are due. They are no lines of the buffer: a command that asks for arguments would take them
// for answers, and a recording plays the file again.
void sample_devices(SessionState& s) {
  for (auto& [name, device] : s.devices) {
    const std::size_t before = device.next;
    while (device.next < device.readings.size() && device.readings[device.next].time <= s.scene.time)
      ++device.next;
    if (device.next == before) continue;
    commands::read_device(s, name, device.readings[device.next - 1].value);
  }
}

// ---- simulating ----

void end_simulation(SessionState& s) {
  record_simulation(s);
  const SimulationReport& report = s.simulation->report;
  if (report.sub_steps > report.steps && s.simulation->options.tolerance <= 0) {
    s.context.notice(fmt::format(
        "{}: steps of {} were taken in parts, {:.1f} on average: {:.3g} is the longest stable one",
        s.simulation->place.text(), commands::format_number(s.simulation->options.dt),
        static_cast<double>(report.sub_steps) / static_cast<double>(report.steps), report.shortest_stable));
  }
  if (report.most_coincident > 0) {
    s.context.warning(
        fmt::format("{}: up to {} springs had both ends at one place, hence no direction and no force",
                    s.simulation->place.text(), report.most_coincident));
  }
  s.simulation.reset();
}

void show_progress(SessionState& s, const Simulation& run) {
  if (run.until && *run.until > run.began) {
    s.context.progress((s.scene.time - run.began) / (*run.until - run.began));
  } else if (run.left > 0) {
    const auto done = static_cast<double>(run.report.steps);
    s.context.progress(done / (done + static_cast<double>(run.left)));
  }
}

// What asks, waits or runs is over.
void drop(SessionState& s) {
  if (s.simulation) end_simulation(s);
  s.asking.reset();
  s.waiting.clear();
  s.at_once.clear();
  s.pause = 0;
}

// As many steps as lie between two drawings; fewer where the user stops them.
Result<void> take_steps(SessionState& s) {
  Simulation& run = *s.simulation;
  for (std::int64_t i = 0; i < run.skip && !run.is_over(s.scene.time); ++i) {
    TURGOR_CHECK(s.context.check());
    const auto done = s.scene.specimen.step(s.scene.time, run.options, run.report, s.context);
    if (!done) return commands::told_at(run.place, done.error());
    s.scene.time += run.options.dt;
    ++run.taken;
    s.stepped = true;
    if (run.left > 0) --run.left;
  }
  return {};
}

// A frame that is stopped half way is finished all the same, as a replay of its steps will do.
Result<void> simulate(SessionState& s) {
  TURGOR_CHECK(update_collisions(s.scene));
  update_holds(s.scene, static_cast<double>(s.simulation->skip) * s.simulation->options.dt);
  auto done = take_steps(s);
  TURGOR_CHECK(s.scene.specimen.adapt());
  for (int handle = 0; handle < s.scene.specimen.handle_count(); ++handle) {
    s.scene.constraints.notify({Node::Kind::sample, handle});
  }
  s.scene.constraints.notify({Node::Kind::time, 0});
  s.scene.serve_constraints();
  show_progress(s, *s.simulation);
  if (done && s.simulation->is_over(s.scene.time)) end_simulation(s);
  return done;
}

// Meshes made in the background, in the frames in which they are due.
Result<void> exchange_meshes(SessionState& s) {
  for (std::size_t i = 0; i < s.remeshing.size();) {
    if (s.remeshing[i].due > s.scene.frame) {
      ++i;
      continue;
    }
    RemeshTask task = std::move(s.remeshing[i]);
    s.remeshing.erase(s.remeshing.begin() + static_cast<std::ptrdiff_t>(i));
    TURGOR_CHECK(finish_remesh(s.scene, task));
  }
  return {};
}

Result<void> turn(SessionState& s) {
  const bool was_simulating = s.simulation.has_value();
  s.scene.begin_frame();
  if (s.pause > 0) --s.pause;
  sample_devices(s);
  auto done = s.context.check();
  if (done) done = exchange_meshes(s);
  if (done) done = execute_all(s);
  if (!done) drop(s);
  if (s.finished && s.simulation) end_simulation(s);
  s.scene.serve_constraints();
  // The frame in which a simulation begins shows what it begins with.
  s.stepped = false;
  if (s.simulation && (was_simulating || s.simulation->resumes)) {
    done = simulate(s);
    if (!done) drop(s);
  }
  TURGOR_CHECK(update_flesh_objects(s.scene));
  TURGOR_CHECK(update_solid_objects(s.scene));
  s.scene.end_frame();
  tell_constraints(s);
  if (!s.stepped) ++s.frames_since;
  if (s.options.frame) TURGOR_CHECK(s.options.frame(s.scene));
  return done;
}

// The program's own view scripts stand at the end of every search path.
ScriptOptions script_options(SessionState& s) {
  ScriptOptions options;
  options.search_paths = s.options.search_paths;
  options.library = [&s](const std::string& name) -> std::optional<std::string> {
    const std::string* text = library_script(name);
    if (text == nullptr) return std::nullopt;
    s.context.notice(fmt::format("'{}' is the program's own", name));
    return *text;
  };
  return options;
}

void enter(std::deque<ScriptLine>& queue, std::vector<ScriptLine> lines) {
  for (ScriptLine& line : lines) {
    if (!line.words.empty()) queue.push_back(std::move(line));
  }
}

}  // namespace

Session::Session(SessionOptions options, Context& context)
    : state_(std::make_unique<SessionState>(std::move(options), context)) {}
Session::Session(Session&&) noexcept = default;
Session& Session::operator=(Session&&) noexcept = default;
Session::~Session() = default;

Result<void> Session::enter_script(const std::filesystem::path& path) {
  TURGOR_TRY(auto lines, load_script(path, script_options(*state_)));
  enter(state_->waiting, std::move(lines));
  return {};
}

Result<void> Session::enter_text(std::string_view text, const std::string& name) {
  TURGOR_TRY(auto lines, load_script_text(text, name, script_options(*state_)));
  enter(state_->waiting, std::move(lines));
  return {};
}

Result<void> Session::enter_now(std::string_view line, const std::string& name) {
  TURGOR_TRY(auto lines, load_script_text(line, name, script_options(*state_)));
  enter(state_->at_once, std::move(lines));
  return {};
}

Result<void> Session::frame() {
  auto done = turn(*state_);
  if (!done) drop(*state_);
  return done;
}

Result<void> Session::run() {
  while (!idle()) {
    if (waits_for_answer()) {
      const std::string wanted = *asks();
      interrupt();
      return Error{ErrorKind::bad_command, "the input ends before " + wanted, "",
                   "Give the missing argument"};
    }
    TURGOR_CHECK(frame());
  }
  return {};
}

void Session::interrupt() {
  drop(*state_);
}

bool Session::finished() const {
  return state_->finished;
}

bool Session::idle() const {
  return state_->waiting.empty() && state_->at_once.empty() && !state_->asking && !state_->simulation &&
         state_->pause == 0;
}

std::optional<std::string> Session::asks() const {
  if (!state_->asking) return std::nullopt;
  return question(*state_->asking, *state_->asked);
}

bool Session::waits_for_answer() const {
  return state_->asking && state_->waiting.empty() && state_->at_once.empty();
}

const Scene& Session::scene() const {
  return state_->scene;
}

std::string Session::recording() const {
  record_simulation(*state_);  // as far as it got
  return commands::recording_of(*state_);
}

}  // namespace turgor
