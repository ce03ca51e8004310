#include "geometry/voxel_lattice.hpp"

#include <fmt/format.h>

#include <cmath>

#include "turgor/core/parallel.hpp"

namespace turgor::detail {
namespace {

constexpr int kBits = 30;
constexpr std::size_t kGrain = 16384;

/// The box of the points that triangles use. The rest of a file's points may lie anywhere.
Result<Box3> box_of(const TriMesh& mesh) {
  struct Part {
    Box3 box;
    int bad = -1;  // the first triangle that cannot be used
  };
  const Part all = parallel_reduce<Part>(
      mesh.triangles.size(), kGrain, {},
      [&](std::size_t begin, std::size_t end) {
        Part part;
        for (std::size_t t = begin; t < end; ++t) {
          for (const int p : mesh.triangles[t]) {
            const bool there = p >= 0 && static_cast<std::size_t>(p) < mesh.points.size();
            if (!there || !is_finite(mesh.points[static_cast<std::size_t>(p)])) {
              part.bad = static_cast<int>(t);
              return part;
            }
            part.box.extend(mesh.points[static_cast<std::size_t>(p)]);
          }
        }
        return part;
      },
      [](Part a, const Part& b) {
        if (a.bad < 0) a.bad = b.bad;
        a.box.extend(b.box.lower), a.box.extend(b.box.upper);
        return a;
      });
  if (all.bad < 0) return all.box;
  return Error{ErrorKind::bad_input, "a corner of the surface is not a point with finite coordinates",
               fmt::format("triangle {}", all.bad), "Repair the surface"};
}

}  // namespace

Vec3 Lattice::position(const LatticePoint& p) const {
  const double unit = std::ldexp(spacing, -shift);
  return lower + Vec3{p[0] * unit, p[1] * unit, p[2] * unit};
}

Result<Lattice> make_lattice(const TriMesh& surface, const VoxelOptions& options) {
  const int n = options.resolution;
  if (n < 1 || n > VoxelOptions::max_resolution) {
    return Error{ErrorKind::bad_input, fmt::format("the resolution {} cannot be used", n), "",
                 fmt::format("Give 1 to {} voxels along the longest axis", VoxelOptions::max_resolution)};
  }
  if (surface.triangles.empty())
    return Error{ErrorKind::bad_input, "the surface has no triangles", "", "Give a surface to mesh"};
  TURGOR_TRY(const Box3 box, box_of(surface));
  const Vec3 extent = box.size();
  const double longest = std::max({extent.x, extent.y, extent.z});
  if (!std::isfinite(longest * longest) || !(longest * longest > 1e-200)) {
    return Error{ErrorKind::bad_input, fmt::format("the surface spans {:g} mm", longest), "",
                 "Give a surface of a size that can be meshed"};
  }
  Lattice lattice;
  // A hair more than the extent, so that what ends on a voxel's face does not touch the next voxel.
  lattice.spacing = longest * (1 + 0x1p-16) / n;
  for (int a = 0; a < 3; ++a) {
    const int count = std::max(1, static_cast<int>(std::ceil(extent[a] / lattice.spacing)));
    lattice.size[static_cast<std::size_t>(a)] = count + 2;
    lattice.lower[a] = box.lower[a] + 0.5 * extent[a] - 0.5 * (count + 2) * lattice.spacing;
  }
  while (((n + 2) >> (kBits - lattice.shift)) == 0) ++lattice.shift;
  --lattice.shift;
  const double units = std::ldexp(1, lattice.shift) / lattice.spacing;
  lattice.triangles = surface.triangles;
  lattice.points.resize(surface.points.size());
  const Vec3 lower = lattice.lower;
  parallel_for(surface.points.size(), kGrain, [&](std::size_t begin, std::size_t end) {
    for (std::size_t p = begin; p < end; ++p) {
      const Vec3& q = surface.points[p];
      if (!box.contains(q)) continue;  // not used, or not a number
      for (int a = 0; a < 3; ++a) {
        lattice.points[p][static_cast<std::size_t>(a)] =
            static_cast<std::int32_t>(std::nearbyint((q[a] - lower[a]) * units));
      }
    }
  });
  return lattice;
}

}  // namespace turgor::detail
