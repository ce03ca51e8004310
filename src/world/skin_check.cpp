#include "world/skin_check.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "turgor/core/index.hpp"
#include "turgor/geometry/surface_query.hpp"
#include "world/bone_contact.hpp"

namespace turgor {
namespace {

double stretch(const LayeredTissue& tissue, const std::vector<Vec3>& points, Vec3* where) {
  double greatest = 1;
  for (const Index3& t : tissue.surface.triangles) {
    for (std::size_t i = 0; i < 3; ++i) {
      const std::size_t a = at(t[i]), b = at(t[(i + 1) % 3]);
      const double ratio =
          distance(points[a], points[b]) / distance(tissue.surface.points[a], tissue.surface.points[b]);
      if (ratio <= greatest) continue;
      greatest = ratio;
      *where = points[a];
    }
  }
  return greatest;
}

}  // namespace

// Bone outside the predicted skin, or skin torn: the move is not one that a face survives.
Result<void> check_skin(const PatientCase& patient, Prediction& prediction, Context& context) {
  // Skin that nothing pushes (the neck before an opening jaw) may be passed by a little: that is told, not
  // refused.
  constexpr double bearable_stretch = 3.0, bearable_mm = 8.0, tolerance_mm = 0.5, reach_mm = 30.0;
  const std::string remedy = "Move the bones less, or check the direction of the move";
  Vec3 torn{};
  prediction.largest_stretch = stretch(patient.tissue(), prediction.surface_points, &torn);
  const SurfaceQuery skin(prediction.skin);
  const std::vector<Vec3> normals = point_normals(prediction.skin);
  const double scan_end = patient.head().scan_box.lower.z + 4;
  for (const BoneSegment& segment : patient.bones().segments()) {
    if (!moves(segment)) continue;
    double farthest = 0;
    Vec3 place{};
    for (const Vec3& rest : segment.surface.points) {
      const Vec3 p = segment.motion.point(rest);
      const auto near = skin.nearest(p, reach_mm);
      if (!near || near->point.z < scan_end) continue;
      const Index3& t = prediction.skin.triangles[at(near->triangle)];
      const Vec3 n = normalized(normals[at(t[0])] * (1 - near->u - near->v) + normals[at(t[1])] * near->u +
                                normals[at(t[2])] * near->v);
      // Beyond an edge of the skin (mouth, end of the scan) or beside a fold of it the side alone says
      // nothing.
      const double out = dot(p - near->point, n);
      if (out < 0.7 * near->distance || out <= std::max(farthest, tolerance_mm) || skin.inside(p)) continue;
      farthest = out;
      place = p;
    }
    if (farthest > tolerance_mm && farthest <= bearable_mm) {
      context.warning(fmt::format(
          "'{}' comes {:.1f} mm through the predicted skin at ({:.0f}, {:.0f}, {:.0f}): the tissue "
          "there is not attached to it, and the prediction not to be trusted",
          segment.name, farthest, place.x, place.y, place.z));
    }
    if (farthest > bearable_mm || prediction.largest_stretch > bearable_stretch) {
      const Vec3 where = farthest > bearable_mm ? place : torn;
      const std::string what =
          farthest > bearable_mm
              ? fmt::format("the move of '{}' drives bone {:.1f} mm through the skin", segment.name, farthest)
              : fmt::format("the move of '{}' stretches the skin to {:.1f} times its length", segment.name,
                            prediction.largest_stretch);
      return Error{ErrorKind::bad_command,
                   fmt::format("{} at ({:.0f}, {:.0f}, {:.0f})", what, where.x, where.y, where.z), "plan",
                   remedy};
    }
  }
  return {};
}

}  // namespace turgor
