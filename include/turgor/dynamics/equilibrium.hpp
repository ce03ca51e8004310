// Static equilibrium of a spring network: the positions at which every free point's force vanishes.
#pragma once

#include <vector>

#include "turgor/core/context.hpp"
#include "turgor/dynamics/chain.hpp"
#include "turgor/tissue/network.hpp"

namespace turgor {

struct EquilibriumOptions {
  double relative_residual = 1e-6;  ///< force norm over the norm at the start (or over the reactions)
  int max_newton_steps = 200;
  int load_steps = 1;               ///< prescribed motion applied in so many parts
};

struct EquilibriumResult {
  std::vector<Vec3> positions;     ///< mm, all points
  double residual_n = 0;           ///< largest force left on a free point, N
  double relative_residual = 0;
  double energy_nmm = 0;
  int newton_steps = 0;
  int linear_iterations = 0;
  bool converged = false;
};

/// Newton's method with a line search on the network's energy; the linear systems by preconditioned conjugate gradients
/// on the Hessian projected to be positive definite. Deterministic. `start` (optional) is a first guess.
Result<EquilibriumResult> solve_equilibrium(const SpringNetwork& network, const PrescribedMotion& motion,
                                            const EquilibriumOptions& options, Context& context,
                                            const std::vector<Vec3>* start = nullptr);

}  // namespace turgor
