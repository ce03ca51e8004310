// What contact does to velocities: friction, damping, and stopping what would cross a face.
#include <algorithm>
#include <cmath>

#include "dynamics/contact_parts.hpp"
#include "dynamics/crossing.hpp"
#include "turgor/core/parallel.hpp"

namespace turgor {
namespace {

constexpr int kMostRounds = 60, kMostHolds = 100;

// Parts of the thickness: what counts as in front of a face, and the gap that is left to what stops at it.
constexpr double kSlack = 1e-3, kLeast = 1e-3;

using Weights = std::array<double, 4>;
using Points = std::array<int, 4>;

void add(std::span<Vec3> x, const Points& points, const Weights& weights, std::span<const double> factor,
         const Vec3& change) {
  for (std::size_t i = 0; i < 4; ++i) x[at(points[i])] += change * (weights[i] * factor[at(points[i])]);
}

std::array<Vec3, 4> pick(std::span<const Vec3> x, const Points& p) {
  return {x[at(p[0])], x[at(p[1])], x[at(p[2])], x[at(p[3])]};
}

/// Height of the point over the plane of the face, mm; 0 where the face is flat.
double height(std::span<const Vec3> x, const Points& p) {
  const Vec3 n = area_vector(x[at(p[1])], x[at(p[2])], x[at(p[3])]);
  const double twice_area = length(n);
  return twice_area > 0 ? dot(x[at(p[0])] - x[at(p[1])], n) / twice_area : 0;
}

}  // namespace

void SurfaceContact::slow(const Workspace& w, double dt, double follow, std::span<Vec3> x,
                          std::span<Vec3> v) const {
  const ContactModel& m = parts_->model;
  if (m.friction == 0 && m.damping == 0) return;
  for (const ContactTouch& t : w.touches_) {
    const double softness = parts_->softness(t.points, t.weights);
    if (!(softness > 0)) continue;
    const Vec3 sliding = relative(t.points, t.weights, v);
    const double along = dot(sliding, t.normal), penalty = m.stiffness_n_mm * t.depth_mm * dt;
    // What moves as far was found somewhere else than it is now; it is stop()'s.
    if (std::abs(along) * dt > 0.5 * m.thickness_mm) continue;
    // A dashpot of 2 ζ √(k m); parting, the two forces together do not pull.
    const double rate = 2 * m.damping * std::sqrt(m.stiffness_n_mm * softness) * dt;
    const double damped = std::max(-along * rate / (1 + rate) / softness, -penalty);
    const Vec3 across = sliding - t.normal * along;
    const double speed = length(across), most = m.friction * (penalty + damped) * softness;
    const double kept = speed > m.stick_mm_ms + most ? 1 - most / speed : 1 / (1 + most / m.stick_mm_ms);
    const Vec3 impulse = t.normal * damped - across * ((1 - kept) / softness);
    add(v, t.points, t.weights, parts_->inverse_mass, impulse);
    add(x, t.points, t.weights, parts_->inverse_mass, impulse * follow);
  }
}

// A pair can only meet where it starts nearer to the plane than it moves against it.
bool SurfaceContact::find_impacts(std::span<const Vec3> from, std::span<const Vec3> to, Workspace& w) const {
  const Parts& parts = *parts_;
  const double slack = kSlack * parts.model.thickness_mm;
  const auto search = [&](std::size_t c) {
    auto& chunk = w.chunks_[c];
    chunk.impacts.clear();
    if (chunk.candidates.empty()) return;
    for (std::size_t i = 0; i + 1 < chunk.begin.size(); ++i) {
      const int p = parts.points[c * Parts::kChunk + i];
      for (int k = chunk.begin[i]; k < chunk.begin[i + 1]; ++k) {
        const Index3& f = parts.faces[at(chunk.candidates[at(k)].face)];
        const Points all{p, f[0], f[1], f[2]};
        const double start = height(from, all);
        double moved = 0;  // squared
        for (const int corner : f) {
          moved =
              std::max(moved, squared_length(to[at(p)] - from[at(p)] - (to[at(corner)] - from[at(corner)])));
        }
        if (std::abs(start) > slack && start * start > moved) continue;
        if (const auto crossing = first_crossing(pick(from, all), pick(to, all), slack))
          chunk.impacts.push_back({crossing->time, all, crossing->weights, crossing->normal});
      }
    }
  };
  parallel_for(w.chunks_.size(), 1, [&](std::size_t begin, std::size_t) { search(begin); });
  w.impacts_.clear();
  for (const auto& chunk : w.chunks_)
    w.impacts_.insert(w.impacts_.end(), chunk.impacts.begin(), chunk.impacts.end());
  std::stable_sort(w.impacts_.begin(), w.impacts_.end(),
                   [](const auto& a, const auto& b) { return a.time < b.time; });
  return !w.impacts_.empty();
}

namespace {

/// An inelastic impulse, with friction: of the way towards the face only what leaves them `thickness` apart
/// is gone, or as far as they were; of the velocity towards it nothing is left. None where an impulse before
/// has settled it.
template <class Parts, class Impact>
void stop_at(const Parts& parts, const Impact& c, std::span<const Vec3> from, std::span<Vec3> x,
             std::span<Vec3> v) {
  const Points& p = c.points;
  const double softness = parts.softness(p, c.weights), thickness = parts.model.thickness_mm;
  if (!(softness > 0)) return;
  const double before = dot(c.normal, relative(p, c.weights, from));
  const double after = dot(c.normal, relative(p, c.weights, x));
  if (after > 0) return;
  const double wanted = std::clamp(before, kLeast * thickness, thickness);
  add(x, p, c.weights, parts.inverse_mass, c.normal * ((wanted - after) / softness));
  const Vec3 velocity = relative(p, c.weights, v);
  const double towards = -dot(c.normal, velocity);
  if (!(towards > 0)) return;
  const Vec3 across = velocity + c.normal * towards;
  const double speed = length(across);
  const double lost = speed > 0 ? std::min(1.0, parts.model.friction * towards / speed) : 0;
  add(v, p, c.weights, parts.inverse_mass, (c.normal * towards - across * lost) / softness);
}

/// All four go on with their common velocity, from where they were.
template <class Parts>
int hold(const Parts& parts, const Points& p, std::span<const Vec3> from, std::span<Vec3> x,
         std::span<Vec3> v) {
  Vec3 momentum;
  double mass = 0;
  int held = 0;
  bool fixed = false;
  for (const int i : p) {
    const double inverse = parts.inverse_mass[at(i)];
    if (!(inverse > 0)) {
      fixed = true;
      continue;
    }
    momentum += v[at(i)] / inverse;
    mass += 1 / inverse;
  }
  for (const int i : p) {
    if (!(parts.inverse_mass[at(i)] > 0)) continue;
    v[at(i)] = fixed ? Vec3{} : momentum / mass;
    held += x[at(i)] != from[at(i)] ? 1 : 0;
    x[at(i)] = from[at(i)];
  }
  return held;
}

}  // namespace

int SurfaceContact::stop(std::span<const Vec3> from, std::span<Vec3> to, std::span<Vec3> v,
                         Workspace& w) const {
  const Parts& parts = *parts_;
  int held = 0;
  for (int round = 0; round < kMostRounds + kMostHolds; ++round) {
    seek(from, to, w);
    if (!find_impacts(from, to, w)) return held;
    for (const auto& impact : w.impacts_) {
      if (round < kMostRounds)
        stop_at(parts, impact, from, to, v);
      else
        held += hold(parts, impact.points, from, to, v);
    }
  }
  return held;
}

}  // namespace turgor
