#include "world/scene/polyline.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace turgor {

Result<Vec3> point_along(std::span<const Vec3> polyline, double fraction) {
  if (polyline.empty())
    return Error{ErrorKind::bad_input, "the path has no points", {}, "Name an object with points"};
  std::vector<double> arc{0};
  arc.reserve(polyline.size());
  for (std::size_t i = 1; i < polyline.size(); ++i) {
    const Vec3 step = polyline[i] - polyline[i - 1];
    arc.push_back(arc.back() + std::hypot(step.x, step.y, step.z));
  }
  if (!std::isfinite(arc.back())) {
    return Error{ErrorKind::bad_input, "the length of the path is not finite", {}, "Bring its points nearer"};
  }
  if (fraction >= 1) return polyline.back();
  const double target = fraction * arc.back();
  const auto end = std::upper_bound(arc.begin(), arc.end(), target);
  if (end == arc.begin() || end == arc.end()) return end == arc.begin() ? polyline.front() : polyline.back();
  const auto i = static_cast<std::size_t>(end - arc.begin());
  return lerp(polyline[i - 1], polyline[i], (target - arc[i - 1]) / (arc[i] - arc[i - 1]));
}

Result<Vec3> PathMotion::place(const Scene& scene) const {
  const Object* const object = scene.find(path);
  if (object == nullptr)
    return Error{ErrorKind::bad_input, "the path is gone", {}, "Name an object that is there"};
  const long long since = static_cast<long long>(scene.frame) - first_frame;
  const long long at = options.loop ? since % options.frames : std::min<long long>(since, options.frames);
  return point_along(world_polyhedron(*object).points, static_cast<double>(at) / options.frames);
}

Result<PathMotion> make_path_motion(const Scene& scene, const std::string& path, const PathOptions& options) {
  TURGOR_TRY(const int id, scene.require(path));
  if (options.frames < 1) {
    return Error{ErrorKind::bad_input,
                 fmt::format("a path takes {} frames", options.frames),
                 {},
                 "Give 1 frame or more"};
  }
  const PathMotion motion{id, scene.frame, options};
  TURGOR_CHECK(motion.place(scene));
  return motion;
}

}  // namespace turgor
