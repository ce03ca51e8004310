// Contact of soft bodies with each other and with themselves: points of the surface against its faces, with
// friction, and without tunnelling where they are fast.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "turgor/core/error.hpp"
#include "turgor/math/vec.hpp"

namespace turgor {

/// The closed surface of one body. An open one holds only against what comes from outside.
struct ContactSurface {
  std::vector<Index3> triangles;  ///< points of the network, anticlockwise seen from outside
  bool self = true;               ///< its points meet its own faces too
};

/// A point is pushed off the nearest face of each other body, and of its own, with the energy
/// ½ k (thickness − d)² at the distance d < thickness; behind the face, d counts as negative, so that the way
/// out is the way it came. Forces on the point and on the three corners are the exact negative gradient:
/// momentum is kept. Friction is Coulomb's, regularised: of μ times the normal force against the sliding
/// velocity, in proportion to it below `stick_mm_ms`. Points that would cross a face within a step are
/// stopped at it, inelastically. Edges do not meet edges.
///
/// Parts of one body that lie together at rest are no contact: of the faces nearer to a point than twice the
/// thickness in the rest shape, those that it faces across a gap act from that distance on, the others never.
struct ContactModel {
  std::vector<ContactSurface> surfaces;  ///< a point belongs to one of them at most
  double thickness_mm = 1;               ///< > 0
  double stiffness_n_mm = 1;             ///< k, of each point, ≥ 0
  double friction = 0.3;                 ///< μ, ≥ 0
  double stick_mm_ms = 1e-3;             ///< > 0
  double damping = 1;  ///< of approach and parting, ≥ 0; 1: critical for the masses in touch. Never pulls
};
/// Errors name the surface, triangle, point or number that is out of range.
Result<void> validate(const ContactModel& model, std::size_t point_count);

/// A point that touches a face: the force on points[i] is weights[i] k depth_mm normal, and ½ k depth_mm²
/// the energy.
struct ContactTouch {
  std::array<int, 4> points;      ///< the one that touches, then the corners of the face
  std::array<double, 4> weights;  ///< 1, then the negative barycentric ones of the nearest point
  Vec3 normal;                    ///< unit, the way out
  double depth_mm;                ///< > 0: threshold − gap
  double gap_mm;                  ///< signed distance, negative behind the face
  int surface, face_surface;      ///< of the point and of the face
};

struct ContactMeasures {
  struct Pair {
    int a, b;           ///< surfaces, a ≤ b
    int contacts;       ///< points of either that touch the other
    double normal_n;    ///< sum of their forces' amounts
    Vec3 force_on_a_n;  ///< of b on a; of a self contact zero
  };
  int contacts = 0;
  double deepest_mm = 0;    ///< of points behind faces
  std::vector<Pair> pairs;  ///< those that touch, by rising a, then b
};

/// Immutable; copies share what was prepared. Positions and velocities are of all points of the network.
/// Deterministic, and the same bits on any number of threads.
class SurfaceContact {
  struct Parts;

 public:
  /// What may come to touch, found again once points have moved by half the thickness. Kept by the caller
  /// between calls; what it holds does not change results.
  class Workspace {
   public:
    /// Found last.
    [[nodiscard]] std::span<const ContactTouch> touches() const { return touches_; }

   private:
    friend class SurfaceContact;
    struct Candidate {
      int face;
      bool from_front_alone;
      double threshold;
    };
    struct Impact {
      double time;                // part of the way
      std::array<int, 4> points;  // as of a touch
      std::array<double, 4> weights;
      Vec3 normal;
    };
    struct Chunk {
      std::vector<int> begin;  // of each point's candidates, and the end
      std::vector<Candidate> candidates;
      std::vector<ContactTouch> touches;
      std::vector<Impact> impacts;
    };
    std::shared_ptr<const Parts> owner_;
    std::vector<Vec3> origin_;  // of the points of surfaces, where chunks were filled
    std::vector<std::vector<Box3>> boxes_;
    std::vector<Chunk> chunks_;
    std::vector<ContactTouch> touches_;
    std::vector<Impact> impacts_;
  };

  /// `inverse_mass` is 1/g, 0 for points that do not move. Errors: those of validate(); sizes that differ.
  static Result<SurfaceContact> prepare(ContactModel model, std::span<const Vec3> rest,
                                        std::span<const double> inverse_mass);

  [[nodiscard]] const ContactModel& model() const;
  /// All touches in a fixed order, of a point at most one with each surface. Valid until the next call.
  std::span<const ContactTouch> find(std::span<const Vec3> positions, Workspace& workspace) const;
  [[nodiscard]] double energy(std::span<const Vec3> positions) const;
  [[nodiscard]] ContactMeasures measure(std::span<const Vec3> positions) const;

  /// Friction and damping of the touches found last, for `dt_ms`: impulses one after another, each backward
  /// Euler, hence stable for every step. Positions follow by `follow_ms` times the change of velocity.
  void slow(const Workspace& workspace, double dt_ms, double follow_ms, std::span<Vec3> positions,
            std::span<Vec3> velocities) const;
  /// Stops points that cross a face from its front on the straight ways from `from` to `to`: `to` is changed
  /// so that none does, approach is taken out of the velocities, with friction. Momentum is kept. Returns
  /// how many points had to be held where they were since impulses did not settle it.
  int stop(std::span<const Vec3> from, std::span<Vec3> to, std::span<Vec3> velocities,
           Workspace& workspace) const;

 private:
  explicit SurfaceContact(std::shared_ptr<const Parts> parts) : parts_(std::move(parts)) {}
  void seek(std::span<const Vec3> from, std::span<const Vec3> to, Workspace& w) const;
  void list_candidates(std::size_t chunk, std::span<const Vec3> from, std::span<const Vec3> to,
                       Workspace& w) const;
  void touch(std::size_t chunk, std::span<const Vec3> positions, Workspace& w) const;
  bool find_impacts(std::span<const Vec3> from, std::span<const Vec3> to, Workspace& w) const;
  std::shared_ptr<const Parts> parts_;
};

}  // namespace turgor
