// Cauchy stress and strain of an element from its laws at Gauss points. Internal.
#pragma once

#include "fem/law_response.hpp"
#include "turgor/fem/elasticity.hpp"

namespace turgor::detail {

/// Means over an element, by the volume at rest, of the Cauchy stress (of Hooke's law the stress as it is)
/// and of the law's strain: logarithmic for the laws of J.
class StressMean {
 public:
  /// `pressure_mpa`: the stress beside θ.
  StressMean(const ElasticMaterial& material, double pressure_mpa)
      : material_(material), pressure_mpa_(pressure_mpa) {}
  /// A point of displacement gradient `h`; `weight`: its part of the volume. False: turned over.
  bool add(const Tensor<double>& h, const LawResponse& response, double weight);
  [[nodiscard]] ElementStress stress() const;

 private:
  const ElasticMaterial& material_;
  double pressure_mpa_;
  Tensor<double> strain_{}, cauchy_{};
};

}  // namespace turgor::detail
