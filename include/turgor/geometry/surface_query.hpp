// Rays, nearest points and inside tests against surfaces (Embree behind the curtain).
#pragma once

#include <limits>
#include <memory>
#include <optional>
#include <vector>

#include "turgor/geometry/tri_mesh.hpp"

namespace turgor {

struct RayHit {
  double distance = 0;  ///< along the unit direction, mm
  int surface = 0;      ///< which of the surfaces given
  int triangle = 0;
  double u = 0, v = 0;  ///< barycentric: point = (1-u-v) p0 + u p1 + v p2
};

struct NearestPoint {
  Vec3 point;
  double distance = 0;
  int surface = 0;
  int triangle = 0;
  double u = 0, v = 0;
};

/// An acceleration structure over one or more surfaces, which are copied in. Queries are const and
/// thread-safe.
class SurfaceQuery {
 public:
  explicit SurfaceQuery(const TriMesh& surface);
  explicit SurfaceQuery(const std::vector<const TriMesh*>& surfaces);
  ~SurfaceQuery();
  SurfaceQuery(SurfaceQuery&&) noexcept;
  SurfaceQuery& operator=(SurfaceQuery&&) noexcept;

  /// First hit of the ray from `origin` along the unit vector `direction` with distance in (near, far).
  [[nodiscard]] std::optional<RayHit> first_hit(const Vec3& origin, const Vec3& direction, double near = 0,
                                                double far = std::numeric_limits<double>::infinity()) const;
  /// All hits in rising distance. Through an edge or a corner one sheet counts once; two sheets of opposite
  /// facing that meet there are two hits. A ray within the plane of a triangle does not hit it.
  [[nodiscard]] std::vector<RayHit> all_hits(const Vec3& origin, const Vec3& direction, double near = 0,
                                             double far = std::numeric_limits<double>::infinity()) const;
  /// Nearest point of the surfaces within `max_distance`, if any. Refined in double precision.
  [[nodiscard]] std::optional<NearestPoint> nearest(
      const Vec3& point, double max_distance = std::numeric_limits<double>::infinity()) const;
  /// Whether `point` lies inside a closed surface (parity of crossings, voted over three directions);
  /// with several surfaces, inside any of them.
  [[nodiscard]] bool inside(const Vec3& point) const;

 private:
  struct Implementation;
  std::unique_ptr<Implementation> impl_;
};

}  // namespace turgor
