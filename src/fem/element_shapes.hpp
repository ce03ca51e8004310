// Isoparametric elements of any shape at their Gauss points: the trilinear hexahedron at 2×2×2, the prism at
// three of its triangle by two across, the tetrahedron at its centre. Internal.
#pragma once

#include <array>
#include <span>
#include <vector>

#include "turgor/math/vec.hpp"

namespace turgor::detail {

/// Of the first so many corners as the element has.
struct GaussPoint {
  double volume = 0;               ///< weight times the Jacobian's determinant, mm³; ≤ 0: turned over
  std::array<double, 8> shape{};   ///< of each corner
  std::array<Vec3, 8> gradient{};  ///< of each shape function, 1/mm
};

/// Adds the Gauss points of a hexahedron (8 corners), prism (6) or tetrahedron (4), corners as in
/// fem/mesh_elasticity.hpp.
void add_gauss_points(std::span<const Vec3> corners, std::vector<GaussPoint>& points);

}  // namespace turgor::detail
