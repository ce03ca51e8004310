// The tissue of a scene: point samples made one by one, by `flesh_out` or by `voxelize`, the forces on them,
// muscles and sutures, and their motion (Pieper 1989, sections 3.2 and 5.1 to 5.7; Morris 2006, section 4).
// Numbers of a script carry no units; any consistent ones do.
#pragma once

#include <array>
#include <functional>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "turgor/anatomy/flesh.hpp"
#include "turgor/core/context.hpp"
#include "turgor/dynamics/implicit_stepper.hpp"
#include "turgor/dynamics/time_stepper.hpp"
#include "turgor/geometry/surface_query.hpp"
#include "turgor/world/object.hpp"
#include "turgor/world/solid_part.hpp"

namespace turgor {

/// A point sample: of those made one by one (body 0), or of a flesh or a solid (bodies from 1 on).
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
  std::shared_ptr<const SurfaceQuery> inside = nullptr;  ///< of a closed surface
  int layer = -1;                                        ///< -1: all; of fleshes alone
  [[nodiscard]] bool contains(const Vec3& p) const {
    return (!box || box->contains(p)) && (!centre || distance(p, *centre) <= radius) &&
           (!inside || inside->inside(p));
  }
};

/// Samples that move with an object, as tissue does with the bone it grows on.
struct Attachment {
  int object = 0;  ///< id
  int body = 0;
  std::vector<int> samples;
  std::vector<Vec3> places;  ///< in the frame of the object's pose

  /// Gives each sample the number that `renumbered` tells, and drops those with a negative one.
  template <class Renumbered>
  void keep(Renumbered&& renumbered) {
    std::size_t kept = 0;
    for (std::size_t i = 0; i < samples.size(); ++i) {
      const int now = renumbered(samples[i]);
      if (now >= 0) samples[kept] = now, places[kept++] = places[i];
    }
    samples.resize(kept);
    places.resize(kept);
  }
};

/// A hand on the tissue: pulls the mean of its samples to a target, or along with an object.
struct NamedGrab {
  std::string name;
  int body = 0;
  std::vector<int> samples;
  Vec3 target;
  std::optional<int> object = std::nullopt;  ///< id; the target keeps its place in the object's frame
  Vec3 place;                                ///< that place
  double stiffness = 1, limit = 1e9;         ///< force over distance, greatest force
};

/// Contact of the surfaces of all solids with each other, and with themselves.
struct SolidContactOptions {
  double thickness = 0;  ///< distance at which surfaces meet; 0: a quarter of the smallest cube
  double stiffness = 0;  ///< force over depth; 0: twice the largest Young's modulus times that cube's edge
  double friction = 0.3;
  bool self = true;
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

/// One flesh or solid, and where its samples lie in the state. Body 0 has the samples made one by one.
struct TissueBody {
  std::string name;
  std::optional<AdaptiveFlesh> adaptive;        ///< while it is refined
  Flesh flesh;                                  ///< without samples for body 0
  FleshNetwork parts;                           ///< of the present flesh
  std::optional<RefinementOptions> refinement;  ///< while set, adapt() follows the deformation
  int offset = 0, count = 0;                    ///< samples in positions()
  double viscosity = 0;                         ///< of its springs
  std::optional<SkinLayer> skin;
  std::optional<SolidPart> solid = std::nullopt;  ///< then `flesh` is empty

  [[nodiscard]] std::size_t samples() const {
    return solid ? solid->mesh.points.size() : flesh.samples.size();
  }
};

struct SimulationOptions {
  double dt = 0.05;
  Integrator integrator = Integrator::euler;
  bool implicit = false;  ///< implicit Euler instead
  double tolerance = 0;   ///< > 0: steps chosen by the estimated error per step instead, none longer than dt
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
  /// Returns its body. Errors: the name is taken.
  Result<int> add_solid(const std::string& name, SolidPart part);
  /// A new solid in place of one's own: points take their motion, and what holds them, from the tetrahedra of
  /// the old one that `from_old` names; fibres, grabs and handles go to the nearest new points. `pose_of`
  /// tells the pose of an object. Errors: not a solid; another number of points.
  Result<void> replace_solid(int body, SolidPart part, const TetraEmbedding& from_old,
                             const std::function<ObjectTransform(int)>& pose_of);
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
  /// All samples of the region become immobile and move with the object from now on; returns how many.
  Result<int> attach(const std::string& body, const Region& region, int object, const ObjectTransform& pose);
  [[nodiscard]] const std::vector<Attachment>& attachments() const { return attachments_; }
  /// Where attached samples are to be after `duration`: they move there at constant speed; at once for 0.
  void lead(const Attachment& attachment, const ObjectTransform& pose, double duration);
  void forget_attachments(const std::function<bool(const Attachment&)>& which);
  /// Replaces one of the same name. Errors: no samples; numbers out of range.
  Result<void> set_grab(NamedGrab grab);
  Result<void> release(const std::string& name);  ///< errors: there is none
  [[nodiscard]] const std::vector<NamedGrab>& grabs() const { return grabs_; }
  [[nodiscard]] Grab lowered(const NamedGrab& grab) const;
  [[nodiscard]] Vec3 force_of(const NamedGrab& grab) const;
  /// nullopt: none. Errors: out of range.
  Result<void> set_contact(const std::optional<SolidContactOptions>& options);
  [[nodiscard]] const std::optional<SolidContactOptions>& contact() const { return contact_; }
  /// As the samples lie; surfaces are the solids in their order. Nothing before the first step after a
  /// change.
  [[nodiscard]] ContactMeasures contact_measures() const {
    return stepper_ ? stepper_->contact_measures(state_) : ContactMeasures{};
  }
  Result<void> set_gravity(const Vec3& acceleration);
  Result<void> set_damping(double damping);

