#include "turgor/dynamics/time_stepper.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>

#include "tissue/incidence.hpp"
#include "tissue/spring_law.hpp"
#include "turgor/core/parallel.hpp"

namespace turgor {
namespace {

constexpr std::size_t kGrain = 2048;
constexpr int kMostSubSteps = 100'000;
constexpr std::array kLaws = {SpringLaw::linear, SpringLaw::exponential, SpringLaw::logarithmic,
                              SpringLaw::square};

// Part of the stable step that is taken. Euler's is stable up to it; Heun's lets an undamped oscillation grow
// by (ω dt)⁴/8 a step, 0.03 % here.
constexpr double kEulerMargin = 0.7, kHeunMargin = 0.11;

Error bad(std::string what, std::string remedy) {
  return {ErrorKind::bad_input, std::move(what), "motion", std::move(remedy)};
}

bool at_least_zero(double x) {
  return std::isfinite(x) && x >= 0;
}

Result<void> check_springs(const MotionModel& model) {
  if (!model.springs.empty() && model.springs.size() != model.network.springs.size()) {
    return bad(fmt::format("{} viscosities are given for {} springs", model.springs.size(),
                           model.network.springs.size()),
               "Give one for each spring, or none");
  }
  for (std::size_t i = 0; i < model.springs.size(); ++i) {
    const SpringMotion& s = model.springs[i];
    if (!at_least_zero(s.viscosity) || !at_least_zero(s.cutoff_mm)) {
      return bad(
          fmt::format("spring {} has the viscosity {} and the cut-off {}", i, s.viscosity, s.cutoff_mm),
          "Both must be finite numbers of at least 0");
    }
  }
  return {};
}

Result<void> check(const MotionModel& model) {
  TURGOR_CHECK(validate(model.network));
  TURGOR_CHECK(check_springs(model));
  if (!model.mobile.empty() && model.mobile.size() != model.network.rest.size()) {
    return bad(fmt::format("{} points are told mobile or fixed, of {}", model.mobile.size(),
                           model.network.rest.size()),
               "Tell it of each point, or of none");
  }
  for (std::size_t i = 0; i < model.network.rest.size(); ++i) {
    const bool mobile = model.mobile.empty() || model.mobile[i] != 0;
    if (mobile && !(model.network.mass_g[i] > 0)) {
      return bad(fmt::format("the mobile point {} has no mass", i), "Give it one, or fix it");
    }
  }
  if (!is_finite(model.gravity_mm_ms2)) return bad("gravity is not finite", "Give an acceleration in mm/ms²");
  if (!at_least_zero(model.damping_g_ms)) {
    return bad(fmt::format("the damping is {} g/ms", model.damping_g_ms),
               "It must be a finite number of at least 0");
  }
  for (const Barrier& barrier : model.barriers) TURGOR_CHECK(validate(barrier));
  return {};
}

struct VolumePart {
  std::array<Vec3, 4> gradient;
  VolumeResponse response;
};

VolumePart volume_part(const VolumeElement& element, std::span<const Vec3> x) {
  const Vec3& o = x[element.p[0]];
  const Vec3 e1 = x[element.p[1]] - o, e2 = x[element.p[2]] - o, e3 = x[element.p[3]] - o;
  const std::array<Vec3, 4> gradient = volume_gradient(e1, e2, e3);
  return {gradient, respond(element, dot(e1, gradient[1]))};
}

}  // namespace

Result<TimeStepper> TimeStepper::prepare(MotionModel model) {
  TURGOR_CHECK(check(model));
  return TimeStepper(std::move(model));
}

TimeStepper::TimeStepper(MotionModel model) : model_(std::move(model)) {
  lay_out();
}

void TimeStepper::lay_out() {
  const auto& net = model_.network;
  for (const SpringLaw law : kLaws) {
    springs_.first_of_law.push_back(static_cast<int>(springs_.a.size()));
    for (std::size_t i = 0; i < net.springs.size(); ++i) {
      const Spring& s = net.springs[i];
      const int mobile_ends = static_cast<int>(is_mobile(s.a)) + static_cast<int>(is_mobile(s.b));
      if (s.law != law || mobile_ends == 0) continue;
      const double share = mobile_ends == 2 ? 0.5 : 1.0;
      const SpringMotion motion = model_.springs.empty() ? SpringMotion{} : model_.springs[i];
      springs_.a.push_back(s.a);
      springs_.b.push_back(s.b);
      springs_.rest_length.push_back(s.rest_length_mm);
      springs_.stiffness.push_back(share * s.stiffness_n);
      springs_.viscosity.push_back(share * motion.viscosity);
      springs_.cutoff.push_back(motion.cutoff_mm > 0 ? motion.cutoff_mm
                                                     : std::numeric_limits<double>::infinity());
    }
  }
  springs_.first_of_law.push_back(static_cast<int>(springs_.a.size()));

  const int points = static_cast<int>(net.rest.size());
  spring_incidence_ = make_incidence(points, 2 * static_cast<int>(springs_.a.size()), [&](int e) {
    return e % 2 == 0 ? springs_.a[e / 2] : springs_.b[e / 2];
  });
  volume_incidence_ = make_incidence(points, 4 * static_cast<int>(net.volumes.size()),
                                     [&](int e) { return net.volumes[e / 4].p[e % 4]; });
}

MotionState TimeStepper::rest() const {
  return {model_.network.rest, std::vector<Vec3>(model_.network.rest.size()), 0};
}

double TimeStepper::potential(std::span<const Vec3> x) const {
  double energy = 0;
  for (std::size_t l = 0; l < kLaws.size(); ++l) {
    const auto first = static_cast<std::size_t>(springs_.first_of_law[l]);
    const auto count = static_cast<std::size_t>(springs_.first_of_law[l + 1]) - first;
    energy += with_law(kLaws[l], [&]<SpringLaw law>() {
      return parallel_sum(count, kGrain, [&](std::size_t k) {
        const std::size_t i = first + k;
        const double length = distance(x[springs_.a[i]], x[springs_.b[i]]);
        if (length > springs_.cutoff[i]) return 0.0;
        return springs_.stiffness[i] * law_energy<law>(length, springs_.rest_length[i]);
      });
    });
  }
  const auto& net = model_.network;
  energy += parallel_sum(net.volumes.size(), kGrain,
                         [&](std::size_t i) { return volume_part(net.volumes[i], x).response.energy; });
  return energy + parallel_sum(x.size(), kGrain, [&](std::size_t i) {
           if (!is_mobile(static_cast<int>(i))) return 0.0;
           double own = -net.mass_g[i] * dot(model_.gravity_mm_ms2, x[i]);
           for (const Barrier& barrier : model_.barriers) own += respond(barrier, x[i]).energy;
           return own;
         });
}

double TimeStepper::kinetic(std::span<const Vec3> v) const {
  return parallel_sum(v.size(), kGrain,
                      [&](std::size_t i) { return 0.5 * model_.network.mass_g[i] * squared_length(v[i]); });
}

// All springs and volumes into arrays of their own, then each point gathers its own: no two threads write to
// one place.
int TimeStepper::evaluate(const MotionState& state, std::span<Vec3> forces, Workspace& w) const {
  const auto &x = state.position, &v = state.velocity;
  w.spring_force.resize(springs_.a.size());
  w.spring_slope.resize(springs_.a.size());
  int coincident = 0;
  for (std::size_t l = 0; l < kLaws.size(); ++l) {
    const auto first = static_cast<std::size_t>(springs_.first_of_law[l]);
    const auto count = static_cast<std::size_t>(springs_.first_of_law[l + 1]) - first;
    coincident += with_law(kLaws[l], [&]<SpringLaw law>() {
      return static_cast<int>(parallel_sum(count, kGrain, [&](std::size_t k) {
        const std::size_t i = first + k;
        const Vec3 d = x[springs_.b[i]] - x[springs_.a[i]];
        const double length = std::sqrt(squared_length(d));
        const bool acts = length > 0 && length <= springs_.cutoff[i];
        const double inverse = acts ? 1.0 / length : 0.0;
        const TensionSlope t = law_tension<law>(length, springs_.rest_length[i]);
        const double tension = springs_.stiffness[i] * t.tension;
        const double rate = dot(v[springs_.b[i]] - v[springs_.a[i]], d) * inverse;
        w.spring_force[i] = d * (inverse * (tension + springs_.viscosity[i] * rate));
        w.spring_slope[i] =
            acts ? std::max(springs_.stiffness[i] * t.slope, std::abs(tension) * inverse) : 0.0;
        return length > 0 ? 0.0 : 1.0;
      }));
    });
  }
  const auto& net = model_.network;
  w.volume_force.resize(4 * net.volumes.size());
  parallel_for(net.volumes.size(), kGrain, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      const VolumePart part = volume_part(net.volumes[i], x);
      for (std::size_t c = 0; c < 4; ++c)
        w.volume_force[4 * i + c] = part.gradient[c] * -part.response.mean_stress;
    }
  });
  parallel_for(x.size(), kGrain, [&](std::size_t begin, std::size_t end) {
    for (std::size_t p = begin; p < end; ++p) {
      forces[p] = {};
      if (!is_mobile(static_cast<int>(p))) continue;
      Vec3 sum = model_.gravity_mm_ms2 * net.mass_g[p] - v[p] * model_.damping_g_ms;
      for (int k = spring_incidence_.offsets[p]; k < spring_incidence_.offsets[p + 1]; ++k) {
        const int e = spring_incidence_.entries[k];
        sum += e % 2 == 0 ? w.spring_force[e / 2] : -w.spring_force[e / 2];
      }
      for (int k = volume_incidence_.offsets[p]; k < volume_incidence_.offsets[p + 1]; ++k) {
        sum += w.volume_force[volume_incidence_.entries[k]];
      }
      for (const Barrier& barrier : model_.barriers) sum += respond(barrier, x[p]).force;
      forces[p] = sum;
    }
  });
  return coincident;
}

