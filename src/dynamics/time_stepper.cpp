#include "turgor/dynamics/time_stepper.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "dynamics/motion_check.hpp"
#include "dynamics/network_blocks.hpp"
#include "dynamics/solid_blocks.hpp"
#include "math/lanes.hpp"
#include "tissue/spring_law.hpp"
#include "turgor/core/index.hpp"
#include "turgor/core/parallel.hpp"

namespace turgor {
namespace {

using Quad = TimeStepper::Workspace::Quad;
using Wants = NetworkBlocks::Wants;
using detail::bad_motion;
using detail::prepare_contact;

constexpr std::size_t kGrain = 2048;
constexpr std::size_t kAhead = 16;     // points whose memory is fetched before its turn
constexpr std::size_t kMostRuns = 64;  // of blocks, each with scratch memory of its own
constexpr int kMostSubSteps = 100'000, kMostAdvances = 1'000'000;

// Both integrators are stable for steps h < 2/f, f = √(ω² + d²) + d of an oscillation of the frequency ω and
// the decay d, or nearly so: Heun where dh < 1 and (ωh)² < 4 (1 − dh + (dh)²), to which h < √3/f suffices.
// Without decay neither lets an oscillation grow or fade. The parts of 1/f that are taken leave room for
// stiffness that grows within a step.
// Verlet's leapfrog has Euler's bound, and takes the same part.
constexpr double kEulerPart = 1.4, kHeunPart = 1.0;

// Barriers count for more than they are: they let go within a step, and what a long one gains at that keeps
// tissue trembling on them. Draped over a hard ball it comes to rest from 9 on (to a third of the step).
constexpr double kBarrierWeight = 9;

}  // namespace

struct TimeStepper::Outcome {
  double fastest = 0;  ///< bound of the eigenvalues of the motion, 1/ms
  int coincident = 0;
  int gone = std::numeric_limits<int>::max();  ///< first point that leaves every bound
  double error = 0;                            ///< of the step, mm
  double solids = 0;                           ///< bound of ω² of solids, 1/ms²