  // ---- edits (section 6.2); each returns how many samples or polygons it changed ----
  // Of solids `scale_stiffness` changes tetrahedra and `set_mobile` points; the others are of fleshes.
  Result<int> scale_growth(const std::string& body, const Region& region, double factor);
  Result<int> scale_stiffness(const std::string& body, const Region& region, double factor);
  /// Calibrated constants in place of those of the solid's material; scale_stiffness() goes on to scale them.
  /// None at all: the material's again.
  /// Errors: no such solid; those of set_constants().
  Result<void> set_solid_constants(const std::string& solid, SolidConstants constants);
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
  [[nodiscard]] const std::vector<TissueBody>& bodies() const { return bodies_; }
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
  [[nodiscard]] std::vector<Vec3> positions_of(const TissueBody& body) const;
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
  /// To static equilibrium under the forces at `time`. On error nothing changes.
  Result<EquilibriumResult> settle(double time, const EquilibriumOptions& options, Context& context);

 private:
  Result<Muscle*> require_muscle(const std::string& name);
  Result<void> rebuild(TissueBody& body);
  void renumber();
  void carry_over(int body, const FleshMap& map);
  Result<bool> adapt_body(int body);
  Result<void> assemble();
  template <class Edit>
  Result<int> edit(const std::string& name, Edit&& change);
  [[nodiscard]] static double rest_length(const Fibre& fibre);
  [[nodiscard]] std::vector<Barrier> barriers() const;
  [[nodiscard]] std::vector<Grab> lowered_grabs() const;
  [[nodiscard]] std::optional<ContactModel> contact_model() const;
  [[nodiscard]] Result<int> require_body(const std::string& name) const;
  void append_solid(MotionModel& model, const TissueBody& body) const;
  void append_flesh(MotionModel& model, const TissueBody& body) const;
  Result<int> stiffen_solid(TissueBody& body, const Region& region, double factor);
  Result<int> fix_solid(TissueBody& body, const Region& region, bool mobile);
  void detach_mobile(int body);
  Result<void> prepare_implicit(Context& context);
  void forget_model() {
    stepper_.reset();
    implicit_.reset();
  }
  [[nodiscard]] std::vector<int> points_of(const Collision& collision) const;
  void append_skin(MotionModel& model, const TissueBody& body, std::size_t first_spring) const;
  void append_fibre(MotionModel& model, const Fibre& fibre) const;
  Result<void> drive_muscles(double time);
  [[nodiscard]] Result<int> require_flesh(const std::string& name) const;
  [[nodiscard]] std::vector<bool> columns_in(const TissueBody& body, const Region& region) const;

  std::vector<TissueBody> bodies_;
  std::vector<std::string> names_;  // of the samples of body 0
  std::vector<double> masses_;      // of the same
  std::vector<bool> mobile_;        // of the same
  std::vector<Fibre> shocks_;
  std::vector<Muscle> muscles_;
  std::vector<Collision> collisions_;
  std::vector<Attachment> attachments_;
  std::vector<NamedGrab> grabs_;
  std::optional<SolidContactOptions> contact_;
  std::vector<std::optional<SampleRef>> handles_;
  Vec3 gravity_;
  double damping_ = 0;
  std::array<Relaxation, kRelaxations> relaxation_{};
  MotionState state_;

  std::optional<TimeStepper> stepper_;       // of the present whole; none after a change
  std::optional<ImplicitStepper> implicit_;  // of the same, once it is asked for
  int first_fibre_ = 0;                      // of the muscles among the stepper's springs
  TimeStepper::Workspace workspace_;
};

}  // namespace turgor
