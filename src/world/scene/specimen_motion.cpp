// How a specimen moves: its parts made one model, muscles driven, samples stepped.
#include <fmt/format.h>

#include <algorithm>

#include "turgor/core/index.hpp"
#include "turgor/world/specimen.hpp"

namespace turgor {
void Specimen::append_fibre(MotionModel& model, const Fibre& fibre) const {
  Spring spring;
  spring.a = index(fibre.a);
  spring.b = index(fibre.b);
  spring.rest_length_mm = rest_length(fibre);
  spring.stiffness_n = fibre.options.stiffness;
  spring.law = fibre.options.law;
  spring.kind = SpringKind::fibre;
  model.network.springs.push_back(spring);
  SpringMotion motion;
  motion.viscosity = fibre.options.viscosity;
  motion.cutoff_mm = fibre.options.cutoff;
  model.springs.push_back(motion);
}

std::vector<int> Specimen::points_of(const Collision& collision) const {
  if (collision.body < 0) return {};
  const TissueBody& body = bodies_[at(collision.body)];
  const int columns = body.flesh.columns();
  std::vector<int> points;
  for (int i = 0; i < body.count; ++i) {
    if (collision.layer < 0 || i / std::max(columns, 1) == collision.layer) points.push_back(body.offset + i);
  }
  return points;
}

std::vector<Barrier> Specimen::barriers() const {
  std::vector<Barrier> all;
  for (const Collision& collision : collisions_) {
    all.push_back(collision.barrier);
    all.back().points = points_of(collision);
  }
  return all;
}

void Specimen::append_flesh(MotionModel& model, const TissueBody& body) const {
  SpringNetwork& net = model.network;
  const SpringNetwork& part = body.parts.network;
  net.rest.insert(net.rest.end(), part.rest.begin(), part.rest.end());
  net.mass_g.insert(net.mass_g.end(), part.mass_g.begin(), part.mass_g.end());
  for (const FleshSample& sample : body.flesh.samples) model.mobile.push_back(sample.mobile ? 1 : 0);
  const std::size_t first_spring = net.springs.size();
  for (Spring spring : part.springs) {
    spring.a += body.offset, spring.b += body.offset;
    net.springs.push_back(spring);
    SpringMotion motion;
    motion.viscosity = body.viscosity;
    model.springs.push_back(motion);
  }
  for (VolumeElement volume : part.volumes) {
    for (int& p : volume.p) p += body.offset;
    net.volumes.push_back(volume);
  }
  append_skin(model, body, first_spring);
}

Result<void> Specimen::assemble() {
  MotionModel model;
  SpringNetwork& net = model.network;
  for (std::size_t i = 0; i < names_.size(); ++i) {
    net.rest.push_back(state_.position[i]);
    net.mass_g.push_back(masses_[i]);
    model.mobile.push_back(mobile_[i] ? 1 : 0);
  }
  for (const TissueBody& body : bodies_) {
    if (body.solid)
      append_solid(model, body);
    else
      append_flesh(model, body);
  }
  for (const Fibre& shock : shocks_) append_fibre(model, shock);
  first_fibre_ = static_cast<int>(net.springs.size());
  for (const Muscle& muscle : muscles_) {
    for (const Fibre& fibre : muscle.fibres) append_fibre(model, fibre);
  }
  model.gravity_mm_ms2 = gravity_;
  model.damping_g_ms = damping_;
  model.barriers = barriers();
  model.grabs = lowered_grabs();
  model.contact = contact_model();
  model.relaxation = relaxation_;
  // An edit renumbers springs: what had relaxed starts afresh.
  const auto relaxing = std::count_if(model.springs.begin(), model.springs.end(),
                                      [](const SpringMotion& m) { return m.relaxes; });
  if (std::ssize(state_.relaxed) != relaxing) state_.relaxed.assign(static_cast<std::size_t>(relaxing), {});
  TURGOR_TRY(stepper_, TimeStepper::prepare(std::move(model)));
  return {};
}

Result<void> Specimen::drive_muscles(double time) {
  int spring = first_fibre_;
  for (Muscle& muscle : muscles_) {
    for (Fibre& fibre : muscle.fibres) {
      if (muscle.twitch) fibre.scale = muscle.twitch->scale_at(time);
      if (implicit_) TURGOR_CHECK(implicit_->set_rest_length(spring, rest_length(fibre)));
      TURGOR_CHECK(stepper_->set_rest_length(spring++, rest_length(fibre)));
    }
  }
  return {};
}

Result<void> Specimen::step(double time, const SimulationOptions& options, SimulationReport& report,
                            Context& context) {
  if (state_.position.empty()) return {};
  if (!stepper_) TURGOR_CHECK(assemble());
  if (options.implicit) TURGOR_CHECK(prepare_implicit(context));
  TURGOR_CHECK(drive_muscles(time));
  state_.time_ms = time;
  if (options.implicit) {
    TURGOR_CHECK(implicit_->step(state_, options.dt, context));
    ++report.sub_steps;
  } else if (options.tolerance > 0) {
    StepControl control;
    control.tolerance_mm = options.tolerance;
    control.longest_ms = options.dt;
    TURGOR_TRY(const AdvanceReport done, stepper_->advance(state_, options.dt, control, context, workspace_));
    report.sub_steps += done.accepted;
  } else {
    TURGOR_TRY(const StepReport done,
               stepper_->step(state_, options.dt, options.integrator, context, workspace_));
    report.sub_steps += done.sub_steps;
    report.shortest_stable = std::min(report.shortest_stable, done.stable_step_ms);
    report.most_coincident = std::max(report.most_coincident, done.coincident_springs);
  }
  ++report.steps;
  return {};
}

Result<void> Specimen::prepare_implicit(Context& context) {
  if (implicit_) return {};
  TURGOR_TRY(implicit_, ImplicitStepper::prepare(stepper_->model(), context));
  return {};
}

Result<EquilibriumResult> Specimen::settle(double time, const EquilibriumOptions& options, Context& context) {
  if (state_.position.empty()) return EquilibriumResult{};
  if (!stepper_) TURGOR_CHECK(assemble());
  TURGOR_CHECK(prepare_implicit(context));
  TURGOR_CHECK(drive_muscles(time));
  state_.time_ms = time;
  return implicit_->settle(state_, options, context);
}

void Specimen::set_position(SampleRef sample, const Vec3& position) {
  state_.position[at(index(sample))] = position;
  state_.velocity[at(index(sample))] = {};
}

Result<void> Specimen::set_state(MotionState state) {
  const auto finite = [](const Vec3& p) { return is_within_reach(p); };
  if (state.position.size() != state_.position.size() || state.velocity.size() != state_.position.size()) {
    return Error{ErrorKind::bad_input,
                 fmt::format("the state is of {} samples, the tissue has {}", state.position.size(),
                             state_.position.size()),
                 "", "Restore it in a scene built by the same commands"};
  }
  if (!std::all_of(state.position.begin(), state.position.end(), finite) ||
      !std::all_of(state.velocity.begin(), state.velocity.end(), finite)) {
    return Error{ErrorKind::bad_input, "the state holds numbers out of range", "",
                 "Use a file that `state` wrote"};
  }
  // A state from before the first step has nothing relaxed yet.
  if (state.relaxed.empty()) state.relaxed.resize(state_.relaxed.size());
  if (stepper_ && state.relaxed.size() != state_.relaxed.size()) {
    return Error{ErrorKind::bad_input,
                 fmt::format("{} springs relax in the state, {} in the tissue", state.relaxed.size(),
                             state_.relaxed.size()),
                 "", "Restore it in a scene built by the same commands"};
  }
  state_ = std::move(state);
  return {};
}

}  // namespace turgor