  // What a velocity that is not finite leads to is not within reach.
  void check_point(int point, const Vec3& x) {
    if (!is_within_reach(x)) gone = std::min(gone, point);
  }
  void add_frequency(double stiffness, double mass, double decay) {
    // √(k/m + d²) + d, the root only where it tells.
    const double own = stiffness > 0 ? stiffness / mass : 0;
    const double square = solids + own + decay * decay, least = fastest - decay;
    if (least <= 0 || square > least * least) fastest = std::max(fastest, std::sqrt(square) + decay);
  }
  [[nodiscard]] bool is_gone() const { return gone != std::numeric_limits<int>::max(); }
  [[nodiscard]] Error departure() const {
    return bad_motion(fmt::format("point {} leaves for more than a thousand kilometres", gone),
                      "Make gravity or the forces on it smaller");
  }
  static Outcome worst(const Outcome& a, const Outcome& b) {
    return {std::max(a.fastest, b.fastest), a.coincident + b.coincident, std::min(a.gone, b.gone),
            a.error > b.error ? a.error : b.error, std::max(a.solids, b.solids)};
  }
};

struct TimeStepper::SubStep {
  double parts;      ///< of the time left, the first of which was taken; not taken where these are too many
  double stable_ms;  ///< at the start
  Outcome outcome;   ///< of the last pass
  int coincident = 0;
};

Result<TimeStepper> TimeStepper::prepare(MotionModel model) {
  TURGOR_CHECK(detail::check(model));
  TURGOR_TRY(auto contact, prepare_contact(model));
  TimeStepper stepper(std::move(model), std::move(contact));
  if (const int stray = stepper.solids_->stray(); stray >= 0) {
    return bad_motion(
        fmt::format("solid {} has an edge or triangle that is of no tetrahedron, or twice", stray),
        "Find them with make_solid");
  }
  return stepper;
}

TimeStepper::TimeStepper(TimeStepper&&) noexcept = default;
TimeStepper& TimeStepper::operator=(TimeStepper&&) noexcept = default;
TimeStepper::~TimeStepper() = default;

TimeStepper::TimeStepper(MotionModel model, std::optional<SurfaceContact> contact)
    : model_(std::move(model)), contact_(std::move(contact)) {
  const auto& net = model_.network;
  const int points = static_cast<int>(net.rest.size());
  std::vector<double> share(net.springs.size()), damping(net.rest.size(), model_.damping_g_ms);
  for (std::size_t i = 0; i < share.size(); ++i) {
    const Spring& s = net.springs[i];
    share[i] = acting_share(s);
    if (model_.springs.empty()) continue;
    for (const int end : {s.a, s.b}) damping[at(end)] += 2 * share[i] * model_.springs[i].viscosity;
    if (model_.springs[i].relaxes) relaxing_.push_back({static_cast<int>(i), share[i]});
  }
  blocks_ = std::make_unique<NetworkBlocks>(model_, share);
  solids_ = std::make_unique<SolidBlocks>(model_);
  decay_.resize(net.rest.size());
  for (int p = 0; p < points; ++p) {
    if (!is_mobile(p)) {
      fixed_.push_back(p);
      continue;
    }
    decay_[at(p)] = 0.5 * damping[at(p)] / net.mass_g[at(p)];
  }
  barriers_of_ = {model_.barriers, net.rest.size()};
}

double TimeStepper::acting_share(const Spring& s) const {
  const int mobile_ends = static_cast<int>(is_mobile(s.a)) + static_cast<int>(is_mobile(s.b));
  return mobile_ends == 2 ? 0.5 : mobile_ends;
}

Result<void> TimeStepper::set_rest_length(int spring, double rest_length_mm) {
  auto& springs = model_.network.springs;
  TURGOR_CHECK(detail::check_rest_length(spring, rest_length_mm, springs.size()));
  springs[at(spring)].rest_length_mm = rest_length_mm;
  blocks_->set_rest_length(spring, rest_length_mm);
  return {};
}

Result<void> TimeStepper::set_barriers(std::vector<Barrier> barriers) {
  TURGOR_CHECK(detail::check_barriers(barriers, model_.network.rest.size()));
  model_.barriers = std::move(barriers);
  barriers_of_ = {model_.barriers, model_.network.rest.size()};
  return {};
}

MotionState TimeStepper::rest() const {
  MotionState state{model_.network.rest, std::vector<Vec3>(model_.network.rest.size()), 0};
  state.relaxed.resize(relaxing_.size());
  return state;
}

double TimeStepper::viscous_decay(int point) const {
  if (model_.springs.empty()) return 0;
  return std::max(0.0, decay_[at(point)] - 0.5 * model_.damping_g_ms / model_.network.mass_g[at(point)]);
}

void TimeStepper::add_relaxation(const MotionState& state, Workspace& w) const {
  w.elastic.resize(relaxing_.size());
  w.offset.resize(relaxing_.size());
  parallel_for(relaxing_.size(), kGrain, [&](std::size_t begin, std::size_t end) {
    for (std::size_t j = begin; j < end; ++j) {
      const std::size_t i = at(relaxing_[j].spring);
      const Spring& s = model_.network.springs[i];
      const double l = distance(state.position[at(s.a)], state.position[at(s.b)]);
      const double cutoff = model_.springs[i].cutoff_mm;
      const bool acts = l > 0 && !(cutoff > 0 && l > cutoff);
      const double tension =
          with_law(s.law, [&]<SpringLaw law>() { return law_tension<law>(l, s.rest_length_mm).tension; });
      w.elastic[j] = acts ? relaxing_[j].share * s.stiffness_n * tension : 0.0;
      w.offset[j] = 0;
      for (const double q : state.relaxed[j]) w.offset[j] += q;
    }
  });
}

// All forces of every mobile point, block by block: move(point, mass, x, v, force, outcome) may write what
// belongs to its point, mostly in `target`, but not the state. Where only forces are wanted, of stiffness the
// outcome tells that of barriers alone. `damping_counts`: as a decay that limits the step.
template <auto wants, class Move>
TimeStepper::Outcome TimeStepper::pass(const MotionState& state, const MotionState& target, Workspace& w,
                                       Move&& move, bool damping_counts) const {
  add_relaxation(state, w);
  add_applied(state, w);
  const bool has_solids = !solids_->empty(), has_barriers = !model_.barriers.empty();
  const double fastest_solids = has_solids ? solids_->sum(state.position, w) : 0;
  const SolidBlocks::Reader solid_force = solids_->reader(w);
  const std::size_t run = std::max<std::size_t>(1, (blocks_->count() + kMostRuns - 1) / kMostRuns);
  w.scratch.resize(std::max(w.scratch.size(), (blocks_->count() + run - 1) / run));
  // Pointers of their own, which what is written cannot change.
  const double *const masses = model_.network.mass_g.data(), *const decays = decay_.data();
  const Vec3 gravity = model_.gravity_mm_ms2;
  const double damping = model_.damping_g_ms;
  const Quad* const applied = w.applied.empty() ? nullptr : w.applied.data();
  const auto point = [=, this](int p, const Vec3& x, const Vec3& v, const Quad& elastic, Outcome& o) {
    const double mass = masses[at(p)];
    Vec3 force = gravity * mass - v * damping;
    force += {elastic.v[0], elastic.v[1], elastic.v[2]};
    if (has_solids) force += solid_force(p);
    double stiffness = elastic.v[3];
    if (has_barriers) {
      barriers_of_.visit(p, [&](int b) {
        const Vec3 here = x;  // so that x itself need not have an address, and stays in registers
        const BarrierResponse r = respond(model_.barriers[at(b)], here);
        force += r.force;
        stiffness += kBarrierWeight * r.stiffness;
      });
    }
    if (applied != nullptr) {
      const Quad& a = applied[at(p)];
      force += {a.v[0], a.v[1], a.v[2]};
      stiffness += a.v[3];
    }
    move(p, mass, x, v, force, o);
    o.add_frequency(stiffness, mass, damping_counts ? decays[at(p)] : viscous_decay(p));
  };
  const auto fetch = [=, x = state.position.data(), v = state.velocity.data(), to_x = target.position.data(),
                      to_v = target.velocity.data()](int p, bool bare) {
    __builtin_prefetch(&masses[at(p)]);
    __builtin_prefetch(&decays[at(p)]);
    __builtin_prefetch(&to_x[at(p)], 1);
    __builtin_prefetch(&to_v[at(p)], 1);
    if (!bare) return;
    __builtin_prefetch(&x[at(p)]);
    __builtin_prefetch(&v[at(p)]);
  };
  return parallel_reduce(
      blocks_->count(), run, Outcome{},
      [&](std::size_t begin, std::size_t end) {
        Outcome o;
        if constexpr (wants == Wants::stiffness) o.solids = fastest_solids;
        for (std::size_t block = begin; block < end; ++block) {
          const auto sums = blocks_->sum<Lanes, wants>(block, state, w.offset, w.scratch[begin / run]);
          o.coincident += sums.coincident;
          for (std::size_t i = 0; i < sums.points.size(); ++i) {
            const int p = sums.points[i];
            if (i + kAhead < sums.points.size()) fetch(sums.points[i + kAhead], sums.bare);
            const auto copied = [](const Quad& q) { return Vec3{q.v[0], q.v[1], q.v[2]}; };
            const Vec3 x = sums.bare ? state.position[at(p)] : copied(sums.position[i]);
            const Vec3 v = sums.bare ? state.velocity[at(p)] : copied(sums.velocity[i]);
            point(p, x, v, sums.bare ? Quad{} : sums.force[i], o);
          }
        }
        return o;
      },
      Outcome::worst);
}

int TimeStepper::forces(const MotionState& state, std::span<Vec3> forces) const {
  Workspace w;
  for (const int p : fixed_) forces[at(p)] = {};
  return pass<Wants::forces>(state, state, w,
                             [&](int p, double, const Vec3&, const Vec3&, const Vec3& force, Outcome&) {
                               forces[at(p)] = force;
                             })
      .coincident;
}

double TimeStepper::stable_step_ms(const MotionState& state, Integrator integrator) const {
  Workspace w;
  return stable_step(pass<Wants::stiffness>(
                         state, state, w, [](int, double, const Vec3&, const Vec3&, const Vec3&, Outcome&) {},
                         integrator != Integrator::verlet),
                     integrator);
}

double TimeStepper::stable_step(const Outcome& outcome, Integrator integrator) const {
  if (!(outcome.fastest > 0)) return std::numeric_limits<double>::infinity();
  return (integrator == Integrator::heun ? kHeunPart : kEulerPart) / outcome.fastest;
}

// Sizes, and the points that are led.
void TimeStepper::prepare_target(const MotionState& from, MotionState& to, double dt) const {
  to.position.resize(from.position.size());
  to.velocity.resize(from.velocity.size());
  to.relaxed.resize(from.relaxed.size());
  for (const int p : fixed_) {
    to.position[at(p)] = from.position[at(p)] + from.velocity[at(p)] * dt;
    to.velocity[at(p)] = from.velocity[at(p)];
  }
}

// Exact for a tension that stays as it is during the step, hence stable for every step.
void TimeStepper::relax(const MotionState& from, MotionState& to, double dt,
                        std::span<const double> elastic) const {
  if (relaxing_.empty()) return;
  std::array<double, kRelaxations> gained;
  for (std::size_t i = 0; i < kRelaxations; ++i) gained[i] = -std::expm1(-dt / model_.relaxation[i].time_ms);
  parallel_for(relaxing_.size(), kGrain, [&](std::size_t begin, std::size_t end) {
    for (std::size_t j = begin; j < end; ++j) {
      for (std::size_t i = 0; i < kRelaxations; ++i) {
        const double q = from.relaxed[j][i];
        to.relaxed[j][i] = q + gained[i] * (model_.relaxation[i].share * elastic[j] - q);
      }
    }
  });
}

// Euler's step or Verlet's. With the damping −c v among the forces, (1 − a) v + dt (F + c v)/m over 1 + a is
// v + dt F/(m + c dt/2).
TimeStepper::Outcome TimeStepper::leap(const MotionState& from, MotionState& to, double dt,
                                       Integrator integrator, Workspace& w) const {
  prepare_target(from, to, dt);
  const bool is_verlet = integrator == Integrator::verlet;
  const double added_mass = is_verlet ? 0.5 * dt * model_.damping_g_ms : 0;
  const Outcome outcome = pass<Wants::stiffness>(
      from, to, w,
      [=, position = to.position.data(), velocity = to.velocity.data()](
          int p, double mass, const Vec3& x, const Vec3& v, const Vec3& force, Outcome& o) {
        const Vec3 faster = v + force * (dt / (mass + added_mass)), there = x + faster * dt;
        velocity[at(p)] = faster;
        position[at(p)] = there;
        o.check_point(p, there);
      },
      !is_verlet);
  relax(from, to, dt, w.elastic);
  return outcome;
}

// Heun's first half: an explicit Euler step to w.ahead.
TimeStepper::Outcome TimeStepper::predict(const MotionState& from, double dt, Workspace& w) const {
  prepare_target(from, w.ahead, dt);
  w.force.resize(from.position.size());
  const Outcome outcome = pass<Wants::stiffness>(
      from, w.ahead, w, [&](int p, double mass, const Vec3& x, const Vec3& v, const Vec3& force, Outcome&) {
        w.force[at(p)] = force;
        w.ahead.position[at(p)] = x + v * dt;
        w.ahead.velocity[at(p)] = v + force * (dt / mass);
      });
  relax(from, w.ahead, dt, w.elastic);
  std::swap(w.elastic, w.elastic_before);
  return outcome;
}

TimeStepper::Outcome TimeStepper::correct(const MotionState& from, MotionState& to, double dt,
                                          Workspace& w) const {
  prepare_target(from, to, dt);
  const auto move = [&](int p, double mass, const Vec3& x, const Vec3& v, const Vec3& force, Outcome& o) {
    const Vec3& before = from.velocity[at(p)];
    const Vec3 faster = before + (w.force[at(p)] + force) * (0.5 * dt / mass);
    const Vec3 there = from.position[at(p)] + (before + faster) * (0.5 * dt);
    to.position[at(p)] = there;
    to.velocity[at(p)] = faster;
    o.check_point(p, there);
    o.error = std::max(o.error, std::max(distance(there, x), distance(faster, v) * dt));
  };
  const Outcome outcome = pass<Wants::forces>(w.ahead, to, w, move);
  parallel_for(relaxing_.size(), kGrain, [&](std::size_t begin, std::size_t end) {
    for (std::size_t j = begin; j < end; ++j) w.elastic[j] = 0.5 * (w.elastic[j] + w.elastic_before[j]);
  });
  relax(from, to, dt, w.elastic);
  return outcome;
}

Result<void> TimeStepper::check_state(const MotionState& state) const {
  const std::size_t points = model_.network.rest.size();
  if (state.position.size() != points || state.velocity.size() != points ||
      state.relaxed.size() != relaxing_.size()) {
    return bad_motion(
        fmt::format("the state has {} positions, {} velocities and {} relaxed springs for {} points and {}",
                    state.position.size(), state.velocity.size(), state.relaxed.size(), points,
                    relaxing_.size()),
        "Start from rest()");
  }
  return {};
}

// The forces tell how far is stable, and the same pass moves the points: by the last stable step at first,
// again where that was not the right one. Tissue changes its stiffness little within such a step, but a
// barrier is met at once: where Heun's step ends within one that is too stiff for it, it is taken again.
TimeStepper::SubStep TimeStepper::sub_step(const MotionState& from, MotionState& to, double left,
                                           int most_parts, Integrator integrator, Workspace& w) const {
  const bool is_heun = integrator == Integrator::heun;
  const auto begin = [&](double dt) {
    return is_heun ? predict(from, dt, w) : leap(from, to, dt, integrator, w);
  };
  const auto parts_of = [&](double stable) { return std::max(1.0, std::ceil(left / stable)); };
  const double guess = w.guess_ms > 0 ? std::min<double>(most_parts, parts_of(w.guess_ms)) : 1.0;
  SubStep s{guess, 0, begin(left / guess)};
  s.coincident = s.outcome.coincident;
  s.stable_ms = w.guess_ms = stable_step(s.outcome, integrator);
  s.parts = parts_of(s.stable_ms);
  if (s.parts != guess && s.parts <= most_parts) s.outcome = begin(left / s.parts);
  while (is_heun && s.parts <= most_parts) {
    s.outcome = correct(from, to, left / s.parts, w);
    const double met = parts_of(stable_step(s.outcome, integrator));
    if (met <= s.parts) break;
    s.parts = met;
    if (s.parts <= most_parts) predict(from, left / s.parts, w);
  }
  return s;
}

Result<StepReport> TimeStepper::step(MotionState& state, double dt_ms, Integrator integrator,
                                     Context& context, Workspace& w) const {
  if (!(dt_ms > 0 && std::isfinite(dt_ms)))
    return bad_motion(fmt::format("the time step is {} ms", dt_ms), "It must be above 0");
  TURGOR_CHECK(check_state(state));
  MotionState *from = &state, *to = &w.next, *other = &w.spare;
  StepReport report;
  report.sub_steps = 0;
  for (double left = dt_ms; left > 0; ++report.sub_steps) {
    TURGOR_CHECK(context.check());
    const int most_parts = kMostSubSteps - report.sub_steps;
    const SubStep s = sub_step(*from, *to, left, most_parts, integrator, w);
    if (!(s.parts <= most_parts)) {
      return bad_motion(fmt::format("a step of {:g} ms would take more than {} stable steps of {:g} ms",
                                    dt_ms, kMostSubSteps, s.stable_ms),
                        "Make the springs softer, the masses larger, or the step shorter");
    }
    if (s.outcome.is_gone()) return s.outcome.departure();
    if (report.sub_steps == 0) report.stable_step_ms = s.stable_ms, report.coincident_springs = s.coincident;
    report.held_points += finish_contact(*from, *to, left / s.parts, integrator, w);
    left = s.parts > 1 ? left - left / s.parts : 0;
    MotionState* const free = from == &state ? other : from;
    from = to;
    to = free;
  }
  from->time_ms = state.time_ms + dt_ms;
  std::swap(state, *from);
  return report;
}

Result<AdvanceReport> TimeStepper::advance(MotionState& state, double duration_ms, const StepControl& control,
                                           Context& context, Workspace& w) const {
  TURGOR_CHECK(detail::check_control(duration_ms, control));
  TURGOR_CHECK(check_state(state));
  MotionState *from = &state, *to = &w.next, *other = &w.spare;
  AdvanceReport report;
  report.shortest_ms = std::numeric_limits<double>::infinity();
  double wanted = std::min(control.longest_ms, duration_ms);
  int tries = 0;
  for (double left = duration_ms; left > 0; ++tries) {
    TURGOR_CHECK(context.check());
    const double parts = std::max(1.0, std::ceil(left / wanted)), dt = left / parts;
    if (!(tries < kMostAdvances && wanted > 0)) {
      return bad_motion(fmt::format("{:g} ms would take more than {} steps", duration_ms, kMostAdvances),
                        "Allow a larger error, make the springs softer, or the masses larger");
    }
    const double stable = stable_step(predict(*from, dt, w), Integrator::heun);
    if (dt > stable) {
      wanted = stable;
      continue;
    }
    const Outcome outcome = correct(*from, *to, dt, w);
    if (const double met = stable_step(outcome, Integrator::heun); dt > met) {  // in a barrier
      wanted = met;
      continue;
    }
    // The local error grows as the square of the step.
    const double ratio = outcome.is_gone() ? 0.0 : std::sqrt(control.tolerance_mm / outcome.error);
    const bool within = ratio >= 1, shortest = dt <= control.shortest_ms;
    wanted = std::clamp(dt * std::clamp(0.9 * ratio, 0.2, 3.0), control.shortest_ms, control.longest_ms);
    if (!within && !shortest) {
      ++report.rejected;
      continue;
    }
    if (outcome.is_gone()) return outcome.departure();
    report.held_points += finish_contact(*from, *to, dt, Integrator::heun, w);
    ++report.accepted;
    if (!within) ++report.beyond_tolerance;
    report.shortest_ms = std::min(report.shortest_ms, dt);
    report.longest_ms = std::max(report.longest_ms, dt);
    left = parts > 1 ? left - dt : 0;
    MotionState* const free = from == &state ? other : from;
    from = to;
    to = free;
  }
  from->time_ms = state.time_ms + duration_ms;
  std::swap(state, *from);
  return report;
}

}  // namespace turgor
