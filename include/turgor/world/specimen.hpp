// The tissue of a scene: point samples made one by one or by `flesh_out`, the forces on them, muscles and
// sutures, and their motion (Pieper 1989, sections 3.2 and 5.1 to 5.7). Numbers of a script carry no units;
// any consistent ones do.
#pragma once

#include <array>
#include <functional>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "turgor/anatomy/flesh.hpp"
#include "turgor/core/context.hpp"
#include "turgor/dynamics/time_stepper.hpp"
#include "turgor/world/object.hpp"

namespace turgor {

/// A point sample: of those made one by one (body 0), or of a flesh (bodies from 1 on).
struct SampleRef {
  int body = 0, number = 0;
  auto operator<=>(const SampleRef&) const = default;
};

struct SpringOptions {
  double stiffness = 1;
  SpringLaw law = SpringLaw::linear;
  double viscosity = 0;
  double cutoff = 0;  ///< length beyond which the spring lets go; 0: never
};

/// A generalised spring between any two samples: a `shock` made by hand, a fibre of a muscle, a suture.
struct Fibre {
  SampleRef a, b;
  double original_length = 1;
  double scale = 1;  ///< of the rest length over the original one
  SpringOptions options;
};

/// Rest lengths over time: keys joined by half cosines, the first and last value beyond them
/// (section 5.4.1).
struct Twitch {
  double start = 0;
  std::vector<double> times, scales;  ///< times ascend, from `start` on; scales ≥ 0
  [[nodiscard]] double scale_at(double time) const;
};
/// Errors: fewer than one pair, times that do not ascend, negative scales.
Result<void> validate(const Twitch& twitch);

/// A named collection of fibres that act as one (section 5.1).
struct Muscle {
  std::string name;
  std::vector<Fibre> fibres;
  std::optional<Twitch> twitch;
};

/// How an object acts as a region: its bounding sphere, the plane through its local origin with its normal,
/// the surface of a depth map or of a closed polyhedron (section 5.2.3).
enum class RegionShape { sphere, plane, depth_map, mesh };

/// A region that samples are kept out of (drape) or drawn to (cling), made of an object of the scene.
struct Collision {
  int object = 0;  ///< id
  RegionShape shape = RegionShape::sphere;
  ObjectTransform placed;  ///< where the object stood when the barrier was made
  Barrier barrier;
  int body = -1;   ///< acts on this body alone; -1: on all
  int layer = -1;  ///< of that body; -1: all
};

/// Which samples an edit changes. Empty optionals restrict nothing.
struct Region {
  std::optional<Box3> box;
  std::optional<Vec3> centre;  ///< of a sphere
  double radius = 0;
  int layer = -1;  ///< -1: all
  [[nodiscard]] bool contains(const Vec3& p) const {
    return (!box || box->contains(p)) && (!centre || distance(p, *centre) <= radius);
  }
};

/// The outermost layer as skin (section 2.1.2): collagen beside the springs of the layer, slack until they
/// are stretched, stiffer and sooner taut along Langer's lines; tension at rest; tension that fades.
struct SkinLayer {
  double collagen = 0;             ///< material constant along Langer's lines, ≥ 0
  double transition_along = 0.35;  ///< strain from which collagen acts, ≥ 0
  double transition_across = 0.55;
  double anisotropy = 2;     ///< of the constant along over across, > 0
  std::vector<Vec3> langer;  ///< direction of the lines: one for all, or one for each column
  double rest_strain = 0;    ///< strain of the layer's springs at rest, ≥ 0
  std::array<Relaxation, kRelaxations> relaxation{};  ///< of the whole scene: the last one given
};
Result<void> validate(const SkinLayer& skin, int columns);

/// One flesh and where its samples lie in the state.
struct FleshBody {
  std::string name;
  std::optional<AdaptiveFlesh> adaptive;        ///< while it is refined
  Flesh flesh;                                  ///< without samples for body 0
  FleshNetwork parts;                           ///< of the present flesh
  std::optional<RefinementOptions> refinement;  ///< while set, adapt() follows the deformation
  int offset = 0, count = 0;                    ///< samples in positions()
  double viscosity = 0;                         ///< of its springs
  std::optional<SkinLayer> skin;
};

struct SimulationOptions {
  double dt = 0.05;
  Integrator integrator = Integrator::euler;
  double tolerance = 0;  ///< > 0: steps chosen by the estimated error per step instead, none longer than dt
};

/// What a step, or many, took.
struct SimulationReport {
  std::int64_t steps = 0, sub_steps = 0;
  double shortest_stable = std::numeric_limits<double>::infinity();
  int most_coincident = 0;
};

class Specimen {
 public:
  Specimen();

  // ---- making ----
  /// Errors: the name is taken; not finite; mass not above 0.
  Result<SampleRef> add_sample(const std::string& name, const Vec3& position, double mass, bool mobile);
  /// Its rest length is the present distance. Errors: the same sample twice, no distance, bad constants.
  Result<void> add_shock(SampleRef a, SampleRef b, const SpringOptions& options);
  /// Returns its body. Errors: the name is taken; an invalid flesh.
  Result<int> add_flesh(const std::string& name, Flesh flesh, double viscosity);
  /// Makes the muscle where there is none of the name. Its rest length is the present distance.
  Result<void> add_fibre(const std::string& muscle, SampleRef a, SampleRef b, const SpringOptions& options);
  Result<void> set_twitch(const std::string& muscle, Twitch twitch);
  /// Rest lengths of all fibres at once: `length` itself, or the present ones times `scale`. No effect on a
  /// muscle that twitches: false (section 5.4.2).
  Result<bool> set_muscle(const std::string& muscle, std::optional<double> length,
                          std::optional<double> scale);
  Result<void> add_collision(Collision collision);
  /// Keeps stiffness, law and kind of collision number `i`; its place is that of `shape`.
  Result<void> reshape_collision(std::size_t i, const Barrier& shape, const ObjectTransform& placed);
  void forget_collisions(const std::function<bool(const Collision&)>& which);
  Result<void> set_gravity(const Vec3& acceleration);
  Result<void> set_damping(double damping);

