// Bytes choose commands of a scene, their flags and numbers: mostly names that exist and values in range,
// often wild ones. No crash, no hang, every error whole, all samples at finite places after every frame, and
// a recording that parses and leads to the same bits.
#include <unistd.h>

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <map>
#include <span>
#include <string>
#include <vector>

#include "turgor/commands/session.hpp"
#include "turgor/core/parallel.hpp"

namespace {
using namespace turgor;

void demand(bool holds, const char* what, const std::string& shown) {
  if (holds) return;
  std::fprintf(stderr, "violated: %s\n%s\n", what, shown.c_str());
  std::abort();
}

std::string folder() {
  static const std::string made = [] {
    const auto path = std::filesystem::temp_directory_path() / ("fuzz_scene_" + std::to_string(::getpid()));
    std::filesystem::create_directories(path);
    return path.string();
  }();
  return made;
}

// ---- from bytes to scripts ----

class Bytes {
 public:
  Bytes(const std::uint8_t* data, std::size_t size) : left_(data, size) {}
  [[nodiscard]] bool empty() const { return left_.empty(); }
  std::size_t below(std::size_t count) {
    if (left_.empty()) return 0;
    const std::size_t value = left_.front();
    left_ = left_.subspan(1);
    return value % count;
  }
  template <class Items>
  std::string one_of(const Items& items) {
    return std::string(items[below(std::size(items))]);
  }

 private:
  std::span<const std::uint8_t> left_;
};

using Names = std::vector<std::string_view>;
const Names kObjects{"a",   "ball",  "floor",           "b",      "camera", "skin.face.a", "muscles.m",
                     "sun", "track", "skin.solid.ball", "nothing"};
const Names kSamples{"s", "t", "ball:3", "a:2:5", "a:0:0", "a:1:15", "b:1:1", "a:9:9", "::"};
const std::map<std::string_view, Names> kNames{
    {"flesh", {"a", "b", "nothing"}},
    {"tissue", {"a", "ball", "b", "nothing"}},
    {"solid", {"ball", "b", "a", "nothing"}},
    {"grab", {"g", "h"}},
    {"muscle", {"m", "n", "m;n"}},
    {"sample", kSamples},
    {"device", {"d", "e"}},
    {"world", {"main", "other"}},
    {"viewport", {"main", "side"}},
    {"camera", {"camera", "eye", "a"}},
    {"light", {"sun", "a"}},
    {"name", {"a", "b", "ball", "floor", "track", "x", "../x"}},
    {"constraint", {"link", "bobblot", "blotbob", "parent", "mv_obj_path", "vp_track_obj", "follow_device"}}};
const Names kFiles{"grid.4.4",       "grid.3.5",
                   "grid.2.2",       "sphere",
                   "cube",           "line",
                   "fusiform",       "wiregrid.3.3",
                   "grid.1.1",       "grid.0.5",
                   "grid.4000000.1", "grid.2.200000",
                   "grid.3000.3000", "grid.99999999999.2",
                   "sphere.obj",     "/u/pieper/data/fusiform",
                   "lookat_wound",   "/dev/null"};
const Names kNumbers{"0",    "1",      "0.1",   "-1",   "0.5",    "2",     "10",  "0.01", "0.3",     "100",
                     "-0.0", "1e-300", "1e300", "1e9",  "-1e9",   "1e-9",  "1e6", "1e12", "-0.2",    "1000",
                     "-1e6", "3",      "4.5",   "0.05", "5e-324", "-1e12", "160", "1e5",  "1.7e308", "1e-12"};
// A hundred cubes along an axis take longer than a script may.
const Names kCubes{"1", "2", "3", "5", "9", "0", "-1"};
const Names kWhole{"0", "1", "2", "3", "-1", "5", "10", "15", "100", "1000000", "2147483647", "1000000000000",
                   "40"};

double as_number(std::string_view text) {
  return std::strtod(std::string(text).c_str(), nullptr);
}

// In range three times of four.
std::string number(Bytes& bytes, const Names& all, const Range& range) {
  if (bytes.below(4) == 0) return bytes.one_of(all);
  Names allowed;
  for (const std::string_view n : all) {
    if (range.contains(as_number(n))) allowed.push_back(n);
  }
  return allowed.empty() ? "1" : bytes.one_of(allowed);
}

std::string name(Bytes& bytes, const CommandDeclaration& command, const Parameter& parameter) {
  if (command.name == "shock") return bytes.one_of(kSamples);
  const bool declares = parameter.positional || parameter.name == "flesh" || parameter.name == "world";
  const auto known = declares || command.name == "viewport" ? kNames.find(parameter.name) : kNames.end();
  return bytes.one_of(known == kNames.end() ? kObjects : known->second);
}

std::string path(Bytes& bytes, const CommandDeclaration& command) {
  if (command.name == "instance_object") return bytes.one_of(kFiles);
  return bytes.one_of(Names{"/dev/null", "nowhere"});
}

std::string value(Bytes& bytes, const CommandDeclaration& command, const Parameter& parameter) {
  switch (parameter.type) {
    case ValueType::flag:
      return "";
    case ValueType::path:
    case ValueType::folder:
      return ' ' + path(bytes, command);
    case ValueType::choice:
      return ' ' + bytes.one_of(parameter.choices);
    case ValueType::integer:
      return ' ' + number(bytes, parameter.name == "resolution" ? kCubes : kWhole, parameter.range);
    case ValueType::number:
      return ' ' + number(bytes, kNumbers, parameter.range);
    case ValueType::box:
      return bytes.below(2) == 0 ? " -1 -1 -1 1 1 1" : " 0 0 0.1 1e9 1 1";
    case ValueType::sphere:
      return bytes.below(2) == 0 ? " 0.16 0.16 0.2 0.2" : " 0 0 0 1e9";
    default:
      return ' ' + name(bytes, command, parameter);
  }
}

std::string argument(Bytes& bytes, const CommandDeclaration& command, const Parameter& parameter) {
  std::string text = parameter.positional ? "" : " -" + std::string(parameter.name);
  std::size_t count = static_cast<std::size_t>(parameter.count.low);
  if (parameter.count.high != parameter.count.low) count += bytes.below(6);
  if (parameter.type == ValueType::box || parameter.type == ValueType::sphere) count = 1;
  for (std::size_t i = 0; i < std::max<std::size_t>(count, 1); ++i) text += value(bytes, command, parameter);
  return text;
}

std::string line(Bytes& bytes) {
  const auto all = scene_commands().commands;
  const CommandDeclaration& command = all[bytes.below(all.size())];
  // Files are written by `state` alone, in a folder of this fuzzer.
  if (command.name == "save_object" || command.name == "record") return "list tissue";
  if (command.name == "state") return "state x";
  if (command.name == "restore") return "restore '" + folder() + "/x.state'";
  std::string text(command.name);
  for (const bool positional : {true, false}) {
    for (const Parameter& parameter : command.parameters) {
      if (parameter.positional != positional) continue;
      const bool wanted = parameter.required || parameter.name == "resolution" ||
                          (positional && bytes.below(8) != 0) || (!positional && bytes.below(4) == 0);
      if (wanted) text += argument(bytes, command, parameter);
    }
  }
  return text;
}

std::vector<std::string> script(Bytes& bytes) {
  std::vector<std::string> lines;
  if (bytes.below(4) != 0) {
    lines = {"instance_object grid.4.4 a",
             "instance_object sphere ball",
             "instance_object grid.2.2 floor",
             "instance_object line track",
             "flesh_out a -dfth 0.1 -sfth 0.1",
             "add_muscle m 5 10",
             "blot s 0 0 1",
             "blot t 0 0.2 1 -fixed",
             "shock s t"};
    if (bytes.below(2) == 0) lines.emplace_back("voxelize ball -resolution 4 -young 2");
  }
  while (!bytes.empty() && lines.size() < 48) {
    lines.push_back(bytes.below(4) == 0 ? "simulate 3 -dt 0.05 -runge_kutta" : line(bytes));
  }
  lines.emplace_back("simulate 2 -dt 0.02");
  return lines;
}

// ---- what must hold ----

bool is_finite(const Specimen& specimen) {
  for (const auto* field : {&specimen.state().position, &specimen.state().velocity}) {
    for (const Vec3& v : *field) {
      if (!(std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z))) return false;
    }
  }
  return true;
}

