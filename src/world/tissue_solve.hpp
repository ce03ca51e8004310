// The tissue after a plan by either solver.
#pragma once

#include "turgor/core/context.hpp"
#include "turgor/world/prediction.hpp"
#include "world/bone_contact.hpp"
#include "world/tissue_motion.hpp"

namespace turgor {

/// Fill the prediction's tissue points, counts and times. Errors: those of the networks and solvers; no
/// equilibrium.
Result<void> solve_chain(const PatientCase& patient, const ChainParameters& parameters,
                         const TissueMotion& tissue, const BoneContact& bone, Prediction& prediction);
Result<void> solve_network(const PatientCase& patient, const EquilibriumOptions& options,
                           const TissueMotion& tissue, const BoneContact& bone, Prediction& prediction,
                           Context& context);

}  // namespace turgor
