// Newton's method for the equilibrium of a network whose prescribed points stand still.
#pragma once

#include <vector>

#include "dynamics/block_cg.hpp"
#include "dynamics/point_clusters.hpp"
#include "turgor/core/context.hpp"
#include "turgor/tissue/network_energy.hpp"
#include "turgor/tissue/stiffness_matrix.hpp"

namespace turgor {

/// A state and what is known of it.
struct EquilibriumState {
  std::vector<Vec3> positions, forces;  // all points
  double energy = 0;
};

class Newton {
 public:
  /// `free`: the points that may move; `force_scale`: least reaction norm, N.
  Newton(const NetworkEnergy& energy, PointClusters free, double force_scale, Context& context);

  /// Energy and forces at state.positions. False where they are not finite.
  bool evaluate(EquilibriumState& state);
  /// Moves the prescribed points to `targets` (by point) and the free ones by the linear answer to that,
  /// unless leaving them where they are costs less energy. False where no state has finite forces.
  Result<bool> predict(EquilibriumState& state, const std::vector<Vec3>& targets);
  /// Newton steps until the relative residual is at most `tolerance`, `step_limit` steps are done in all, or
  /// no step lowers the energy.
  Result<bool> descend(EquilibriumState& state, double tolerance, int step_limit);

  [[nodiscard]] double reaction_norm(const EquilibriumState& state) const;
  [[nodiscard]] double free_norm(const EquilibriumState& state) const;
  [[nodiscard]] double relative_residual(const EquilibriumState& state) const;
  [[nodiscard]] double largest_free_force(const EquilibriumState& state) const;
  [[nodiscard]] int steps() const { return steps_; }
  [[nodiscard]] int linear_iterations() const { return linear_iterations_; }

 private:
  Result<void> find_direction(const EquilibriumState& state, double tolerance);
  CgResult solve_linear(const EquilibriumState& state, double projection, double tolerance);
  bool search(EquilibriumState& state);
  double slope_along_direction(const EquilibriumState& state) const;
  void step_to(const EquilibriumState& from, double t, EquilibriumState& to) const;
  void adapt_damping(double accepted_step);

  const NetworkEnergy& energy_;
  StiffnessMatrix matrix_;
  BlockCg cg_;
  Context& context_;
  double force_scale_, start_norm_ = 0;
  std::vector<char> is_free_;
  ElementStiffness stiffness_;
  NetworkEnergy::Workspace workspace_;
  std::vector<Vec3> load_, direction_;  // by unknown
  EquilibriumState trial_;
  double damping_ = 0;
  double projection_ = 0;
  int since_indefinite_ = 0;
  int steps_ = 0, linear_iterations_ = 0;
};

}  // namespace turgor
