// Equilibrium of a body on a lattice: Newton's method on the energy. For Hooke's law without contacts that is
// one linear system. Internal.
#pragma once

#include <vector>

#include "fem/voxel_step.hpp"
#include "turgor/core/context.hpp"

namespace turgor::detail {

class VoxelSolver {
 public:
  VoxelSolver(const VoxelProblem& problem, std::vector<double> force, Context& context);
  /// `start`: values to begin from, or empty.
  Result<ElasticSolution> solve(const std::vector<double>& start);

 private:
  void evaluate(VoxelState& state) const;
  [[nodiscard]] bool is_linear() const { return problem_.contacts.empty() && problem_.laws == nullptr; }
  Result<ElasticSolution> solve_large(const std::vector<double>& start);
  Result<double> predict(double part);
  [[nodiscard]] double forcing() const;
  Result<bool> correct(double relative);
  [[nodiscard]] double rounding() const;
  bool line_search();
  void move_to(double t);
  [[nodiscard]] ElasticSolution solution() const;

  const VoxelProblem& problem_;
  std::vector<double> force_;
  Context& context_;
  VoxelState state_, trial_;
  VoxelStep step_;
  double norm_before_ = 0;
  int newton_steps_ = 0;
  std::size_t turned_over_ = 0;  // most cubes of any state tried
  double whole_ = 0, target_ = 0;
};

}  // namespace turgor::detail
