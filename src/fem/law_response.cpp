#include "fem/law_response.hpp"

#include <Eigen/Eigenvalues>
#include <cmath>

namespace turgor::detail {
namespace {

using Rows = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;

Rows rows_of(const Tensor<double>& a) {
  return Eigen::Map<const Rows>(a.m);
}
Tensor<double> tensor_of(const Rows& a) {
  return Tensor<double>::each([&](int i) { return a(i / 3, i % 3); });
}

// Smallest sum of two principal stretches at which the rotation still has a derivative to work with.
constexpr double kLeastStretches = 1e-6;

}  // namespace

// Corotational: W = μ (|S − 1|² − ⅓ θ²), θ = tr (S − 1). As R : dF = tr dS, P = 2 μ (F − (1 + ⅓ θ) R).
LawPoint<ElasticLaw::corotational, double>::LawPoint(const Tensor<double>& h, const LawModuli<double>& moduli)
    : two_mu_(2 * moduli.shear), turning_(Eigen::Matrix3d::Zero()) {
  const Tensor<double> squares = h + h.transposed() + h.transposed() * h;  // S² − 1, to the digits of h
  valid_ = std::isfinite(contract(squares, squares));
  if (!valid_) return;
  const Eigen::Matrix3d f = rows_of(h + Tensor<double>::unit());
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(rows_of(squares));
  Eigen::Matrix3d v = solver.eigenvectors().rowwise().reverse(), u;
  const Eigen::Vector3d d = solver.eigenvalues().reverse();
  v.col(2) = v.col(0).cross(v.col(1));
  u.col(0) = (f * v.col(0)).normalized();
  u.col(1) = (f * v.col(1) - u.col(0) * u.col(0).dot(f * v.col(1))).normalized();
  u.col(2) = u.col(0).cross(u.col(1));  // no reflection: of what is turned over the least stretch is below 0
  const Eigen::Vector3d root = (d.array() + 1).max(0).sqrt();
  Eigen::Vector3d strain = d.array() / (root.array() + 1);
  if (u.col(2).dot(f * v.col(2)) < 0) strain[2] = -root[2] - 1;
  valid_ = strain[1] + strain[2] + 2 > kLeastStretches;
  if (!valid_) return;
  rotation_ = tensor_of(u * v.transpose());
  theta_ = strain.sum();
  strain_ = tensor_of(v * strain.asDiagonal() * v.transpose());
  stress_ = (rotation_ * strain_.deviator()) * two_mu_;
  turning_ = v * (theta_ + 2 - strain.array()).inverse().matrix().asDiagonal() * v.transpose();
}

double LawPoint<ElasticLaw::corotational, double>::energy() const {
  return 0.5 * two_mu_ * contract(strain_.deviator(), strain_);
}

// Rᵀ dF = [ω] S + dS: its skew part has the axial vector (tr S 1 − S) ω; dR = R [ω].
Tensor<double> LawPoint<ElasticLaw::corotational, double>::tangent(const Tensor<double>& df,
                                                                   double pressure) const {
  const Tensor<double> m = rotation_.transposed() * df;
  const Eigen::Vector3d w =
      turning_ * Eigen::Vector3d(m(2, 1) - m(1, 2), m(0, 2) - m(2, 0), m(1, 0) - m(0, 1));
  const Tensor<double> turn{{0, -w[2], w[1], w[2], 0, -w[0], -w[1], w[0], 0}};
  const Tensor<double> rotation_change = rotation_ * turn;
  return df * two_mu_ - rotation_ * (two_mu_ / 3 * m.trace()) +
         rotation_change * (pressure - two_mu_ * (1 + theta_ / 3));
}

LawResponse law_response(const ElasticMaterial& material, const Tensor<double>& h) {
  return with_law(material.law, [&]<ElasticLaw law>() {
    const LawPoint<law, double> point(h, moduli_of(material));
    LawResponse r;
    if (!point.valid()) return r;
    r.energy = point.energy(), r.stress = point.stress();
    r.theta = point.theta(), r.theta_gradient = point.theta_gradient();
    r.valid = std::isfinite(r.energy) && std::isfinite(r.theta * r.theta) &&
              std::isfinite(contract(r.stress, r.stress)) &&
              std::isfinite(contract(r.theta_gradient, r.theta_gradient));
    return r;
  });
}

Eigen::Matrix<double, 9, 9> law_tangent(const ElasticMaterial& material, const Tensor<double>& h,
                                        double pressure) {
  return with_law(material.law, [&]<ElasticLaw law>() {
    const LawPoint<law, double> point(h, moduli_of(material));
    Eigen::Matrix<double, 9, 9> all;
    for (int c = 0; c < 9; ++c) {
      const auto df = Tensor<double>::each([&](int i) { return i == c ? 1.0 : 0.0; });
      const Tensor<double> column = point.tangent(df, pressure);
      for (int r = 0; r < 9; ++r) all(r, c) = column.m[r];
    }
    return all;
  });
}

}  // namespace turgor::detail
