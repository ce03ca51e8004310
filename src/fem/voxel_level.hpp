// A lattice of cubes, and the coarser one of cubes twice as large. Internal.
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "fem/voxel_operator.hpp"

namespace turgor::detail {

/// A node whose interpolation from the coarser lattice is not that of its place: one that has a double there,
/// or is one.
struct OddNode {
  NodePlace node;
  int count = 0;
  std::array<NodePlace, 8> coarse;
  std::array<float, 8> weight{};
};

/// Cells are there as `shear` and `bulk` say, or with a matrix of their own. Coarse ones have the Galerkin
/// product of their children with the components that are held left out, so that no coarse lattice has to
/// know the boundary. What shares no node on the finest lattice shares none on any: where parts of the body
/// lie so close that their coarse cells meet or coincide, there are several cells in one place and doubles of
/// nodes, kept as extra nodes of the rows.
struct VoxelLevel {
  VoxelLevel() = default;
  VoxelLevel(const VoxelLevel&) = delete;  // its operator refers to it
  VoxelLevel& operator=(const VoxelLevel&) = delete;

  VoxelRows rows;
  std::vector<CellSpan> spans;
  CubeStiffness stiffness;         ///< of a cell of unit moduli
  std::vector<float> shear, bulk;  ///< of each cell of the rows
  DenseCells dense;                ///< those of one place follow one another
  std::vector<int> dense_of;  ///< the first of them for each cell of the rows, −1: none; empty: none at all
  std::vector<std::uint8_t> held_cell;  ///< on the finest: whether a component of the cell's nodes is held
  std::vector<OddNode> odd_nodes;       ///< those of this lattice, set with the coarser one
  /// 1 / diagonal of each value, 0 where it is held or no cell is.
  std::vector<float> scaling;
  std::unique_ptr<VoxelOperator<float>> stiffness_operator;
  double largest_eigenvalue = 1;  ///< of scaling · stiffness

  [[nodiscard]] bool regular(std::size_t cell) const {
    return cell < rows.cell_count && (shear[cell] != 0 || bulk[cell] != 0);
  }
  /// Once the cells are known; `held`: of each value, or empty.
  void finish(const std::vector<std::uint8_t>& held);
};

/// Values of the 24 unknowns of a cell, numbered as in CubeMatrix.
std::array<std::size_t, kCubeUnknowns> unknowns_of(const std::array<NodePlace, 8>& corners);

/// `held`: of each value of `fine`, or empty where `fine` is not the finest. Sets the odd nodes of `fine`.
std::unique_ptr<VoxelLevel> coarser(VoxelLevel& fine, const std::vector<std::uint8_t>& held);

/// coarse = Pᵀ fine (`from` is changed on the way and given back), and fine = P coarse where fine.scaling is
/// not zero.
void restrict_values(const VoxelLevel& fine, float* from, const VoxelLevel& coarse, float* to);
void prolong_values(const VoxelLevel& coarse, const float* from, const VoxelLevel& fine, float* to);

}  // namespace turgor::detail
