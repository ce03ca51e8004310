// Surfaces of equal value in a volume.
#pragma once

#include "turgor/core/context.hpp"
#include "turgor/geometry/tri_mesh.hpp"
#include "turgor/imaging/volume.hpp"

namespace turgor {

/// Triangles where the trilinear field crosses `level`, normals towards smaller values. Marching cubes whose 256
/// cases are generated from one rule (on an ambiguous face the inside corners are kept apart), so neighbouring cells
/// always match: the result is a closed manifold except where the surface meets the end of the volume. Points are
/// shared, in LPS mm. With `close_at_border` the volume counts as surrounded by values below the level, so the surface
/// is closed there too (flat, half a voxel outside at most). Deterministic for any number of threads.
TriMesh isosurface(const CtVolume& volume, double level, bool close_at_border = false);
/// The same of a label mask (level 0.5): inside = voxels with `mask != 0`.
TriMesh isosurface(const LabelVolume& mask, double level = 0.5, bool close_at_border = false);
/// Of the CT field, but only within voxels near `mask`: values outside the mask dilated by one voxel count as
/// `outside_value`, so that a labelled body gets its own sub-voxel surface.
TriMesh isosurface_within(const CtVolume& volume, double level, const LabelVolume& mask, std::uint8_t label,
                          std::int16_t outside_value, bool close_at_border = false);

/// Moves each point along its normal to the place where the value is midway between the tissues on either side there
/// (the plateaus of the profile within `reach_mm`), so that partial volume does not shift the surface. Points whose
/// profile has no clear step keep their place. Returns the number of points moved.
int refine_to_local_level(TriMesh& mesh, const CtVolume& volume, double reach_mm, double max_shift_mm);

}  // namespace turgor
