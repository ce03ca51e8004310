#include "geometry/vtk_cells.hpp"

#include <fmt/format.h>

#include <cmath>
#include <limits>

#include "turgor/core/index.hpp"

namespace turgor::detail {

int whole_number(double value) {
  const bool whole = value >= 0 && value < std::numeric_limits<int>::max() && std::floor(value) == value;
  return whole ? static_cast<int>(value) : -1;
}

Result<void> VtkSurface::add_points(const std::vector<double>& coordinates) {
  piece_ = mesh_.points.size();
  const std::size_t count = coordinates.size() / 3;
  if (piece_ + count > static_cast<std::size_t>(std::numeric_limits<int>::max()))
    return source_.whole("has more points than can be numbered");
  mesh_.points.reserve(piece_ + count);
  for (std::size_t p = 0; p < count; ++p) {
    const Vec3 point{coordinates[3 * p], coordinates[3 * p + 1], coordinates[3 * p + 2]};
    if (!is_finite(point)) return source_.whole(fmt::format("point {} is not finite", p));
    mesh_.points.push_back(point);
  }
  return {};
}

void VtkSurface::add_cell(int type, std::span<const int> c) {
  if (type == vtk::triangle || type == vtk::polygon || type == vtk::quad) {
    add_polygon(mesh_, c);
  } else if (type == vtk::strip) {
    for (std::size_t i = 2; i < c.size(); ++i) {
      const bool odd = i % 2 == 1;
      add_polygon(mesh_, std::array{c[odd ? i - 1 : i - 2], c[odd ? i - 2 : i - 1], c[i]});
    }
  } else if (type == vtk::pixel && c.size() == 4) {
    add_polygon(mesh_, std::array{c[0], c[1], c[3], c[2]});
  }
}

Result<void> VtkSurface::add_cells(std::span<const double> types, const std::vector<double>& ends,
                                   const std::vector<double>& corners) {
  const std::size_t points = mesh_.points.size() - piece_;
  std::vector<int> cell;
  std::size_t from = 0;
  for (std::size_t n = 0; n < ends.size(); ++n, ++cells_) {
    const int end = whole_number(ends[n]);
    if (end < 0 || at(end) < from || at(end) > corners.size())
      return source_.whole(fmt::format("cell {} does not end within its list of points", n));
    cell.clear();
    for (; from < at(end); ++from) {
      const int p = whole_number(corners[from]);
      if (p < 0 || at(p) >= points)
        return source_.whole(fmt::format("cell {} names point {:g} of {}", n, corners[from], points));
      cell.push_back(p + static_cast<int>(piece_));
    }
    add_cell(whole_number(types.size() == 1 ? types[0] : types[n]), cell);
  }
  return {};
}

Result<TriMesh> VtkSurface::finish() {
  if (!mesh_.triangles.empty()) return std::move(mesh_);
  Error error = source_.whole("holds no triangles");
  if (cells_ > 0) error.remedy = "Export a surface of polygons (ParaView: Extract Surface)";
  return error;
}

}  // namespace turgor::detail
