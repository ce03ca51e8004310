#include "turgor/dynamics/implicit_stepper.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "dynamics/equilibrium_detail.hpp"
#include "dynamics/motion_check.hpp"
#include "turgor/core/index.hpp"

namespace turgor {
namespace {

using detail::bad_motion;

constexpr int kMostNewtonSteps = 100;

PrescribedMotion fixed_points(const MotionModel& model) {
  PrescribedMotion motion;
  for (std::size_t p = 0; p < model.mobile.size(); ++p) {
    if (model.mobile[p] == 0) motion.fixed.push_back(static_cast<int>(p));
  }
  return motion;
}

Loads loads_of(const MotionModel& model) {
  return {{}, model.gravity_mm_ms2, model.barriers, model.grabs};
}

void warn_of_what_does_not_act(const MotionModel& model, Context& context) {
  const auto warn_if = [&](auto&& has, const char* what) {
    if (const auto n = std::count_if(model.springs.begin(), model.springs.end(), has); n > 0)
      context.warning(fmt::format("the {} of {} springs does not act in implicit steps", what, n));
  };
  warn_if([](const SpringMotion& s) { return s.viscosity > 0; }, "viscosity");
  warn_if([](const SpringMotion& s) { return s.cutoff_mm > 0; }, "cut-off");
  warn_if([](const SpringMotion& s) { return s.relaxes; }, "relaxation");
}

Result<void> check_state(const MotionState& state, std::size_t points) {
  if (state.position.size() != points || state.velocity.size() != points) {
    return bad_motion(fmt::format("the state has {} positions and {} velocities for {} points",
                                  state.position.size(), state.velocity.size(), points),
                      "Start from rest()");
  }
  for (std::size_t p = 0; p < points; ++p) {
    if (!is_within_reach(state.position[p]) || !is_finite(state.velocity[p]))
      return bad_motion(fmt::format("the position or velocity of point {} is not finite", p),
                        "Coordinates reach to 1e9 mm");
  }
  return {};
}

Error too_far() {
  return bad_motion("points leave for more than a thousand kilometres, or forces are not finite",
                    "Make the step, the velocities or the forces smaller");
}

}  // namespace

struct ImplicitStepper::Parts {
  MotionModel model;
  std::optional<SurfaceContact> contact;
  SurfaceContact::Workspace touching;
  Loads loads;  // without contact
  NetworkEnergy energy;
  Newton newton;
  PointTerms terms;
  Inertia inertia;
  EquilibriumState from_place, from_ahead;

