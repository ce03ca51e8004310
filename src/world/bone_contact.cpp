#include "world/bone_contact.hpp"

#include <algorithm>
#include <cmath>

#include "turgor/core/index.hpp"
#include "turgor/core/parallel.hpp"

namespace turgor {
namespace {

/// Bone that has passed the skin is looked for so far outside it.
constexpr double kOutsideMm = 25.0;
/// Bone this far beyond an inner end is known to its contact.
constexpr double kNearMm = 10.0;
/// Some twenty times what a column resists with: ends sink into bone by a few hundredths of a millimetre.
constexpr double kStiffness = 5.0;

}  // namespace

bool moves(const BoneSegment& segment) {
  const Box3 box = bounds(segment.surface);
  for (int corner = 0; corner < 8; ++corner) {
    const Vec3 p{(corner & 1) ? box.upper.x : box.lower.x, (corner & 2) ? box.upper.y : box.lower.y,
                 (corner & 4) ? box.upper.z : box.lower.z};
    if (distance(segment.motion.point(p), p) > 1e-9) return true;
  }
  return false;
}

void BoneContact::Bones::prepare() {
  std::vector<const TriMesh*> all;
  for (const TriMesh& mesh : surfaces) all.push_back(&mesh);
  query.emplace(all);
}

std::vector<BoneContact::Interval> BoneContact::Bones::along(const Vec3& skin, const Vec3& inwards,
                                                             double reach) const {
  // Bones may overlap after the plan: within bone is where more surfaces have been entered than left.
  int within = 0;
  std::vector<Interval> out;
  for (const RayHit& hit : query->all_hits(skin - inwards * kOutsideMm, inwards, 0, kOutsideMm + reach)) {
    const TriMesh& mesh = surfaces[at(hit.surface)];
    const Vec3 normal = normalized(triangle_normal(mesh, mesh.triangles[at(hit.triangle)]));
    const double place = hit.distance - kOutsideMm;
    if (dot(normal, inwards) < 0) {
      if (within++ == 0) out.push_back({place, reach, normal});
    } else if (within > 0 && --within == 0) {
      out.back().to = place;
    }
  }
  return out;
}

BoneContact::BoneContact(const PatientCase& patient)
    : tissue_(patient.tissue()), adhesion_n_mm_(patient.options().contact.adhesion_n_mm) {
  Bones before;
  for (const BoneSegment& s : patient.bones().segments()) {
    before.surfaces.push_back(s.surface);
    all_.surfaces.push_back(transformed(s.surface, s.motion));
    if (moves(s)) moved_.surfaces.push_back(all_.surfaces.back());
  }
  if (!patient.head().rami.empty()) {
    before.surfaces.push_back(patient.head().rami);
    all_.surfaces.push_back(patient.head().rami);
  }
  for (Bones* bones : {&before, &moved_, &all_}) bones->prepare();
  depth_at_rest_.assign(at(tissue_.columns()), 0);
  parallel_for(depth_at_rest_.size(), 64, [&](std::size_t begin, std::size_t end) {
    for (std::size_t c = begin; c < end; ++c) {
      const Column column = column_at_rest(static_cast<int>(c));
      const auto bone = at_end(before, column, column.skin + column.inwards * column.thickness);
      if (bone) depth_at_rest_[c] = std::max(0.0, column.thickness - bone->from);
    }
  });
}

BoneContact::Column BoneContact::column_at_rest(int column) const {
  const Vec3& skin = tissue_.points[at(column)];
  const Vec3& end = tissue_.points[at(tissue_.point(tissue_.sheets - 1, column))];
  const double thickness = distance(skin, end);
  return {skin, (end - skin) / thickness, thickness};
}

// The bone that the end of a column is in, or next to.
std::optional<BoneContact::Interval> BoneContact::at_end(const Bones& bones, const Column& column,
                                                         const Vec3& end) {
  std::optional<Interval> nearest;
  double least = kNearMm;
  for (const Interval& bone :
       bones.along(end - column.inwards * column.thickness, column.inwards, column.thickness + kNearMm)) {
    const bool in = bone.from <= column.thickness && column.thickness <= bone.to;
    const double gap = std::abs(bone.from - column.thickness);
    if (gap > least || (!in && bone.from < column.thickness)) continue;
    least = gap;
    nearest = bone;
  }
  return nearest;
}

std::optional<Vec3> BoneContact::pushed(int column) const {
  constexpr double slack_mm = 0.2;
  const Column c = column_at_rest(column);
  for (const Interval& bone : moved_.along(c.skin, c.inwards, c.thickness)) {
    // Bone that has passed the skin altogether is not in this column.
    if (bone.to <= 0) continue;
    if (bone.from >= c.thickness - slack_mm) return std::nullopt;
    return c.skin + c.inwards * bone.from;
  }
  return std::nullopt;
}

std::optional<Contact> BoneContact::plane(int column, const Vec3& end) const {
  const Column c = column_at_rest(column);
  const auto bone = at_end(all_, c, end);
  if (!bone) return std::nullopt;
  // What lay in bone before the plan is not driven out of it.
  const Vec3 place = end + c.inwards * (bone->from - c.thickness + depth_at_rest_[at(column)]);
  const bool wet = tissue_.vestibule[at(column)];
  return Contact{tissue_.inner_end(column), bone->normal, dot(bone->normal, place), kStiffness,
                 wet ? adhesion_n_mm_ : 0.0};
}

double BoneContact::depth(int column, const Vec3& end) const {
  const Column c = column_at_rest(column);
  const auto bone = at_end(all_, c, end);
  if (!bone) return 0;
  return std::max(0.0, c.thickness - bone->from - depth_at_rest_[at(column)]) * -dot(bone->normal, c.inwards);
}

}  // namespace turgor
