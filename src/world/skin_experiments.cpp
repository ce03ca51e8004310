#include "turgor/world/skin_experiments.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "turgor/core/index.hpp"
#include "world/langer.hpp"

namespace turgor {
namespace {

constexpr int kColumns = 21, kRows = 5;
constexpr double kLength = 50, kWidth = 10, kSpacing = kLength / (kColumns - 1);  // mm
static_assert(kSpacing * (kRows - 1) == kWidth);
constexpr double kStepMs = 2;
constexpr int kSamples = 200;  // of an experiment, or of one cycle

Error bad(std::string what, std::string remedy) {
  return {ErrorKind::bad_input, std::move(what), "skin experiment", std::move(remedy)};
}

bool is_between(double x, double low, double high) {
  return x >= low && x <= high;
}

double kept_share(const SkinProperties& s) {
  double left = 1;
  for (const Relaxation& r : s.relaxation) left -= r.share;
  return left;
}

Result<void> check(const SkinProperties& s) {
  constexpr double most = 1e4;  // N/cm: far above any tendon
  if (!is_between(s.lax_n_cm, 1e-4, most) || !is_between(s.stiff_n_cm, 0, most) ||
      !is_between(s.rest_tension_n_cm, 0, most)) {
    return bad(fmt::format("skin of {} N/cm lax and {} N/cm stiff under {} N/cm", s.lax_n_cm, s.stiff_n_cm,
                           s.rest_tension_n_cm),
               "Give tensions of at least 0, the lax one of at least 1e-4, and at most 1e4");
  }
  if (!is_between(s.anisotropy, 1e-2, 1e2) || !is_between(s.shear, 0, 10) || !std::isfinite(s.langer_deg)) {
    return bad(
        fmt::format("an anisotropy of {} at {}° with a shear of {}", s.anisotropy, s.langer_deg, s.shear),
        "Give an anisotropy of 0.01 to 100, a finite angle, a shear of 0 to 10");
  }
  if (!is_between(s.transition_along, 0, 5) || !is_between(s.transition_across, 0, 5)) {
    return bad(fmt::format("transitions at strains {} and {}", s.transition_along, s.transition_across),
               "Give strains of 0 to 5");
  }
  const double left = kept_share(s);
  if (!(left >= 0.05)) return bad(fmt::format("{} of the tension stays", left), "Let at least 0.05 stay");
  return {};
}

/// Of elastin that keeps the rest tension for ever.
double rest_strain(const SkinProperties& s) {
  return s.rest_tension_n_cm / (s.lax_n_cm * kept_share(s));
}

struct Collagen {
  double stiffness_n_cm, transition;
};

/// Of fibres at an angle to Langer's lines.
Collagen collagen_at(const SkinProperties& s, double angle_deg) {
  const double c = std::cos(radians(angle_deg));
  return {at_angle(s.stiff_n_cm, s.stiff_n_cm / s.anisotropy, c * c),
          at_angle(s.transition_along, s.transition_across, c * c)};
}

/// The strip and its state.
class Strip {
 public:
  static Result<Strip> prepare(const SkinProperties& skin);

  [[nodiscard]] double strain() const { return strain_; }
  [[nodiscard]] double time_s() const { return 1e-3 * state_.time_ms; }
  [[nodiscard]] double tension_n_cm() const;
  /// Moves the grips to a strain, every point along with them, and lets a step of time pass.
  Result<void> step_to(double strain, Context& context);

 private:
  explicit Strip(TimeStepper stepper) : stepper_(std::move(stepper)) {}

  TimeStepper stepper_;
  MotionState state_;
  TimeStepper::Workspace workspace_;
  double strain_ = 0;
};

int point(int column, int row) {
  return row * kColumns + column;
}
bool is_gripped(int p) {
  return p % kColumns == 0 || p % kColumns == kColumns - 1;
}

class Sheet {
 public:
  explicit Sheet(const SkinProperties& skin) : skin_(skin) {
    for (int row = 0; row < kRows; ++row) {
      for (int column = 0; column < kColumns; ++column) {
        model_.network.rest.push_back({column * kSpacing, row * kSpacing, 0});
        model_.mobile.push_back(static_cast<char>(!is_gripped(point(column, row))));
      }
    }
    for (int row = 0; row < kRows; ++row)
      for (int column = 0; column < kColumns; ++column) add_cell(column, row);
    model_.springs.assign(model_.network.springs.size(), {0, 0, true});
    model_.relaxation = skin.relaxation;
    set_mass();
  }
  [[nodiscard]] const MotionModel& model() const { return model_; }

