// Motion at constant speed along a polyline. Internal to the scene.
#pragma once

#include <span>

#include "turgor/world/object_constraints.hpp"

namespace turgor {

/// The point at `fraction` (0 to 1) of the length of the polyline; its first point where it has no length.
/// Errors: no points; a length that is not finite.
Result<Vec3> point_along(std::span<const Vec3> polyline, double fraction);

struct PathMotion {
  int path = 0;  ///< object
  int first_frame = 0;
  PathOptions options;

  /// Where it is at the scene's frame.
  [[nodiscard]] Result<Vec3> place(const Scene& scene) const;
};
/// From the present frame on. Errors: no such path, or one without points; fewer than 1 frame.
Result<PathMotion> make_path_motion(const Scene& scene, const std::string& path, const PathOptions& options);

}  // namespace turgor
