// Bones that touch in the voxels, parted where the bridge between them is weakest.
#pragma once

#include "turgor/imaging/volume.hpp"

namespace turgor {

/// Gives each voxel of `bone` (mask ≠ 0) the label of the marker from which it is reached by the densest
/// path: the path whose least dense voxel is densest (watershed by flooding, Meyer 1994, on Hounsfield
/// units). Bones that touch are so parted along the joint space, whose voxels hold less bone than either
/// side; where there is no such seam, midway. `markers`: 0 none, else a label; markers outside `bone` count
/// for nothing. Voxels that no marker reaches become 0. Labels advance through shared faces.
LabelVolume flood_by_density(const CtVolume& hu, const LabelVolume& bone, const LabelVolume& markers);

}  // namespace turgor
