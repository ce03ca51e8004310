#include "turgor/dynamics/surface_contact.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>

#include "dynamics/contact_parts.hpp"
#include "geometry/triangle_math.hpp"
#include "tissue/incidence.hpp"
#include "turgor/core/parallel.hpp"

namespace turgor {
namespace {

// In the rest shape a point faces a triangle across a gap where it lies in front of it and their normals are
// opposed, both by this cosine at least. In a crease they are not.
constexpr double kAcross = 0.5;

constexpr double kOnEdge = 1e-12;  // barycentrics no larger are rounding

Error bad_contact(std::string what, std::string remedy) {
  return {ErrorKind::bad_input, std::move(what), "contact", std::move(remedy)};
}

constexpr double kMost = 1e12;  // of any number of a model, so that no product overflows

Result<void> check_number(const char* name, double value, bool may_be_zero) {
  if (value <= kMost && (value > 0 || (may_be_zero && value == 0))) return {};
  return bad_contact(
      fmt::format("the {} is {}", name, value),
      fmt::format("It must be {} 0 and no more than {:g}", may_be_zero ? "at least" : "above", kMost));
}

Result<void> check_surfaces(const ContactModel& model, std::size_t point_count) {
  std::vector<int> owner(point_count, -1);
  for (std::size_t s = 0; s < model.surfaces.size(); ++s) {
    const auto& triangles = model.surfaces[s].triangles;
    for (std::size_t f = 0; f < triangles.size(); ++f) {
      const Index3& t = triangles[f];
      for (const int p : t) {
        if (p < 0 || at(p) >= point_count) {
          return bad_contact(
              fmt::format("triangle {} of surface {} has point {} of {}", f, s, p, point_count),
              "Point numbers start at 0");
        }
        if (owner[at(p)] >= 0 && at(owner[at(p)]) != s) {
          return bad_contact(fmt::format("point {} is on the surfaces {} and {}", p, owner[at(p)], s),
                             "Give both as one surface that meets itself");
        }
        owner[at(p)] = static_cast<int>(s);
      }
      if (t[0] == t[1] || t[1] == t[2] || t[2] == t[0])
        return bad_contact(fmt::format("triangle {} of surface {} has a point twice", f, s), "Leave it out");
    }
  }
  return {};
}

Box3 swept_box(std::span<const Vec3> from, std::span<const Vec3> to, std::span<const int> points,
               double inflate) {
  Box3 box;
  for (const int p : points) box.extend(from[at(p)]), box.extend(to[at(p)]);
  const Vec3 more{inflate, inflate, inflate};
  return {box.lower - more, box.upper + more};
}

double angle_between(const Vec3& a, const Vec3& b) {
  return std::atan2(length(cross(a, b)), dot(a, b));
}

}  // namespace

Result<void> validate(const ContactModel& model, std::size_t point_count) {
  TURGOR_CHECK(check_surfaces(model, point_count));
  TURGOR_CHECK(check_number("thickness", model.thickness_mm, false));
  TURGOR_CHECK(check_number("stiffness", model.stiffness_n_mm, true));
  TURGOR_CHECK(check_number("friction", model.friction, true));
  TURGOR_CHECK(check_number("velocity that sticks", model.stick_mm_ms, false));
  return check_number("damping", model.damping, true);
}

Result<SurfaceContact> SurfaceContact::prepare(ContactModel model, std::span<const Vec3> rest,
                                               std::span<const double> inverse_mass) {
  TURGOR_CHECK(validate(model, rest.size()));
  if (inverse_mass.size() != rest.size()) {
    return bad_contact(fmt::format("{} masses are given for {} points", inverse_mass.size(), rest.size()),
                       "Give one for each");
  }
  for (std::size_t p = 0; p < rest.size(); ++p) {
    if (!(std::isfinite(inverse_mass[p]) && inverse_mass[p] >= 0 && is_finite(rest[p]))) {
      return bad_contact(fmt::format("point {} rests at ({}, {}, {}) with the inverse mass {}/g", p,
                                     rest[p].x, rest[p].y, rest[p].z, inverse_mass[p]),
                         "Give finite numbers, masses not below 1e-300 g");
    }
  }
  auto parts = std::make_shared<Parts>();
  parts->rest.assign(rest.begin(), rest.end());
  parts->inverse_mass.assign(inverse_mass.begin(), inverse_mass.end());
  parts->slot.assign(rest.size(), -1);
  for (std::size_t s = 0; s < model.surfaces.size(); ++s) {
    const auto& triangles = model.surfaces[s].triangles;
    const int first = static_cast<int>(parts->faces.size());
    std::vector<Vec3> centres;
    for (const Index3& t : triangles) {
      centres.push_back((rest[at(t[0])] + rest[at(t[1])] + rest[at(t[2])]) / 3.0);
      for (const int p : t) {
        if (parts->slot[at(p)] >= 0) continue;
        parts->slot[at(p)] = static_cast<int>(parts->points.size());
        parts->points.push_back(p);
        parts->surface.push_back(static_cast<int>(s));
      }
    }
    parts->faces.insert(parts->faces.end(), triangles.begin(), triangles.end());
    parts->face_surface.resize(parts->faces.size(), static_cast<int>(s));
    parts->bodies.push_back({first, static_cast<int>(parts->faces.size()), BoxTree(centres)});
  }
  parts->faces_around =
      make_incidence(static_cast<int>(parts->points.size()), static_cast<int>(3 * parts->faces.size()),
                     [&](int e) { return parts->slot[at(parts->faces[at(e / 3)][at(e % 3)])]; });
  parts->normal.resize(parts->points.size());
  for (const Index3& f : parts->faces) {
    const Vec3 normal = area_vector(rest[at(f[0])], rest[at(f[1])], rest[at(f[2])]);
    parts->face_normal.push_back(normalized(normal));
    for (const int p : f) parts->normal[at(parts->slot[at(p)])] += normal;
  }
  for (Vec3& normal : parts->normal) normal = normalized(normal);
  parts->model = std::move(model);
  return SurfaceContact(std::move(parts));
}

const ContactModel& SurfaceContact::model() const {
  return parts_->model;
}

// Lists hold all pairs nearer than thickness + margin, and all that come as near on the way, so that they
// serve until a point has moved by half the margin.
void SurfaceContact::seek(std::span<const Vec3> from, std::span<const Vec3> to, Workspace& w) const {
  const Parts& parts = *parts_;
  const double allowed = 0.25 * parts.margin() * parts.margin();
  const auto moved = [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      const std::size_t p = at(parts.points[i]);
      if (!(squared_length(from[p] - w.origin_[i]) <= allowed &&
            squared_length(to[p] - w.origin_[i]) <= allowed))
        return 1;
    }
    return 0;
  };
  if (w.owner_ == parts_ && parallel_reduce(parts.points.size(), 4096, 0, moved, std::plus<>()) == 0) return;
  w.owner_ = parts_;
  w.origin_.resize(parts.points.size());
  for (std::size_t i = 0; i < parts.points.size(); ++i) w.origin_[i] = to[at(parts.points[i])];
  w.boxes_.resize(parts.bodies.size());
  for (std::size_t b = 0; b < parts.bodies.size(); ++b) {
    const auto& body = parts.bodies[b];
    body.tree.fit(w.boxes_[b],
                  [&](int item) { return swept_box(from, to, parts.faces[at(body.first_face + item)], 0); });
  }
  w.chunks_.resize(parts.chunks());
  parallel_for(parts.chunks(), 1, [&](std::size_t begin, std::size_t end) {
    for (std::size_t c = begin; c < end; ++c) list_candidates(c, from, to, w);
  });
}