void check(const Error& error, const std::string& line) {
  const std::string shown = line + "\n" + error.message();
  demand(error.kind != ErrorKind::internal, "nothing fails within", shown);
  demand(!error.what.empty(), "errors say what is wrong", shown);
  if (error.kind == ErrorKind::cancelled) return;
  demand(!error.where.empty(), "errors say where", shown);
  demand(!error.remedy.empty(), "errors say what to do", shown);
  for (const char c : shown)
    demand(static_cast<unsigned char>(c) >= 0x20 || c == '\n', "errors are printable", shown);
}

/// A session that may look a limited number of times whether it is to stop, and then has to.
struct Run {
  explicit Run(int checks)
      : left(checks), context({}, {}, [this] { return --left < 0; }), session(options(), context) {}

  void take(const std::string& line) {
    demand(static_cast<bool>(session.enter_text(line, "script")), "a line is a line", line);
    const auto done = session.run();
    if (!done) check(done.error(), line);
    demand(session.idle(), "what fails, and what waits, is dropped", line);
  }

  int left;
  Context context;
  Session session;

 private:
  static SessionOptions options() {
    SessionOptions options;
    options.output = folder();
    options.frame = [](const Scene& scene) -> Result<void> {
      if (!is_finite(scene.specimen)) demand(false, "all samples stay at finite places", scene_json(scene));
      return {};
    };
    return options;
  }
};

void check_replay(const Run& first) {
  const std::string recording = first.session.recording();
  const auto parsed = parse_script_text(recording, "recording", scene_commands());
  demand(static_cast<bool>(parsed), "a recording parses",
         recording + (parsed ? "" : parsed.error().message()));
  // A file that `restore` names may have been written since.
  if (first.left < 0 || recording.find("restore") != std::string::npos) return;
  Run again(1'000'000);
  demand(static_cast<bool>(again.session.enter_text(recording, "recording")), "a recording is entered",
         recording);
  const auto done = again.session.run();
  demand(static_cast<bool>(done), "a recording runs", recording + (done ? "" : done.error().message()));
  for (const auto& [id, object] : first.session.scene().objects()) {
    const Object* other = again.session.scene().find(object.name);
    demand(other != nullptr && other->transform == object.transform, "a recording leads to the same places",
           recording);
  }
  demand(again.session.scene().specimen.state().position == first.session.scene().specimen.state().position,
         "a recording leads to the same bits", recording);
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  set_thread_count(1);
  Bytes bytes(data, size);
  const std::vector<std::string> lines = script(bytes);
  if (std::getenv("SHOW_SCRIPT") != nullptr) {
    for (const std::string& line : lines) std::fprintf(stderr, "%s\n", line.c_str());
  }
  Run run(200);
  for (const std::string& line : lines) {
    if (run.left >= 0) run.take(line);
  }
  check_replay(run);
  return 0;
}
