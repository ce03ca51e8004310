// Surfaces of equal value in a volume.
#pragma once

#include "turgor/core/context.hpp"
#include "turgor/geometry/tri_mesh.hpp"
#include "turgor/imaging/volume.hpp"

namespace turgor {

/// Triangles where the trilinear field crosses `level`, normals towards smaller values. Marching cubes whose
/// 256 cases are generated from one rule (on an ambiguous face the inside corners are kept apart), so
/// neighbouring cells always match: the result is a closed manifold except where the surface meets the end of
/// the volume. Points are shared, in LPS mm. With `close_at_border` the volume counts as surrounded by values
/// below the level, so the surface is closed there too (flat, half a voxel outside at most). Deterministic
/// for any number of threads.
TriMesh isosurface(const CtVolume& volume, double level, bool close_at_border = false);
/// The same of a label mask (level 0.5): inside = voxels with `mask != 0`.
TriMesh isosurface(const LabelVolume& mask, double level = 0.5, bool close_at_border = false);
/// Of the CT field, but only within voxels near `mask`: values outside the mask dilated by one voxel (26
/// neighbours) and those of voxels with another label count as `outside_value`, so that a labelled body gets
/// its own sub-voxel surface. Empty where the two volumes differ in size.
TriMesh isosurface_within(const CtVolume& volume, double level, const LabelVolume& mask, std::uint8_t label,
                          std::int16_t outside_value, bool close_at_border = false);

/// Surface between the voxels with `label` and all others: the mask alone says what is inside, the CT says
/// where the surface lies between two voxels. Where CT and mask agree this is the iso-surface of the CT;
/// where they do not (a closed nostril, two bones that touch, a filled hole) it runs midway between voxels
/// alike. Everything that a mask has filled stays filled, so there are as many closed surfaces as the mask
/// has. Empty where the sizes differ.
TriMesh isosurface_of_label(const CtVolume& volume, double level, const LabelVolume& mask,
                            std::uint8_t label = 1, bool close_at_border = false);

/// Moves each point along its normal to the place where the value is midway between the tissues on either
/// side there (the plateaus of the profile within `reach_mm`, and the nearest step within `max_shift_mm`), so
/// that partial volume does not shift the surface. The peak of a plate thinner than about three times the
/// blur is lower than its tissue, which puts the middle too far out; that much is taken off again, the blur
/// being found from the steps of the mesh that have no other side near. Points whose profile has no clear
/// step (100 HU) keep their place. Shifts are averaged once over the neighbours. Returns the number of points
/// moved. Meant for a mesh of about the voxels' fineness or coarser; a reach of two to three voxels and a
/// shift of one to two suit a head.
int refine_to_local_level(TriMesh& mesh, const CtVolume& volume, double reach_mm, double max_shift_mm);

}  // namespace turgor