namespace {

/// How a point meets a face of its own body: parts that lie together at rest do not, but across a gap.
template <class Parts, class Candidate>
bool may_meet(const Parts& parts, std::size_t slot, Candidate& candidate) {
  const Index3& f = parts.faces[at(candidate.face)];
  const Vec3 &p = parts.rest[at(parts.points[slot])], &normal = parts.face_normal[at(candidate.face)];
  const Vec3 &a = parts.rest[at(f[0])], &b = parts.rest[at(f[1])], &c = parts.rest[at(f[2])];
  const double near = 2 * parts.model.thickness_mm;
  const bool opposed = dot(parts.normal[slot], normal) < -kAcross;
  const double corner = std::min({squared_length(p - a), squared_length(p - b), squared_length(p - c)});
  if (!opposed && corner < near * near) return false;
  const auto nearest = detail::closest_on_triangle(p, a, b, c);
  const double d = std::sqrt(nearest.squared_distance), ahead = dot(normal, p - nearest.point);
  candidate.from_front_alone = ahead < -kAcross * d;
  if (!(d < near)) return true;
  candidate.threshold = std::min(candidate.threshold, d);
  return opposed && ahead > kAcross * d;
}

}  // namespace

void SurfaceContact::list_candidates(std::size_t c, std::span<const Vec3> from, std::span<const Vec3> to,
                                     Workspace& w) const {
  const Parts& parts = *parts_;
  auto& chunk = w.chunks_[c];
  chunk.begin.clear();
  chunk.candidates.clear();
  const auto list = [&](std::size_t slot, int face) {
    const Index3& f = parts.faces[at(face)];
    const int p = parts.points[slot];
    if (p == f[0] || p == f[1] || p == f[2]) return;
    Workspace::Candidate candidate{face, false, parts.model.thickness_mm};
    if (parts.face_surface[at(face)] == parts.surface[slot] && !may_meet(parts, slot, candidate)) return;
    double moved = 0, mobile = parts.inverse_mass[at(p)];
    for (const int corner : f) {
      moved = std::max(moved, squared_length(to[at(p)] - from[at(p)] - (to[at(corner)] - from[at(corner)])));
      mobile += parts.inverse_mass[at(corner)];
    }
    if (mobile == 0) return;
    const double reach = candidate.threshold + parts.margin() + std::sqrt(moved);
    const auto now = detail::closest_on_triangle(to[at(p)], to[at(f[0])], to[at(f[1])], to[at(f[2])]);
    if (now.squared_distance < reach * reach) chunk.candidates.push_back(candidate);
  };
  const std::size_t end = std::min(parts.points.size(), (c + 1) * Parts::kChunk);
  for (std::size_t slot = c * Parts::kChunk; slot < end; ++slot) {
    chunk.begin.push_back(static_cast<int>(chunk.candidates.size()));
    const Box3 box = swept_box(from, to, {&parts.points[slot], 1}, parts.model.thickness_mm + parts.margin());
    for (std::size_t b = 0; b < parts.bodies.size(); ++b) {
      if (at(parts.surface[slot]) == b && !parts.model.surfaces[b].self) continue;
      const int first = parts.bodies[b].first_face;
      parts.bodies[b].tree.visit(w.boxes_[b], box, [&](int item) { list(slot, first + item); });
    }
  }
  chunk.begin.push_back(static_cast<int>(chunk.candidates.size()));
}

