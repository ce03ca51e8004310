#include "dynamics/newton.hpp"

#include <algorithm>
#include <cmath>
#include <functional>

#include "turgor/core/parallel.hpp"

namespace turgor {
namespace {

constexpr std::size_t kGrain = 4096;
constexpr int kMaxLinearIterations = 2000;
constexpr int kMaxBacktracks = 30;
constexpr double kSufficientDecrease = 1e-4;
// Range of the linear tolerance: a sharper direction than this is not followed so far that it would pay.
constexpr double kLeastForcing = 0.01, kGreatestForcing = 0.1;
constexpr double kLeastProjection = 1.0 / 16;
constexpr double kUsefulReduction = 0.3;
constexpr int kPatience = 1;
// Share of the first forces that scales the residual where the reactions vanish.
constexpr double kStartShare = 1e-3;
// Where springs lie on a line, share of their length that resists turning about it.
constexpr double kLeastArm = 1e-3;
// Strain at which the forces of all elements together set the least scale of a residual.
constexpr double kScaleStrain = 1e-6;
constexpr double kFirstDamping = 1e-4, kLargestDamping = 1e4;

// ∫₀¹ R(τω) d dτ, R the rotation by the vector.
Vec3 turned(const Vec3& omega, const Vec3& d) {
  const double angle = length(omega);
  if (!(angle > 1e-6)) return d + cross(omega, d) * 0.5;
  const Vec3 axis = omega / angle, across = cross(axis, d);
  return d + across * ((1 - std::cos(angle)) / angle) + cross(axis, across) * (1 - std::sin(angle) / angle);
}

// As Context::check() puts it; the flag may have been raised for an instant only.
Error cancelled() {
  return {ErrorKind::cancelled, "stopped on request; nothing was written"};
}

}  // namespace

Newton::Newton(const NetworkEnergy& energy, PointClusters free, bool turns)
    : energy_(energy),
      matrix_(energy, std::move(free.points)),
      cg_(matrix_, std::move(free.offsets)),
      turns_(turns),
      force_scale_(kScaleStrain * energy.unit_force()),
      is_free_(static_cast<std::size_t>(energy.point_count()), 0),
      load_(matrix_.unknowns().size()),
      direction_(matrix_.unknowns().size()) {
  for (const int p : matrix_.unknowns()) is_free_[p] = 1;
}

void Newton::restart(const PointTerms* terms, double damping) {
  terms_ = terms;
  damping_ = damping;
  projection_ = start_norm_ = 0;
  since_indefinite_ = steps_ = linear_iterations_ = 0;
}

bool Newton::evaluate(EquilibriumState& state) {
  state.forces.resize(state.positions.size());
  if (!std::all_of(state.positions.begin(), state.positions.end(), is_within_reach)) return false;
  state.energy = energy_.forces(state.positions, state.forces, workspace_);
  if (terms_ != nullptr) state.energy += terms_->add_forces(state.positions, state.forces);
  return std::isfinite(state.energy) && std::isfinite(free_norm(state)) &&
         std::isfinite(reaction_norm(state));
}

double Newton::reaction_norm(const EquilibriumState& state) const {
  return std::sqrt(parallel_sum(state.forces.size(), kGrain, [&](std::size_t i) {
    return is_free_[i] ? 0.0 : squared_length(state.forces[i]);
  }));
}

double Newton::free_norm(const EquilibriumState& state) const {
  return std::sqrt(parallel_sum(state.forces.size(), kGrain, [&](std::size_t i) {
    return is_free_[i] ? squared_length(state.forces[i]) : 0.0;
  }));
}

double Newton::relative_residual(const EquilibriumState& state) const {
  const double loads = terms_ != nullptr ? terms_->scale() : 0.0;
  const double scale = std::max({reaction_norm(state), loads, kStartShare * start_norm_, force_scale_});
  const double norm = free_norm(state);
  return norm > 0 ? norm / scale : 0.0;
}

double Newton::largest_free_force(const EquilibriumState& state) const {
  double largest = 0;
  for (const int p : matrix_.unknowns()) largest = std::max(largest, length(state.forces[p]));
  return largest;
}

CgResult Newton::solve_linear(const EquilibriumState& state, double projection, double tolerance,
                              const Context& context) {
  energy_.linearise(state.positions, projection, stiffness_);
  matrix_.assemble(energy_, stiffness_);
  std::vector<CoupledStiffness> coupled;
  if (terms_ != nullptr) {
    terms_->add_stiffness(state.positions, matrix_);
    coupled = terms_->coupled(state.positions);
  }
  if (!cg_.factor(matrix_, damping_, coupled)) return {CgOutcome::indefinite, 0};
  const CgResult result = cg_.solve(load_, tolerance, kMaxLinearIterations, context, direction_);
  linear_iterations_ += result.iterations;
  return result;
}

Result<bool> Newton::predict(EquilibriumState& state, const std::vector<Vec3>& targets,
                             const Context& context) {
  std::vector<Vec3> shift(state.positions.size()), product(shift.size());
  for (std::size_t i = 0; i < shift.size(); ++i) {
    if (!is_free_[i]) shift[i] = targets[i] - state.positions[i];
  }
  const bool moves = std::any_of(shift.begin(), shift.end(), [](const Vec3& v) { return v != Vec3{}; });
  if (!moves && turns_) return evaluate(state);
  energy_.linearise(state.positions, 1, stiffness_);
  energy_.multiply(stiffness_, shift, product, workspace_);
  for (int row = 0; row < matrix_.rows(); ++row) {
    const int p = matrix_.unknowns()[row];
    load_[row] = state.forces[p] - product[p];
  }
  EquilibriumState moved = state;
  for (std::size_t i = 0; i < shift.size(); ++i) moved.positions[i] += shift[i];
  EquilibriumState predicted = moved;
  const bool moved_finite = evaluate(moved);
  constexpr double tolerance = 1e-2;
  const CgOutcome outcome = solve_linear(state, 1, tolerance, context).outcome;
  if (outcome == CgOutcome::cancelled) return cancelled();
  bool predicted_finite = false;
  if (outcome != CgOutcome::indefinite) {
    for (int row = 0; row < matrix_.rows(); ++row)
      predicted.positions[matrix_.unknowns()[row]] += direction_[row];
    predicted_finite = evaluate(predicted);
  }
  if (!moved_finite && !predicted_finite) return false;
  state = predicted_finite && (!moved_finite || predicted.energy < moved.energy) ? predicted : moved;
  return true;
}

Result<void> Newton::find_direction(const EquilibriumState& state, double tolerance, const Context& context) {
  for (int row = 0; row < matrix_.rows(); ++row) load_[row] = state.forces[matrix_.unknowns()[row]];
  // As little projection as leaves no negative curvature: more makes steps short, less fails. What conjugate
  // gradients reached before they met negative curvature is a direction of descent; far enough, it will do.
  const double lower = projection_ > kLeastProjection ? 0.5 * projection_ : 0.0;
  projection_ = since_indefinite_ < kPatience ? projection_ : lower;
  ++since_indefinite_;
  CgResult result = solve_linear(state, projection_, tolerance, context);
  while (result.outcome == CgOutcome::indefinite && projection_ < 1) {
    since_indefinite_ = 0;
    projection_ = std::min(1.0, std::max(4 * projection_, 2 * kLeastProjection));
    if (result.reduction < kUsefulReduction) break;
    result = solve_linear(state, projection_, tolerance, context);
  }
  if (result.outcome == CgOutcome::cancelled) return cancelled();
  if (!(slope_along_direction(state) < 0)) std::copy(load_.begin(), load_.end(), direction_.begin());
  return {};
}

// dE/dt along the direction: minus the force times the direction.
double Newton::slope_along_direction(const EquilibriumState& state) const {
  return -parallel_sum(direction_.size(), kGrain, [&](std::size_t row) {
    return dot(state.forces[matrix_.unknowns()[row]], direction_[row]);
  });
}

// How the direction turns the surroundings of each point: the rotation that fits the displacements of its
// neighbours best, Σ e × (δ − ω × e) = 0 over the springs e at it, δ the change of e.
void Newton::find_spin(const EquilibriumState& state) {
  shift_.assign(state.positions.size(), {});
  for (std::size_t row = 0; row < direction_.size(); ++row) shift_[matrix_.unknowns()[row]] = direction_[row];
  spin_.resize(direction_.size());
  const auto& springs = energy_.spring_incidence();
  parallel_for(direction_.size(), kGrain, [&](std::size_t begin, std::size_t end) {
    for (std::size_t row = begin; row < end; ++row) {
      const int point = matrix_.unknowns()[row];
      Mat3 inertia{{Vec3{}, Vec3{}, Vec3{}}};
      Vec3 moment;
      double trace = 0;
      for (int k = springs.offsets[point]; k < springs.offsets[point + 1]; ++k) {
        const auto& ends = energy_.spring_ends()[springs.entries[k] / 2];
        const int other = ends.a == point ? ends.b : ends.a;
        const Vec3 e = state.positions[other] - state.positions[point];
        moment += cross(e, shift_[other] - direction_[row]);
        for (int j = 0; j < 3; ++j) inertia.c[static_cast<std::size_t>(j)] -= e * e[j];
        trace += squared_length(e);
      }
      for (int j = 0; j < 3; ++j) inertia.c[static_cast<std::size_t>(j)][j] += (1 + kLeastArm) * trace;
      const Vec3 spin = inertia.inverse() * moment;
      spin_[row] = is_finite(spin) ? spin : Vec3{};
    }
  });
}

// Along straight lines parts that turn would grow. Each point's displacement turns with its surroundings: the
// integral of R(τω) d over τ to t (modal warping, Choi and Ko 2005), which leaves as d does.
void Newton::step_to(const EquilibriumState& from, double t, EquilibriumState& to) const {
  to.positions = from.positions;
  for (std::size_t row = 0; row < direction_.size(); ++row) {
    Vec3& x = to.positions[matrix_.unknowns()[row]];
    x += turns_ ? turned(spin_[row] * t, direction_[row] * t) : direction_[row] * t;
  }
}

// Backtracking on the energy. Close to the minimum the energy's decrease drowns in its rounding; there a step
// counts that brings the slope along the direction down (Hager and Zhang 2005, the approximate Wolfe
// condition).
bool Newton::search(EquilibriumState& state) {
  if (turns_) find_spin(state);
  const double slope = slope_along_direction(state);
  const double rounding = 1e-12 * std::abs(state.energy);
  double t = 1;
  for (int i = 0; i < kMaxBacktracks; ++i) {
    step_to(state, t, trial_);
    double next = 0.1 * t;
    if (evaluate(trial_)) {
      const double change = trial_.energy - state.energy, trial_slope = slope_along_direction(trial_);
      const bool decreased = change <= kSufficientDecrease * t * slope;
      const bool flattened = std::abs(change) <= rounding && std::abs(trial_slope) <= 0.9 * std::abs(slope);
      if (decreased || flattened) {
        std::swap(state, trial_);
        adapt_damping(t);
        return true;
      }
      // The minimum of the parabola through both energies and the slope at the start.
      const double parabola = -slope * t * t / (2 * (change - slope * t));
      next = std::clamp(parabola, 0.1 * t, 0.5 * t);
    }
    t = next;
  }
  adapt_damping(0);
  return false;
}

// Levenberg and Marquardt's: short steps say that the quadratic model reaches too far.
void Newton::adapt_damping(double accepted_step) {
  if (accepted_step < 0.1) {
    damping_ = std::max(kFirstDamping, 10 * damping_);
  } else if (accepted_step >= 0.5) {
    damping_ = damping_ > kFirstDamping ? damping_ / 10 : 0;
  }
}

Result<bool> Newton::descend(EquilibriumState& state, double tolerance, int step_limit, Context& context) {
  start_norm_ = free_norm(state);
  const double first = relative_residual(state);
  double previous = first, forcing = kGreatestForcing;
  for (double residual = first;; residual = relative_residual(state)) {
    TURGOR_CHECK(context.check());
    if (residual <= tolerance) return true;
    if (steps_ >= step_limit) return false;
    context.progress(std::log(first / residual) / std::log(first / tolerance));
    // Eisenstat and Walker's second choice: solve as closely as the last step's success makes worth while.
    if (steps_ > 0 && residual < previous) {
      const double ratio = residual / previous;
      forcing = std::clamp(0.9 * ratio * ratio, kLeastForcing, kGreatestForcing);
    }
    // But not beyond what is asked for (Kelley 1995).
    forcing = std::clamp(0.3 * tolerance / residual, forcing, kGreatestForcing);
    previous = residual;
    TURGOR_CHECK(find_direction(state, forcing, context));
    ++steps_;
    if (!search(state) && damping_ > kLargestDamping) return false;
  }
}

}  // namespace turgor
