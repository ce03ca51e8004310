// Cameras that look at things, run along paths and follow objects (`cam_moves`: Pieper 1989, section 4.5.7).
#include <fmt/format.h>

#include "turgor/world/object_constraints.hpp"
#include "world/scene/constraint_tools.hpp"
#include "world/scene/polyline.hpp"
#include "world/scene/transforms.hpp"

namespace turgor {
namespace {

/// The camera of a viewport, by name at every frame: viewports change their cameras.
Result<int> camera_of(Scene& scene, const std::string& viewport) {
  const Viewport* const found = scene.find_viewport(viewport);
  if (found == nullptr) {
    return Error{ErrorKind::bad_input,
                 fmt::format("there is no viewport '{}'", viewport),
                 {},
                 "`list viewports` shows those that are there"};
  }
  TURGOR_TRY(const int id, scene.require(found->camera));
  if (scene.find(id)->kind() != ObjectKind::camera) {
    return Error{ErrorKind::bad_input,
                 fmt::format("'{}' of the viewport '{}' is not a camera", found->camera, viewport),
                 {},
                 "Give the viewport a camera"};
  }
  return id;
}

/// The camera's own point (0, 0, 0) at `eye`, its direction as it is.
ObjectTransform with_eye_at(ObjectTransform transform, const Vec3& eye) {
  transform.translation += eye - transform.point({});
  return transform;
}

/// A camera at `eye` that looks along the unit vector `forward`.
ObjectTransform looking_along(const Vec3& eye, const Vec3& forward, const Vec3& up) {
  Vec3 right = cross(forward, unit(up));
  if (length(right) < 1e-6) right = any_orthogonal(forward);
  right = unit(right);
  return {Mat3{{right, cross(right, forward), -forward}}, eye, {}};
}

/// The orientation's normal; cameras and lights look along the other side of their z axis.
Result<ObjectTransform> looking_with(const Object& object) {
  const Orientation along = orientation(object);
  if (along.normal == Vec3{}) {
    return Error{ErrorKind::bad_input, "is flat: it looks nowhere", object.name, "Scale it"};
  }
  const bool backwards = object.kind() == ObjectKind::camera || object.kind() == ObjectKind::light;
  return looking_along(centre_of(object), backwards ? -along.normal : along.normal, along.up);
}

struct Tracking {
  std::string viewport;
  int eye = -1, target = -1;  ///< objects; -1: not given

  Result<void> operator()(Scene& scene) const {
    TURGOR_TRY(const int camera, camera_of(scene, viewport));
    if (target < 0) {
      TURGOR_TRY(const ObjectTransform place, looking_with(*scene.find(eye)));
      return move_object(scene, camera, place);
    }
    const Vec3 from = eye < 0 ? scene.find(camera)->transform.point({}) : centre_of(*scene.find(eye));
    const Vec3 to = centre_of(*scene.find(target));
    TURGOR_TRY(const ObjectTransform place, look_at(from, to, {0, 0, 1}));
    auto lens = std::get<CameraLens>(scene.find(camera)->description);
    lens.target_distance = distance(from, to);
    scene.set_description(camera, lens);
    return move_object(scene, camera, place);
  }
};

}  // namespace

Result<ObjectTransform> look_at(const Vec3& eye, const Vec3& target, const Vec3& up) {
  if (!is_finite(eye) || !is_finite(target) || !is_finite(up)) {
    return Error{ErrorKind::bad_input, "a point of the camera is not finite", {}, "Give smaller numbers"};
  }
  // Halves, so that the difference of far points is finite.
  const Vec3 forward = unit(target * 0.5 - eye * 0.5);
  if (forward == Vec3{}) {
    return Error{ErrorKind::bad_input, "the camera's eye is on its target", {}, "Move one of the two"};
  }
  return looking_along(eye, forward, up);
}

Result<std::string> add_camera_path(Scene& scene, const std::string& viewport, const std::string& path,
                                    const PathOptions& options) {
  TURGOR_CHECK(camera_of(scene, viewport));
  TURGOR_TRY(const PathMotion motion, make_path_motion(scene, path, options));
  return add_served(scene, {.kind = "mv_vp_path",
                            .triggers = {{Node::Kind::frame_start}, object_node(motion.path)},
                            .satisfy = [viewport, motion](Scene& s) -> Result<void> {
                              TURGOR_TRY(const int camera, camera_of(s, viewport));
                              TURGOR_TRY(const Vec3 eye, motion.place(s));
                              return move_object(s, camera, with_eye_at(s.find(camera)->transform, eye));
                            },
                            .arguments = viewport + " " + path});
}

Result<std::string> add_camera_tracking(Scene& scene, const std::string& viewport, const std::string& eye,
                                        const std::string& look_at) {
  if (eye.empty() && look_at.empty()) {
    return Error{ErrorKind::bad_input,
                 "neither an eye nor something to look at is given",
                 {},
                 "Name an object for one of them, or for both"};
  }
  TURGOR_TRY(const int camera, camera_of(scene, viewport));
  Tracking tracking{viewport};
  // The camera may be moved by others: it turns to its target at the end of the frame at the latest.
  Constraint constraint{.kind = "vp_track_obj", .triggers = {{Node::Kind::frame_end}}};
  for (auto [name, id] : {std::pair{&eye, &tracking.eye}, std::pair{&look_at, &tracking.target}}) {
    if (name->empty()) continue;
    TURGOR_TRY(*id, scene.require(*name));
    if (*id == camera) {
      return Error{ErrorKind::bad_input, "a camera cannot follow itself", *name, "Name another object"};
    }
    constraint.triggers.push_back(object_node(*id));
  }
  constraint.arguments = viewport + (eye.empty() ? "" : " -eye " + eye);
  if (!look_at.empty()) constraint.arguments += " -look_at " + look_at;
  constraint.satisfy = tracking;
  return add_served(scene, std::move(constraint));
}

}  // namespace turgor