namespace {

/// Outside, seen from a point of a face with the barycentrics `bary`: the normal of the face, of an edge or a
/// corner with its neighbours, weighted by their angles, which tells inside from outside wherever that point
/// is the nearest (Bærentzen and Aanæs 2005). Unit, or zero of degenerate faces alone.
template <class Parts>
Vec3 outward(const Parts& parts, int face, const std::array<double, 3>& bary, std::span<const Vec3> x) {
  const Index3& f = parts.faces[at(face)];
  const int zeros =
      static_cast<int>(bary[0] <= 0) + static_cast<int>(bary[1] <= 0) + static_cast<int>(bary[2] <= 0);
  const auto unit_normal = [&](const Index3& g) {
    return normalized(area_vector(x[at(g[0])], x[at(g[1])], x[at(g[2])]));
  };
  if (zeros == 0) return unit_normal(f);
  const std::size_t on = at(static_cast<int>(std::max_element(bary.begin(), bary.end()) - bary.begin()));
  const std::size_t off = at(static_cast<int>(std::min_element(bary.begin(), bary.end()) - bary.begin()));
  const int corner = f[on], other = f[3 - on - off];  // of an edge its second point
  Vec3 sum;
  const auto& around = parts.faces_around;
  const int slot = parts.slot[at(corner)];
  for (int k = around.offsets[at(slot)]; k < around.offsets[at(slot) + 1]; ++k) {
    const int entry = around.entries[at(k)], c = entry % 3;
    const Index3& g = parts.faces[at(entry / 3)];
    const int left = g[at((c + 1) % 3)], right = g[at((c + 2) % 3)];
    if (zeros == 1) {
      if (left == other || right == other) sum += unit_normal(g);
    } else {
      const Vec3& here = x[at(corner)];
      sum += unit_normal(g) * angle_between(x[at(left)] - here, x[at(right)] - here);
    }
  }
  return normalized(sum);
}

/// The face that a point is deepest in, sides aside.
struct Deepest {
  int face = -1;
  double depth = 0, threshold = 0;
  bool from_front_alone = false;
  detail::ClosestOnTriangle nearest{};
};

/// Nothing where the point is behind a face that acts from its front alone, or nothing has a direction.
template <class Parts>
bool make_touch(const Parts& parts, int point, int surface, const Deepest& best, std::span<const Vec3> x,
                ContactTouch& touch) {
  const Index3& f = parts.faces[at(best.face)];
  std::array<double, 3> bary{1 - best.nearest.u - best.nearest.v, best.nearest.u, best.nearest.v};
  for (double& part : bary) part = part > kOnEdge ? part : 0;
  const Vec3 away = x[at(point)] - best.nearest.point, out = outward(parts, best.face, bary, x);
  const double d = std::sqrt(best.nearest.squared_distance);
  const double side = dot(away, out) < 0 ? -1 : 1;
  if (side < 0 && best.from_front_alone) return false;
  const bool within = bary[0] > 0 && bary[1] > 0 && bary[2] > 0 && out != Vec3{};
  const bool has_direction = d > 1e-9 * parts.model.thickness_mm;
  touch.normal = within || !has_direction ? out : away * (side / d);
  touch.points = {point, f[0], f[1], f[2]};
  touch.weights = {1, -bary[0], -bary[1], -bary[2]};
  touch.gap_mm = side * d;
  touch.depth_mm = best.threshold - touch.gap_mm;
  touch.surface = surface;
  touch.face_surface = parts.face_surface[at(best.face)];
  return touch.normal != Vec3{};
}

}  // namespace

