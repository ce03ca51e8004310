// Regions that point samples are kept out of, or drawn to: drape and cling (Pieper 1989,
// sections 3.2.1, 5.2.3, 5.2.4).
#pragma once

#include "turgor/core/error.hpp"
#include "turgor/tissue/network.hpp"

namespace turgor {

/// A sphere, or the half-space behind a plane, with a force along the outward normal:
///
///     sphere of radius R:  s = R/r − 1 at the distance r < R from the centre   (as a compressed spring of
///     length R) plane:               s = depth / scale_mm force k f(s), energy its integral; nothing outside
///
/// The thesis prints the distance itself as the sphere's strain (3.2.1), which would push hardest at the
/// surface; it is read as penetration in the measure of springs. With `clings` the force draws points outside
/// to the surface too.
struct Barrier {
  enum class Shape : std::uint8_t { sphere, plane } shape = Shape::sphere;
  Vec3 centre;                ///< of the sphere, mm
  double radius_mm = 1;       ///< of the sphere, > 0
  Plane plane{{0, 0, 1}, 0};  ///< normal to the free side
  double scale_mm = 1;        ///< depth behind the plane that is strain 1, > 0
  double stiffness_n = 1;     ///< force at strain 1 under the linear law, ≥ 0
  SpringLaw law = SpringLaw::linear;
  bool clings = false;
};

/// Errors name what is not a number or out of range.
Result<void> validate(const Barrier& barrier);

/// Energy in N·mm, force in N, and the stiffness along the force in N/mm, at `point`. Finite everywhere; at
/// the centre of a sphere there is no direction and no force.
struct BarrierResponse {
  double energy = 0;
  Vec3 force;
  double stiffness = 0;
};
BarrierResponse respond(const Barrier& barrier, const Vec3& point);

}  // namespace turgor
