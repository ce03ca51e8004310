// A lattice of cubes, and the coarser one of cubes twice as large. Internal.
#pragma once

#include <algorithm>
#include <cstdint>
#include <memory>
#include <span>
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

/// A plane that a node of the finest lattice lies on: its motion along the normal is held, where the plane is
/// stiff, or resisted. Stiffness in the units of the lattice.
struct NodePlane {
  NodePlace node;
  std::size_t cell = 0;           ///< that counts the stiffness among its own
  std::array<float, 3> normal{};  ///< unit; 0 in components that are held
  float stiffness = 0;
  bool holds = false;
};

/// Those of a range of values, of planes by rising value of their nodes.
inline std::span<const NodePlane> planes_in(std::span<const NodePlane> planes, std::size_t begin,
                                            std::size_t end) {
  const auto before = [](const NodePlane& p, std::size_t value) { return p.node.value < value; };
  const auto first = std::lower_bound(planes.begin(), planes.end(), begin, before);
  return {first, std::lower_bound(first, planes.end(), end, before)};
}
inline float along_normal(const NodePlane& plane, const float* values) {
  float sum = 0;
  for (std::size_t c = 0; c < 3; ++c) sum += plane.normal[c] * values[plane.node.component(c)];
  return sum;
}
inline void add_along_normal(const NodePlane& plane, float amount, float* values) {
  for (std::size_t c = 0; c < 3; ++c) values[plane.node.component(c)] += plane.normal[c] * amount;
}
/// Takes out of vectors what lies along the normals of planes that hold.
inline void project(std::span<const NodePlane> planes, float* values) {
  for (const NodePlane& p : planes)
    if (p.holds) add_along_normal(p, -along_normal(p, values), values);
}

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
  std::unique_ptr<DenseBlocks> dense_blocks;
  std::vector<int> dense_of;  ///< the first of them for each cell of the rows, −1: none; empty: none at all
  /// On the finest: whether a component of the cell's nodes is held, or lies on a plane.
  std::vector<std::uint8_t> held_cell;
  std::vector<NodePlane> planes;   ///< on the finest, by rising value of their nodes
  std::vector<int> plane_of;       ///< of each value that is a node's first; −1: none; empty: none at all
  std::vector<OddNode> odd_nodes;  ///< those of this lattice, set with the coarser one
  /// 1 / diagonal of each value, 0 where it is held or no cell is.
  std::vector<float> scaling;
  std::unique_ptr<VoxelOperator<float>> stiffness_operator;
  double largest_eigenvalue = 1;  ///< of scaling · stiffness

  [[nodiscard]] bool regular(std::size_t cell) const {
    return cell < rows.cell_count && (shear[cell] != 0 || bulk[cell] != 0);
  }
  /// out = Z (K + stiffness of planes that only resist) in, Z taking out what planes hold.
  void apply(std::span<const NodePlane> on, const float* in, float* out, const PlaneDone& done) const;
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
