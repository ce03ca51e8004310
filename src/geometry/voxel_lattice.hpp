// The surface in units of a fraction of a voxel, as integers, where every test is exact. Internal.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "turgor/geometry/tri_mesh.hpp"
#include "turgor/geometry/voxel_solid.hpp"

namespace turgor::detail {

__extension__ using Wide = __int128;

using LatticePoint = std::array<std::int32_t, 3>;

/// Voxel (i, j, k) spans i << shift to (i + 1) << shift, and so on; its centre is in the middle. Coordinates
/// are positive and below 2^30, so that differences of products fit 64 bits. One empty voxel on every side.
struct Lattice {
  int shift = 0;
  Index3 size{0, 0, 0};  ///< voxels
  Vec3 lower;            ///< mm
  double spacing = 1;    ///< mm
  std::vector<LatticePoint> points;
  std::vector<Index3> triangles;

  [[nodiscard]] const LatticePoint& point(int p) const { return points[static_cast<std::size_t>(p)]; }
  [[nodiscard]] std::int64_t centre(int i) const {
    return (static_cast<std::int64_t>(i) << shift) + (std::int64_t{1} << (shift - 1));
  }
  /// mm
  [[nodiscard]] Vec3 position(const LatticePoint& p) const;
};

Result<Lattice> make_lattice(const TriMesh& surface, const VoxelOptions& options);

}  // namespace turgor::detail
