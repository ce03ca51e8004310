#include "turgor/dynamics/barrier.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "tissue/incidence.hpp"

namespace turgor {
namespace {

Error broken(const char* what, double value) {
  return {ErrorKind::bad_input, fmt::format("{} of a barrier is {}", what, value), "barrier",
          "Give a finite number above 0"};
}

Error missing(std::string what, std::string remedy) {
  return {ErrorKind::bad_input, std::move(what), "barrier", std::move(remedy)};
}

SpringResponse respond_at(const Barrier& b, double rest_mm, double length_mm) {
  Spring spring;
  spring.rest_length_mm = rest_mm;
  spring.stiffness_n = b.stiffness_n;
  spring.law = b.law;
  return respond(spring, length_mm);
}

/// Whether the barrier acts at a signed distance from its surface, negative inside.
bool acts_at(const Barrier& b, double distance) {
  if (distance < 0) return !(b.threshold_mm > 0 && -distance > b.threshold_mm);
  return b.clings && distance > 0 && !(b.reach_mm > 0 && distance > b.reach_mm);
}

// A sphere resists as a spring from its centre, as long as its radius.
BarrierResponse sphere(const Barrier& b, const Vec3& point) {
  const Vec3 out = point - b.centre;
  const double r = length(out);
  if (!(r > 0) || !acts_at(b, r - b.radius_mm)) return {};
  const SpringResponse s = respond_at(b, b.radius_mm, r);
  const double slope = std::max(s.slope, 0.0);
  return {s.energy, out * (-s.tension / r), slope + std::abs(s.tension) / r, slope};
}

// A signed distance with its gradient; depth counts as the lengthening of a spring of length scale_mm, whose
// strain is then depth / scale_mm. `curvature` bounds the second derivatives of the distance, 1/mm.
BarrierResponse by_distance(const Barrier& b, double distance, const Vec3& gradient, double curvature) {
  if (!acts_at(b, distance)) return {};
  const SpringResponse s = respond_at(b, b.scale_mm, b.scale_mm + std::abs(distance));
  const double towards = distance < 0 ? 1.0 : -1.0;
  const double slope = std::max(s.slope, 0.0) * squared_length(gradient);
  return {s.energy, gradient * (towards * s.tension), slope + std::abs(s.tension) * curvature, slope};
}

// The second derivative of a distance to an edge or a corner is one over the distance; that of the flat of a
// triangle is zero.
BarrierResponse mesh(const Barrier& b, const Vec3& point) {
  const bool inside = b.mesh->inside(point);
  if (!inside && !b.clings) return {};
  const double bound = inside ? b.threshold_mm : b.reach_mm;
  const auto nearest = b.mesh->nearest(point, bound > 0 ? bound : std::numeric_limits<double>::infinity());
  if (!nearest) return {};
  const Vec3 away = point - nearest->point;
  const double distance = length(away);
  if (!(distance > 0)) return {};
  const double side = inside ? -1.0 : 1.0;
  return by_distance(b, side * distance, away * (side / distance), 1.0 / distance);
}

// Height above the map along local z, in mm, is |A e_z| (u.z − h(u.x, u.y)) with u = A⁻¹ (p − origin).
BarrierResponse depth_map(const Barrier& b, const Vec3& point) {
  const HeightField& m = *b.depth_map;
  const Mat3 inverse = m.linear.inverse();
  const Vec3 u = inverse * (point - m.origin);
  if (!(u.x >= 0 && u.y >= 0 && u.x <= m.nx - 1 && u.y <= m.ny - 1)) return {};
  const int i = std::min(static_cast<int>(u.x), m.nx - 2), j = std::min(static_cast<int>(u.y), m.ny - 2);
  const double fx = u.x - i, fy = u.y - j;
  const double* low = m.height.data() + static_cast<std::size_t>(j) * static_cast<std::size_t>(m.nx) + i;
  const double* high = low + m.nx;
  const double twist = high[1] - high[0] - low[1] + low[0];
  const double slope_x = low[1] - low[0] + fy * twist, slope_y = high[0] - low[0] + fx * twist;
  const double height = low[0] + fx * (low[1] - low[0]) + fy * slope_y;
  const double unit = length(m.linear.c[2]);
  const Mat3 transposed = inverse.transposed();
  const Vec3 gradient = (transposed * Vec3{-slope_x, -slope_y, 1}) * unit;
  const double curvature = std::abs(twist) * length(transposed.c[0]) * length(transposed.c[1]) * unit;
  return by_distance(b, (u.z - height) * unit, gradient, curvature);
}

Result<void> check_depth_map(const HeightField* m) {
  if (m == nullptr) return missing("a depth map barrier has no depth map", "Give one");
  if (m->nx < 2 || m->ny < 2 ||
      m->height.size() != static_cast<std::size_t>(m->nx) * static_cast<std::size_t>(m->ny)) {
    return missing(fmt::format("a depth map of {} × {} has {} heights", m->nx, m->ny, m->height.size()),
                   "Give nx · ny of them, two at least each way");
  }
  const auto wild = std::find_if_not(m->height.begin(), m->height.end(),
                                     [](double h) { return std::abs(h) <= kFarthestMm; });
  if (wild != m->height.end()) return broken("a height of the depth map", *wild);
  if (!is_within_reach(m->origin)) return broken("a coordinate of the depth map's origin", m->origin.x);
  const Mat3 inverse = m->linear.inverse();
  for (const Mat3& matrix : {m->linear, inverse}) {
    for (const Vec3& column : matrix.c) {
      if (!is_within_reach(column))
        return missing("the axes of a depth map are not finite or lie in a plane", "Make them independent");
    }
  }
  return {};
}

}  // namespace

Result<void> validate(const Barrier& b) {
  const auto positive = [](double x) { return std::isfinite(x) && x > 0; };
  if (b.shape == Barrier::Shape::sphere) {
    if (!positive(b.radius_mm)) return broken("the radius", b.radius_mm);
    if (!is_within_reach(b.centre)) return broken("a coordinate of the centre", b.centre.x);
  } else if (!positive(b.scale_mm)) {
    return broken("the scale", b.scale_mm);
  }
  if (b.shape == Barrier::Shape::plane) {
    if (!(std::abs(length(b.plane.normal) - 1) < 1e-6))
      return broken("the length of the normal", length(b.plane.normal));
    if (!std::isfinite(b.plane.offset)) return broken("the offset", b.plane.offset);
  }
  if (b.shape == Barrier::Shape::depth_map) TURGOR_CHECK(check_depth_map(b.depth_map.get()));
  if (b.shape == Barrier::Shape::mesh && b.mesh == nullptr)
    return missing("a mesh barrier has no mesh", "Give a closed one");
  if (!(std::isfinite(b.stiffness_n) && b.stiffness_n >= 0)) return broken("the stiffness", b.stiffness_n);
  if (!(std::isfinite(b.threshold_mm) && b.threshold_mm >= 0)) return broken("the threshold", b.threshold_mm);
  if (!(std::isfinite(b.reach_mm) && b.reach_mm >= 0)) return broken("the reach", b.reach_mm);
  if (b.law > SpringLaw::square)
    return missing(fmt::format("a barrier has the law {}", static_cast<int>(b.law)),
                   "Choose linear, exponential, logarithmic or square");
  return {};
}

BarrierResponse respond(const Barrier& barrier, const Vec3& point) {
  switch (barrier.shape) {
    case Barrier::Shape::plane:
      return by_distance(barrier, barrier.plane.signed_distance(point), barrier.plane.normal, 0);
    case Barrier::Shape::depth_map:
      return depth_map(barrier, point);
    case Barrier::Shape::mesh:
      return mesh(barrier, point);
    case Barrier::Shape::sphere:
      break;
  }
  return sphere(barrier, point);
}

BarriersOfPoints::BarriersOfPoints(std::span<const Barrier> barriers, std::size_t points) {
  std::vector<std::array<int, 2>> pairs;  // point, barrier
  for (std::size_t b = 0; b < barriers.size(); ++b) {
    if (barriers[b].points.empty()) everywhere_.push_back(static_cast<int>(b));
    for (const int p : barriers[b].points) pairs.push_back({p, static_cast<int>(b)});
  }
  if (pairs.empty()) return;
  listed_ = make_incidence(static_cast<int>(points), static_cast<int>(pairs.size()),
                           [&](int e) { return pairs[at(e)][0]; });
  for (int& entry : listed_.entries) entry = pairs[at(entry)][1];
}

}  // namespace turgor
