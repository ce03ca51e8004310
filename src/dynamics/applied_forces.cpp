// Forces on points from beyond the network: grabs and contact.
#include <cmath>

#include "dynamics/motion_check.hpp"
#include "turgor/core/index.hpp"
#include "turgor/dynamics/time_stepper.hpp"

namespace turgor {
namespace {

// As barriers, contact lets go within a step.
constexpr double kContactWeight = 4;

void add_to(TimeStepper::Workspace::Quad& sum, const Vec3& force, double stiffness) {
  sum.v[0] += force.x, sum.v[1] += force.y, sum.v[2] += force.z, sum.v[3] += stiffness;
}

}  // namespace

Result<std::optional<SurfaceContact>> detail::prepare_contact(const MotionModel& model) {
  if (!model.contact) return std::optional<SurfaceContact>{};
  const auto& net = model.network;
  std::vector<double> inverse_mass(net.rest.size());
  for (std::size_t i = 0; i < inverse_mass.size(); ++i) {
    const bool mobile = model.mobile.empty() || model.mobile[i] != 0;
    inverse_mass[i] = mobile ? 1 / net.mass_g[i] : 0;
  }
  TURGOR_TRY(auto contact, SurfaceContact::prepare(*model.contact, net.rest, inverse_mass));
  return std::optional(std::move(contact));
}

Result<void> TimeStepper::set_grabs(std::vector<Grab> grabs) {
  for (const Grab& grab : grabs) TURGOR_CHECK(validate(grab, model_.network.rest.size()));
  model_.grabs = std::move(grabs);
  return {};
}

Vec3 TimeStepper::grab_force(const MotionState& state, int grab) const {
  if (grab < 0 || at(grab) >= model_.grabs.size()) return {};
  return respond(model_.grabs[at(grab)], state.position).force;
}

double TimeStepper::applied_energy(std::span<const Vec3> position) const {
  double energy = 0;
  for (const Grab& grab : model_.grabs) energy += respond(grab, position).energy;
  if (contact_) energy += contact_->energy(position);
  return energy;
}

void TimeStepper::add_applied(const MotionState& state, Workspace& w) const {
  w.applied.clear();
  const auto touches = contact_ ? contact_->find(state.position, w.contact) : std::span<const ContactTouch>{};
  if (model_.grabs.empty() && touches.empty()) return;
  w.applied.resize(state.position.size());
  for (const Grab& grab : model_.grabs) {
    const GrabResponse r = respond(grab, state.position);
    for (std::size_t i = 0; i < grab.points.size(); ++i) {
      // The row of Gershgorin's theorem: wᵢ k Σ wⱼ.
      add_to(w.applied[at(grab.points[i])], r.force * grab.weights[i], r.stiffness * grab.weights[i]);
    }
  }
  for (const ContactTouch& t : touches) {
    const double k = contact_->model().stiffness_n_mm;
    double sum = 0;
    for (const double weight : t.weights) sum += std::abs(weight);
    for (std::size_t i = 0; i < t.points.size(); ++i) {
      add_to(w.applied[at(t.points[i])], t.normal * (t.weights[i] * k * t.depth_mm),
             kContactWeight * std::abs(t.weights[i]) * sum * k);
    }
  }
}

// Positions follow a change of velocity as they do within the integrator's step.
int TimeStepper::finish_contact(const MotionState& from, MotionState& to, double dt, Integrator integrator,
                                Workspace& w) const {
  if (!contact_) return 0;
  contact_->slow(w.contact, dt, integrator == Integrator::heun ? 0.5 * dt : dt, to.position, to.velocity);
  return contact_->stop(from.position, to.position, to.velocity, w.contact);
}

ContactMeasures TimeStepper::contact_measures(const MotionState& state) const {
  return contact_ ? contact_->measure(state.position) : ContactMeasures{};
}

}  // namespace turgor