int TimeStepper::forces(const MotionState& state, std::span<Vec3> forces) const {
  Workspace w;
  return evaluate(state, forces, w);
}

double TimeStepper::stable_step_ms(const MotionState& state, Integrator integrator) const {
  Workspace w;
  w.force.resize(state.position.size());
  evaluate(state, w.force, w);
  return stable_step(state, integrator, w);
}

// Of the springs as evaluate() has left them. Gershgorin: no eigenvalue of M⁻¹K exceeds the largest sum of a
// row, and a spring adds its stiffness to its ends' rows twice.
double TimeStepper::stable_step(const MotionState& state, Integrator integrator, Workspace& w) const {
  const auto& net = model_.network;
  const double fastest = parallel_reduce<double>(
      net.rest.size(), kGrain, 0.0,
      [&](std::size_t begin, std::size_t end) {
        double most = 0;
        for (std::size_t p = begin; p < end; ++p) {
          if (!is_mobile(static_cast<int>(p))) continue;
          double stiffness = 0, damping = model_.damping_g_ms;
          for (int k = spring_incidence_.offsets[p]; k < spring_incidence_.offsets[p + 1]; ++k) {
            const int i = spring_incidence_.entries[k] / 2;
            stiffness += 2 * w.spring_slope[i];
            damping += 2 * springs_.viscosity[i];
          }
          for (int k = volume_incidence_.offsets[p]; k < volume_incidence_.offsets[p + 1]; ++k) {
            const VolumeElement& element = net.volumes[volume_incidence_.entries[k] / 4];
            const VolumePart part = volume_part(element, state.position);
            double gradients = 0, reach = 0;
            for (const Vec3& g : part.gradient) gradients += length(g);
            for (const int c : element.p)
              reach = std::max(reach, distance(state.position[c], state.position[p]));
            stiffness +=
                part.response.slope * length(part.gradient[volume_incidence_.entries[k] % 4]) * gradients +
                std::abs(part.response.mean_stress) * reach;
          }
          for (const Barrier& barrier : model_.barriers)
            stiffness += respond(barrier, state.position[p]).stiffness;
          const double mass = net.mass_g[p], decay = 0.5 * damping / mass;
          most = std::max(most, std::sqrt(stiffness / mass + decay * decay) + decay);
        }
        return most;
      },
      [](double a, double b) { return std::max(a, b); });
  const double margin = integrator == Integrator::euler ? kEulerMargin : kHeunMargin;
  return fastest > 0 ? margin * 2 / fastest : std::numeric_limits<double>::infinity();
}

