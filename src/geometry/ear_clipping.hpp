// Polygons with holes to triangles by bridges and ears (Meisters 1975; Eberly 1998). Internal to the module.
#pragma once

#include <vector>

#include "geometry/grid_points.hpp"

namespace turgor::detail {

/// One weakly simple polygon: the outer loop with each hole joined to it by a bridge that is walked both
/// ways.
std::vector<int> with_bridges(const std::vector<GridPoint>& grid, const std::vector<int>& outer,
                              std::vector<std::vector<int>> holes);

/// n - 2 triangles over a polygon of n points, always; where no ear is left (the polygon crosses itself) the
/// least bad corner is cut. A uniform grid over the reflex corners keeps the usual time near linear.
std::vector<Index3> clip_ears(const std::vector<GridPoint>& grid, const std::vector<int>& polygon);

}  // namespace turgor::detail
