#include "fem/hexahedron.hpp"

#include <Eigen/LU>
#include <cmath>

namespace turgor::detail {
namespace {

constexpr std::array<std::array<int, 3>, 8> kSigns{
    {{-1, -1, -1}, {1, -1, -1}, {1, 1, -1}, {-1, 1, -1}, {-1, -1, 1}, {1, -1, 1}, {1, 1, 1}, {-1, 1, 1}}};

// Strain xx, yy, zz, xy, yz, zx (engineer's shear) of the 24 unknowns.
using StrainMatrix = Eigen::Matrix<double, 6, 24>;

HexGradients mean_gradients(const std::array<HexPoint, 8>& points) {
  HexGradients sum = HexGradients::Zero();
  double volume = 0;
  for (const HexPoint& p : points) {
    sum += p.gradients * p.volume;
    volume += p.volume;
  }
  return sum / volume;
}

StrainMatrix strain_matrix(const HexGradients& own, const HexGradients& mean) {
  StrainMatrix b = StrainMatrix::Zero();
  for (int n = 0; n < 8; ++n) {
    for (int c = 0; c < 3; ++c) {
      const double dilatation = (mean(n, c) - own(n, c)) / 3;
      for (int d = 0; d < 3; ++d) b(d, 3 * n + c) = dilatation;
      b(c, 3 * n + c) += own(n, c);
    }
    b(3, 3 * n) = own(n, 1), b(3, 3 * n + 1) = own(n, 0);
    b(4, 3 * n + 1) = own(n, 2), b(4, 3 * n + 2) = own(n, 1);
    b(5, 3 * n + 2) = own(n, 0), b(5, 3 * n) = own(n, 2);
  }
  return b;
}

}  // namespace

std::array<HexPoint, 8> gauss_points(const HexCorners& corners) {
  std::array<HexPoint, 8> points;
  const double at = 1 / std::sqrt(3.0);
  for (std::size_t g = 0; g < 8; ++g) {
    const double xi[3] = {kSigns[g][0] * at, kSigns[g][1] * at, kSigns[g][2] * at};
    Eigen::Matrix<double, 8, 3> local, positions;
    for (int n = 0; n < 8; ++n) {
      const auto& s = kSigns[static_cast<std::size_t>(n)];
      const double f[3] = {1 + s[0] * xi[0], 1 + s[1] * xi[1], 1 + s[2] * xi[2]};
      points[g].shape[n] = f[0] * f[1] * f[2] / 8;
      local.row(n) << s[0] * f[1] * f[2] / 8, f[0] * s[1] * f[2] / 8, f[0] * f[1] * s[2] / 8;
      const Vec3& p = corners[static_cast<std::size_t>(n)];
      positions.row(n) << p.x, p.y, p.z;
    }
    const Eigen::Matrix3d jacobian = positions.transpose() * local;  // ∂x/∂ξ
    points[g].volume = jacobian.determinant();
    points[g].gradients = local * jacobian.inverse();
  }
  return points;
}

HexMatrix hex_stiffness(const std::array<HexPoint, 8>& points, const ElasticMaterial& material) {
  const double mu = material.shear_modulus(), lambda = material.lame_lambda();
  Eigen::Matrix<double, 6, 6> hooke = Eigen::Matrix<double, 6, 6>::Zero();
  hooke.topLeftCorner<3, 3>().setConstant(lambda);
  hooke.diagonal() << lambda + 2 * mu, lambda + 2 * mu, lambda + 2 * mu, mu, mu, mu;
  const HexGradients mean = mean_gradients(points);
  HexMatrix k = HexMatrix::Zero();
  for (const HexPoint& p : points) {
    const StrainMatrix b = strain_matrix(p.gradients, mean);
    k += p.volume * b.transpose() * hooke * b;
  }
  return k;
}

ElementStress hex_stress(const std::array<HexPoint, 8>& points, const ElasticMaterial& material,
                         const std::array<Vec3, 8>& displacement_mm) {
  const HexGradients mean = mean_gradients(points);
  Eigen::Matrix3d g = Eigen::Matrix3d::Zero();
  for (int n = 0; n < 8; ++n) {
    const Vec3& u = displacement_mm[static_cast<std::size_t>(n)];
    g += Eigen::Vector3d(u.x, u.y, u.z) * mean.row(n);
  }
  ElementStress out;
  out.strain = {g(0, 0),
                g(1, 1),
                g(2, 2),
                0.5 * (g(0, 1) + g(1, 0)),
                0.5 * (g(1, 2) + g(2, 1)),
                0.5 * (g(2, 0) + g(0, 2))};
  out.stress_mpa = stress_of(out.strain, material);
  return out;
}

}  // namespace turgor::detail
