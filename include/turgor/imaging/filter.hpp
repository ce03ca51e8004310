// Noise filters on volumes.
#pragma once

#include "turgor/imaging/volume.hpp"

namespace turgor {

/// The exact median of the 3×3×3 voxels around each voxel; beyond the border the outermost voxels repeat.
/// Removes noise and single voxels and keeps edges, but also removes plates and cords thinner than two
/// voxels.
CtVolume median_filter(const CtVolume& volume);

}  // namespace turgor
