#include "world/face_supports.hpp"

#include <algorithm>
#include <limits>

#include "turgor/core/index.hpp"
#include "turgor/core/parallel.hpp"
#include "world/bone_contact.hpp"

namespace turgor {
namespace {

/// Bone farther away than this pushes nothing, mm.
constexpr double kReachMm = 15.0;
/// Of the layered tissue's columns, whose stiffness and adhesion are spread over it.
constexpr double kColumnMm2 = 20.0, kColumnStiffness = 5.0;

std::vector<TriMesh> bones_of(const PatientCase& patient, bool after) {
  std::vector<TriMesh> out;
  for (const BoneSegment& s : patient.bones().segments())
    out.push_back(after ? transformed(s.surface, s.motion) : s.surface);
  out.push_back(patient.head().rami);
  return out;
}

std::vector<Vec3> evened(const TriMesh& mesh, std::vector<Vec3> normals) {
  constexpr int rounds = 8;
  std::vector<Vec3> next(normals.size());
  const PointAdjacency adjacency = point_adjacency(mesh);
  for (int round = 0; round < rounds; ++round) {
    for (std::size_t p = 0; p < normals.size(); ++p) {
      Vec3 sum = normals[p];
      for (int k = adjacency.offsets[p]; k < adjacency.offsets[p + 1]; ++k)
        sum += normals[at(adjacency.neighbours[at(k)])];
      next[p] = normalized(sum);
    }
    normals.swap(next);
  }
  return normals;
}

/// Of the inner ends of columns on bone, the nearest to each point; -1 where there are none.
std::vector<int> nearest_columns(const LayeredTissue& tissue, const std::vector<Vec3>& points) {
  std::vector<int> on_bone;
  for (int c = 0; c < tissue.columns(); ++c)
    if (tissue.ends[at(c)] != ColumnEnd::none) on_bone.push_back(c);
  std::vector<int> out(points.size(), -1);
  parallel_for(points.size(), 64, [&](std::size_t begin, std::size_t end) {
    for (std::size_t p = begin; p < end; ++p) {
      double least = std::numeric_limits<double>::infinity();
      for (const int c : on_bone) {
        const double d = squared_length(tissue.points[at(tissue.inner_end(c))] - points[p]);
        if (d < least) least = d, out[p] = c;
      }
    }
  });
  return out;
}

/// Whether bone near `rest` parts from the bone `own` there, which takes it to `taken`.
bool is_undermined(const PatientCase& patient, const SlidingSurface& bones, const Vec3& rest,
                   const Vec3& taken, int own) {
  constexpr double parted_mm = 0.5;
  const auto& segments = patient.bones().segments();
  for (int s = 0; s < static_cast<int>(segments.size()); ++s) {
    const bool parts = s != own && distance(segments[at(s)].motion.point(rest), taken) > parted_mm;
    if (parts && bones.is_near(s, rest, patient.options().contact.undermining_mm)) return true;
  }
  return false;
}

}  // namespace

SlidingSurface::SlidingSurface(const std::vector<TriMesh>& bones) {
  for (const TriMesh& mesh : bones) {
    const std::vector<Vec3> normals = point_normals(mesh);
    bones_.push_back({mesh, normals, evened(mesh, normals), SurfaceQuery(mesh), bounds(mesh)});
  }
}

bool SlidingSurface::within_another(std::size_t bone, const Vec3& p) const {
  for (std::size_t b = 0; b < bones_.size(); ++b)
    if (b != bone && bones_[b].box.contains(p) && bones_[b].query.inside(p)) return true;
  return false;
}

bool SlidingSurface::is_near(int bone, const Vec3& p, double reach_mm) const {
  return bones_[at(bone)].query.nearest(p, reach_mm).has_value();
}

std::optional<SlidingSurface::Place> SlidingSurface::nearest(const Vec3& p, double reach_mm) const {
  std::optional<NearestPoint> best;
  std::size_t bone = 0;
  for (std::size_t b = 0; b < bones_.size(); ++b) {
    const auto near = bones_[b].query.nearest(p, best ? best->distance : reach_mm);
    if (!near || (best && near->distance >= best->distance) || within_another(b, near->point)) continue;
    best = near;
    bone = b;
  }
  if (!best) return std::nullopt;
  const Bone& found = bones_[bone];
  const Index3& t = found.mesh.triangles[at(best->triangle)];
  const auto mean = [&](const std::vector<Vec3>& of) {
    const Vec3 n =
        normalized(of[at(t[0])] * (1 - best->u - best->v) + of[at(t[1])] * best->u + of[at(t[2])] * best->v);
    return n == Vec3{} ? normalized(triangle_normal(found.mesh, t)) : n;
  };
  const double side = dot(mean(found.normals), p - best->point) < 0 ? -1 : 1;
  // The way to the nearest point is the gradient of the distance, and has no direction on the bone itself.
  constexpr double clear_mm = 1.0;
  const double share = std::min(1.0, best->distance / clear_mm);
  const Vec3 away = normalized(p - best->point) * side;
  const Vec3 normal = normalized(away * share + mean(found.even_normals) * (1 - share));
  return Place{static_cast<int>(bone), normal == Vec3{} ? mean(found.normals) : normal,
               side * best->distance};
}

FaceSupports::FaceSupports(const PatientCase& patient, const FaceSolid& face)
    : face_(face),
      adhesion_n_mm_(patient.options().contact.adhesion_n_mm),
      before_(bones_of(patient, false)),
      after_(bones_of(patient, true)) {}

Result<FaceSupports> FaceSupports::find(const PatientCase& patient, const FaceSolid& face) {
  TURGOR_TRY(const TissueMotion motion, tissue_motion(patient));
  FaceSupports supports(patient, face);
  supports.hold(patient, motion);
  return supports;
}

// What holds the layered tissue where its nearest column meets bone holds a node there too, by the bone that
// the node itself lies on.
void FaceSupports::hold(const PatientCase& patient, const TissueMotion& motion) {
  const LayeredTissue& tissue = patient.tissue();
  const auto& segments = patient.bones().segments();
  std::vector<bool> loose(at(tissue.columns()), false);
  for (const int c : motion.free_columns) loose[at(c)] = true;
  std::vector<int> on_bone;
  std::vector<Vec3> places;
  for (std::size_t n = 0; n < face_.nodes.size(); ++n) {
    if (face_.nodes[n] == FaceNode::rim) held_.push_back({.node = static_cast<int>(n)});
    if (face_.nodes[n] != FaceNode::bone) continue;
    on_bone.push_back(static_cast<int>(n));
    places.push_back(face_.mesh.points[n]);
  }
  const std::vector<int> columns = nearest_columns(tissue, places);
  for (std::size_t b = 0; b < places.size(); ++b) {
    const Vec3& rest = places[b];
    const auto place = before_.nearest(rest, kReachMm);
    const int c = columns[b];
    // The rami of a mandible that the scan does not show come after the segments, and stay.
    const int own = place && at(place->bone) < segments.size() ? place->bone : -1;
    const Vec3 taken = own >= 0 ? segments[at(own)].motion.point(rest) : rest;
    const bool agree =
        c < 0 || tissue.fixed[at(c)] || patient.segment_of_column(c) == own || distance(taken, rest) < 1e-9;
    if (agree && (c < 0 || !loose[at(c)]) && !is_undermined(patient, before_, rest, taken, own)) {
      const bool stays = c >= 0 && tissue.fixed[at(c)];
      held_.push_back({.node = on_bone[b], .displacement_mm = stays ? Vec3{} : taken - rest});
    } else if (place) {
      const bool wet = c >= 0 && tissue.vestibule[at(c)];
      // What was taken off the bone may come nearer to it, and is kept out of it.
      const double height = wet ? place->height_mm : std::min(0.0, place->height_mm);
      sliding_.push_back({on_bone[b], height, face_.bone_area_mm2[at(on_bone[b])], wet, taken});
    }
  }
  std::sort(held_.begin(), held_.end(), [](const auto& a, const auto& b) { return a.node < b.node; });
}

std::vector<Vec3> FaceSupports::start() const {
  std::vector<Vec3> out(face_.mesh.points.begin(), face_.mesh.points.end());
  for (const NodeSupport& s : held_) out[at(s.node)] += s.displacement_mm;
  for (const Sliding& s : sliding_) out[at(s.node)] = s.start;
  return out;
}

std::vector<std::optional<SlidingSurface::Place>> FaceSupports::places(
    const std::vector<Vec3>& positions) const {
  std::vector<std::optional<SlidingSurface::Place>> out(sliding_.size());
  parallel_for(out.size(), 64, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i)
      out[i] = after_.nearest(positions[at(sliding_[i].node)], kReachMm);
  });
  return out;
}