void TimeStepper::euler(MotionState& state, double dt, Workspace& w) const {
  parallel_for(state.position.size(), kGrain, [&](std::size_t begin, std::size_t end) {
    for (std::size_t p = begin; p < end; ++p) {
      if (!is_mobile(static_cast<int>(p))) continue;
      state.velocity[p] += w.force[p] * (dt / model_.network.mass_g[p]);
      state.position[p] += state.velocity[p] * dt;
    }
  });
}

void TimeStepper::heun(MotionState& state, double dt, Workspace& w) const {
  MotionState& ahead = w.ahead;
  ahead = state;
  for (std::size_t p = 0; p < state.position.size(); ++p) {
    if (!is_mobile(static_cast<int>(p))) continue;
    ahead.position[p] += state.velocity[p] * dt;
    ahead.velocity[p] += w.force[p] * (dt / model_.network.mass_g[p]);
  }
  w.next_force.resize(w.force.size());
  evaluate(ahead, w.next_force, w);
  for (std::size_t p = 0; p < state.position.size(); ++p) {
    if (!is_mobile(static_cast<int>(p))) continue;
    state.position[p] += (state.velocity[p] + ahead.velocity[p]) * (0.5 * dt);
    state.velocity[p] += (w.force[p] + w.next_force[p]) * (0.5 * dt / model_.network.mass_g[p]);
  }
}

