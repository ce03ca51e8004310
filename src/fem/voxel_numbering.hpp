// From the points and cubes of a solid to the rows of its lattice. Internal.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "fem/voxel_rows.hpp"
#include "turgor/core/error.hpp"
#include "turgor/geometry/solid_mesh.hpp"

namespace turgor::detail {

struct VoxelNumbering {
  VoxelRows rows;
  std::vector<CellSpan> spans;
  std::vector<NodePlace> nodes;           ///< of each point; none for a point of no cube
  std::vector<std::array<int, 8>> cubes;  ///< nodes, in the order of hexahedra()
  std::vector<Index3> cells;              ///< of each cube, in the lattice

  /// Error: not the cubes of a lattice, each once, with one point a corner.
  static Result<VoxelNumbering> of(const SolidMesh& solid);

  /// Pairs of cubes that share a face.
  void face_pairs(const std::function<void(int, int)>& pair) const;
  [[nodiscard]] std::size_t cell(std::size_t cube) const {
    return rows.cell(cells[cube][0], cells[cube][1], cells[cube][2]);
  }
  void scatter(std::span<const Vec3> of_nodes, std::vector<double>& values) const;
  [[nodiscard]] std::vector<Vec3> gather(const std::vector<double>& values) const;
};

/// The corner, by bits x 1, y 2, z 4, of each of a hexahedron's corners in the order of VTK.
inline constexpr std::array<int, 8> kCornerBits{0, 1, 3, 2, 4, 5, 7, 6};

}  // namespace turgor::detail
