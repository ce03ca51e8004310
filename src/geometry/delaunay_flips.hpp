// Better-shaped triangles of a plane triangulation by edge flips. Internal to the module.
#pragma once

#include <vector>

#include "geometry/planar_fill.hpp"

namespace turgor::detail {

/// Lawson's flips (1977): edges shared by two triangles are turned where that widens the smallest angle.
/// Edges of one triangle stay, as do edges whose turned twin exists already.
void flip_to_delaunay(const std::vector<Vec2>& points, std::vector<Index3>& triangles);

}  // namespace turgor::detail
