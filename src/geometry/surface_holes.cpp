#include "turgor/geometry/surface_holes.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "geometry/voxel_fill.hpp"
#include "geometry/voxel_lattice.hpp"

namespace turgor {
namespace detail {

SurfaceHole in_mm(const Hole& hole, const Lattice& lattice) {
  SurfaceHole out;
  for (const auto& [a, b] : hole.edges) out.rim.push_back({lattice.position(a), lattice.position(b)});
  out.middle = lattice.position(hole.middle);
  out.box.extend(lattice.position(hole.low)), out.box.extend(lattice.position(hole.high));
  out.radius = hole.width * std::ldexp(lattice.spacing, -lattice.shift) / std::sqrt(std::numbers::pi);
  // The edges have no direction: each triangle of the lid is turned to the side of the largest.
  std::vector<Vec3> areas;
  for (const auto& [a, b] : out.rim) areas.push_back(cross(a - out.middle, b - out.middle));
  const Vec3 largest = *std::max_element(areas.begin(), areas.end(), [](const Vec3& a, const Vec3& b) {
    return squared_length(a) < squared_length(b);
  });
  Vec3 sum;
  for (const Vec3& area : areas) sum += dot(area, largest) < 0 ? -area : area;
  out.normal = normalized(sum);
  return out;
}

}  // namespace detail

std::string SurfaceHole::text() const {
  const Vec3 size = box.size();
  return fmt::format("hole of {:.3g} x {:.3g} x {:.3g} mm about ({:.4g}, {:.4g}, {:.4g}) mm", size.x, size.y,
                     size.z, middle.x, middle.y, middle.z);
}

Result<std::vector<SurfaceHole>> surface_holes(const TriMesh& surface) {
  TURGOR_TRY(const detail::Lattice lattice, detail::make_lattice(surface, VoxelOptions{.resolution = 1}));
  std::vector<SurfaceHole> holes;
  for (const detail::Hole& hole : detail::find_holes(lattice)) holes.push_back(detail::in_mm(hole, lattice));
  return holes;
}

}  // namespace turgor
