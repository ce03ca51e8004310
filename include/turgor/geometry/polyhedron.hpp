// Surfaces of polygons and polylines, as the objects of a scene and the sources of tissue are.
#pragma once

#include <array>
#include <span>
#include <vector>

#include "turgor/geometry/tri_mesh.hpp"

namespace turgor {

using Edge = std::array<int, 2>;  ///< point numbers, the smaller one first

/// Polygons of three or more corners, anticlockwise seen from outside, and loose segments.
/// Invariant (see validate): numbers in range, no polygon names a point twice, coordinates finite.
struct Polyhedron {
  std::vector<Vec3> points;
  std::vector<int> corners;  ///< point numbers, polygon after polygon
  std::vector<int> ends;     ///< end of each polygon in `corners`
  std::vector<Edge> lines;   ///< segments that bound no polygon, in any order of their ends

  [[nodiscard]] int polygon_count() const { return static_cast<int>(ends.size()); }
  [[nodiscard]] std::span<const int> polygon(int number) const {
    const int begin = number == 0 ? 0 : ends[static_cast<std::size_t>(number) - 1];
    return std::span(corners).subspan(
        static_cast<std::size_t>(begin),
        static_cast<std::size_t>(ends[static_cast<std::size_t>(number)] - begin));
  }
  void add_polygon(std::span<const int> polygon) {
    corners.insert(corners.end(), polygon.begin(), polygon.end());
    ends.push_back(static_cast<int>(corners.size()));
  }
};

/// Errors name the first polygon, line or point that breaks the invariant.
Result<void> validate(const Polyhedron& polyhedron);

Polyhedron to_polyhedron(const TriMesh& mesh);
/// Every polygon as triangles over the same points: quadrilaterals along their shorter diagonal (the one from
/// the first corner where both are equal), larger ones as fans. Lines are left out.
TriMesh triangulated(const Polyhedron& polyhedron);
/// Edges of all polygons, and all lines, each once, ascending.
std::vector<Edge> edges(const Polyhedron& polyhedron);
/// Mean of the unit normals of the polygons at each point, of unit length; zero where no polygon has the
/// point (Pieper 1989, section 5.6). A polygon's normal is that of its vector area.
std::vector<Vec3> vertex_normals(const Polyhedron& polyhedron);

}  // namespace turgor