  // ---- edits of a flesh (section 6.2); each returns how many samples or polygons it changed ----
  Result<int> scale_growth(const std::string& body, const Region& region, double factor);
  Result<int> scale_stiffness(const std::string& body, const Region& region, double factor);
  Result<int> set_mobile(const std::string& body, const Region& region, bool mobile);
  /// Volume-preserving prisms between the layers: modulus and inversion guard, MPa.
  Result<int> set_volume(const std::string& body, double modulus, double guard);
  /// Ends refinement: the present resolution stays.
  Result<int> remove(const std::string& body, const Region& region);
  /// Makes the outermost layer skin. Errors: numbers out of range; directions of another number.
  Result<void> set_skin(const std::string& body, SkinLayer skin);
  /// Refines where deformation is large, and back, now and at every adapt(); nullopt ends that and joins all
  /// again.
  Result<int> refine(const std::string& body, const std::optional<RefinementOptions>& options);
  /// Fits the resolution of all bodies that are to follow their deformation; returns how many changed.
  Result<int> adapt();

  // ---- handles: samples that things outside hold on to through every edit ----
  int hold(SampleRef sample);  ///< a handle; the same one for the same sample
  [[nodiscard]] int handle_count() const { return static_cast<int>(handles_.size()); }
  [[nodiscard]] std::optional<SampleRef> held(int handle) const;  ///< none where the sample is gone

  // ---- looking ----
  [[nodiscard]] const std::vector<FleshBody>& bodies() const { return bodies_; }
  [[nodiscard]] int body_number(const std::string& name) const;  ///< -1 where there is none
  [[nodiscard]] const std::vector<Muscle>& muscles() const { return muscles_; }
  [[nodiscard]] const std::vector<Fibre>& shocks() const { return shocks_; }
  [[nodiscard]] const std::vector<std::string>& sample_names() const { return names_; }
  [[nodiscard]] std::optional<SampleRef> sample(const std::string& name) const;
  /// Nearest mobile or fixed sample of any flesh; errors: there is none.
  [[nodiscard]] Result<SampleRef> nearest_sample(const Vec3& point) const;
  [[nodiscard]] bool exists(SampleRef sample) const;
  [[nodiscard]] int index(SampleRef sample) const {
    return bodies_[static_cast<std::size_t>(sample.body)].offset + sample.number;
  }
  [[nodiscard]] Vec3 position(SampleRef sample) const {
    return state_.position[static_cast<std::size_t>(index(sample))];
  }
  [[nodiscard]] const MotionState& state() const { return state_; }
  [[nodiscard]] std::vector<Vec3> positions_of(const FleshBody& body) const;
  [[nodiscard]] double damping() const { return damping_; }
  [[nodiscard]] const std::vector<Collision>& collisions() const { return collisions_; }
  [[nodiscard]] int spring_count() const;
  /// Tension of a fibre now: > 0 pulls.
  [[nodiscard]] double tension(const Fibre& fibre) const;
  [[nodiscard]] double length(const Fibre& fibre) const {
    return distance(position(fibre.a), position(fibre.b));
  }

  // ---- moving ----
  /// Puts a sample somewhere, at rest.
  void set_position(SampleRef sample, const Vec3& position);
  Result<void> set_state(MotionState state);
  /// One step from `time`: muscles take their lengths, forces act, samples move. On error nothing changes.
  Result<void> step(double time, const SimulationOptions& options, SimulationReport& report,
                    Context& context);

 private:
  Result<Muscle*> require_muscle(const std::string& name);
  Result<void> rebuild(FleshBody& body);
  void renumber();
  void carry_over(int body, const FleshMap& map);
  Result<bool> adapt_body(int body);
  Result<void> assemble();
  template <class Edit>
  Result<int> edit(const std::string& name, Edit&& change);
  [[nodiscard]] static double rest_length(const Fibre& fibre);
  [[nodiscard]] std::vector<Barrier> barriers() const;
  [[nodiscard]] std::vector<int> points_of(const Collision& collision) const;
  void append_skin(MotionModel& model, const FleshBody& body, std::size_t first_spring) const;
  void append_fibre(MotionModel& model, const Fibre& fibre) const;
  Result<void> drive_muscles(double time);
  [[nodiscard]] Result<int> require_flesh(const std::string& name) const;
  [[nodiscard]] std::vector<bool> columns_in(const FleshBody& body, const Region& region) const;

  std::vector<FleshBody> bodies_;
  std::vector<std::string> names_;  // of the samples of body 0
  std::vector<double> masses_;      // of the same
  std::vector<bool> mobile_;        // of the same
  std::vector<Fibre> shocks_;
  std::vector<Muscle> muscles_;
  std::vector<Collision> collisions_;
  std::vector<std::optional<SampleRef>> handles_;
  Vec3 gravity_;
  double damping_ = 0;
  std::array<Relaxation, kRelaxations> relaxation_{};
  MotionState state_;

  std::optional<TimeStepper> stepper_;  // of the present whole; none after a change
  int first_fibre_ = 0;                 // of the muscles among the stepper's springs
  TimeStepper::Workspace workspace_;
};

}  // namespace turgor
