#include "tissue_region.hpp"

#include <algorithm>
#include <cmath>

#include "turgor/anatomy/lips.hpp"
#include "turgor/geometry/mesh_edit.hpp"
#include "turgor/geometry/remesh.hpp"

namespace turgor {
namespace {

std::optional<Vec3> find(const Landmarks& landmarks, std::string_view name) {
  const auto it = landmarks.find(name);
  if (it == landmarks.end()) return std::nullopt;
  return it->second.point;
}

FaceRegion find_limits(const Head& head, const Landmarks& landmarks, const TissueOptions& options) {
  const Box3 skull = bounds(head.skull), skin = bounds(head.skin);
  FaceRegion limits;
  // The face ends in front of the ears, which lie behind the condyles; without condyles take the zygomatic
  // arches.
  const auto left = find(landmarks, "condylion_left"), right = find(landmarks, "condylion_right");
  const auto arch = find(landmarks, "zygion_left");
  if (left && right) {
    limits.back_y = std::min(left->y, right->y);
  } else if (arch) {
    limits.back_y = arch->y + 10;
  } else {
    limits.back_y = skin.lower.y + 0.45 * skin.size().y;
  }
  const double beside_ears = left && right ? std::min(left->z, right->z)
                             : arch        ? arch->z - 10
                                           : skull.lower.z;
  limits.ear_z = beside_ears - 30;
  limits.top_z = options.bone_level_mm.value_or(skull.upper.z);
  limits.bottom_z = skin.lower.z;
  const auto chin = find(landmarks, "soft_menton");
  if (chin) limits.bottom_z = std::max(skin.lower.z, chin->z - options.neck_mm);
  return limits;
}

// Sheared by its reach the region's back is a plane.
TriMesh clip_back(TriMesh face, const FaceRegion& limits, double snap_mm) {
  for (Vec3& p : face.points) p.y -= limits.reach_back(p.z);
  face = clip(face, Plane{{0, -1, 0}, -limits.back_y}, false, snap_mm);
  for (Vec3& p : face.points) p.y += limits.reach_back(p.z);
  return face;
}

// Keeps only the largest piece, so that no crumb of skin is left without neighbours.
TriMesh largest_piece(const TriMesh& mesh) {
  const std::vector<int> component = triangle_components(mesh);
  std::vector<bool> keep(component.size());
  for (std::size_t i = 0; i < keep.size(); ++i) keep[i] = component[i] == 0;
  return submesh(mesh, keep);
}

// Smaller triangles at mouth and nose, where form and movement are finest.
SizingField face_sizing(const TriMesh& face, const Landmarks& landmarks, int columns) {
  std::vector<Vec3> fine;
  for (const std::string_view name :
       {"stomion", "cheilion_left", "cheilion_right", "subnasale", "soft_b_point"}) {
    if (const auto p = find(landmarks, name)) fine.push_back(*p);
  }
  const auto relative = [fine](const Vec3& p) {
    double nearest = 60;
    for (const Vec3& f : fine) nearest = std::min(nearest, distance(p, f));
    const double t = std::clamp((nearest - 12) / 48, 0.0, 1.0);
    return 0.62 + 0.5 * t;
  };
  // Number of points ≈ ∫ dA / (√3/2 h²): solve for the common scale of the sizes.
  double points_at_unit_size = 0;
  for (const Index3& t : face.triangles) {
    const Vec3 c =
        (face.points[static_cast<std::size_t>(t[0])] + face.points[static_cast<std::size_t>(t[1])] +
         face.points[static_cast<std::size_t>(t[2])]) /
        3.0;
    const double h = relative(c);
    points_at_unit_size += 0.5 * length(triangle_normal(face, t)) / (0.8660254 * h * h);
  }
  // Remeshing leaves edges a little shorter than asked for.
  const double scale = 1.09 * std::sqrt(points_at_unit_size / columns);
  return [relative, scale](const Vec3& p) { return scale * relative(p); };
}

}  // namespace

double FaceRegion::reach_back(double z) const {
  return std::clamp(slope * (ear_z - z), 0.0, farthest_back_mm);
}

Result<TissueRegion> find_tissue_region(const Head& head, const Landmarks& landmarks,
                                        const TissueOptions& options, Context& context) {
  const FaceRegion limits = find_limits(head, landmarks, options);
  TissueRegion region;
  region.limits = limits;
  region.skin_points_above_bone = static_cast<int>(std::count_if(
      head.skin.points.begin(), head.skin.points.end(), [&](const Vec3& p) { return p.z > limits.top_z; }));

  constexpr double snap_mm = 0.2;
  TriMesh face = clip_back(head.skin, limits, snap_mm);
  face = clip(face, Plane{{0, 0, -1}, -limits.top_z}, false, snap_mm);
  face = clip(face, Plane{{0, 0, 1}, limits.bottom_z}, false, snap_mm);
  if (face.empty()) {
    return Error{ErrorKind::bad_input, "no skin lies in front of the bone", "scan",
                 "Check that the scan shows a face and that its orientation is right"};
  }
  face = largest_piece(face);
  const SizingField sizing = face_sizing(face, landmarks, options.columns);
  TURGOR_TRY(face, remesh_isotropic(face, sizing, 5, context));

  region.slit = find_lip_slit(landmarks, options.lip_level_mm);
  const auto middle = find(landmarks, "stomion");
  // Where the scan ends above the lips all skin aims at the upper centre.
  region.lip_level_mm = options.lip_level_mm ? *options.lip_level_mm : middle ? middle->z : limits.bottom_z;
  region.lip_side.assign(face.points.size(), 0);
  if (!options.lip_slit) region.slit.reset();
  if (region.slit) face = part_lips(face, *region.slit, 0.3 * sizing(*middle), &region.lip_side);
  // Where the scan cuts through the face nothing is known of the tissue beyond: it is left free there.
  const bool free_below = head.open_below && !find(landmarks, "soft_menton");
  region.rim = boundary_points(face);
  for (std::size_t i = 0; i < face.points.size(); ++i) {
    const Vec3& p = face.points[i];
    constexpr double margin_mm = 1.0;
    const bool at_mouth =
        region.slit && region.slit->covers(p) && std::abs(region.slit->plane.signed_distance(p)) < margin_mm;
    if (at_mouth || (free_below && p.z < limits.bottom_z + margin_mm)) region.rim[i] = false;
  }
  region.surface = std::move(face);
  return region;
}

}  // namespace turgor
