// The face as cubes after a plan, by the constitutive law and by tetrahedra.
#pragma once

#include "turgor/core/context.hpp"
#include "turgor/world/prediction.hpp"

namespace turgor {

/// Fills the prediction's surface points, cubes, counts and times. Errors: those of build_face_solid(),
/// VoxelElasticity and solve_equilibrium(); nothing moves; no equilibrium.
Result<void> solve_cubes(const PatientCase& patient, Solver solver, const CubeOptions& options,
                         const EquilibriumOptions& equilibrium, Prediction& prediction, Context& context);

}  // namespace turgor
