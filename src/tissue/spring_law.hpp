// The laws of Pieper (1989, section 3.2.1), of collagen and of Hooke as functions of strain, for one spring
// or for several side by side (Real is double or Lanes), and the integrals that make them energies.
#pragma once

#include <cmath>

#include "math/lanes.hpp"
#include "turgor/tissue/network.hpp"

namespace turgor {

/// A function of the library, lane by lane.
template <class Function>
double each_lane(double x, Function function) {
  return function(x);
}
template <class Function>
Lanes each_lane(Lanes x, Function function) {
  return Lanes{function(x[0]), function(x[1]), function(x[2]), function(x[3])};
}

/// f(s), the law itself.
template <SpringLaw law, class Real>
Real law_value(Real s) {
  if constexpr (law == SpringLaw::exponential) return each_lane(s, [](double x) { return std::expm1(x); });
  if constexpr (law == SpringLaw::logarithmic) return each_lane(s, [](double x) { return std::log1p(x); });
  if constexpr (law == SpringLaw::square) return s * s;
  if constexpr (law == SpringLaw::collagen) {
    constexpr double w = kCollagenRecruitment;
    return s < w ? s * s * (0.5 / w) : s - 0.5 * w;
  }
  return s;
}

/// f'(s) where f(s) is `value`.
template <SpringLaw law, class Real>
Real law_slope(Real s, Real value) {
  if constexpr (law == SpringLaw::exponential) return 1.0 + value;
  if constexpr (law == SpringLaw::logarithmic) return 1.0 / (1.0 + s);
  if constexpr (law == SpringLaw::square) return 2.0 * s;
  const Real one = Real{} + 1.0;
  if constexpr (law == SpringLaw::collagen) return s < kCollagenRecruitment ? s / kCollagenRecruitment : one;
  return one;
}

/// ∫₀ˢ f(σ) dσ: the energy of a stretched spring over k L0.
template <SpringLaw law>
double stretch_integral(double s);

/// ∫₀ˢ f(σ)/(1 + σ)² dσ: the energy of a compressed spring over k L0, with L = L0/(1 + σ), dL = −L0 dσ/(1 +
/// σ)².
template <SpringLaw law>
double compression_integral(double s);

/// Tension and dT/dL of the law with stiffness 1 at the length L, without branches so that it runs on lanes.
template <class Real>
struct TensionSlope {
  Real tension, slope;
};
template <SpringLaw law, class Real>
TensionSlope<Real> law_tension(Real length, Real rest) {
  if constexpr (law == SpringLaw::hookean) {
    const Real per_length = 1.0 / rest;
    return {(length - rest) * per_length, per_length};
  }
  // Beyond the strain limit the tension continues along its tangent: finite for every length.
  constexpr double reach = 1.0 + kStrainLimit;
  const Real low = rest * (1.0 / reach), high = rest * reach;
  const Real bounded = length < low ? low : length;
  const Real inside = bounded > high ? high : bounded;
  const auto stretched = inside >= rest;
  // (longer - shorter) / shorter, not their ratio - 1: near rest the difference of lengths is exact.
  const Real none = Real{}, one = none + 1.0;
  const Real over_shorter = 1.0 / (stretched ? rest : inside);
  const Real s = (stretched ? inside - rest : rest - inside) * over_shorter;
  const Real f = law_value<law>(s), df = law_slope<law>(s, f) * over_shorter;
  // Compressed, ds/dL = −L0/L². Collagen is slack there.
  constexpr bool slack = law == SpringLaw::collagen;
  const Real tension = stretched ? f : (slack ? none : -f);
  const Real slope = df * (stretched ? one : (slack ? none : rest * over_shorter));
  return {tension + slope * (length - inside), slope};
}

/// Energy over k; its derivative is law_tension().
template <SpringLaw law>
double law_energy(double length, double rest) {
  if constexpr (law == SpringLaw::hookean) return 0.5 * (length - rest) * (length - rest) / rest;
  const double reach = 1.0 + kStrainLimit;
  const double low = rest / reach, high = rest * reach;
  const double inside = length < low ? low : (length > high ? high : length);
  const double e = inside >= rest ? rest * stretch_integral<law>((inside - rest) / rest)
                                  : rest * compression_integral<law>((rest - inside) / inside);
  const double beyond = length - inside;
  if (beyond == 0.0) return e;
  const auto edge = law_tension<law>(inside, rest);
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
    case SpringLaw::collagen:
      return body.template operator()<SpringLaw::collagen>();
    case SpringLaw::hookean:
      return body.template operator()<SpringLaw::hookean>();
    case SpringLaw::linear:
      break;
  }
  return body.template operator()<SpringLaw::linear>();
}

}  // namespace turgor
