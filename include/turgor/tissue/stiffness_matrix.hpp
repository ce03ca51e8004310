// The Hessian of a network assembled over the points that may move: a symmetric sparse matrix of 3×3 blocks.
#pragma once

#include <span>
#include <vector>

#include "turgor/tissue/network_energy.hpp"

namespace turgor {

/// Rows and columns are the unknown points in the order given, all other points being held. Both triangles
/// are stored; columns ascend within a row; every row has its diagonal block. The pattern is made once,
/// assemble() refills it in parallel, row by row, in a fixed order.
class StiffnessMatrix {
 public:
  /// `unknowns`: point numbers, each at most once.
  StiffnessMatrix(const NetworkEnergy& energy, std::vector<int> unknowns);

  void assemble(const NetworkEnergy& energy, const ElementStiffness& stiffness);
  /// After assemble(): what else holds the point of one row, symmetric, N/mm.
  void add_to_diagonal(int row, const Mat3& block);

  [[nodiscard]] int rows() const { return static_cast<int>(unknowns_.size()); }
  [[nodiscard]] const std::vector<int>& unknowns() const { return unknowns_; }
  /// Blocks of row i: offsets()[i] to offsets()[i + 1].
  [[nodiscard]] const std::vector<int>& offsets() const { return offsets_; }
  [[nodiscard]] const std::vector<int>& columns() const { return columns_; }
  [[nodiscard]] const std::vector<Mat3>& blocks() const { return blocks_; }
  /// Number of the diagonal block of each row.
  [[nodiscard]] const std::vector<int>& diagonal() const { return diagonal_; }

 private:
  void make_pattern(const NetworkEnergy& energy);
  void make_slots(const NetworkEnergy& energy);
  void assemble_row(const NetworkEnergy& energy, const ElementStiffness& stiffness, int row);
  [[nodiscard]] int slot(int row, int point) const;

  std::vector<int> unknowns_, row_of_point_;
  std::vector<int> offsets_, columns_, diagonal_;
  // Where each element at a row's point adds its blocks: one slot per other corner, -1 where that corner is
  // held.
  std::vector<int> slot_offsets_, slots_;
  std::vector<Mat3> blocks_;
};

}  // namespace turgor
