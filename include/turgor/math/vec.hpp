// Small vectors, matrices, rigid transforms and boxes. Plain values; double precision unless named otherwise.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace turgor {

template <class T>
struct VecT {
  T x{}, y{}, z{};

  constexpr T& operator[](int i) { return i == 0 ? x : i == 1 ? y : z; }
  constexpr const T& operator[](int i) const { return i == 0 ? x : i == 1 ? y : z; }
  constexpr VecT& operator+=(const VecT& b) { return x += b.x, y += b.y, z += b.z, *this; }
  constexpr VecT& operator-=(const VecT& b) { return x -= b.x, y -= b.y, z -= b.z, *this; }
  constexpr VecT& operator*=(T s) { return x *= s, y *= s, z *= s, *this; }
  constexpr VecT& operator/=(T s) { return x /= s, y /= s, z /= s, *this; }
  friend constexpr VecT operator+(VecT a, const VecT& b) { return a += b; }
  friend constexpr VecT operator-(VecT a, const VecT& b) { return a -= b; }
  friend constexpr VecT operator*(VecT a, T s) { return a *= s; }
  friend constexpr VecT operator*(T s, VecT a) { return a *= s; }
  friend constexpr VecT operator/(VecT a, T s) { return a /= s; }
  constexpr VecT operator-() const { return {-x, -y, -z}; }
  constexpr bool operator==(const VecT&) const = default;
};

using Vec3 = VecT<double>;
using Vec3f = VecT<float>;
using Index3 = std::array<int, 3>;

template <class T>
constexpr T dot(const VecT<T>& a, const VecT<T>& b) {
  return a.x * b.x + a.y * b.y + a.z * b.z;
}
template <class T>
constexpr VecT<T> cross(const VecT<T>& a, const VecT<T>& b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
template <class T>
constexpr T squared_length(const VecT<T>& a) {
  return dot(a, a);
}
template <class T>
T length(const VecT<T>& a) {
  return std::sqrt(dot(a, a));
}
template <class T>
T distance(const VecT<T>& a, const VecT<T>& b) {
  return length(a - b);
}
/// Unit vector along `a`, or zero where `a` has no direction.
template <class T>
VecT<T> normalized(const VecT<T>& a) {
  const T l = length(a);
  return l > T(0) ? a / l : VecT<T>{};
}
template <class T>
constexpr VecT<T> lerp(const VecT<T>& a, const VecT<T>& b, T t) {
  return a + (b - a) * t;
}
template <class T>
bool is_finite(const VecT<T>& a) {
  return std::isfinite(a.x) && std::isfinite(a.y) && std::isfinite(a.z);
}
inline Vec3f to_float(const Vec3& a) {
  return {static_cast<float>(a.x), static_cast<float>(a.y), static_cast<float>(a.z)};
}
inline Vec3 to_double(const Vec3f& a) {
  return {a.x, a.y, a.z};
}
/// Some unit vector at right angles to the unit vector `n`.
Vec3 any_orthogonal(const Vec3& n);

/// 3×3 matrix by columns: m.c[j][i] is row i, column j.
struct Mat3 {
  std::array<Vec3, 3> c{Vec3{1, 0, 0}, Vec3{0, 1, 0}, Vec3{0, 0, 1}};

  friend constexpr Vec3 operator*(const Mat3& m, const Vec3& v) {
    return m.c[0] * v.x + m.c[1] * v.y + m.c[2] * v.z;
  }
  friend constexpr Mat3 operator*(const Mat3& a, const Mat3& b) {
    return Mat3{{a * b.c[0], a * b.c[1], a * b.c[2]}};
  }
  [[nodiscard]] constexpr Mat3 transposed() const {
    return Mat3{{Vec3{c[0].x, c[1].x, c[2].x}, Vec3{c[0].y, c[1].y, c[2].y}, Vec3{c[0].z, c[1].z, c[2].z}}};
  }
  [[nodiscard]] constexpr double determinant() const { return dot(c[0], cross(c[1], c[2])); }
  /// Undefined where the determinant is zero.
  [[nodiscard]] Mat3 inverse() const;
};

/// Right-handed rotation about the unit vector `axis`.
Mat3 rotation(const Vec3& axis, double angle_rad);
constexpr double radians(double degrees) {
  return degrees * 0.017453292519943295;
}
constexpr double degrees(double rad) {
  return rad * 57.29577951308232;
}

/// p ↦ R p + t.
struct RigidTransform {
  Mat3 rotation{};
  Vec3 translation{};

  [[nodiscard]] Vec3 point(const Vec3& p) const { return rotation * p + translation; }
  [[nodiscard]] Vec3 direction(const Vec3& d) const { return rotation * d; }
  [[nodiscard]] RigidTransform inverse() const;
  /// `a * b` applies b first.
  friend RigidTransform operator*(const RigidTransform& a, const RigidTransform& b) {
    return {a.rotation * b.rotation, a.rotation * b.translation + a.translation};
  }
  static RigidTransform translate(const Vec3& t) { return {Mat3{}, t}; }
  /// Rotation by `angle_rad` about the line through `point` along the unit vector `axis`.
  static RigidTransform rotate_about(const Vec3& point, const Vec3& axis, double angle_rad);
};

/// The points p with dot(normal, p) = offset; `normal` has unit length and points to the positive side.
struct Plane {
  Vec3 normal{0, 0, 1};
  double offset = 0;

  static Plane through(const Vec3& point, const Vec3& normal);
  [[nodiscard]] double signed_distance(const Vec3& p) const { return dot(normal, p) - offset; }
};

struct Box3 {
  Vec3 lower{std::numeric_limits<double>::infinity(), std::numeric_limits<double>::infinity(),
             std::numeric_limits<double>::infinity()};
  Vec3 upper{-lower.x, -lower.y, -lower.z};

  [[nodiscard]] bool empty() const { return lower.x > upper.x || lower.y > upper.y || lower.z > upper.z; }
  [[nodiscard]] Vec3 centre() const { return (lower + upper) * 0.5; }
  [[nodiscard]] Vec3 size() const { return upper - lower; }
  [[nodiscard]] bool contains(const Vec3& p) const {
    return p.x >= lower.x && p.x <= upper.x && p.y >= lower.y && p.y <= upper.y && p.z >= lower.z &&
           p.z <= upper.z;
  }
  void extend(const Vec3& p) {
    for (int i = 0; i < 3; ++i) {
      lower[i] = std::min(lower[i], p[i]);
      upper[i] = std::max(upper[i], p[i]);
    }
  }
};

}  // namespace turgor
