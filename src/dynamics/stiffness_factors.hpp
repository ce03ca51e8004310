// The stiffness matrix of a network factored directly, for several right-hand sides. Internal to the module.
#pragma once

#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "dynamics/block_cg.hpp"
#include "turgor/tissue/stiffness_matrix.hpp"

namespace turgor {

/// K = L D Lᵀ of its points in an order of small fill (minimum degree). For tens of thousands of points.
class StiffnessFactors {
 public:
  /// Nothing where the matrix is not positive definite beyond rounding.
  static std::optional<StiffnessFactors> of(const StiffnessMatrix& matrix,
                                            std::span<const CoupledStiffness> coupled);
  StiffnessFactors(StiffnessFactors&&) noexcept;
  StiffnessFactors& operator=(StiffnessFactors&&) noexcept;
  ~StiffnessFactors();

  /// Replaces each right-hand side, by row, with its solution. The same bits on any number of threads.
  void solve(std::span<std::vector<Vec3>> sides) const;

 private:
  struct Parts;
  explicit StiffnessFactors(std::unique_ptr<Parts> parts);
  std::unique_ptr<Parts> parts_;
};

}  // namespace turgor
