// The trilinear hexahedron of any shape, integrated at 2×2×2 Gauss points, with its dilatation replaced by
// the mean over the element (B-bar; Hughes 1980, "Generalization of selective integration procedures to
// anisotropic and nonlinear media"). Internal.
#pragma once

#include <Eigen/Core>
#include <array>

#include "turgor/fem/elasticity.hpp"

namespace turgor::detail {

using HexCorners = std::array<Vec3, 8>;            ///< in the order of VTK
using HexMatrix = Eigen::Matrix<double, 24, 24>;   ///< 3 · corner + component
using HexGradients = Eigen::Matrix<double, 8, 3>;  ///< of the shape functions, 1/mm

struct HexPoint {
  HexGradients gradients;
  Eigen::Matrix<double, 8, 1> shape;
  double volume = 0;  ///< weight times the Jacobian's determinant, mm³; ≤ 0: the map is not one to one
};

std::array<HexPoint, 8> gauss_points(const HexCorners& corners);
HexMatrix hex_stiffness(const std::array<HexPoint, 8>& points, const ElasticMaterial& material);
/// Mean strain and stress under the displacements of the corners.
ElementStress hex_stress(const std::array<HexPoint, 8>& points, const ElasticMaterial& material,
                         const std::array<Vec3, 8>& displacement_mm);

}  // namespace turgor::detail
