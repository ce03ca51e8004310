// What the commands do that bind objects, samples, cameras and devices to each other.
#include <fmt/format.h>

#include <charconv>
#include <sstream>

#include "session_state.hpp"
#include "turgor/core/file.hpp"
#include "turgor/world/object_constraints.hpp"

namespace turgor::commands {
namespace {

using Added = Result<std::string>;

Result<void> told(const SessionState& s, const Added& added) {
  if (!added) return added.error();
  s.say(*added);
  return {};
}

Result<void> link(SessionState& s, const Invocation& c) {
  return told(s, add_link(s.scene, c.word("link"), c.word("from"), c.word("to"), c.flag("volume")));
}
Result<void> parent(SessionState& s, const Invocation& c) {
  return told(s, add_parent(s.scene, c.word("child"), c.word("parent")));
}
Result<void> stand_in(SessionState& s, const Invocation& c) {
  return told(s, add_stand_in(s.scene, c.word("object")));
}

PathOptions path_options(const Invocation& c) {
  return {static_cast<int>(c.integer("frames")), c.flag("loop")};
}
Result<void> object_path(SessionState& s, const Invocation& c) {
  return told(s, add_object_path(s.scene, c.word("object"), c.word("path"), path_options(c)));
}
Result<void> camera_path(SessionState& s, const Invocation& c) {
  return told(s, add_camera_path(s.scene, c.word("viewport"), c.word("path"), path_options(c)));
}
Result<void> track(SessionState& s, const Invocation& c) {
  const auto word = [&](const char* name) { return c.given(name) ? c.word(name) : std::string(); };
  return told(s, add_camera_tracking(s.scene, c.word("viewport"), word("eye"), word("look_at")));
}

// Moves an object so that the middle of its bounding box is at `place` (section 5.5.1).
void centre_at(Scene& scene, int id, const Vec3& place) {
  const Object* object = scene.find(id);
  if (object == nullptr) return;
  ObjectTransform next = object->transform;
  next.translation += place - world_sphere(*object).centre;
  if (is_within_reach(next.translation)) scene.set_transform(id, next);
}

std::string add(SessionState& s, Constraint constraint) {
  const std::vector<Node> triggers = constraint.triggers;
  std::string name = s.scene.constraints.add(std::move(constraint));
  for (const Node& node : triggers) s.scene.constraints.notify(node);
  return name;
}

Result<void> bobblot(SessionState& s, const Invocation& c) {
  TURGOR_TRY(const int id, s.scene.require(c.word("object")));
  TURGOR_TRY(const SampleRef sample, find_sample(s.scene, c.word("sample")));
  const int handle = s.scene.specimen.hold(sample);
  const auto follow = [id, handle](Scene& scene) -> Result<void> {
    if (const auto held = scene.specimen.held(handle)) centre_at(scene, id, scene.specimen.position(*held));
    return {};
  };
  return told(s, add(s, {"bobblot",
                         "bobblot",
                         {{Node::Kind::sample, handle}},
                         follow,
                         fmt::format("{} follows {}", c.word("object"), c.word("sample")),
                         {{Node::Kind::object, id}}}));
}

Result<void> blotbob(SessionState& s, const Invocation& c) {
  TURGOR_TRY(const SampleRef sample, find_sample(s.scene, c.word("sample")));
  TURGOR_TRY(const int id, s.scene.require(c.word("object")));
  const int handle = s.scene.specimen.hold(sample);
  const auto follow = [id, handle](Scene& scene) -> Result<void> {
    const auto held = scene.specimen.held(handle);
    const Object* object = scene.find(id);
    if (!held || object == nullptr) return {};
    const Vec3 place = world_sphere(*object).centre;
    // What the sample itself brought about is no new place.
    if (!is_within_reach(place) || distance(place, scene.specimen.position(*held)) < 1e-12) return {};
    scene.specimen.set_position(*held, place);
    scene.constraints.notify({Node::Kind::sample, handle});
    return {};
  };
  return told(s, add(s, {"blotbob",
                         "blotbob",
                         {{Node::Kind::object, id}},
                         follow,
                         fmt::format("{} follows {}", c.word("sample"), c.word("object"))}));
}

// ---- devices ----

Result<std::vector<DeviceReading>> read_readings(const std::filesystem::path& path) {
  TURGOR_TRY(const std::string text, read_text_file(path));
  TURGOR_TRY(const auto lines, lex(text, path.string()));
  std::vector<DeviceReading> readings;
  for (const ScriptLine& line : lines) {
    std::array<double, 4> n{};
    bool sound = !line.include && line.words.size() == 4;
    for (std::size_t i = 0; sound && i < 4; ++i) {
      const std::string& word = line.words[i].text;
      const auto read = std::from_chars(word.data(), word.data() + word.size(), n[i]);
      sound =
          read.ec == std::errc() && read.ptr == word.data() + word.size() && std::abs(n[i]) <= kFarthestMm;
    }
    sound = sound && (readings.empty() || n[0] >= readings.back().time);
    if (!sound) {
      return Error{ErrorKind::bad_input, "not a reading of a device", line.words.front().place.text(),
                   "Each line holds time x y z, the times rising"};
    }
    readings.push_back({n[0], {n[1], n[2], n[3]}});
  }
  return readings;
}

Node device_node(SessionState& s, const std::string& name) {
  const auto [found, made] = s.device_nodes.try_emplace(name, static_cast<int>(s.device_nodes.size()));
  return {Node::Kind::device, found->second};
}

Result<void> device(SessionState& s, const Invocation& c) {
  const std::string& name = c.word("device");
  if (!c.given("value") && !c.given("file"))
    return c.error("a device needs a reading", "Give x y z, or -file");
  if (c.given("file")) {
    TURGOR_TRY(auto readings, read_readings(c.path("file")));
    Device& d = s.devices[name];
    d.readings = std::move(readings);
    d.next = 0;
  }
  if (c.given("value")) read_device(s, name, triple(c, "value"));
  return {};
}

Result<void> follow_device(SessionState& s, const Invocation& c) {
  TURGOR_TRY(const int id, s.scene.require(c.word("object")));
  const std::string& name = c.word("device");
  if (!s.devices.contains(name)) {
    return c.error(fmt::format("there is no device '{}'", name), "Give it a reading first: device NAME X Y Z",
                   "device");
  }
  const auto follow = [id, name, &devices = s.devices](Scene& scene) -> Result<void> {
    centre_at(scene, id, devices.at(name).value);
    return {};
  };
  return told(s, add(s, {"follow_device",
                         "follow_device",
                         {device_node(s, name)},
                         follow,
                         fmt::format("{} follows {}", c.word("object"), name),
                         {{Node::Kind::object, id}}}));
}

Result<void> remove_constraint(SessionState& s, const Invocation& c) {
  if (s.scene.constraints.remove(c.word("constraint"))) return {};
  return c.error(fmt::format("there is no constraint '{}'", c.word("constraint")),
                 "`list constraints` shows them");
}

}  // namespace

void read_device(SessionState& s, const std::string& device, const Vec3& value) {
  s.devices[device].value = value;
  s.scene.constraints.notify(device_node(s, device));
}

std::span<const NamedHandler> constraint_handlers() {
  static constexpr NamedHandler table[] = {{"link", link},
                                           {"parent", parent},
                                           {"stand_in", stand_in},
                                           {"mv_obj_path", object_path},
                                           {"mv_vp_path", camera_path},
                                           {"vp_track_obj", track},
                                           {"bobblot", bobblot},
                                           {"blotbob", blotbob},
                                           {"device", device},
                                           {"follow_device", follow_device},
                                           {"remove_constraint", remove_constraint}};
  return table;
}

}  // namespace turgor::commands
