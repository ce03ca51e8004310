// Motion in long steps: implicit Euler, and straight to rest.
#pragma once

#include <memory>

#include "turgor/core/context.hpp"
#include "turgor/dynamics/equilibrium.hpp"
#include "turgor/dynamics/time_stepper.hpp"

namespace turgor {

struct ImplicitReport {
  int newton_steps = 0, linear_iterations = 0;
  bool converged = true;
};

/// Steps of any length: the next positions minimise E(x) + Σ mᵢ |xᵢ − yᵢ|²/(2 dt²) + Σ c |xᵢ − xᵢ⁰|²/(2 dt),
/// y = x⁰ + v⁰ dt, of the energy E of springs, solids, volumes, areas, gravity, barriers and grabs (Martin et
/// al. 2011); first order, never unstable. Springs pull with their whole force on both ends; viscosity,
/// cut-off and relaxation of springs do not act here (prepare() warns). Points that touch another body are
/// kept off the planes in which its faces lie at the start of a step, its faces take the forces of the start,
/// and friction and stopping follow the step as in TimeStepper. Points that are not mobile are led by their
/// velocity.
class ImplicitStepper {
 public:
  static Result<ImplicitStepper> prepare(const MotionModel& model, Context& context);
  ImplicitStepper(ImplicitStepper&&) noexcept;
  ImplicitStepper& operator=(ImplicitStepper&&) noexcept;
  ~ImplicitStepper();

  /// Between steps; the pattern of the matrix stays. On error nothing changes.
  Result<void> set_rest_length(int spring, double rest_length_mm);
  Result<void> set_barriers(std::vector<Barrier> barriers);
  Result<void> set_grabs(std::vector<Grab> grabs);

  /// To a residual relative to the reactions, to the constant loads and to the forces that would stop all
  /// motion within the step, the largest of them. Where it is not reached the best state found is taken, and
  /// the report tells. On error the state is as it was. Errors: dt or the residual not above 0; a state of
  /// another size or not finite; points that leave for more than a thousand kilometres; cancelled.
  Result<ImplicitReport> step(MotionState& state, double dt_ms, Context& context,
                              double relative_residual = 1e-5);
  /// To static equilibrium, from the state; velocities become 0, time stays. Contact of bodies does not act.
  Result<EquilibriumResult> settle(MotionState& state, const EquilibriumOptions& options, Context& context);

 private:
  struct Parts;
  explicit ImplicitStepper(std::unique_ptr<Parts> parts);
  std::unique_ptr<Parts> parts_;
};

}  // namespace turgor