  Parts(MotionModel m, NetworkEnergy e, std::optional<SurfaceContact> c)
      : model(std::move(m)),
        contact(std::move(c)),
        loads(loads_of(model)),
        energy(std::move(e)),
        newton(energy,
               cluster_free_points(model.network, energy, fixed_points(model), BlockCg::kClusterPoints),
               !model.network.solids.empty()),
        terms(model.network, energy, newton.unknowns()) {
    terms.set_loads(loads);
  }
  Result<void> change_loads(Loads next) {
    TURGOR_CHECK(validate(next, model.network.rest.size()));
    loads = std::move(next);
    terms.set_loads(loads);
    return {};
  }
  void add_contact(const MotionState& state);
  // Inertia holds every free point; without it and without fixed ones the matrix may be singular.
  [[nodiscard]] double rest_damping() const {
    return newton.unknowns().size() == model.network.rest.size() ? Newton::kSingularDamping : 0;
  }
  void prepare_inertia(const MotionState& state, double dt_ms);
  EquilibriumState* choose_start();
};

// A point that touches a face is kept off the plane in which the face lies at the start of the step, so that
// no step is too long for it; the face takes the force that the point has at the start.
void ImplicitStepper::Parts::add_contact(const MotionState& state) {
  if (!contact) return;
  Loads all = loads;
  const double k = contact->model().stiffness_n_mm;
  for (const ContactTouch& touch : contact->find(state.position, touching)) {
    const Vec3& x = state.position[at(touch.points[0])];
    Barrier off;
    off.shape = Barrier::Shape::plane;
    off.plane = Plane::through(x + touch.normal * touch.depth_mm, touch.normal);
    off.stiffness_n = k;
    off.points = {touch.points[0]};
    all.barriers.push_back(std::move(off));
    all.force_n.resize(state.position.size());
    for (std::size_t i = 1; i < 4; ++i)
      all.force_n[at(touch.points[i])] += touch.normal * (touch.weights[i] * k * touch.depth_mm);
  }
  terms.set_loads(std::move(all));
}

// Points that are led lie where they are to be from the first.
void ImplicitStepper::Parts::prepare_inertia(const MotionState& state, double dt_ms) {
  inertia.dt_ms = dt_ms;
  inertia.damping_g_ms = model.damping_g_ms;
  inertia.ahead = state.position;
  for (std::size_t p = 0; p < inertia.ahead.size(); ++p) inertia.ahead[p] += state.velocity[p] * dt_ms;
  inertia.from = inertia.ahead;
  for (const int p : newton.unknowns()) inertia.from[at(p)] = state.position[at(p)];
  terms.set_inertia(&inertia);
  newton.restart(&terms, 0);
}

// Where points are, or would be without forces, whichever costs less; null where neither can be computed.
EquilibriumState* ImplicitStepper::Parts::choose_start() {
  from_place.positions = inertia.from;
  from_ahead.positions = inertia.ahead;
  const bool place = newton.evaluate(from_place), ahead = newton.evaluate(from_ahead);
  if (!place && !ahead) return nullptr;
  return ahead && (!place || from_ahead.energy < from_place.energy) ? &from_ahead : &from_place;
}

Result<ImplicitStepper> ImplicitStepper::prepare(const MotionModel& model, Context& context) {
  TURGOR_CHECK(detail::check(model));
  TURGOR_CHECK(validate(loads_of(model), model.network.rest.size()));
  TURGOR_TRY(NetworkEnergy energy, NetworkEnergy::prepare(model.network));
  warn_of_what_does_not_act(model, context);
  TURGOR_TRY(auto contact, detail::prepare_contact(model));
  return ImplicitStepper(std::make_unique<Parts>(model, std::move(energy), std::move(contact)));
}

ImplicitStepper::ImplicitStepper(std::unique_ptr<Parts> parts) : parts_(std::move(parts)) {}
ImplicitStepper::ImplicitStepper(ImplicitStepper&&) noexcept = default;
ImplicitStepper& ImplicitStepper::operator=(ImplicitStepper&&) noexcept = default;
ImplicitStepper::~ImplicitStepper() = default;

Result<void> ImplicitStepper::set_rest_length(int spring, double rest_length_mm) {
  const auto& springs = parts_->model.network.springs;
  TURGOR_CHECK(detail::check_rest_length(spring, rest_length_mm, springs.size()));
  parts_->energy.set_rest_length(spring, rest_length_mm);
  return {};
}

Result<void> ImplicitStepper::set_barriers(std::vector<Barrier> barriers) {
  Loads loads = parts_->loads;
  loads.barriers = std::move(barriers);
  return parts_->change_loads(std::move(loads));
}

Result<void> ImplicitStepper::set_grabs(std::vector<Grab> grabs) {
  Loads loads = parts_->loads;
  loads.grabs = std::move(grabs);
  return parts_->change_loads(std::move(loads));
}

Result<ImplicitReport> ImplicitStepper::step(MotionState& state, double dt_ms, Context& context,
                                             double relative_residual) {
  if (!(std::isfinite(dt_ms) && dt_ms > 0))
    return bad_motion(fmt::format("the step is {} ms", dt_ms), "It must be a finite number above 0");
  if (!(std::isfinite(relative_residual) && relative_residual > 0))
    return bad_motion(fmt::format("the relative residual asked for is {}", relative_residual),
                      "It must lie above 0");
  TURGOR_CHECK(check_state(state, parts_->model.network.rest.size()));
  Parts& p = *parts_;
  p.add_contact(state);
  p.prepare_inertia(state, dt_ms);
  EquilibriumState* found = p.choose_start();
  if (found == nullptr) return too_far();
  TURGOR_TRY(const bool converged, p.newton.descend(*found, relative_residual, kMostNewtonSteps, context));
  for (std::size_t i = 0; i < state.position.size(); ++i)
    state.velocity[i] = (found->positions[i] - state.position[i]) / dt_ms;
  if (p.contact) {
    p.contact->slow(p.touching, dt_ms, dt_ms, found->positions, state.velocity);
    p.contact->stop(state.position, found->positions, state.velocity, p.touching);
  }
  state.position.swap(found->positions);
  state.time_ms += dt_ms;
  return ImplicitReport{p.newton.steps(), p.newton.linear_iterations(), converged};
}

Result<EquilibriumResult> ImplicitStepper::settle(MotionState& state, const EquilibriumOptions& options,
                                                  Context& context) {
  const Stage stage(context, "equilibrium");
  TURGOR_CHECK(detail::check_options(options));
  TURGOR_CHECK(check_state(state, parts_->model.network.rest.size()));
  Parts& p = *parts_;
  p.terms.set_loads(p.loads);
  p.terms.set_inertia(nullptr);
  p.newton.restart(&p.terms, p.rest_damping());
  EquilibriumState at_rest{state.position, {}, 0};
  if (!p.newton.evaluate(at_rest)) return too_far();
  TURGOR_TRY(const bool converged,
             p.newton.descend(at_rest, options.relative_residual, options.max_newton_steps, context));
  state.position = at_rest.positions;
  std::fill(state.velocity.begin(), state.velocity.end(), Vec3{});
  return detail::result_of(p.newton, p.energy, std::move(at_rest), options, converged, context);
}

}  // namespace turgor
