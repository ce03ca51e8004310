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
constexpr double kFirstDamping = 1e-4, kLargestDamping = 1e4;

// As Context::check() puts it; the flag may have been raised for an instant only.
Error cancelled() {
  return {ErrorKind::cancelled, "stopped on request; nothing was written"};
}

}  // namespace

Newton::Newton(const NetworkEnergy& energy, PointClusters free, double force_scale, Context& context)
    : energy_(energy),
      matrix_(energy, std::move(free.points)),
      cg_(matrix_, std::move(free.offsets)),
      context_(context),
      force_scale_(force_scale),
      is_free_(static_cast<std::size_t>(energy.point_count()), 0),
      load_(matrix_.unknowns().size()),
      direction_(matrix_.unknowns().size()) {
  for (const int p : matrix_.unknowns()) is_free_[p] = 1;
}

bool Newton::evaluate(EquilibriumState& state) {
  state.forces.resize(state.positions.size());
  state.energy = energy_.forces(state.positions, state.forces, workspace_);
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
  const double scale = std::max({reaction_norm(state), kStartShare * start_norm_, force_scale_});
  const double norm = free_norm(state);
  return norm > 0 ? norm / scale : 0.0;
}

double Newton::largest_free_force(const EquilibriumState& state) const {
  double largest = 0;
  for (const int p : matrix_.unknowns()) largest = std::max(largest, length(state.forces[p]));
  return largest;
}

CgResult Newton::solve_linear(const EquilibriumState& state, double projection, double tolerance) {
  energy_.linearise(state.positions, projection, stiffness_);
  matrix_.assemble(energy_, stiffness_);
  if (!cg_.factor(matrix_, damping_)) return {CgOutcome::indefinite, 0};
  const CgResult result = cg_.solve(load_, tolerance, kMaxLinearIterations, context_, direction_);
  linear_iterations_ += result.iterations;
  return result;
}

Result<bool> Newton::predict(EquilibriumState& state, const std::vector<Vec3>& targets) {
  std::vector<Vec3> shift(state.positions.size()), product(shift.size());
  for (std::size_t i = 0; i < shift.size(); ++i) {
    if (!is_free_[i]) shift[i] = targets[i] - state.positions[i];
  }
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
  const CgOutcome outcome = solve_linear(state, 1, tolerance).outcome;
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

Result<void> Newton::find_direction(const EquilibriumState& state, double tolerance) {
  for (int row = 0; row < matrix_.rows(); ++row) load_[row] = state.forces[matrix_.unknowns()[row]];
  // As little projection as leaves no negative curvature: more makes steps short, less fails. What conjugate
  // gradients reached before they met negative curvature is a direction of descent; far enough, it will do.
  const double lower = projection_ > kLeastProjection ? 0.5 * projection_ : 0.0;
  projection_ = since_indefinite_ < kPatience ? projection_ : lower;
  ++since_indefinite_;
  CgResult result = solve_linear(state, projection_, tolerance);
  while (result.outcome == CgOutcome::indefinite && projection_ < 1) {
    since_indefinite_ = 0;
    projection_ = std::min(1.0, std::max(4 * projection_, 2 * kLeastProjection));
    if (result.reduction < kUsefulReduction) break;
    result = solve_linear(state, projection_, tolerance);
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

void Newton::step_to(const EquilibriumState& from, double t, EquilibriumState& to) const {
  to.positions = from.positions;
  for (std::size_t row = 0; row < direction_.size(); ++row) {
    to.positions[matrix_.unknowns()[row]] += direction_[row] * t;
  }
}

// Backtracking on the energy. Close to the minimum the energy's decrease drowns in its rounding; there a step
// counts that brings the slope along the direction down (Hager and Zhang 2005, the approximate Wolfe
// condition).
bool Newton::search(EquilibriumState& state) {
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

Result<bool> Newton::descend(EquilibriumState& state, double tolerance, int step_limit) {
  start_norm_ = free_norm(state);
  const double first = relative_residual(state);
  double previous = first, forcing = kGreatestForcing;
  for (double residual = first;; residual = relative_residual(state)) {
    TURGOR_CHECK(context_.check());
    if (residual <= tolerance) return true;
    if (steps_ >= step_limit) return false;
    context_.progress(std::log(first / residual) / std::log(first / tolerance));
    // Eisenstat and Walker's second choice: solve as closely as the last step's success makes worth while.
    if (steps_ > 0 && residual < previous) {
      const double ratio = residual / previous;
      forcing = std::clamp(0.9 * ratio * ratio, kLeastForcing, kGreatestForcing);
    }
    previous = residual;
    TURGOR_CHECK(find_direction(state, forcing));
    ++steps_;
    if (!search(state) && damping_ > kLargestDamping) return false;
  }
}

}  // namespace turgor
