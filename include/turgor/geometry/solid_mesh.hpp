// A solid of tetrahedra with its surface marked: what the mesh generators make and the solvers take.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "turgor/geometry/bulk_array.hpp"
#include "turgor/geometry/tri_mesh.hpp"

namespace turgor {

/// Points in mm. All tetrahedra have positive volume, ⅙ (b − a)·((c − a) × (d − a)), and share whole faces.
/// With `spacing` above 0 they are the cubes of a lattice, five tetrahedra each in two mirrored patterns that
/// alternate, cube c having numbers 5 c to 5 c + 4, cubes and points in the order x, then y, then z.
struct SolidMesh {
  BulkArray<Vec3> points;
  BulkArray<std::array<int, 4>> tetrahedra;
  BulkArray<Index3> surface_triangles;   ///< anticlockwise seen from outside
  BulkArray<int> surface_cells;          ///< the tetrahedron behind each of them
  std::vector<std::uint8_t> on_surface;  ///< one a point: 1 on the surface, 0 within
  double spacing = 0;                    ///< edge of a cube, mm; 0: not the cubes of a lattice
};

}  // namespace turgor
