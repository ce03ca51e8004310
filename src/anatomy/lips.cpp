#include "turgor/anatomy/lips.hpp"

#include <algorithm>
#include <cmath>

#include "turgor/geometry/mesh_edit.hpp"

namespace turgor {

bool LipSlit::covers(const Vec3& p) const {
  const Vec3 across = left - right;
  const double t = dot(p - right, across) / squared_length(across);
  return t > 0 && t < 1 && p.y < back_y;
}

std::optional<LipSlit> find_lip_slit(const Landmarks& landmarks, std::optional<double> lip_level_mm) {
  const auto middle = landmarks.find("stomion");
  const auto left = landmarks.find("cheilion_left"), right = landmarks.find("cheilion_right");
  if (middle == landmarks.end() || left == landmarks.end() || right == landmarks.end()) return std::nullopt;
  LipSlit slit;
  slit.left = left->second.point;
  slit.right = right->second.point;
  slit.back_y = std::max(slit.left.y, slit.right.y) + 4;
  Vec3 through = middle->second.point;
  if (lip_level_mm) through.z = *lip_level_mm;
  const Vec3 across = normalized(slit.left - slit.right);
  Vec3 normal = normalized(cross(slit.left - through, slit.right - through));
  if (normal.z < 0) normal = -normal;
  // Corners and middle nearly in line leave the tilt undetermined: then the plane runs straight back.
  if (normal.z < 0.7) normal = normalized(cross(Vec3{0, -1, 0}, across));
  if (normal.z < 0) normal = -normal;
  slit.plane = Plane::through(through, normal);
  return slit;
}

TriMesh part_lips(const TriMesh& skin, const LipSlit& slit, double snap_mm, std::vector<int>* side) {
  return cut_slit(
      skin, slit.plane, [&](const Vec3& p) { return slit.covers(p); }, snap_mm, side);
}

std::vector<Vec3> spread_lips(const std::vector<Vec3>& points, const std::vector<int>& side,
                              const LipSlit& slit, double gap_mm) {
  const double reach = 4 * gap_mm;
  std::vector<Vec3> out(points);
  for (std::size_t i = 0; i < points.size(); ++i) {
    const double height = slit.plane.signed_distance(points[i]);
    if (std::abs(height) >= reach) continue;
    if (side[i] == 0 && !slit.covers(points[i])) continue;
    const double direction = side[i] != 0 ? side[i] : height > 0 ? 1 : -1;
    out[i] += slit.plane.normal * (direction * gap_mm * (1 - std::abs(height) / reach));
  }
  return out;
}

}  // namespace turgor