Result<StepReport> TimeStepper::step(MotionState& state, double dt_ms, Integrator integrator,
                                     Context& context, Workspace& w) const {
  if (!(dt_ms > 0 && std::isfinite(dt_ms)))
    return bad(fmt::format("the time step is {} ms", dt_ms), "It must be above 0");
  const std::size_t points = model_.network.rest.size();
  if (state.position.size() != points || state.velocity.size() != points) {
    return bad(fmt::format("the state has {} positions and {} velocities for {} points",
                           state.position.size(), state.velocity.size(), points),
               "Start from rest()");
  }
  MotionState& next = w.next;
  next = state;
  w.force.resize(points);
  StepReport report;
  report.sub_steps = 0;
  for (double left = dt_ms; left > 0;) {
    TURGOR_CHECK(context.check());
    const int coincident = evaluate(next, w.force, w);
    const double stable = stable_step(next, integrator, w), parts = std::max(1.0, std::ceil(left / stable));
    if (!(parts + report.sub_steps <= kMostSubSteps)) {
      return bad(fmt::format("a step of {:g} ms would take more than {} stable steps of {:g} ms", dt_ms,
                             kMostSubSteps, stable),
                 "Make the springs softer, the masses larger, or the step shorter");
    }
    if (report.sub_steps == 0) report.stable_step_ms = stable, report.coincident_springs = coincident;
    const double dt = left / parts;
    integrator == Integrator::euler ? euler(next, dt, w) : heun(next, dt, w);
    left = parts > 1 ? left - dt : 0;
    ++report.sub_steps;
  }
  const auto gone = std::find_if_not(next.position.begin(), next.position.end(), is_within_reach);
  if (gone != next.position.end()) {
    return bad(
        fmt::format("point {} leaves for more than a thousand kilometres", gone - next.position.begin()),
        "Make gravity or the forces on it smaller");
  }
  next.time_ms += dt_ms;
  std::swap(state, next);
  return report;
}

}  // namespace turgor
