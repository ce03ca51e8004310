// Cells of VTK's files as triangles: VTK file formats, "Cell types". Internal to the module.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "geometry/mesh_readers.hpp"

namespace turgor::detail {

/// Numbers of the cell types that have triangles.
namespace vtk {
constexpr int triangle = 5, strip = 6, polygon = 7, pixel = 8, quad = 9;
}  // namespace vtk

/// A number of an array as a whole one; -1 where it is none, or none that can number something.
int whole_number(double value);

/// Gathers points and cells, piece by piece: cells name points of the piece begun last.
class VtkSurface {
 public:
  explicit VtkSurface(const MeshSource& source) : source_(source) {}

  /// Begins a piece. Three numbers a point. Errors: not finite; too many to number.
  Result<void> add_points(const std::vector<double>& coordinates);
  /// The cells of one list: corners one after the other, and the end of each cell among them. `types` holds
  /// one of a cell, or one for all. Cells without triangles (lines, volumes) are left out. Errors: corners
  /// that are not points, ends out of order.
  Result<void> add_cells(std::span<const double> types, const std::vector<double>& ends,
                         const std::vector<double>& corners);
  [[nodiscard]] const std::vector<Vec3>& points() const { return mesh_.points; }
  /// Error where there is no triangle.
  Result<TriMesh> finish();

 private:
  void add_cell(int type, std::span<const int> corners);
  const MeshSource& source_;
  TriMesh mesh_;
  std::size_t piece_ = 0;  ///< its first point
  std::size_t cells_ = 0;  ///< all, also those without triangles
};

}  // namespace turgor::detail
