#include "turgor/dynamics/barrier.hpp"

#include <fmt/format.h>

#include <cmath>

namespace turgor {
namespace {

Error broken(const char* what, double value) {
  return {ErrorKind::bad_input, fmt::format("{} of a barrier is {}", what, value), "barrier",
          "Give a finite number above 0"};
}

// A sphere resists as a spring from its centre, as long as its radius.
BarrierResponse sphere(const Barrier& b, const Vec3& point) {
  const Vec3 out = point - b.centre;
  const double r = length(out);
  if (r >= b.radius_mm && !b.clings) return {};
  if (!(r > 0)) return {};
  Spring spring;
  spring.rest_length_mm = b.radius_mm;
  spring.stiffness_n = b.stiffness_n;
  spring.law = b.law;
  const SpringResponse s = respond(spring, r);
  return {s.energy, out * (-s.tension / r), std::max(s.slope, 0.0)};
}

// Depth as the lengthening of a spring of length scale_mm, whose strain is then depth / scale_mm.
BarrierResponse plane(const Barrier& b, const Vec3& point) {
  const double distance = b.plane.signed_distance(point);
  if (distance >= 0 && !b.clings) return {};
  Spring spring;
  spring.rest_length_mm = b.scale_mm;
  spring.stiffness_n = b.stiffness_n;
  spring.law = b.law;
  const SpringResponse s = respond(spring, b.scale_mm + std::abs(distance));
  const double towards = distance < 0 ? 1.0 : -1.0;
  return {s.energy, b.plane.normal * (towards * s.tension), std::max(s.slope, 0.0)};
}

}  // namespace

Result<void> validate(const Barrier& b) {
  const auto positive = [](double x) { return std::isfinite(x) && x > 0; };
  if (b.shape == Barrier::Shape::sphere) {
    if (!positive(b.radius_mm)) return broken("the radius", b.radius_mm);
    if (!is_within_reach(b.centre)) return broken("a coordinate of the centre", b.centre.x);
  } else {
    if (!positive(b.scale_mm)) return broken("the scale", b.scale_mm);
    if (!(std::abs(length(b.plane.normal) - 1) < 1e-6))
      return broken("the length of the normal", length(b.plane.normal));
    if (!std::isfinite(b.plane.offset)) return broken("the offset", b.plane.offset);
  }
  if (!(std::isfinite(b.stiffness_n) && b.stiffness_n >= 0)) return broken("the stiffness", b.stiffness_n);
  return {};
}

BarrierResponse respond(const Barrier& barrier, const Vec3& point) {
  return barrier.shape == Barrier::Shape::sphere ? sphere(barrier, point) : plane(barrier, point);
}

}  // namespace turgor
