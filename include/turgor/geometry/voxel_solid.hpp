// Any surface to a solid of cubes and of tetrahedra: Morris (2006), "Automatic Preparation, Calibration, and
// Simulation of Deformable Objects", section 2.
#pragma once

#include <array>
#include <bit>
#include <cstdint>
#include <vector>

#include "turgor/core/context.hpp"
#include "turgor/core/error.hpp"
#include "turgor/geometry/solid_mesh.hpp"

namespace turgor {

/// Cubes of one size, one bit each. Bit i of row (j, k) is bit i % 64 of word i / 64; rows lie one after
/// another, j fastest, and end with at least one zero bit. The outermost voxels on every side are empty.
struct VoxelGrid {
  Index3 size{0, 0, 0};
  int words = 0;       ///< a row
  Vec3 lower;          ///< the grid's lowest corner, mm
  double spacing = 1;  ///< edge of a voxel, mm
  std::vector<std::uint64_t> bits;
  int closed_holes = 0;  ///< small holes of the surface that had to be closed on the way

  VoxelGrid() = default;
  explicit VoxelGrid(const Index3& n)
      : size(n),
        words(n[0] / 64 + 1),
        bits(static_cast<std::size_t>(n[1]) * static_cast<std::size_t>(n[2]) *
             static_cast<std::size_t>(words)) {}

  [[nodiscard]] std::size_t row_offset(int j, int k) const {
    return (static_cast<std::size_t>(k) * static_cast<std::size_t>(size[1]) + static_cast<std::size_t>(j)) *
           static_cast<std::size_t>(words);
  }
  [[nodiscard]] std::uint64_t* row(int j, int k) { return bits.data() + row_offset(j, k); }
  [[nodiscard]] const std::uint64_t* row(int j, int k) const { return bits.data() + row_offset(j, k); }
  [[nodiscard]] bool test(int i, int j, int k) const { return ((row(j, k)[i / 64] >> (i % 64)) & 1) != 0; }
  void set(int i, int j, int k) { row(j, k)[i / 64] |= std::uint64_t{1} << (i % 64); }
  [[nodiscard]] std::size_t count() const {
    std::size_t n = 0;
    for (const std::uint64_t word : bits) n += static_cast<std::size_t>(std::popcount(word));
    return n;
  }
};

struct VoxelOptions {
  /// How inside is told: by parity of the crossings of the grid lines through voxel centres, which asks for a
  /// closed surface; or by the generalised winding number (Jacobson et al. 2013), which closes any opening as
  /// a soap film would but asks for triangles that agree on what is outside.
  enum class Fill { crossings, winding };

  int resolution = 30;  ///< voxels along the longest axis, 1 to max_resolution
  bool border = true;   ///< also every voxel that the surface touches, as in the paper
  Fill fill = Fill::crossings;
  /// `crossings` closes holes up to one voxel wide, and up to this part of the longest axis; the width is the
  /// root of the area of the lid. Scans stand on such holes: the bunny's widest takes 0.12.
  double largest_hole = 0.15;

  static constexpr int max_resolution = 1024;
};

/// The voxels whose centre lies inside the surface, and with `border` those it touches. Facing of triangles
/// does not matter to `crossings`; what overlaps is joined, a shell wholly within another is a cavity, one
/// within that a body again. Exact: positions are rounded once to 2^-19 of a voxel or finer, and then every
/// test is decided in integers, with ties broken as if the grid lay a little aside, so that no line passes
/// between two triangles. The same bits on any number of threads.
/// Errors: nothing to mesh; coordinates not finite; an index out of range; no extent; a surface that is open
/// (`where` names the place and size of its largest hole, mm); no voxel inside; cancelled.
Result<VoxelGrid> voxelise(const TriMesh& surface, const VoxelOptions& options,
                           const Context& context = Context{});

/// Error where there are more than 2^31 - 1 indices to hold.
Result<SolidMesh> solid_of(const VoxelGrid& voxels);

/// The cubes that the tetrahedra came from, over the same points: cube c is tetrahedra 5 c to 5 c + 4.
/// Corners in the order of VTK and Abaqus: anticlockwise below, then above.
std::vector<std::array<int, 8>> hexahedra(const SolidMesh& solid);

}  // namespace turgor
