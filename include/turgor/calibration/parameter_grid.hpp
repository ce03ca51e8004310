// Parameters on a coarse grid over a body, interpolated to its elements (Morris 2006, section 3.5).
#pragma once

#include <array>
#include <span>
#include <vector>

#include "turgor/core/error.hpp"
#include "turgor/math/vec.hpp"

namespace turgor {

/// Rows of weights by columns that count: value of element e = Σ weight · value of node, entries offsets[e]
/// to offsets[e + 1] − 1. Weights are ≥ 0 and sum to 1 in each row.
struct ParameterWeights {
  std::vector<int> offsets{0}, columns;
  std::vector<double> weights;
  int column_count = 0;

  [[nodiscard]] std::size_t rows() const { return offsets.size() - 1; }
  /// out[e] = Σ weight · values[column]; `values` of length column_count, `out` of length rows().
  void apply(std::span<const double> values, std::span<double> out) const;
};

struct ParameterGrid {
  Index3 nodes{1, 1, 1};        ///< along x, y, z; 1: constant along that axis
  std::vector<Index3> places;   ///< of the nodes kept: those with influence, x fastest
  std::vector<Vec3> positions;  ///< of those, mm
  ParameterWeights weights;     ///< of the points given, columns by `places`
};

/// Trilinear weights at `points` of a grid over their box. Nodes that influence none are left out. Errors: no
/// points, or not finite; fewer than one node along an axis, more than a million in all.
Result<ParameterGrid> make_parameter_grid(const Index3& nodes, std::span<const Vec3> points);

}  // namespace turgor