void SurfaceContact::touch(std::size_t c, std::span<const Vec3> x, Workspace& w) const {
  const Parts& parts = *parts_;
  auto& chunk = w.chunks_[c];
  chunk.touches.clear();
  if (chunk.candidates.empty()) return;
  for (std::size_t i = 0; i + 1 < chunk.begin.size(); ++i) {
    const std::size_t slot = c * Parts::kChunk + i;
    const int p = parts.points[slot];
    Deepest best;
    const auto finish = [&] {
      ContactTouch found;
      if (best.face >= 0 && make_touch(parts, p, parts.surface[slot], best, x, found))
        chunk.touches.push_back(found);
      best = {};
    };
    int surface = -1;
    for (int k = chunk.begin[i]; k < chunk.begin[i + 1]; ++k) {
      const auto& candidate = chunk.candidates[at(k)];
      if (const int s = parts.face_surface[at(candidate.face)]; s != surface) finish(), surface = s;
      const Index3& f = parts.faces[at(candidate.face)];
      const Vec3 &a = x[at(f[0])], &b = x[at(f[1])], &c3 = x[at(f[2])];
      const auto nearest = detail::closest_on_triangle(x[at(p)], a, b, c3);
      const double least = candidate.threshold - best.depth;
      if (!(least > 0 && nearest.squared_distance < least * least)) continue;
      if (candidate.from_front_alone && dot(area_vector(a, b, c3), x[at(p)] - a) < 0) continue;
      best = {candidate.face, candidate.threshold - std::sqrt(nearest.squared_distance), candidate.threshold,
              candidate.from_front_alone, nearest};
    }
    finish();
  }
}

std::span<const ContactTouch> SurfaceContact::find(std::span<const Vec3> positions, Workspace& w) const {
  seek(positions, positions, w);
  parallel_for(w.chunks_.size(), 1, [&](std::size_t begin, std::size_t end) {
    for (std::size_t c = begin; c < end; ++c) touch(c, positions, w);
  });
  w.touches_.clear();
  for (const auto& chunk : w.chunks_)
    w.touches_.insert(w.touches_.end(), chunk.touches.begin(), chunk.touches.end());
  return w.touches_;
}

double SurfaceContact::energy(std::span<const Vec3> positions) const {
  Workspace w;
  double sum = 0;
  for (const ContactTouch& t : find(positions, w))
    sum += 0.5 * parts_->model.stiffness_n_mm * t.depth_mm * t.depth_mm;
  return sum;
}

ContactMeasures SurfaceContact::measure(std::span<const Vec3> positions) const {
  Workspace w;
  ContactMeasures m;
  for (const ContactTouch& t : find(positions, w)) {
    const int a = std::min(t.surface, t.face_surface), b = std::max(t.surface, t.face_surface);
    auto pair = std::lower_bound(m.pairs.begin(), m.pairs.end(), std::array{a, b},
                                 [](const ContactMeasures::Pair& q, const std::array<int, 2>& wanted) {
                                   return std::array{q.a, q.b} < wanted;
                                 });
    if (pair == m.pairs.end() || pair->a != a || pair->b != b) pair = m.pairs.insert(pair, {a, b, 0, 0, {}});
    const double force = parts_->model.stiffness_n_mm * t.depth_mm;
    ++m.contacts, ++pair->contacts;
    pair->normal_n += force;
    if (a != b) pair->force_on_a_n += t.normal * (t.surface == a ? force : -force);
    m.deepest_mm = std::max(m.deepest_mm, -t.gap_mm);
  }
  return m;
}

}  // namespace turgor
