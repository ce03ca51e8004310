// Rays and points against one triangle, in double precision. Internal to the module.
#pragma once

#include <algorithm>
#include <utility>

#include "turgor/math/vec.hpp"

namespace turgor::detail {

/// Barycentrics (u, v) of the point where the line origin + t direction crosses the plane of abc, brought
/// back into the triangle where they lie outside (Möller and Trumbore 1997). The middle where the line lies
/// in the plane.
inline std::pair<double, double> ray_barycentrics(const Vec3& origin, const Vec3& direction, const Vec3& a,
                                                  const Vec3& b, const Vec3& c) {
  const Vec3 e1 = b - a, e2 = c - a, s = origin - a;
  const Vec3 p = cross(direction, e2);
  const double determinant = dot(e1, p);
  if (determinant == 0) return {1.0 / 3, 1.0 / 3};
  double u = std::max(0.0, dot(s, p) / determinant);
  double v = std::max(0.0, dot(direction, cross(s, e1)) / determinant);
  if (const double sum = u + v; sum > 1) u /= sum, v /= sum;
  return {u, v};
}

struct ClosestOnTriangle {
  Vec3 point;
  double u, v;
  double squared_distance;
};

/// The point of the triangle nearest to p, by its Voronoi regions (Ericson, Real-Time Collision
/// Detection, 5.1.5).
inline ClosestOnTriangle closest_on_triangle(const Vec3& p, const Vec3& a, const Vec3& b, const Vec3& c) {
  const Vec3 ab = b - a, ac = c - a, ap = p - a;
  const auto at = [&](double u, double v) {
    const Vec3 q = a + ab * u + ac * v;
    return ClosestOnTriangle{q, u, v, squared_length(p - q)};
  };
  const auto corner = [&](const Vec3& q, double u, double v) {
    return ClosestOnTriangle{q, u, v, squared_length(p - q)};
  };
  const double d1 = dot(ab, ap), d2 = dot(ac, ap);
  if (d1 <= 0 && d2 <= 0) return corner(a, 0, 0);
  const Vec3 bp = p - b;
  const double d3 = dot(ab, bp), d4 = dot(ac, bp);
  if (d3 >= 0 && d4 <= d3) return corner(b, 1, 0);
  const double vc = d1 * d4 - d3 * d2;
  if (vc <= 0 && d1 >= 0 && d3 <= 0 && d1 > d3) return at(d1 / (d1 - d3), 0);
  const Vec3 cp = p - c;
  const double d5 = dot(ab, cp), d6 = dot(ac, cp);
  if (d6 >= 0 && d5 <= d6) return corner(c, 0, 1);
  const double vb = d5 * d2 - d1 * d6;
  if (vb <= 0 && d2 >= 0 && d6 <= 0 && d2 > d6) return at(0, d2 / (d2 - d6));
  const double va = d3 * d6 - d5 * d4;
  const double e43 = d4 - d3, e56 = d5 - d6;
  if (va <= 0 && e43 >= 0 && e56 >= 0 && e43 + e56 > 0) {
    const double w = e43 / (e43 + e56);
    return at(1 - w, w);
  }
  const double sum = va + vb + vc;
  if (!(sum > 0)) return corner(a, 0, 0);
  return at(vb / sum, vc / sum);
}

}  // namespace turgor::detail
