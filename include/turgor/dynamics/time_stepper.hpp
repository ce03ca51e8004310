// Point samples in motion: a spring network stepped through time (Pieper 1989, sections 3.2.1, 5.2 and 5.8).
#pragma once

#include <array>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "turgor/core/context.hpp"
#include "turgor/dynamics/barrier.hpp"
#include "turgor/dynamics/grab.hpp"
#include "turgor/dynamics/surface_contact.hpp"
#include "turgor/tissue/network_energy.hpp"

namespace turgor {

/// What a spring does in motion beside its law.
struct SpringMotion {
  double viscosity = 0;  ///< force against the rate of change of its length, N·ms/mm, ≥ 0
  double cutoff_mm = 0;  ///< where above 0: while longer than this the spring lets go
  bool relaxes = false;  ///< its tension fades as MotionModel::relaxation tells
};

/// One term of a Prony series: `share` of a spring's elastic tension fades with the time constant `time_ms`.
struct Relaxation {
  double share = 0;    ///< 0 to 1; 0: unused
  double time_ms = 1;  ///< > 0
};
inline constexpr std::size_t kRelaxations = 3;

struct MotionModel {
  SpringNetwork network;              ///< mobile points need a mass above 0
  std::vector<SpringMotion> springs;  ///< one for each spring, or none at all: only their laws
  /// One for each point, or none at all: every point may move. A point that is not mobile is led: it goes on
  /// with the velocity that the state gives it, mostly 0.
  std::vector<char> mobile;
  Vec3 gravity_mm_ms2;      ///< acceleration: (0, 0, −0.00980665) on earth
  double damping_g_ms = 0;  ///< force against the velocity of a point, ≥ 0
  /// Forces of solids in double precision; else in single, of displacements within blocks of neighbours that
  /// are moved and turned back: errors of some 1e-7 of the forces of the elements.
  bool exact_solids = false;
  std::vector<Barrier> barriers;
  std::vector<Grab> grabs;
  std::optional<ContactModel> contact;  ///< of soft bodies with each other and themselves
  /// Quasi-linear viscoelasticity (Fung 1993, section 7.6) of the springs that relax: tension T = Tₑ − Σ qᵢ
  /// of the elastic one Tₑ, with dqᵢ/dt = (gᵢ Tₑ − qᵢ)/τᵢ. Held at a length, T = Tₑ (1 − Σ gᵢ (1 −
  /// e^(−t/τᵢ))). The shares gᵢ add up to less than 1.
  std::array<Relaxation, kRelaxations> relaxation{};
};

struct MotionState {
  std::vector<Vec3> position, velocity;  ///< mm, mm/ms; one for each point
  double time_ms = 0;
  /// q of the springs that relax, in the order of the network and counted as the spring acts on its ends, N;
  /// empty where none does.
  std::vector<std::array<double, kRelaxations>> relaxed = {};
};

enum class Integrator : std::uint8_t {
  /// v += a dt, then x += v dt with the velocity just found (section 3.2.1 leaves open which; with the old
  /// one an undamped spring gains energy in every step). First order.
  euler,
  /// Forces averaged between both ends of an Euler step with the old velocity, then velocities between the
  /// old and the new one (Heun averages the old one and Euler's: with it an undamped spring gains energy in
  /// every step). Second order.
  heun,
  /// Verlet's method in the form of the leapfrog, damping by the mean of both velocities: v ← ((1 − a) v +
  /// F dt/m)/(1 + a), a = c dt/2m, then x += v dt. Velocities are those of half a step ago: positions are of
  /// second order where it starts with such. Damping never limits the step, viscosity of springs counts as in
  /// Euler's. Without either the energy stays within bounds.
  verlet,
};

struct StepReport {
  int sub_steps = 1;           ///< taken in place of the step asked for
  double stable_step_ms = 0;   ///< estimated at the start
  int coincident_springs = 0;  ///< without direction, hence without force, at the start
  int held_points = 0;         ///< held where they were, as impulses could not keep them from crossing faces
};

/// How advance() chooses its steps.
struct StepControl {
  double tolerance_mm = 1e-3;  ///< > 0, error of one step: of a position, and of a velocity times the step
  double shortest_ms = 1e-6;   ///< > 0; at it a step counts whatever its error
  double longest_ms = 1e9;     ///< ≥ shortest
};

struct AdvanceReport {
  int accepted = 0, rejected = 0;
  int beyond_tolerance = 0;                ///< of those accepted: no shorter step was allowed
  double shortest_ms = 0, longest_ms = 0;  ///< of the steps accepted
  int held_points = 0;                     ///< as in StepReport
};

class NetworkBlocks;
class SolidBlocks;

/// A spring's force acts by half on either end where both are mobile, whole where the other is fixed, not at
/// all where both are (section 3.2.1): as if such springs had half their stiffness and viscosity.
/// Deterministic, and the same bits on any number of threads. Const members may be called from several
/// threads, with workspaces of their own.
class TimeStepper {
 public:
  /// Memory of a step, kept by the caller so that repeated steps allocate nothing of size. What it holds does
  /// not change results.
  struct Workspace {
    template <class Real>
    struct alignas(4 * sizeof(Real)) QuadOf {
      Real v[4];
    };
    using Quad = QuadOf<double>;
    std::vector<std::vector<Quad>> scratch;  // for each run of blocks
    std::vector<QuadOf<float>> solid_force;  // on the points of each block of solids
    std::vector<Quad> exact_solid_force;
    std::vector<double> elastic, offset;  // for each spring that relaxes: Tₑ and Σ q
    std::vector<double> elastic_before;
    std::vector<Vec3> force;
    std::vector<Quad> applied;  // of grabs and contact: force on each point and stiffness; empty: none
    SurfaceContact::Workspace contact;
    MotionState next, spare, ahead;
    double guess_ms = 0;  // the last stable step
  };

