// How triangles hang together: corners around points, half-edges by edge. Internal to the module.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "turgor/geometry/tri_mesh.hpp"

namespace turgor::detail {

/// Corner c is corner c % 3 of triangle c / 3; half-edge c runs from that corner's point to the next one's.
inline int corner_point(const std::vector<Index3>& triangles, int corner) {
  return triangles[static_cast<std::size_t>(corner / 3)][static_cast<std::size_t>(corner % 3)];
}
inline int next_corner(int corner) {
  return corner % 3 == 2 ? corner - 2 : corner + 1;
}
inline int previous_corner(int corner) {
  return corner % 3 == 0 ? corner + 2 : corner - 1;
}

/// Lists of ints, one after the other.
struct Lists {
  std::vector<int> offsets;
  std::vector<int> items;
  [[nodiscard]] std::size_t size() const { return offsets.empty() ? 0 : offsets.size() - 1; }
  [[nodiscard]] std::span<const int> operator[](std::size_t i) const {
    return {items.data() + offsets[i], static_cast<std::size_t>(offsets[i + 1] - offsets[i])};
  }
};

/// The corners at each point, ascending.
Lists corners_by_point(std::size_t points, const std::vector<Index3>& triangles);

/// The half-edges of each undirected edge, ascending; edges sorted by (smaller point, larger point).
Lists half_edges_by_edge(std::size_t points, const std::vector<Index3>& triangles);

/// Makes every edge belong to at most two triangles, of opposite direction, and every point to one fan: pairs
/// of triangles on the same points that face each other are removed, and where more than one sheet meets in
/// an edge or a point, the point is doubled so that each sheet has its own; a sheet that passes twice through
/// one edge gets a new point in the middle of it. A closed oriented surface stays closed. `origin` (optional)
/// receives for each point the one of the input it came from (for a middle point, one end).
TriMesh separated_sheets(TriMesh mesh, std::vector<int>* origin = nullptr);

/// Drops the points that no triangle uses.
TriMesh without_unused_points(TriMesh mesh);

}  // namespace turgor::detail
