#include "fem/law_stress.hpp"

#include <Eigen/Eigenvalues>

namespace turgor::detail {
namespace {

double determinant(const Tensor<double>& f) {
  const Tensor<double> c = cofactor(f);
  return f.m[0] * c.m[0] + f.m[1] * c.m[1] + f.m[2] * c.m[2];
}

SymmetricTensor symmetric_of(const Tensor<double>& a) {
  const Tensor<double> s = a.symmetric();
  return {s(0, 0), s(1, 1), s(2, 2), s(0, 1), s(1, 2), s(2, 0)};
}

// ln V = ½ ln FFᵀ, to the digits of h.
Tensor<double> log_stretch(const Tensor<double>& h) {
  const Tensor<double> b = h + h.transposed() + h * h.transposed();  // FFᵀ − 1
  using Rows = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(Eigen::Map<const Rows>(b.m));
  const Eigen::Vector3d log = 0.5 * solver.eigenvalues().array().log1p();
  const Eigen::Matrix3d v = solver.eigenvectors() * log.asDiagonal() * solver.eigenvectors().transpose();
  return Tensor<double>::each([&](int i) { return v(i / 3, i % 3); });
}

Tensor<double> strain_of(const ElasticMaterial& m, const Tensor<double>& h) {
  switch (m.law) {
    case ElasticLaw::corotational:
      return LawPoint<ElasticLaw::corotational, double>(h, moduli_of(m)).strain();
    case ElasticLaw::st_venant_kirchhoff:
      return h.symmetric() + (h.transposed() * h) * 0.5;
    case ElasticLaw::neo_hookean:
    case ElasticLaw::mooney_rivlin:
      return log_stretch(h);
    default:
      return h.symmetric();
  }
}

}  // namespace

bool StressMean::add(const Tensor<double>& h, const LawResponse& response, double weight) {
  Tensor<double> stress = response.stress + response.theta_gradient * pressure_mpa_;
  if (material_.law != ElasticLaw::linear) {
    const Tensor<double> f = h + Tensor<double>::unit();
    const double j = determinant(f);
    if (!(j > kLeastVolumeRatio)) return false;
    stress = (stress * f.transposed()) * (1 / j);
  }
  cauchy_ = cauchy_ + stress * weight;
  strain_ = strain_ + strain_of(material_, h) * weight;
  return true;
}

ElementStress StressMean::stress() const {
  return {symmetric_of(strain_), symmetric_of(cauchy_)};
}

}  // namespace turgor::detail