  /// Errors: an invalid network or barrier; numbers out of range; a mobile point without mass.
  static Result<TimeStepper> prepare(MotionModel model);
  TimeStepper(TimeStepper&&) noexcept;
  TimeStepper& operator=(TimeStepper&&) noexcept;
  ~TimeStepper();

  [[nodiscard]] const MotionModel& model() const { return model_; }
  /// Drives a muscle fibre: a new rest length for model().network.springs[spring], between steps.
  /// Errors: no such spring; a length that is not a finite number above 0.
  Result<void> set_rest_length(int spring, double rest_length_mm);
  /// Moves obstacles between steps. Errors: those of validate(), a point that is not there; then nothing
  /// changes.
  Result<void> set_barriers(std::vector<Barrier> barriers);
  /// Moves hands between steps. Errors: those of validate(); then nothing changes.
  Result<void> set_grabs(std::vector<Grab> grabs);
  /// Of grab number `grab` on the tissue, N; the hand feels the opposite. Zero where there is no such grab.
  [[nodiscard]] Vec3 grab_force(const MotionState& state, int grab) const;
  /// Nothing where the model has no contact.
  [[nodiscard]] ContactMeasures contact_measures(const MotionState& state) const;
  /// At rest in the network's rest positions, nothing relaxed.
  [[nodiscard]] MotionState rest() const;

  /// Potential energy of springs, volumes, areas, solids, gravity, barriers and grabs, N·mm; of springs that
  /// relax as if they did not.
  [[nodiscard]] double potential(std::span<const Vec3> position) const;
  [[nodiscard]] double kinetic(std::span<const Vec3> velocity) const;
  /// Fills `forces` with all forces on each point, N, but friction and damping of contact, which act as
  /// impulses at the end of a step; zero on fixed ones. Returns springs without direction.
  int forces(const MotionState& state, std::span<Vec3> forces) const;

