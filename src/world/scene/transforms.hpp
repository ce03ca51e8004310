// Directions and transforms of any magnitude. Internal to the scene.
#pragma once

#include "turgor/world/object.hpp"

namespace turgor {

/// Unit vector along `a` also where its squared length overflows or vanishes; zero where `a` has no
/// direction.
inline Vec3 unit(const Vec3& a) {
  const double largest = std::max({std::abs(a.x), std::abs(a.y), std::abs(a.z)});
  if (!(largest > 0) || !std::isfinite(largest)) return {};
  // A power of two, so that scaling costs no bits.
  const int exponent = std::ilogb(largest);
  return normalized(
      Vec3{std::scalbn(a.x, -exponent), std::scalbn(a.y, -exponent), std::scalbn(a.z, -exponent)});
}

inline bool is_finite(const ObjectTransform& t) {
  return is_finite(t.linear.c[0]) && is_finite(t.linear.c[1]) && is_finite(t.linear.c[2]) &&
         is_finite(t.translation) && is_finite(t.origin);
}

/// The same map about another origin.
inline ObjectTransform about(const Vec3& origin, const ObjectTransform& t) {
  return {t.linear, t.point({}) - origin + t.linear * origin, origin};
}
/// `a * b` applies b first; about (0, 0, 0).
inline ObjectTransform operator*(const ObjectTransform& a, const ObjectTransform& b) {
  return {a.linear * b.linear, a.point(b.point({})), {}};
}
/// About (0, 0, 0). Not finite where the map is flat.
inline ObjectTransform inverse(const ObjectTransform& t) {
  const Mat3 back = t.linear.inverse();
  return {back, -(back * t.point({})), {}};
}
/// With the given linear part, about `origin`, taking `from` to `to`.
inline ObjectTransform taking(const Vec3& from, const Vec3& to, const Mat3& linear, const Vec3& origin) {
  return {linear, to - origin - linear * (from - origin), origin};
}

/// The middle of the world's bounding box; the point at the origin of an object without points.
inline Vec3 centre_of(const Object& object) {
  const Box3 box = world_box(object);
  return box.empty() ? object.transform.point({}) : box.lower * 0.5 + box.upper * 0.5;
}

}  // namespace turgor
