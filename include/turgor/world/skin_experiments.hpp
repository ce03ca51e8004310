// A strip of skin in the grips of a testing machine: the experiments of Pieper (1989), figures 2-1 to 2-5,
// after Larrabee (1986), on the model's own springs.
#pragma once

#include <array>
#include <vector>

#include "turgor/core/context.hpp"
#include "turgor/dynamics/time_stepper.hpp"

namespace turgor {

/// Skin as a sheet of springs in parallel: elastin, linear from the start, and collagen, slack until its
/// fibres lie in the direction of the pull (the thesis, 2.1.2). Tensions are forces per width of skin. For a
/// strip that keeps its width, and for slow pulls but for what relaxes,
///
///     T(ε) = lax ((1 + ε)(1 + ε₀) − 1) + stiff f((1 + ε)/(1 + εₜ) − 1),      f of SpringLaw::collagen
///
/// Defaults are of the order of facial skin: 35 kPa at 2 mm when lax (Luboz et al. 2014) and a few MPa when
/// taut.
struct SkinProperties {
  double lax_n_cm = 0.7;            ///< of elastin per strain, > 0
  double stiff_n_cm = 12;           ///< of taut collagen along Langer's lines, ≥ 0
  double anisotropy = 2;            ///< of it along over across, > 0
  double transition_along = 0.35;   ///< strain εₜ from which collagen acts, 0 to 5
  double transition_across = 0.55;  ///< the same across Langer's lines
  double langer_deg = 0;            ///< angle between Langer's lines and the strip: 0 along, 90 across
  double rest_tension_n_cm = 0;     ///< at strain 0 along the strip and ever since, ≥ 0
  double shear = 0.25;              ///< of diagonals over lax elastin, ≥ 0; 0: rows that keep their width
  /// Of all springs, ms.
  std::array<Relaxation, kRelaxations> relaxation{{{0.15, 500}, {0.12, 6'000}, {0.12, 60'000}}};
};

/// Samples of an experiment, evenly spread over its time. Strain is that of the distance between the grips,
/// tension the force on a grip over the width of 1 cm.
struct SkinCurve {
  std::vector<double> time_s, strain, tension_n_cm;
};

struct SkinPull {
  double peak_strain = 0.6;  ///< above 0, at most 2
  double rate_per_s = 0.02;  ///< strain per second, 0.001 to 1
  int cycles = 1;            ///< 1 to 20
  /// After each, to strain 0 or where the skin, longer by what has relaxed, goes slack; else it ends at the
  /// peak, once.
  bool unloads = true;
};

// The strip is 50 × 10 mm (the skin island of figures 2-2 to 2-5), clamped at both ends. Motion is
// quasi-static: the mass of the points is scaled up to allow steps of milliseconds, and all of them follow
// the grips, so that inertia and its waves play no part. An experiment takes a second or two at most. Errors:
// numbers out of range; cancelled.

/// Load and unload at one rate: the J (2-1), hysteresis (2-2), and from cycle to cycle pre-conditioning
/// (2-5). All cycles have the same number of samples, of which the first half or so loads.
Result<SkinCurve> pull_skin(const SkinProperties& skin, const SkinPull& pull, Context& context);
/// Pulled to a strain within a second and held (2-3).
Result<SkinCurve> relax_skin(const SkinProperties& skin, double strain, double seconds, Context& context);
/// A servo pulls to a tension within seconds and keeps it (2-4).
Result<SkinCurve> creep_skin(const SkinProperties& skin, double tension_n_cm, double seconds,
                             Context& context);

/// Tension of a strip that keeps its width at the strain, without relaxation: the formula above.
double elastic_skin_tension(const SkinProperties& skin, double strain);

}  // namespace turgor
