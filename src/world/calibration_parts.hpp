// Parts of a calibration case: which points a region holds, what a load puts on them, loads made up, and the
// network whose constants are fitted. Internal to world.
#pragma once

#include "turgor/fem/voxel_elasticity.hpp"
#include "turgor/world/calibration_case.hpp"
#include "turgor/world/network_fit.hpp"

namespace turgor {

/// Ascending. Errors: none.
Result<std::vector<int>> points_in(const RestRegion& region, const SolidMesh& mesh, bool surface_only);
/// Whether the cube's centre lies in the region, one a cube. Errors: of none.
Result<std::vector<char>> cubes_in(const RestRegion& region, const SolidMesh& mesh);

/// The load without its reference. `held`: ascending. Errors: a region without points, sides of cubes, or
/// points that may move; a load without forces.
Result<PreparedLoad> place_load(const CalibrationLoad& load, const SolidMesh& mesh,
                                std::span<const int> held);

/// `hooke`: the reference under Hooke's law, of which only `held` is held. `loads`: those there are, with
/// their references.
Result<std::vector<PreparedLoad>> probing_loads(const ProbeOptions& options, const SolidMesh& mesh,
                                                std::span<const int> held, const VoxelElasticity& hooke,
                                                std::span<const PreparedLoad> loads, Context& context);

/// All that holds the body: `held`, and what the load displaces.
ElasticSupports supports_of(std::span<const int> held, const PreparedLoad& load);
ElasticLoad elastic_load(const PreparedLoad& load);

NetworkLoad network_load(const PreparedLoad& load, const SolidMesh& mesh, std::span<const int> held);

}  // namespace turgor
