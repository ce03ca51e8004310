// Static equilibrium of a spring network: the positions at which every free point's force vanishes.
#pragma once

#include <vector>

#include "turgor/core/context.hpp"
#include "turgor/dynamics/barrier.hpp"
#include "turgor/dynamics/grab.hpp"
#include "turgor/dynamics/prescribed_motion.hpp"
#include "turgor/tissue/network.hpp"

namespace turgor {

struct EquilibriumOptions {
  /// Norm of the forces on all free points over the norm of the reactions at the moved and fixed points or
  /// that of the constant loads, whichever is larger. Where these vanish at equilibrium, over a thousandth of
  /// the norm of the free points' forces at the start, or the forces that a strain of 1e-6 would make in
  /// every element, whichever is larger. Above 0.
  double relative_residual = 1e-4;
  int max_newton_steps = 200;  ///< of all load steps together, ≥ 1
  int load_steps = 1;          ///< prescribed motion applied in so many parts, ≥ 1
};

struct EquilibriumResult {
  std::vector<Vec3> positions;   ///< mm, all points
  double residual_n = 0;         ///< largest force left on a free point, N
  double relative_residual = 0;  ///< as in the options
  double reaction_n = 0;         ///< norm of the reactions at the moved and fixed points, N
  double energy_nmm = 0;         ///< loads included, work against constant ones counted from rest
  int newton_steps = 0;
  int linear_iterations = 0;
  int inverted_volumes = 0;  ///< flat or inverted at the end
  bool converged = false;
};

/// What acts on the free points beside the network, in equilibria and implicit steps. In equilibria points
/// without any element stay where they are, whatever acts on them.
struct Loads {
  std::vector<Vec3> force_n;  ///< on each point, N; or none
  Vec3 gravity_mm_ms2;        ///< acceleration on the points' masses
  std::vector<Barrier> barriers;
  std::vector<Grab> grabs;
};
/// Errors name what is out of range.
Result<void> validate(const Loads& loads, std::size_t point_count);

/// Newton's method with a line search on the network's energy; the linear systems by preconditioned conjugate
/// gradients on the Hessian, projected to be positive definite where it is not. Deterministic. The search
/// starts from the linear answer to the motion, or from `start` (one position per point; optional). Where it
/// does not converge the best state found comes back with converged = false and a warning. Errors: an invalid
/// network, motion, option or start; a motion so large that its forces are not finite; cancelled.
Result<EquilibriumResult> solve_equilibrium(const SpringNetwork& network, const PrescribedMotion& motion,
                                            const EquilibriumOptions& options, Context& context,
                                            const std::vector<Vec3>* start = nullptr);
/// The same under loads. A body that only barriers or grabs hold, or whose loads balance, comes to rest
/// somewhere near; one that nothing holds does not converge.
Result<EquilibriumResult> solve_equilibrium(const SpringNetwork& network, const PrescribedMotion& motion,
                                            const Loads& loads, const EquilibriumOptions& options,
                                            Context& context, const std::vector<Vec3>* start = nullptr);

}  // namespace turgor
