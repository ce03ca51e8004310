// What a session holds, and the tables of what its commands do.
#pragma once

#include <deque>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "turgor/commands/session.hpp"
#include "turgor/world/object_file.hpp"
#include "turgor/world/solid_objects.hpp"

namespace turgor {

/// A `simulate` that is under way.
struct Simulation {
  SimulationOptions options;
  std::int64_t left = -1;  ///< steps; -1: no limit
  std::optional<double> until;
  std::int64_t skip = 1;
  bool resumes = false;    ///< steps in the frame in which it begins
  std::int64_t taken = 0;  ///< since the last line of the recording
  double began = 0;
  SimulationReport report;
  SourcePlace place;

  [[nodiscard]] bool is_over(double time) const {
    return left == 0 || (until && time > *until - 0.5 * options.dt);
  }
};

struct DeviceReading {
  double time = 0;
  Vec3 value;
};
struct Device {
  Vec3 value;
  std::vector<DeviceReading> readings;  ///< to be played, times rising
  std::size_t next = 0;
};

struct SessionState {
  SessionState(SessionOptions given, Context& whole) : options(std::move(given)), context(whole) {}

  SessionOptions options;
  Context& context;
  Scene scene;
  std::deque<ScriptLine> waiting;    ///< of scripts and the console
  std::deque<ScriptLine> at_once;    ///< of devices, and of the console while a simulation runs
  std::optional<ScriptLine> asking;  ///< a command without all of its arguments
  const Parameter* asked = nullptr;
  std::optional<Simulation> simulation;
  std::map<std::string, Device> devices;
  std::map<std::string, int> device_nodes;
  std::vector<std::string> recording;
  std::int64_t frames_since = 0;  ///< frames without steps that ended since the last line of the recording
  std::vector<RemeshTask> remeshing;
  bool stepped = false;        ///< in this frame
  std::int64_t pause = 0;      ///< frames that lines of scripts wait for
  bool finished = false;       ///< `quit`
  std::set<std::string> told;  ///< notices that are said once

  void say(const std::string& text) const {
    if (options.say) options.say(text);
  }
  void tell_once(const std::string& text) {
    if (told.insert(text).second) context.notice(text);
  }
};

namespace commands {

using SceneHandler = Result<void> (*)(SessionState&, const Invocation&);
struct NamedHandler {
  std::string_view name;
  SceneHandler handler;
};
std::span<const NamedHandler> object_handlers();
std::span<const NamedHandler> view_handlers();
std::span<const NamedHandler> constraint_handlers();
std::span<const NamedHandler> tissue_handlers();
std::span<const NamedHandler> edit_handlers();
std::span<const NamedHandler> solid_handlers();
std::span<const NamedHandler> talk_handlers();
std::string recording_of(const SessionState& s);
/// Not those that only talk, and not `simulate`, which is recorded by the steps it took.
bool is_recorded(std::string_view command);

/// All numbers of a text file, parted by blanks, commas or lines.
Result<std::vector<double>> read_numbers(const std::string& file);
/// What a device reads now.
void read_device(SessionState& s, const std::string& device, const Vec3& value);
/// A sample by its name, or as FLESH:LAYER:NUMBER.
Result<SampleRef> find_sample(const Scene& scene, const std::string& text);
Result<Region> region_of(const Scene& scene, const Invocation& c);
inline Vec3 triple(const Invocation& c, std::string_view parameter) {
  const auto n = c.numbers(parameter);
  return {n.at(0), n.at(1), n.at(2)};
}
inline Vec3f colour_triple(const Invocation& c, std::string_view parameter) {
  return to_float(triple(c, parameter));
}

}  // namespace commands
}  // namespace turgor
