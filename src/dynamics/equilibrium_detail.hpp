// What solves for equilibrium share. Internal to the module.
#pragma once

#include "dynamics/newton.hpp"
#include "turgor/dynamics/equilibrium.hpp"

namespace turgor::detail {

Result<void> check_options(const EquilibriumOptions& options);
/// What is known of a final state; warns where it is not at rest.
EquilibriumResult result_of(const Newton& newton, const NetworkEnergy& energy, EquilibriumState state,
                            const EquilibriumOptions& options, bool converged, Context& context);

}  // namespace turgor::detail
