// Points of a plane on a fine integer grid, where orientation and order are exact. Internal to the module.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <vector>

#include "geometry/planar_fill.hpp"

namespace turgor::detail {

__extension__ using Wide = __int128;

struct GridPoint {
  std::int64_t x = 0, y = 0;
  bool operator==(const GridPoint&) const = default;
  /// By x, then by y.
  bool operator<(const GridPoint& b) const { return x != b.x ? x < b.x : y < b.y; }
};

/// Twice the signed area of abc: positive where anticlockwise.
inline Wide orientation(const GridPoint& a, const GridPoint& b, const GridPoint& c) {
  return static_cast<Wide>(b.x - a.x) * (c.y - a.y) - static_cast<Wide>(b.y - a.y) * (c.x - a.x);
}
inline int sign(Wide w) {
  return w > 0 ? 1 : w < 0 ? -1 : 0;
}

/// Whether p lies in the anticlockwise triangle abc or on its edges.
inline bool in_triangle(const GridPoint& p, const GridPoint& a, const GridPoint& b, const GridPoint& c) {
  return orientation(a, b, p) >= 0 && orientation(b, c, p) >= 0 && orientation(c, a, p) >= 0;
}

/// The points on a grid of 2^-40 of their extent.
inline std::vector<GridPoint> on_grid(const std::vector<Vec2>& points) {
  std::vector<GridPoint> grid(points.size());
  if (points.empty()) return grid;
  Vec2 lower = points[0], upper = points[0];
  for (const Vec2& p : points) {
    for (std::size_t i = 0; i < 2; ++i)
      lower[i] = std::min(lower[i], p[i]), upper[i] = std::max(upper[i], p[i]);
  }
  const double extent = std::max({upper[0] - lower[0], upper[1] - lower[1], 1e-300});
  const double scale = 0x1p40 / extent;
  for (std::size_t i = 0; i < points.size(); ++i) {
    grid[i] = {std::llround((points[i][0] - lower[0]) * scale),
               std::llround((points[i][1] - lower[1]) * scale)};
  }
  return grid;
}

}  // namespace turgor::detail
