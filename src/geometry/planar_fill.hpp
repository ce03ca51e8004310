// Triangles over a plane region bounded by loops. Internal to the module.
#pragma once

#include <array>
#include <vector>

#include "turgor/math/vec.hpp"

namespace turgor::detail {

using Vec2 = std::array<double, 2>;

struct DirectedEdge {
  int from, to;
};

/// Closed loops of directed edges that bound a region on their left. Where several loops share a point, each
/// goes on along the same piece of the region, so loops touch but never cross. Open chains are left out.
std::vector<std::vector<int>> trace_loops(const std::vector<Vec2>& points,
                                          const std::vector<DirectedEdge>& edges);

/// Fills the region with triangles (anticlockwise, no new points, Delaunay where the loops allow). Outer
/// loops run anticlockwise, holes clockwise, nested to any depth. Every loop edge is used by exactly one
/// triangle, whatever the geometry: loops that cross each other still give a closed cap, only not a flat one.
std::vector<Index3> fill_loops(const std::vector<Vec2>& points, const std::vector<std::vector<int>>& loops);

}  // namespace turgor::detail
