// Point samples in motion: a spring network stepped through time (Pieper 1989, sections 3.2.1, 5.2 and 5.8).
#pragma once

#include <span>
#include <vector>

#include "turgor/core/context.hpp"
#include "turgor/dynamics/barrier.hpp"
#include "turgor/tissue/network_energy.hpp"

namespace turgor {

/// What a spring does in motion beside its law.
struct SpringMotion {
  double viscosity = 0;  ///< force against the rate of change of its length, N·ms/mm, ≥ 0
  double cutoff_mm = 0;  ///< where above 0: while longer than this the spring lets go
};

struct MotionModel {
  SpringNetwork network;              ///< mobile points need a mass above 0
  std::vector<SpringMotion> springs;  ///< one for each spring, or none at all: neither viscous nor cut off
  std::vector<char> mobile;           ///< one for each point, or none at all: every point may move
  Vec3 gravity_mm_ms2;                ///< acceleration: (0, 0, −0.00980665) on earth
  double damping_g_ms = 0;            ///< force against the velocity of a point, ≥ 0
  std::vector<Barrier> barriers;      ///< each acts on every mobile point
};

struct MotionState {
  std::vector<Vec3> position, velocity;  ///< mm, mm/ms; one for each point
  double time_ms = 0;
};

enum class Integrator : std::uint8_t {
  /// v += a dt, then x += v dt with the velocity just found (section 3.2.1 leaves open which; with the old
  /// one an
  /// undamped spring gains energy in every step). First order.
  euler,
  /// Forces and velocities averaged between both ends of an Euler step with the old velocity. Second order.
  heun,
};

struct StepReport {
  int sub_steps = 1;           ///< taken in place of the step asked for
  double stable_step_ms = 0;   ///< estimated at the start
  int coincident_springs = 0;  ///< without direction, hence without force, at the start
};

/// A spring's force acts by half on either end where both are mobile, whole where the other is fixed, not at
/// all where both are (section 3.2.1): as if such springs had half their stiffness and viscosity.
/// Deterministic, and the same bits on any number of threads.
class TimeStepper {
 public:
  /// Memory of a step, kept by the caller so that repeated steps allocate nothing.
  struct Workspace {
    std::vector<Vec3> spring_force, volume_force;
    std::vector<double> spring_slope;
    std::vector<Vec3> force, next_force;
    MotionState next, ahead;
  };

  /// Errors: an invalid network or barrier; numbers out of range; a mobile point without mass.
  static Result<TimeStepper> prepare(MotionModel model);

  [[nodiscard]] const MotionModel& model() const { return model_; }
  /// At rest in the network's rest positions.
  [[nodiscard]] MotionState rest() const;

  /// Potential energy of springs, volumes, gravity and barriers, N·mm.
  [[nodiscard]] double potential(std::span<const Vec3> position) const;
  [[nodiscard]] double kinetic(std::span<const Vec3> velocity) const;
  /// Fills `forces` with all forces on each point, N; zero on fixed ones. Returns springs without direction.
  int forces(const MotionState& state, std::span<Vec3> forces) const;

  /// The longest step that is stable at `state`: (2/ω)(√(1 + ζ²) − ζ) of the stiffest point, its frequency ω
  /// and damping ratio ζ bounded by Gershgorin's theorem, times a margin for the integrator.
  [[nodiscard]] double stable_step_ms(const MotionState& state, Integrator integrator) const;

  /// Steps by `dt_ms` > 0, in sub-steps where that is more than is stable. On error the state is as it was.
  /// Errors: more than 100,000 sub-steps; positions beyond a thousand kilometres; cancelled.
  Result<StepReport> step(MotionState& state, double dt_ms, Integrator integrator, Context& context,
                          Workspace& workspace) const;
  Result<StepReport> step(MotionState& state, double dt_ms, Integrator integrator, Context& context) const {
    Workspace workspace;
    return step(state, dt_ms, integrator, context, workspace);
  }

 private:
  // Springs of one law side by side; both ends' share of the force is in the stiffness.
  struct Springs {
    std::vector<int> a, b;
    std::vector<double> rest_length, stiffness, viscosity, cutoff;
    std::vector<int> first_of_law;  // five
  };

  explicit TimeStepper(MotionModel model);
  void lay_out();
  [[nodiscard]] bool is_mobile(int point) const { return model_.mobile.empty() || model_.mobile[point] != 0; }
  int evaluate(const MotionState& state, std::span<Vec3> forces, Workspace& w) const;
  [[nodiscard]] double stable_step(const MotionState& state, Integrator integrator, Workspace& w) const;
  void euler(MotionState& state, double dt, Workspace& w) const;
  void heun(MotionState& state, double dt, Workspace& w) const;

  MotionModel model_;
  Springs springs_;
  NetworkEnergy::Incidence spring_incidence_, volume_incidence_;
};

}  // namespace turgor