std::vector<Contact> FaceSupports::contacts(const std::vector<Vec3>& positions) const {
  std::vector<Contact> out;
  const auto found = places(positions);
  for (std::size_t i = 0; i < found.size(); ++i) {
    const Sliding& s = sliding_[i];
    if (!found[i]) continue;
    const double share = s.area_mm2 / kColumnMm2;
    out.push_back({s.node, found[i]->normal,
                   dot(found[i]->normal, positions[at(s.node)]) + s.height_mm - found[i]->height_mm,
                   kColumnStiffness * share, s.wet ? adhesion_n_mm_ * share : 0});
  }
  return out;
}

void FaceSupports::pin(const std::vector<Vec3>& positions, double bearable_mm) {
  const std::vector<double> depth = depths(positions);
  std::vector<Sliding> left;
  for (std::size_t i = 0; i < depth.size(); ++i) {
    const Sliding& s = sliding_[i];
    if (depth[i] <= bearable_mm) {
      left.push_back(s);
      continue;
    }
    constexpr int steps = 4;
    Vec3 x = positions[at(s.node)];
    for (int step = 0; step < steps; ++step) {
      const auto place = after_.nearest(x, kReachMm);
      if (place && place->height_mm < s.height_mm) x += place->normal * (s.height_mm - place->height_mm);
    }
    held_.push_back({.node = s.node, .displacement_mm = x - face_.mesh.points[at(s.node)]});
  }
  sliding_ = std::move(left);
  std::sort(held_.begin(), held_.end(), [](const auto& a, const auto& b) { return a.node < b.node; });
}

std::vector<double> FaceSupports::depths(const std::vector<Vec3>& positions) const {
  std::vector<double> out;
  const auto found = places(positions);
  for (std::size_t i = 0; i < found.size(); ++i)
    out.push_back(found[i] ? std::max(0.0, sliding_[i].height_mm - found[i]->height_mm) : 0);
  return out;
}

}  // namespace turgor
