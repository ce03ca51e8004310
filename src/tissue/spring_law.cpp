#include "tissue/spring_law.hpp"

#include <array>

namespace turgor {
namespace {

// The integrals of the laws that hold a logarithm are small differences of larger terms near rest. In
//     z = s/(2 + s),   ln(1 + s) = 2 artanh z,   s = 2z/(1 − z),   t = s/(1 + s) = 2z/(1 + z)
// the terms that cancel drop out by hand and what is left is artanh z − z = z³/3 + z⁵/5 + …, here over z³.
constexpr std::array kOddReciprocals = {1.0 / 23, 1.0 / 21, 1.0 / 19, 1.0 / 17, 1.0 / 15, 1.0 / 13,
                                        1.0 / 11, 1.0 / 9,  1.0 / 7,  1.0 / 5,  1.0 / 3};

double artanh_tail(double z) {
  constexpr double series_limit = 0.2;
  if (z > series_limit) return (std::atanh(z) - z) / (z * z * z);
  const double q = z * z;
  double sum = 1.0 / 25;
  for (const double c : kOddReciprocals) sum = sum * q + c;
  return sum;
}

double half_logarithmic(double s) {
  return s / (2.0 + s);
}

// Nodes and weights of the Gauss-Legendre rule of twelve points on [-1, 1], the positive half.
constexpr std::array<double, 6> kNodes = {0.1252334085114689, 0.3678314989981802, 0.5873179542866175,
                                          0.7699026741943047, 0.9041172563704749, 0.9815606342467193};
constexpr std::array<double, 6> kWeights = {0.2491470458134028, 0.2334925365383548, 0.2031674267230659,
                                            0.1600783285433462, 0.1069393259953184, 0.0471753363865118};

double exp_compression_density(double s) {
  const double length_ratio = 1.0 / (1.0 + s);
  return std::expm1(s) * length_ratio * length_ratio;
}

}  // namespace

template <>
double stretch_integral<SpringLaw::linear>(double s) {
  return 0.5 * s * s;
}

template <>
double stretch_integral<SpringLaw::square>(double s) {
  return s * s * s / 3.0;
}

template <>
double stretch_integral<SpringLaw::exponential>(double s) {
  if (s > 0.2) return std::expm1(s) - s;
  double sum = 1;  // e^s − 1 − s = s²/2 (1 + s/3 (1 + s/4 (1 + …)))
  for (int n = 14; n >= 3; --n) sum = 1 + sum * s / n;
  return 0.5 * s * s * sum;
}

template <>
double stretch_integral<SpringLaw::logarithmic>(double s) {  // (1 + s) ln(1 + s) − s
  const double z = half_logarithmic(s);
  return 2 * z * z / (1 - z) * (1 + (1 + z) * z * artanh_tail(z));
}

template <>
double compression_integral<SpringLaw::linear>(double s) {  // ln(1 + s) − t
  const double z = half_logarithmic(s);
  return 2 * z * z * (1 / (1 + z) + z * artanh_tail(z));
}

template <>
double compression_integral<SpringLaw::logarithmic>(double s) {  // t − (1 − t) ln(1 + s)
  const double z = half_logarithmic(s);
  return 2 * z * z / (1 + z) * (1 - (1 - z) * z * artanh_tail(z));
}

template <>
double compression_integral<SpringLaw::square>(double s) {  // s − 2 ln(1 + s) + t
  const double z = half_logarithmic(s);
  return 4 * z * z * z * (1 / (1 - z * z) - artanh_tail(z));
}

// s³/(6w), then s²/2 − ws/2 + w²/6.
template <>
double stretch_integral<SpringLaw::collagen>(double s) {
  constexpr double w = kCollagenRecruitment;
  return s < w ? s * s * s / (6.0 * w) : 0.5 * s * (s - w) + w * w / 6.0;
}

template <>
double compression_integral<SpringLaw::collagen>(double /*s*/) {
  return 0;
}

// In closed form (Ei(1 + s) − Ei(1))/e − (e^s − 1)/(1 + s), which cancels near zero and needs the exponential
// integral. The integrand is positive and analytic up to σ = −1, so twelve Gauss points per unit of strain
// are exact to round-off.
template <>
double compression_integral<SpringLaw::exponential>(double s) {
  const int panels = static_cast<int>(std::ceil(s));
  double sum = 0;
  for (int panel = 0; panel < panels; ++panel) {
    const double half = 0.5 * s / panels, middle = (2 * panel + 1) * half;
    for (std::size_t i = 0; i < kNodes.size(); ++i) {
      const double offset = half * kNodes[i];
      sum += half * kWeights[i] *
             (exp_compression_density(middle - offset) + exp_compression_density(middle + offset));
    }
  }
  return sum;
}

SpringResponse respond(const Spring& spring, double length_mm) {
  return with_law(spring.law, [&]<SpringLaw law>() {
    const auto t = law_tension<law>(length_mm, spring.rest_length_mm);
    const double k = spring.stiffness_n;
    return SpringResponse{k * law_energy<law>(length_mm, spring.rest_length_mm), k * t.tension, k * t.slope};
  });
}

VolumeResponse respond(const VolumeElement& element, double volume_mm3) {
  const double rest = element.rest_volume_mm3, k = element.modulus_mpa, g = element.inversion_guard_mpa;
  const double change = (volume_mm3 - rest) / rest;
  VolumeResponse r{0.5 * k * rest * change * change, k * change, k / rest};
  constexpr double from = VolumeElement::kGuardFrom;
  const double depth = std::max(from - volume_mm3 / rest, 0.0) / from;
  r.energy += g * rest * from / 3.0 * depth * depth * depth;
  r.mean_stress -= g * depth * depth;
  r.slope += 2.0 * g * depth / (from * rest);
  return r;
}

}  // namespace turgor
