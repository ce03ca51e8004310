// Where a surface is open: what voxelise closes, or calls a leak.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "turgor/core/error.hpp"
#include "turgor/geometry/tri_mesh.hpp"

namespace turgor {

/// Edges that an odd number of triangles use, joined at their ends. mm.
struct SurfaceHole {
  std::vector<std::array<Vec3, 2>> rim;
  Vec3 middle;        ///< of the ends of the edges
  Vec3 normal;        ///< unit, across the lid: a cone from `middle` over the rim; either way. Zero: no area
  double radius = 0;  ///< of a disc as large as the lid
  Box3 box;           ///< of the rim

  /// "hole of 9 x 9 x 0 mm about (4, 5, 6) mm"
  [[nodiscard]] std::string text() const;
};

/// Widest first; empty where the surface is closed. Points at one place, to 2^-19 of the longest axis or
/// finer, count as one. Errors: no triangles, coordinates not finite, an index out of range, no extent.
Result<std::vector<SurfaceHole>> surface_holes(const TriMesh& surface);

}  // namespace turgor
