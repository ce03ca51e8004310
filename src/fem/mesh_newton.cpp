#include "fem/mesh_newton.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace turgor::detail {
namespace {

using Tangent = MeshEquilibrium::Tangent;

constexpr int kMostStepsOfAPart = 40;
constexpr int kMostWholeSteps = 15;
constexpr int kMostHalvings = 10;                                  // of a part of the load
constexpr int kMostShortenings = 30;                               // of a step
constexpr double kEnoughOfTheSlope = 1e-4, kRestOfTheSlope = 0.9;  // Armijo's and Wolfe's numbers
constexpr double kRounding = 1e-13;                                // of energies

}  // namespace

double MeshNewton::tolerance(const MeshState& state) const {
  return std::max(options_.relative_residual * state.carried_n, 4 * state.elements.rounding_n);
}

Result<MeshNewton::Outcome> MeshNewton::run(std::vector<Vec3> start, bool at_once) {
  MeshState state = equilibrium_.evaluate(std::move(start), 0);
  if (!state.valid()) return turned_over(state.elements.first_turned_over);
  double part = 0, size = at_once ? 1 : 1.0 / options_.newton.load_steps;
  const double whole = size, least = std::ldexp(size, -kMostHalvings);
  while (part < 1) {
    const double next = part + size > 1 - 1e-9 ? 1 : part + size;
    MeshState trial = state;
    const int before = steps_;
    TURGOR_TRY(const bool reached, reach(trial, next));
    if (reached) {
      state = std::move(trial), part = next;
      if (steps_ - before < kMostStepsOfAPart / 4) size = std::min(whole, 2 * size);
      context_.progress(part);
      continue;
    }
    size /= 2;
    if (size < least || steps_ >= options_.newton.max_newton_steps) {
      if (part == 0) state = std::move(trial);
      return Outcome{std::move(state.displacement_mm), steps_, part, obstacle_};
    }
  }
  return Outcome{std::move(state.displacement_mm), steps_, 1, {}};
}

// To the equilibrium under another part of the load; not reached: the last state that was tried. Whole steps
// come first, whatever the energy does on the way: what is slender stretches before it bends, and steps that
// may not stretch it are short (a watchdog, Chamberlain et al. 1982). Then steps down the energy alone.
Result<bool> MeshNewton::reach(MeshState& state, double part) {
  if (!predict(state, part)) return false;
  const int left = options_.newton.max_newton_steps - steps_;
  MeshState leapt = state;
  TURGOR_TRY(const bool balanced,
             balance(leapt, part, std::min(kMostWholeSteps, left / 2), &MeshNewton::leap));
  if (balanced) {
    state = std::move(leapt);
    return true;
  }
  return balance(state, part, std::min(kMostStepsOfAPart, options_.newton.max_newton_steps - steps_),
                 &MeshNewton::descend);
}

Result<bool> MeshNewton::balance(MeshState& state, double part, int most, Move move) {
  stable_ = true;
  for (int step = 0; !(state.unbalanced.norm() <= tolerance(state)); ++step) {
    TURGOR_CHECK(context_.check());
    if (step >= most) {
      obstacle_ = "the forces have not come to balance within the steps allowed";
      return false;
    }
    ++steps_;
    if (!(this->*move)(state, part)) return false;
  }
  return stable_;
}

// A whole step by the exact stiffness, which on the way may have negative curvatures.
bool MeshNewton::leap(MeshState& state, double part) {
  const auto step = equilibrium_.newton_step(state, {}, Tangent::exact);
  if (!step) return false;
  stable_ = step->stable;
  std::vector<Vec3> there = equilibrium_.moved(state.displacement_mm, step->step, 1);
  if (equilibrium_.carried_off(there)) return false;
  MeshState trial = equilibrium_.evaluate(std::move(there), part);
  if (!trial.valid()) return false;
  state = std::move(trial);
  return true;
}

// Moves what is held, and with it the rest as the stiffness there says: nothing is crushed at the supports.
bool MeshNewton::predict(MeshState& state, double part) {
  std::vector<Vec3> moves = equilibrium_.with_prescribed(state.displacement_mm, part);
  bool any = false;
  for (std::size_t p = 0; p < moves.size(); ++p) {
    moves[p] -= state.displacement_mm[p];
    any = any || squared_length(moves[p]) > 0;
  }
  if (!any) {
    state = equilibrium_.evaluate(std::move(state.displacement_mm), part);
    return true;
  }
  state.unbalanced.setZero();
  auto step = equilibrium_.newton_step(state, moves, Tangent::exact);
  if (!step) step = equilibrium_.newton_step(state, moves, Tangent::definite);
  if (!step) {
    obstacle_ = "the stiffness cannot be factored";
    return false;
  }
  MeshState trial = equilibrium_.evaluate(
      equilibrium_.moved(equilibrium_.with_prescribed(state.displacement_mm, part), step->step, 1), part);
  if (!trial.valid()) return refuse(trial);
  state = std::move(trial);
  return true;
}

bool MeshNewton::refuse(const MeshState& trial) {
  obstacle_ = fmt::format("{} elements would turn over, the first of them element {}",
                          trial.elements.turned_over, trial.elements.first_turned_over);
  return false;
}

// One step, along the exact stiffness or, where that leads nowhere, along a definite one.
bool MeshNewton::descend(MeshState& state, double part) {
  obstacle_ = "the stiffness cannot be factored";
  for (const Tangent tangent : {Tangent::exact, Tangent::definite}) {
    const auto step = equilibrium_.newton_step(state, {}, tangent);
    if (step && step->stable && search(state, *step, part)) return true;
  }
  return false;
}

// Shortens the step until the energy falls enough; where it falls by less than its rounding, until the slope
// along the step does.
bool MeshNewton::search(MeshState& state, const MeshEquilibrium::Step& step, double part) {
  const double slope = -state.unbalanced.dot(step.step);
  if (!(slope < 0)) {
    obstacle_ = "the step leads nowhere";
    return false;
  }
  double factor = 1;
  for (int i = 0; i < kMostShortenings; ++i, factor /= 2) {
    std::vector<Vec3> there = equilibrium_.moved(state.displacement_mm, step.step, factor);
    if (equilibrium_.carried_off(there)) {
      obstacle_ = "the body is carried off: nothing holds it against the load";
      continue;
    }
    MeshState trial = equilibrium_.evaluate(std::move(there), part);
    if (!trial.valid()) {
      refuse(trial);
      continue;
    }
    const double fall = trial.potential_nmm - state.potential_nmm;
    const bool enough = fall <= kEnoughOfTheSlope * factor * slope;
    const bool flat = fall <= kRounding * state.size_nmm &&
                      std::abs(trial.unbalanced.dot(step.step)) <= -kRestOfTheSlope * slope;
    if (!enough && !flat) {
      obstacle_ = "no step lowers the energy";
      continue;
    }
    state = std::move(trial);
    return true;
  }
  return false;
}

}  // namespace turgor::detail
