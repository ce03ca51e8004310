#include "turgor/world/scene.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <string_view>

#include "turgor/core/nearest.hpp"
#include "turgor/world/object_constraints.hpp"
#include "world/scene/constraint_tools.hpp"
#include "world/scene/name.hpp"
#include "world/scene/transforms.hpp"

namespace turgor {
namespace {

template <class Items>
auto* find_named(Items& items, const std::string& name) {
  const auto found =
      std::find_if(items.begin(), items.end(), [&](const auto& item) { return item.name == name; });
  return found == items.end() ? nullptr : &*found;
}

Error no_object(int id) {
  return {ErrorKind::internal, fmt::format("no object has the number {}", id)};
}

}  // namespace

Scene::Scene() : worlds{{"main", {}}}, current_world("main") {
  Object camera;
  camera.name = "camera";
  camera.description = CameraLens{};
  // From the front, a little from the right and above, so that a unit cube fills half of the picture.
  if (auto place = look_at({1, -2.5, 1.5}, {}, {0, 0, 1})) camera.transform = *place;
  std::get<CameraLens>(camera.description).target_distance = length(camera.transform.translation);
  objects_.emplace(next_id_++, std::move(camera));
  worlds[0].objects = {"camera"};
  Viewport viewport;
  viewport.name = "main", viewport.camera = "camera", viewport.world = "main";
  screen.viewports = {viewport};
}

Result<int> Scene::add_object(Object object) {
  TURGOR_CHECK(check_name(object.name));
  if (find(object.name) != nullptr) {
    return Error{ErrorKind::bad_input,
                 fmt::format("there is an object {} already", shown_name(object.name)),
                 {},
                 "Choose another name, or remove that one first"};
  }
  if (const auto valid = validate(object); !valid) {
    Error error = valid.error();
    error.where = object.name;
    return error;
  }
  World* world = find_world(current_world);
  if (world == nullptr) {
    return Error{ErrorKind::bad_input,
                 fmt::format("there is no world {}", shown_name(current_world)),
                 {},
                 "Make a world, or choose one"};
  }
  world->objects.push_back(object.name);
  const int id = next_id_++;
  objects_.emplace(id, std::move(object));
  return id;
}

bool Scene::remove_object(const std::string& name) {
  const int id = id_of(name);
  if (id < 0) return false;
  // Held for as long as `name` is read, which may be the object's own.
  const auto gone = objects_.extract(id);
  for (World& world : worlds) std::erase(world.objects, gone.mapped().name);
  hardened_.erase(id);
  constraints.remove_dependents(object_node(id));
  return true;
}

int Scene::id_of(const std::string& name) const {
  const auto found = std::find_if(objects_.begin(), objects_.end(),
                                  [&](const auto& entry) { return entry.second.name == name; });
  return found == objects_.end() ? -1 : found->first;
}

const Object* Scene::find(const std::string& name) const {
  return find(id_of(name));
}

const Object* Scene::find(int id) const {
  const auto found = objects_.find(id);
  return found == objects_.end() ? nullptr : &found->second;
}

Result<int> Scene::require(const std::string& name) const {
  if (const int id = id_of(name); id >= 0) return id;
  std::vector<std::string_view> names;
  for (const auto& [id, object] : objects_) names.emplace_back(object.name);
  const std::string_view nearest = nearest_word(name, names);
  return Error{ErrorKind::bad_input,
               fmt::format("there is no object {}", shown_name(name)),
               {},
               nearest.empty() ? "`list objects` shows those that are there"
                               : fmt::format("Did you mean {}?", nearest)};
}

void Scene::set_transform(int id, const ObjectTransform& transform) {
  const auto found = objects_.find(id);
  if (found == objects_.end() || found->second.transform == transform || !is_finite(transform)) return;
  found->second.transform = transform;
  constraints.notify(object_node(id));
}

void Scene::set_description(int id, Description description) {
  const auto found = objects_.find(id);
  if (found == objects_.end() || same_description(found->second.description, description)) return;
  std::swap(found->second.description, description);
  if (validate(found->second)) {
    constraints.notify(object_node(id));
  } else {
    std::swap(found->second.description, description);
  }
}

void Scene::set_optics(int id, const Optics& optics) {
  const auto found = objects_.find(id);
  if (found != objects_.end() && validate(optics)) found->second.optics = optics;
}
void Scene::set_visible(int id, bool visible) {
  if (const auto found = objects_.find(id); found != objects_.end()) found->second.visible = visible;
}
void Scene::set_triangulated(int id, bool triangulated) {
  if (const auto found = objects_.find(id); found != objects_.end())
    found->second.triangulated = triangulated;
}

Result<void> Scene::harden(int id) {
  const auto found = objects_.find(id);
  if (found == objects_.end()) return no_object(id);
  const ObjectTransform before = found->second.transform, pose_before = pose(id);
  TURGOR_CHECK(turgor::harden(found->second));
  if (found->second.transform == before) return {};
  hardened_[id] = pose_before;
  constraints.notify(object_node(id));
  return {};
}

ObjectTransform Scene::pose(int id) const {
  const auto object = objects_.find(id);
  if (object == objects_.end()) return {};
  const auto hardened = hardened_.find(id);
  return hardened == hardened_.end() ? about({}, object->second.transform)
                                     : object->second.transform * hardened->second;
}

World* Scene::find_world(const std::string& name) {
  return find_named(worlds, name);
}
const World* Scene::find_world(const std::string& name) const {
  return find_named(worlds, name);
}
Viewport* Scene::find_viewport(const std::string& name) {
  return find_named(screen.viewports, name);
}

void Scene::begin_frame() {
  // Else what waits would take its turn before the things that it depends on have moved.
  constraints.renormalise(*this);
  ++frame;
  constraints.begin_frame();
  constraints.notify({Node::Kind::frame_start});
  constraints.renormalise(*this);
}

void Scene::end_frame() {
  constraints.notify({Node::Kind::frame_end});
  constraints.renormalise(*this);
}

}  // namespace turgor
