// Regions that point samples are kept out of, or drawn to: drape and cling (Pieper 1989, sections 3.2.1,
// 5.2.3, 5.2.4).
#pragma once

#include <memory>
#include <span>
#include <vector>

#include "turgor/core/error.hpp"
#include "turgor/core/index.hpp"
#include "turgor/geometry/surface_query.hpp"
#include "turgor/tissue/network_energy.hpp"

namespace turgor {

/// Heights over a grid, local z over local x and y counted in grid steps, and the map to the world
/// p = linear · local + origin. Between the four samples around a point the height is their weighted average.
struct HeightField {
  int nx = 0, ny = 0;          ///< samples, at least 2 each
  std::vector<double> height;  ///< nx · ny, x fastest
  Mat3 linear;                 ///< invertible
  Vec3 origin;                 ///< mm
};

/// A closed region with a force k f(s) that is the exact gradient of an energy; nothing outside:
///
///     sphere     s = R/r − 1 at the distance r < R from the centre, as a compressed spring of length R
///     plane      s = depth / scale_mm behind the plane
///     mesh       s = depth / scale_mm, the distance to the nearest point of a closed surface from inside
///     depth_map  s = depth / scale_mm under the map, along its local z axis; nothing beyond the grid's edge
///
/// The thesis prints the distance itself as the sphere's strain (3.2.1), which would push hardest at the
/// surface; it is read as penetration in the measure of springs. On a slope of a depth map the force is along
/// the map's normal, which is where the energy falls; the thesis pushes along local z. With `clings` the
/// force draws points outside to the surface too.
struct Barrier {
  enum class Shape : std::uint8_t { sphere, plane, depth_map, mesh } shape = Shape::sphere;
  Vec3 centre;                ///< of the sphere, mm
  double radius_mm = 1;       ///< of the sphere, > 0
  Plane plane{{0, 0, 1}, 0};  ///< normal to the free side
  double scale_mm = 1;        ///< depth that is strain 1, > 0; not for spheres
  double stiffness_n = 1;     ///< force at strain 1 under the linear law, ≥ 0
  SpringLaw law = SpringLaw::linear;
  bool clings = false;
  double threshold_mm = 0;       ///< where above 0: it lets go of what is deeper
  double reach_mm = 0;           ///< where above 0: it clings to nothing farther away
  std::vector<int> points = {};  ///< the points it acts on; empty: every mobile one
  std::shared_ptr<const HeightField> depth_map = nullptr;
  std::shared_ptr<const SurfaceQuery> mesh = nullptr;  ///< closed
};

/// Errors name what is missing, not a number, or out of range.
Result<void> validate(const Barrier& barrier);

/// Energy in N·mm, force in N, a bound of the stiffness and the stiffness along the force in N/mm, at
/// `point`, whichever points the barrier acts on. Finite everywhere; where there is no direction (a sphere's
/// centre, the surface itself) there is no force.
struct BarrierResponse {
  double energy = 0;
  Vec3 force;
  double stiffness = 0;
  double slope = 0;  ///< ≥ 0
};
BarrierResponse respond(const Barrier& barrier, const Vec3& point);

/// Which of several barriers act on each point.
class BarriersOfPoints {
 public:
  BarriersOfPoints() = default;
  /// Of points 0 to `points` − 1; the barriers name no others.
  BarriersOfPoints(std::span<const Barrier> barriers, std::size_t points);

  /// visit(b) with the number of each that acts on the point: those of all points, then the others,
  /// ascending.
  template <class Visit>
  void visit(int point, Visit&& visit) const {
    for (const int b : everywhere_) visit(b);
    if (listed_.entries.empty()) return;
    for (int k = listed_.offsets[at(point)]; k < listed_.offsets[at(point) + 1]; ++k)
      visit(listed_.entries[at(k)]);
  }

 private:
  std::vector<int> everywhere_;
  NetworkEnergy::Incidence listed_;
};

}  // namespace turgor
