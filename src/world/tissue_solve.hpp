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
Result<void> solve_network(const PatientCase& patient, const SolverOptions& options,
                           const TissueMotion& tissue, const BoneContact& bone, Prediction& prediction,
                           Context& context);

/// Solves, and lays the planes of the bone anew at the places where the last round left free inner ends,
/// until they no longer enter it; the last planes stay in the network. `start`: tissue points to begin from;
/// null: those that the plan suggests. `deepest_mm`: how far ends still reach into bone; may be null.
Result<EquilibriumResult> settle_network(const PatientCase& patient, const EquilibriumOptions& options,
                                         const TissueMotion& tissue, const BoneContact& bone,
                                         SpringNetwork& network, const std::vector<Vec3>* start,
                                         double* deepest_mm, Context& context);

}  // namespace turgor
