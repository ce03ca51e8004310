// Newton's method for the equilibrium of a network whose prescribed points stand still, under what else acts
// on its points.
#pragma once

#include <vector>

#include "dynamics/block_cg.hpp"
#include "dynamics/point_clusters.hpp"
#include "dynamics/point_terms.hpp"
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
  /// `energy` must outlive it; `free`: the points that may move; `turns`: steps follow the rotations of
  /// the parts of a body, as solids bend far.
  Newton(const NetworkEnergy& energy, PointClusters free, bool turns);

  /// The free points, in the order of the rows.
  [[nodiscard]] const std::vector<int>& unknowns() const { return matrix_.unknowns(); }
  /// Starts another solve with the same pattern, under `terms` (or none), which must outlive it; `damping`
  /// relative to the mean of the matrix' diagonal, for a matrix that is singular.
  void restart(const PointTerms* terms, double damping);
  static constexpr double kSingularDamping = 1e-4;

  /// Energy and forces at state.positions. False where they are not finite.
  bool evaluate(EquilibriumState& state);
  /// Moves the prescribed points to `targets` (by point) and the free ones by the linear answer to that,
  /// unless leaving them where they are costs less energy. False where no state has finite forces.
  Result<bool> predict(EquilibriumState& state, const std::vector<Vec3>& targets, const Context& context);
  /// Newton steps until the relative residual is at most `tolerance`, `step_limit` steps are done in all, or
  /// no step lowers the energy.
  Result<bool> descend(EquilibriumState& state, double tolerance, int step_limit, Context& context);

  [[nodiscard]] double reaction_norm(const EquilibriumState& state) const;
  [[nodiscard]] double free_norm(const EquilibriumState& state) const;
  [[nodiscard]] double relative_residual(const EquilibriumState& state) const;
  [[nodiscard]] double largest_free_force(const EquilibriumState& state) const;
  [[nodiscard]] int steps() const { return steps_; }
  [[nodiscard]] int linear_iterations() const { return linear_iterations_; }

 private:
  Result<void> find_direction(const EquilibriumState& state, double tolerance, const Context& context);
  CgResult solve_linear(const EquilibriumState& state, double projection, double tolerance,
                        const Context& context);
  bool search(EquilibriumState& state);
  double slope_along_direction(const EquilibriumState& state) const;
  void find_spin(const EquilibriumState& state);
  void step_to(const EquilibriumState& from, double t, EquilibriumState& to) const;
  void adapt_damping(double accepted_step);

  const NetworkEnergy& energy_;
  const PointTerms* terms_ = nullptr;
  StiffnessMatrix matrix_;
  BlockCg cg_;
  bool turns_;
  double force_scale_, start_norm_ = 0;
  std::vector<char> is_free_;
  ElementStiffness stiffness_;
  NetworkEnergy::Workspace workspace_;
  std::vector<Vec3> load_, direction_, spin_;  // by unknown
  std::vector<Vec3> shift_;                    // the direction by point
  EquilibriumState trial_;
  double damping_ = 0;
  double projection_ = 0;
  int since_indefinite_ = 0;
  int steps_ = 0, linear_iterations_ = 0;
};

}  // namespace turgor
