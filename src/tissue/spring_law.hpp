// The four laws of Pieper (1989, section 3.2.1) as functions of strain, and the integrals that make them
// energies.
#pragma once

#include <cmath>

#include "turgor/tissue/network.hpp"

namespace turgor {

/// f(s), the law itself.
template <SpringLaw law>
double law_value(double s) {
  if constexpr (law == SpringLaw::linear) return s;
  if constexpr (law == SpringLaw::exponential) return std::expm1(s);
  if constexpr (law == SpringLaw::logarithmic) return std::log1p(s);
  if constexpr (law == SpringLaw::square) return s * s;
}

/// f'(s).
template <SpringLaw law>
double law_slope(double s) {
  if constexpr (law == SpringLaw::linear) return 1.0;
  if constexpr (law == SpringLaw::exponential) return std::exp(s);
  if constexpr (law == SpringLaw::logarithmic) return 1.0 / (1.0 + s);
  if constexpr (law == SpringLaw::square) return 2.0 * s;
}

/// ∫₀ˢ f(σ) dσ: the energy of a stretched spring over k L0.
template <SpringLaw law>
double stretch_integral(double s);

/// ∫₀ˢ f(σ)/(1 + σ)² dσ: the energy of a compressed spring over k L0, with L = L0/(1 + σ), dL = −L0 dσ/(1 +
/// σ)².
template <SpringLaw law>
double compression_integral(double s);

/// Tension and dT/dL of the law with stiffness 1 at the length L, without branches so that loops over it
/// vectorise.
struct TensionSlope {
  double tension, slope;
};
template <SpringLaw law>
TensionSlope law_tension(double length, double rest) {
  // Beyond the strain limit the tension continues along its tangent: finite for every length.
  const double reach = 1.0 + kStrainLimit;
  const double low = rest / reach, high = rest * reach;
  const double inside = length < low ? low : (length > high ? high : length);
  const bool stretched = inside >= rest;
  const double ratio = stretched ? inside / rest : rest / inside;
  // (longer - shorter) / shorter, not ratio - 1: near rest the difference of lengths is exact.
  const double s = stretched ? (inside - rest) / rest : (rest - inside) / inside;
  const double f = law_value<law>(s), df = law_slope<law>(s);
  const double slope = stretched ? df / rest : df * ratio * ratio / rest;  // ds/dL = −L0/L² = −ratio²/L0
  return {(stretched ? f : -f) + slope * (length - inside), slope};
}

/// Energy over k; its derivative is law_tension().
template <SpringLaw law>
double law_energy(double length, double rest) {
  const double reach = 1.0 + kStrainLimit;
  const double low = rest / reach, high = rest * reach;
  const double inside = length < low ? low : (length > high ? high : length);
  const double e = inside >= rest ? rest * stretch_integral<law>((inside - rest) / rest)
                                  : rest * compression_integral<law>((rest - inside) / inside);
  const double beyond = length - inside;
  if (beyond == 0.0) return e;
  const TensionSlope edge = law_tension<law>(inside, rest);
  return e + beyond * (edge.tension + 0.5 * edge.slope * beyond);
}

/// Calls body.template operator()<law>() for the law named at run time.
template <class Body>
decltype(auto) with_law(SpringLaw law, Body&& body) {
  switch (law) {
    case SpringLaw::exponential:
      return body.template operator()<SpringLaw::exponential>();
    case SpringLaw::logarithmic:
      return body.template operator()<SpringLaw::logarithmic>();
    case SpringLaw::square:
      return body.template operator()<SpringLaw::square>();
    case SpringLaw::linear:
      break;
  }
  return body.template operator()<SpringLaw::linear>();
}

}  // namespace turgor
