// Solids that are fine along their surface and coarse within: the future work of Morris (2006), section 5.1.
#pragma once

#include <vector>

#include "turgor/core/context.hpp"
#include "turgor/core/error.hpp"
#include "turgor/geometry/voxel_solid.hpp"

namespace turgor {

struct GradedOptions {
  VoxelOptions voxels;     ///< the finest cells: `resolution` along the longest axis
  int levels = 3;          ///< the coarsest cells have 2^levels finest ones along an edge; 0: all the finest
  std::vector<Box3> fine;  ///< mm; the finest cells alone within these

  /// Above 0: cells are coarse along the surface too where its triangles, over the cell and those around it,
  /// face within this angle of one another: fine cells follow edges, curvature and thin parts. A coarse cell
  /// takes in all of its cube, so the solid grows by up to a coarse cell there, as by `border` by a voxel.
  double smooth_deg = 0;

  static constexpr int max_levels = 4;
  static constexpr double most_smooth_deg = 90;
};

/// An octree of the voxels inside a surface, its cells as tetrahedra that share whole faces. A cell is as
/// coarse as it can be while all around it are cells of its own size or the next finer one, also across edges
/// and corners: so the finest lie along the whole surface and throughout thin parts, and sizes grow by two.
/// The surface, and the volume, are those of solid_of(voxels).
///
/// Cells with no finer neighbour are five tetrahedra, as in solid_of; the others are cones from their centre
/// over their sides, and sides of which an edge or the whole is halved are fans about their own centre. On
/// every lattice diagonals join corners whose coordinates have an even sum: two cells agree on the side
/// between them, also where they differ in size. There are but few shapes, with dihedral angles from 45° to
/// 120° and radius ratios of 0.64 or more. A coarse cell alone
/// among finest ones takes 48 tetrahedra for their 40, whole layers of them take far fewer.
/// `spacing` of the result is 0. Errors: levels beyond 0 to max_levels, a box that is not finite; those of
/// voxelise and solid_of.
Result<SolidMesh> graded_solid(const TriMesh& surface, const GradedOptions& options,
                               const Context& context = Context{});
/// The same with the surface's voxels at hand.
Result<SolidMesh> graded_solid(const VoxelGrid& voxels, const TriMesh& surface, const GradedOptions& options);
/// Of voxels that have no surface.
Result<SolidMesh> graded_solid(const VoxelGrid& voxels, int levels, const std::vector<Box3>& fine = {});

}  // namespace turgor