 private:
  // Springs to the right, up, and along both diagonals; those on an edge of the strip stand for half the
  // width.
  void add_cell(int column, int row) {
    const bool right = column + 1 < kColumns, up = row + 1 < kRows;
    const double width = 0.1 * kSpacing;  // cm
    const bool edge = row == 0 || row + 1 == kRows;
    if (right) add_skin(point(column, row), point(column + 1, row), edge ? 0.5 * width : width, 0);
    if (up) add_skin(point(column, row), point(column, row + 1), width, 90);
    if (!right || !up) return;
    const double diagonal = skin_.shear * skin_.lax_n_cm * width;
    add(point(column, row), point(column + 1, row + 1), 1, diagonal, SpringLaw::linear);
    add(point(column + 1, row), point(column, row + 1), 1, diagonal, SpringLaw::linear);
  }

  void add_skin(int a, int b, double width_cm, double angle_deg) {
    const Collagen collagen = collagen_at(skin_, angle_deg - skin_.langer_deg);
    const double stretched = angle_deg == 0 ? 1 + rest_strain(skin_) : 1;
    add(a, b, 1 / stretched, skin_.lax_n_cm * width_cm, SpringLaw::linear);
    add(a, b, 1 + collagen.transition, collagen.stiffness_n_cm * width_cm, SpringLaw::collagen);
  }

  // A spring acts by half between mobile points: it is made twice as stiff there, so that it is what it is
  // meant to be.
  void add(int a, int b, double rest_ratio, double stiffness_n, SpringLaw law) {
    auto& net = model_.network;
    const double share = is_gripped(a) || is_gripped(b) ? 1 : 2;
    const double length = distance(net.rest[at(a)], net.rest[at(b)]);
    net.springs.push_back({a, b, rest_ratio * length, share * stiffness_n, law, SpringKind::membrane});
  }

  // As much as makes a step of kStepMs stable with all collagen taut, and damping that lets the slowest wave
  // die in its own time.
  void set_mass() {
    auto& net = model_.network;
    std::vector<double> stiffness(net.rest.size());
    for (const Spring& s : net.springs)
      for (const int end : {s.a, s.b}) stiffness[at(end)] += s.stiffness_n / s.rest_length_mm;
    const double stiffest = *std::max_element(stiffness.begin(), stiffness.end());
    const double mass = 1.5 * 2 * stiffest * (kStepMs / 1.4) * (kStepMs / 1.4);
    net.mass_g.assign(net.rest.size(), mass);
    const double lax = skin_.lax_n_cm * 0.1;  // N/mm per width and strain, and here N/mm between neighbours
    model_.damping_g_ms = 2 * mass * (3.14 / kColumns) * std::sqrt(lax / mass);
  }

