// Constraints between objects of a scene: links, hierarchies, stand-ins, and moves of objects and cameras
// (Pieper 1989, sections 4.4, 4.5.1 and 4.5.7). Each adds itself to the scene, is served once at once, and
// returns its name.
#pragma once

#include "turgor/world/scene.hpp"

namespace turgor {

/// Stretches `link` from the centre of `a` to that of `b`, along its own x axis; `keep_volume` thins it as it
/// lengthens.
Result<std::string> add_link(Scene& scene, const std::string& link, const std::string& a,
                             const std::string& b, bool keep_volume);
/// `child` keeps its place relative to `parent`. Errors: the same object.
Result<std::string> add_parent(Scene& scene, const std::string& child, const std::string& parent);
/// Shows the world's bounding box of `object` in its stead; the object becomes invisible. The new object is
/// named "box.NAME".
Result<std::string> add_stand_in(Scene& scene, const std::string& object);

struct PathOptions {
  int frames = 100;   ///< from the first point to the last
  bool loop = false;  ///< start again at the end; otherwise the object stays there
};
/// Moves `object` (`mv_obj_path`), or a viewport's camera (`mv_vp_path`), along the polyline through the
/// points of `path` at constant speed, from the present frame on. The object's centre runs on the path; the
/// camera's eye does.
Result<std::string> add_object_path(Scene& scene, const std::string& object, const std::string& path,
                                    const PathOptions& options);
Result<std::string> add_camera_path(Scene& scene, const std::string& viewport, const std::string& path,
                                    const PathOptions& options);
/// A rigid motion over some frames: it turns about the axis through a point, and shifts, evenly.
struct MoveBy {
  Vec3 shift;
  double angle_deg = 0;
  Vec3 axis{0, 0, 1};
  std::optional<Vec3> about = std::nullopt;  ///< a point on the axis; else the object's centre
  int frames = 100;
};
/// From the next frame on (`mv_obj_by`). Errors: an axis without length; frames below 1.
Result<std::string> add_object_move(Scene& scene, const std::string& object, const MoveBy& move);
/// The viewport's camera follows (`vp_track_obj`): `eye` gives its place, `look_at` what it looks at; with
/// `eye` alone the view goes along the eye's orientation, with `look_at` alone the camera only turns. Empty:
/// not given. Errors: neither given.
Result<std::string> add_camera_tracking(Scene& scene, const std::string& viewport, const std::string& eye,
                                        const std::string& look_at);

/// Transform of a camera at `eye` that looks at `target`. Errors: eye on the target, not finite.
Result<ObjectTransform> look_at(const Vec3& eye, const Vec3& target, const Vec3& up);

}  // namespace turgor
