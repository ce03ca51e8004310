// What the commands about worlds, viewports, cameras, lights and output do.
#include <fmt/format.h>

#include <algorithm>

#include "session_state.hpp"
#include "turgor/world/flesh_objects.hpp"
#include "turgor/world/object_constraints.hpp"

namespace turgor::commands {
namespace {

Result<void> world(SessionState& s, const Invocation& c) {
  const std::string& name = c.word("world");
  if (s.scene.find_world(name) == nullptr) s.scene.worlds.push_back({name, {}});
  s.scene.current_world = name;
  return {};
}

Result<World*> world_of(SessionState& s, const Invocation& c) {
  const std::string& name = c.given("world") ? c.word("world") : s.scene.current_world;
  World* found = s.scene.find_world(name);
  if (found == nullptr)
    return c.error(fmt::format("there is no world '{}'", name), "Make it with the command world");
  return found;
}

Result<void> post(SessionState& s, const Invocation& c) {
  TURGOR_TRY([[maybe_unused]] const int id, s.scene.require(c.word("object")));
  TURGOR_TRY(World * where, world_of(s, c));
  if (std::ranges::find(where->objects, c.word("object")) == where->objects.end()) {
    where->objects.push_back(c.word("object"));
  }
  return {};
}

Result<void> unpost(SessionState& s, const Invocation& c) {
  TURGOR_TRY([[maybe_unused]] const int id, s.scene.require(c.word("object")));
  TURGOR_TRY(World * where, world_of(s, c));
  std::erase(where->objects, c.word("object"));
  return {};
}

Result<void> check_viewport(const SessionState& s, const Invocation& c, const Viewport& v) {
  if (!(v.left < v.right && v.bottom < v.top)) {
    return c.error("the viewport has no extent", "Give left below right and bottom below top", "at");
  }
  const Object* camera = s.scene.find(v.camera);
  if (camera == nullptr || camera->kind() != ObjectKind::camera) {
    return c.error(fmt::format("there is no camera '{}'", v.camera), "Make it with the command camera",
                   "camera");
  }
  if (s.scene.find_world(v.world) == nullptr) {
    return c.error(fmt::format("there is no world '{}'", v.world), "Make it with the command world", "world");
  }
  return {};
}

Result<void> viewport(SessionState& s, const Invocation& c) {
  const std::string& name = c.word("viewport");
  if (c.flag("remove")) {
    if (std::erase_if(s.scene.screen.viewports, [&](const Viewport& v) { return v.name == name; }) > 0)
      return {};
    return c.error(fmt::format("there is no viewport '{}'", name), "`list viewports` shows them");
  }
  Viewport* found = s.scene.find_viewport(name);
  Viewport v = found != nullptr ? *found : Viewport{};
  if (found == nullptr) v.name = name, v.camera = "camera", v.world = s.scene.current_world;
  if (c.given("at")) {
    const auto n = c.numbers("at");
    v.left = n.at(0), v.bottom = n.at(1), v.right = n.at(2), v.top = n.at(3);
  }
  if (c.given("camera")) v.camera = c.word("camera");
  if (c.given("world")) v.world = c.word("world");
  if (c.given("style")) v.style = c.word("style") == "wire" ? DrawStyle::wire : DrawStyle::shaded;
  if (c.flag("stereo")) v.stereo = true;
  if (c.flag("mono")) v.stereo = false;
  if (c.given("eyes")) v.eye_separation = c.number("eyes");
  if (c.flag("title")) v.title = true;
  if (c.flag("border")) v.border = true;
  if (c.flag("plain")) v.title = v.border = false;
  if (c.flag("on")) v.visible = true;
  if (c.flag("off")) v.visible = false;
  TURGOR_CHECK(check_viewport(s, c, v));
  if (found != nullptr)
    *found = v;
  else
    s.scene.screen.viewports.push_back(v);
  return {};
}

Result<void> screen(SessionState& s, const Invocation& c) {
  if (c.given("size")) {
    const auto& size = c.all("size").front().integers;
    s.scene.screen.width = static_cast<int>(size.at(0));
    s.scene.screen.height = static_cast<int>(size.at(1));
  }
  if (c.given("background")) s.scene.screen.background = colour_triple(c, "background");
  return {};
}

// The object of that name and kind, made where there is none.
Result<int> of_kind(SessionState& s, const Invocation& c, const std::string& name, Description description) {
  const ObjectKind kind = static_cast<ObjectKind>(description.index());
  if (const Object* found = s.scene.find(name); found != nullptr) {
    if (found->kind() == kind) return s.scene.id_of(name);
    return c.error(fmt::format("'{}' is a {}", name, name_of(found->kind())), "Choose another name");
  }
  Object object;
  object.name = name;
  object.description = std::move(description);
  return s.scene.add_object(std::move(object));
}

Result<void> camera(SessionState& s, const Invocation& c) {
  TURGOR_TRY(const int id, of_kind(s, c, c.word("camera"), CameraLens{}));
  CameraLens lens = std::get<CameraLens>(s.scene.find(id)->description);
  const ObjectTransform& present = s.scene.find(id)->transform;
  const Vec3 eye = c.given("eye") ? triple(c, "eye") : present.point({});
  const Vec3 target = c.given("look_at") ? triple(c, "look_at")
                                         : present.point({}) + normalized(present.direction({0, 0, -1})) *
                                                                   lens.target_distance;
  TURGOR_TRY(const ObjectTransform placed, look_at(eye, target, triple(c, "up")));
  lens.target_distance = distance(eye, target);
  if (c.given("fov")) lens.fov_deg = c.number("fov");
  if (c.given("height")) lens.height = c.number("height"), lens.fov_deg = 0;
  s.scene.set_description(id, lens);
  s.scene.set_transform(id, placed);
  return {};
}

Result<void> light(SessionState& s, const Invocation& c) {
  TURGOR_TRY(const int id, of_kind(s, c, c.word("light"), Light{}));
  TURGOR_TRY(const ObjectTransform placed, look_at(triple(c, "from"), {}, {0, 0, 1}));
  s.scene.set_description(id, Light{colour_triple(c, "colour"), c.number("strength")});
  s.scene.set_transform(id, placed);
  return {};
}

// ---- output ----

Result<std::filesystem::path> output_file(const SessionState& s, const Invocation& c, const char* extension) {
  const std::string& name = c.word("name");
  if (name.find('/') != std::string::npos || name.starts_with('.')) {
    return c.error(fmt::format("'{}' is not the name of a file", name), "Give a name without folders",
                   "name");
  }
  return s.options.output / (name + extension);
}

Result<void> picture(SessionState& s, const Invocation& c) {
  TURGOR_TRY(const auto path, output_file(s, c, ".png"));
  if (!s.options.picture)
    return c.error("this program draws no pictures", "Run the script with `turgor run`");
  s.scene.serve_constraints();
  TURGOR_CHECK(update_flesh_objects(s.scene));
  return s.options.picture(s.scene, path);
}

Result<void> state(SessionState& s, const Invocation& c) {
  TURGOR_TRY(const auto path, output_file(s, c, ".state"));
  return write_state(s.scene, path);
}

Result<void> restore(SessionState& s, const Invocation& c) {
  return read_state(s.scene, c.path("file"));
}

}  // namespace

std::span<const NamedHandler> view_handlers() {
  static constexpr NamedHandler table[] = {{"world", world},       {"post", post},       {"unpost", unpost},
                                           {"viewport", viewport}, {"screen", screen},   {"camera", camera},
                                           {"light", light},       {"picture", picture}, {"state", state},
                                           {"restore", restore}};
  return table;
}

}  // namespace turgor::commands
