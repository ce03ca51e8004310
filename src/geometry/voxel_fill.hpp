// Inside and outside from crossed links, by arithmetic on rows of bits. Internal.
#pragma once

#include <vector>

#include "geometry/voxel_crossings.hpp"
#include "geometry/voxel_lattice.hpp"
#include "turgor/geometry/surface_holes.hpp"

namespace turgor::detail {

/// Sets the voxels with an odd number of crossings below them along x. False where the links along y or z, or
/// the end of a row, say otherwise: the surface is open.
bool fill_by_parity(const CrossedLinks& links, VoxelGrid& inside);

/// The voxels joined to `seeds`, or to the rim of the grid, by links that nothing crosses.
VoxelGrid flood_outside(const CrossedLinks& links, VoxelGrid seeds);

/// A hole of the surface: edges that an odd number of triangles use, joined at their ends.
struct Hole {
  std::vector<std::array<LatticePoint, 2>> edges;
  LatticePoint low{}, high{}, middle{};
  double width = 0;  ///< root of the area of its lid, a cone from `middle`; lattice units
};
/// The same in the surface's coordinates.
SurfaceHole in_mm(const Hole& hole, const Lattice& lattice);
/// Widest first. Points at the same place count as one.
std::vector<Hole> find_holes(const Lattice& lattice);
/// Pairs of points of such edges that lie at one place, for surfaces whose triangles do not share points.
std::vector<std::array<int, 2>> coinciding_points(const Lattice& lattice);
/// Puts the lid on: after it, an even number of triangles use each of its edges. Adds points and
/// triangles to the lattice.
void close_hole(const Hole& hole, Lattice& lattice);

/// Decides `doubtful` voxels, which an even number of crossings shut off from outside: they lie where shells
/// overlap (inside), in a cavity or between folds (outside). Adds those inside to `inside`.
void resolve_shells(const Lattice& lattice, const VoxelGrid& doubtful, VoxelGrid& inside);

/// Sets the voxels whose centre has a generalised winding number above a half. Ends early when cancelled:
/// where far triangles cannot be told from near ones, each voxel takes time with each triangle.
void fill_by_winding(const TriMesh& surface, const CrossedLinks& links, VoxelGrid& inside,
                     const Context& context);

}  // namespace turgor::detail