  SkinProperties skin_;
  MotionModel model_;
};

Result<Strip> Strip::prepare(const SkinProperties& skin) {
  TURGOR_CHECK(check(skin));
  TURGOR_TRY(TimeStepper stepper, TimeStepper::prepare(Sheet(skin).model()));
  Strip strip(std::move(stepper));
  const MotionModel& model = strip.stepper_.model();
  strip.state_ = strip.stepper_.rest();
  // The rest tension has been there for ever: what relaxes has relaxed.
  for (std::size_t i = 0; i < model.network.springs.size(); ++i) {
    const Spring& s = model.network.springs[i];
    const double share = is_gripped(s.a) || is_gripped(s.b) ? 1 : 0.5;
    const double length = distance(model.network.rest[at(s.a)], model.network.rest[at(s.b)]);
    for (std::size_t k = 0; k < kRelaxations; ++k)
      strip.state_.relaxed[i][k] = model.relaxation[k].share * share * respond(s, length).tension;
  }
  return strip;
}

// What the springs at the left grip pull it with.
double Strip::tension_n_cm() const {
  const auto& springs = stepper_.model().network.springs;
  double force = 0;
  for (std::size_t i = 0; i < springs.size(); ++i) {
    const Spring& s = springs[i];
    const Vec3 d = state_.position[at(s.b)] - state_.position[at(s.a)];
    const double l = length(d);
    const bool a_held = s.a % kColumns == 0, b_held = s.b % kColumns == 0;
    if (a_held == b_held || !(l > 0)) continue;
    double tension = respond(s, l).tension;
    for (const double q : state_.relaxed[i]) tension -= q;
    force += tension * std::abs(d.x) / l;
  }
  return force / (0.1 * kWidth);
}

Result<void> Strip::step_to(double strain, Context& context) {
  const double factor = (1 + strain) / (1 + strain_);
  for (Vec3& p : state_.position) p.x *= factor;
  strain_ = strain;
  TURGOR_TRY(const StepReport report, stepper_.step(state_, kStepMs, Integrator::euler, context, workspace_));
  static_cast<void>(report);
  return {};
}

/// Runs for `seconds`; next_strain(strip) is where the grips go in the next step.
template <class NextStrain>
Result<SkinCurve> run(const SkinProperties& skin, double seconds, int samples, Context& context,
                      NextStrain&& next_strain) {
  TURGOR_TRY(Strip strip, Strip::prepare(skin));
  SkinCurve curve;
  const auto record = [&] {
    curve.time_s.push_back(strip.time_s());
    curve.strain.push_back(strip.strain());
    curve.tension_n_cm.push_back(strip.tension_n_cm());
  };
  record();
  const int steps = std::max(samples, static_cast<int>(std::ceil(1e3 * seconds / kStepMs)));
  for (int i = 1; i <= steps; ++i) {
    TURGOR_CHECK(strip.step_to(next_strain(strip), context));
    const auto due = [&](int step) { return static_cast<std::int64_t>(step) * samples / steps; };
    if (due(i) > due(i - 1)) record();
  }
  return curve;
}

Result<void> check_seconds(double seconds) {
  if (!is_between(seconds, 0.1, 1e3)) return bad(fmt::format("it lasts {} s", seconds), "Give 0.1 to 1000 s");
  return {};
}

}  // namespace

double elastic_skin_tension(const SkinProperties& skin, double strain) {
  const Collagen c = collagen_at(skin, skin.langer_deg);
  const Spring elastin{0, 1, 1 / (1 + rest_strain(skin)), skin.lax_n_cm, SpringLaw::linear};
  const Spring collagen{0, 1, 1 + c.transition, c.stiffness_n_cm, SpringLaw::collagen};
  return respond(elastin, 1 + strain).tension + respond(collagen, 1 + strain).tension;
}

Result<SkinCurve> pull_skin(const SkinProperties& skin, const SkinPull& pull, Context& context) {
  if (!is_between(pull.peak_strain, 1e-6, 2) || !is_between(pull.rate_per_s, 1e-3, 1) || pull.cycles < 1 ||
      pull.cycles > 20) {
    return bad(fmt::format("{} pulls to the strain {} at {} per second", pull.cycles, pull.peak_strain,
                           pull.rate_per_s),
               "Give 1 to 20, up to 2, and 0.001 to 1");
  }
  const double leg = pull.peak_strain / pull.rate_per_s;
  const double seconds = pull.unloads ? 2 * leg * pull.cycles : leg;
  TURGOR_CHECK(check_seconds(seconds));
  const int samples = pull.unloads ? kSamples * pull.cycles : kSamples;
  return run(skin, seconds, samples, context, [&](const Strip& strip) {
    const double legs = (strip.time_s() + 1e-3 * kStepMs) / leg;
    const double phase = legs - 2 * std::floor(0.5 * legs);
    const double asked = pull.peak_strain * (phase <= 1 || !pull.unloads ? std::min(phase, 1.0) : 2 - phase);
    if (asked >= strip.strain()) return asked;
    // Back no faster than at the rate, and not at all where no tension is left.
    const double back = strip.tension_n_cm() > 0 ? 1e-3 * kStepMs * pull.rate_per_s : 0.0;
    return std::max(asked, strip.strain() - back);
  });
}

Result<SkinCurve> relax_skin(const SkinProperties& skin, double strain, double seconds, Context& context) {
  TURGOR_CHECK(check_seconds(seconds));
  if (!is_between(strain, 1e-6, 2)) return bad(fmt::format("the strain is {}", strain), "Give up to 2");
  return run(skin, seconds, kSamples, context,
             [&](const Strip& strip) { return strain * std::min(1.0, strip.time_s() + 1e-3 * kStepMs); });
}

Result<SkinCurve> creep_skin(const SkinProperties& skin, double tension_n_cm, double seconds,
                             Context& context) {
  TURGOR_CHECK(check_seconds(seconds));
  if (!is_between(tension_n_cm, 0, 100)) {
    return bad(fmt::format("the tension is {} N/cm", tension_n_cm), "Give 0 to 100");
  }
  // Strain follows the tension that is missing with a time constant of 0.1 s where the skin is stiffest.
  const double stiffest = (skin.lax_n_cm * (1 + rest_strain(skin)) * (1 + 2 * skin.shear) +
                           collagen_at(skin, skin.langer_deg).stiffness_n_cm);
  const double gain = 1e-3 * kStepMs / (0.1 * stiffest);
  return run(skin, seconds, kSamples, context, [&](const Strip& strip) {
    return std::clamp(strip.strain() + gain * (tension_n_cm - strip.tension_n_cm()), -0.5, 5.0);
  });
}

}  // namespace turgor
