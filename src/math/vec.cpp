#include "turgor/math/vec.hpp"

namespace turgor {

Vec3 any_orthogonal(const Vec3& n) {
  const Vec3 axis = std::abs(n.x) < 0.6 ? Vec3{1, 0, 0} : Vec3{0, 1, 0};
  return normalized(cross(n, axis));
}

Mat3 Mat3::inverse() const {
  const double inv = 1.0 / determinant();
  const Mat3 rows{{cross(c[1], c[2]) * inv, cross(c[2], c[0]) * inv, cross(c[0], c[1]) * inv}};
  return rows.transposed();
}

Mat3 rotation(const Vec3& axis, double angle_rad) {
  const double s = std::sin(angle_rad), k = 1.0 - std::cos(angle_rad);
  const auto column = [&](const Vec3& e) { return e + cross(axis, e) * s + cross(axis, cross(axis, e)) * k; };
  return Mat3{{column({1, 0, 0}), column({0, 1, 0}), column({0, 0, 1})}};
}

RigidTransform RigidTransform::inverse() const {
  const Mat3 back = rotation.transposed();
  return {back, -(back * translation)};
}

RigidTransform RigidTransform::rotate_about(const Vec3& point, const Vec3& axis, double angle_rad) {
  const Mat3 turn = turgor::rotation(axis, angle_rad);
  return {turn, point - turn * point};
}

Plane Plane::through(const Vec3& point, const Vec3& normal) {
  const Vec3 n = normalized(normal);
  return {n, dot(n, point)};
}

}  // namespace turgor
