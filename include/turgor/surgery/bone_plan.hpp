// Bones, the segments cut from them, and how they are moved.
#pragma once

#include <array>
#include <string>
#include <string_view>
#include <vector>

#include "turgor/anatomy/head.hpp"
#include "turgor/core/error.hpp"
#include "turgor/geometry/tri_mesh.hpp"

namespace turgor {

enum class Bone : std::uint8_t { skull, mandible };
std::string_view name_of(Bone bone);

/// A convex region: points on the positive side of every plane. Empty: all of space.
struct CutRegion {
  std::vector<Plane> planes;
  [[nodiscard]] bool contains(const Vec3& p) const {
    for (const Plane& plane : planes) {
      if (plane.signed_distance(p) < 0) return false;
    }
    return true;
  }
  /// The box's six sides added to the planes.
  void add_box(const Box3& box);
};

/// A piece of bone that moves as one. Segment 0 is the whole skull, 1 the whole mandible (where there is
/// one); further ones are cut from them and take their part away.
struct BoneSegment {
  std::string name;
  Bone bone = Bone::skull;
  int parent = -1;
  CutRegion region;       ///< within the parent, in the patient's position before surgery
  TriMesh surface;        ///< before any move, closed by caps where it was cut
  RigidTransform motion;  ///< from before surgery to after
};

/// The bones of one head under a plan. A value: copy it to try a variant.
class BonePlan {
 public:
  explicit BonePlan(const Head& head);

  [[nodiscard]] const std::vector<BoneSegment>& segments() const { return segments_; }
  [[nodiscard]] int find(std::string_view name) const;  ///< -1: no such segment
  /// Segment that holds a point of the given bone (before surgery).
  [[nodiscard]] int segment_at(Bone bone, const Vec3& point) const;

  /// Cuts the part of segment `of` within `region` free under a new name.
  /// Errors: unknown segment, name taken, the cut misses the bone or takes all of it.
  Result<void> osteotomy(const std::string& name, std::string_view of, const CutRegion& region);
  /// Applies `motion` after the segment's motion so far. Errors: unknown segment.
  Result<void> move(std::string_view segment, const RigidTransform& motion);

 private:
  std::vector<BoneSegment> segments_;
};

}  // namespace turgor