  /// The longest step taken at `state`, unless it ends in a barrier that is stiffer: a part of
  /// (2/ω)(√(1 + ζ²) − ζ) of the stiffest point, its frequency ω and damping ratio ζ bounded by Gershgorin's
  /// theorem; of Euler and Verlet 0.7, of Heun 0.5, a third of these in barriers. Solids: see
  /// solid_blocks.hpp.
  [[nodiscard]] double stable_step_ms(const MotionState& state, Integrator integrator) const;

  /// Steps by `dt_ms` > 0, in sub-steps where that is more than is stable. On error the state is as it was.
  /// Errors: a state of another size; more than 100,000 sub-steps; positions beyond a thousand kilometres;
  /// cancelled.
  Result<StepReport> step(MotionState& state, double dt_ms, Integrator integrator, Context& context,
                          Workspace& workspace) const;
  Result<StepReport> step(MotionState& state, double dt_ms, Integrator integrator, Context& context) const {
    Workspace workspace;
    return step(state, dt_ms, integrator, context, workspace);
  }

  /// Moves on by `duration_ms` > 0 in Heun steps as long as the difference to the Euler step within each
  /// allows, never longer than is stable. Errors: those of step(); a control out of range; more than a
  /// million steps.
  Result<AdvanceReport> advance(MotionState& state, double duration_ms, const StepControl& control,
                                Context& context, Workspace& workspace) const;
  Result<AdvanceReport> advance(MotionState& state, double duration_ms, const StepControl& control,
                                Context& context) const {
    Workspace workspace;
    return advance(state, duration_ms, control, context, workspace);
  }

 private:
  struct Relaxing {
    int spring;
    double share;  // of its force that acts on an end
  };
  struct Outcome;  // of a pass over all points
  struct SubStep;

  explicit TimeStepper(MotionModel model, std::optional<SurfaceContact> contact);
  [[nodiscard]] bool is_mobile(int point) const { return model_.mobile.empty() || model_.mobile[point] != 0; }
  [[nodiscard]] double acting_share(const Spring& spring) const;
  [[nodiscard]] double spring_energy(std::size_t spring, std::span<const Vec3> position) const;
  void add_relaxation(const MotionState& state, Workspace& w) const;
  [[nodiscard]] double applied_energy(std::span<const Vec3> position) const;
  void add_applied(const MotionState& state, Workspace& w) const;
  int finish_contact(const MotionState& from, MotionState& to, double dt, Integrator integrator,
                     Workspace& w) const;
  template <auto wants, class Move>
  Outcome pass(const MotionState& state, const MotionState& target, Workspace& w, Move&& move,
               bool damping_counts = true) const;
  [[nodiscard]] double viscous_decay(int point) const;
  void prepare_target(const MotionState& from, MotionState& to, double dt) const;
  void relax(const MotionState& from, MotionState& to, double dt, std::span<const double> elastic) const;
  Outcome leap(const MotionState& from, MotionState& to, double dt, Integrator integrator,
               Workspace& w) const;
  Outcome predict(const MotionState& from, double dt, Workspace& w) const;
  Outcome correct(const MotionState& from, MotionState& to, double dt, Workspace& w) const;
  SubStep sub_step(const MotionState& from, MotionState& to, double left, int most_parts,
                   Integrator integrator, Workspace& w) const;
  [[nodiscard]] double stable_step(const Outcome& outcome, Integrator integrator) const;
  [[nodiscard]] Result<void> check_state(const MotionState& state) const;

  MotionModel model_;
  std::unique_ptr<NetworkBlocks> blocks_;
  std::unique_ptr<SolidBlocks> solids_;
  std::vector<int> fixed_;
  std::vector<double> decay_;  // for each point: half its damping over its mass, at most
  std::vector<Relaxing> relaxing_;
  std::optional<SurfaceContact> contact_;
  BarriersOfPoints barriers_of_;
};

}  // namespace turgor
