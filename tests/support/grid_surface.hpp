// Flat grids of quadrilaterals for tests and benchmarks.
#pragma once

#include <array>
#include <vector>

#include "turgor/geometry/polyhedron.hpp"

namespace turgor::support {

/// Points row by row, x along a row, `spacing_mm` apart in the plane z = 0; squares facing +z.
inline Polyhedron make_grid(int columns, int rows, double spacing_mm = 1) {
  Polyhedron grid;
  for (int y = 0; y < rows; ++y) {
    for (int x = 0; x < columns; ++x) grid.points.push_back({x * spacing_mm, y * spacing_mm, 0});
  }
  for (int y = 0; y + 1 < rows; ++y) {
    for (int x = 0; x + 1 < columns; ++x) {
      const int p = y * columns + x;
      grid.add_polygon(std::array{p, p + 1, p + 1 + columns, p + columns});
    }
  }
  return grid;
}

/// The grid without the polygons for which drop(number) holds; every point stays.
template <class Drop>
Polyhedron without_polygons(const Polyhedron& grid, Drop&& drop) {
  Polyhedron rest;
  rest.points = grid.points;
  for (int i = 0; i < grid.polygon_count(); ++i) {
    if (!drop(i)) rest.add_polygon(grid.polygon(i));
  }
  return rest;
}

/// Columns of the fusiform wound of Pieper 1989 (section 6.1) in a sheet of 13 columns and 14 rows: eight
/// points are missing, which leaves 174.
inline std::vector<bool> wound_columns() {
  std::vector<bool> removed(std::size_t{13 * 14}, false);
  const std::array<std::array<int, 2>, 8> points{
      {{5, 6}, {6, 5}, {6, 6}, {6, 7}, {7, 5}, {7, 6}, {7, 7}, {8, 6}}};
  for (const auto& [row, column] : points) removed[static_cast<std::size_t>(row * 13 + column)] = true;
  return removed;
}

}  // namespace turgor::support
