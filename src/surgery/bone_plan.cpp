#include "turgor/surgery/bone_plan.hpp"

#include "turgor/geometry/mesh_edit.hpp"

namespace turgor {
namespace {

constexpr double snap_mm = 0.02;

std::string known_names(const std::vector<BoneSegment>& segments) {
  std::string names;
  for (const BoneSegment& s : segments) names += (names.empty() ? "" : ", ") + s.name;
  return names;
}

Plane opposite(const Plane& plane) {
  return {-plane.normal, -plane.offset};
}

// Splits a surface into the part inside a convex region and the rest: what lies behind the first plane, then
// what of the remainder lies behind the second, and so on.
void split(const TriMesh& surface, const CutRegion& region, TriMesh& inside, TriMesh& rest) {
  inside = surface;
  rest = {};
  for (const Plane& plane : region.planes) {
    rest = append(std::move(rest), clip(inside, opposite(plane), true, snap_mm));
    inside = clip(inside, plane, true, snap_mm);
  }
}

}  // namespace

std::string_view name_of(Bone bone) {
  return bone == Bone::skull ? "skull" : "mandible";
}

void CutRegion::add_box(const Box3& box) {
  for (int axis = 0; axis < 3; ++axis) {
    Vec3 n{};
    n[axis] = 1;
    planes.push_back({n, box.lower[axis]});
    planes.push_back({-n, -box.upper[axis]});
  }
}

BonePlan::BonePlan(const Head& head) {
  segments_.push_back({"skull", Bone::skull, -1, {}, head.skull, {}});
  if (!head.mandible.empty()) segments_.push_back({"mandible", Bone::mandible, -1, {}, head.mandible, {}});
}

int BonePlan::find(std::string_view name) const {
  for (std::size_t i = 0; i < segments_.size(); ++i) {
    if (segments_[i].name == name) return static_cast<int>(i);
  }
  return -1;
}

int BonePlan::segment_at(Bone bone, const Vec3& point) const {
  int found = -1;
  for (int i = 0; i < static_cast<int>(segments_.size()); ++i) {
    const BoneSegment& s = segments_[static_cast<std::size_t>(i)];
    // Parents come before their parts, so the last one that holds the point is the innermost.
    if (s.bone == bone && s.parent == found && s.region.contains(point)) found = i;
  }
  return found;
}

Result<void> BonePlan::osteotomy(const std::string& name, std::string_view of, const CutRegion& region) {
  const int parent = find(of);
  if (parent < 0) {
    return Error{ErrorKind::bad_command, "there is no bone segment '" + std::string(of) + "'", "",
                 "Name one of: " + known_names(segments_)};
  }
  if (find(name) >= 0) {
    return Error{ErrorKind::bad_command, "the name '" + name + "' is taken", "",
                 "Choose another name for the segment"};
  }
  BoneSegment& whole = segments_[static_cast<std::size_t>(parent)];
  BoneSegment part{name, whole.bone, parent, region, {}, whole.motion};
  TriMesh rest;
  split(whole.surface, region, part.surface, rest);
  if (part.surface.empty() || region.planes.empty()) {
    return Error{ErrorKind::bad_command, "the planes of '" + name + "' miss the bone '" + whole.name + "'",
                 "", "Move the planes, or turn their normals towards the part to be cut free"};
  }
  if (rest.empty()) {
    return Error{ErrorKind::bad_command,
                 "the planes of '" + name + "' cut nothing: all of '" + whole.name + "' lies within them", "",
                 "Move the planes into the bone"};
  }
  whole.surface = std::move(rest);
  segments_.push_back(std::move(part));
  return {};
}

Result<void> BonePlan::move(std::string_view segment, const RigidTransform& motion) {
  const int i = find(segment);
  if (i < 0) {
    return Error{ErrorKind::bad_command, "there is no bone segment '" + std::string(segment) + "'", "",
                 "Name one of: " + known_names(segments_)};
  }
  // A part cut from a segment goes along with it, unless it was cut free before: then it moves by itself.
  BoneSegment& s = segments_[static_cast<std::size_t>(i)];
  s.motion = motion * s.motion;
  return {};
}

}  // namespace turgor
