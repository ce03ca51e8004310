// Symmetric 3×3 blocks and the inverses of their Cholesky factors, for block factorisations.
#pragma once

#include <cmath>

#include "turgor/math/vec.hpp"

namespace turgor {

struct Symmetric3 {
  double xx = 0, xy = 0, xz = 0, yy = 0, yz = 0, zz = 0;

  explicit constexpr Symmetric3() = default;
  /// The lower triangle of a symmetric matrix.
  explicit Symmetric3(const Mat3& m)
      : xx(m.c[0].x), xy(m.c[0].y), xz(m.c[0].z), yy(m.c[1].y), yz(m.c[1].z), zz(m.c[2].z) {}

  [[nodiscard]] double trace() const { return xx + yy + zz; }
  void add_to_diagonal(double s) { xx += s, yy += s, zz += s; }
  /// += s v vᵀ.
  void add_outer(const Vec3& v, double s) {
    xx += s * v.x * v.x, xy += s * v.x * v.y, xz += s * v.x * v.z;
    yy += s * v.y * v.y, yz += s * v.y * v.z, zz += s * v.z * v.z;
  }
};

/// W = C⁻¹ of P = C Cᵀ, a lower triangle: P⁻¹ = Wᵀ W.
struct InverseFactor {
  double w00 = 1, w10 = 0, w11 = 1, w20 = 0, w21 = 0, w22 = 1;

  /// False, and nothing changed, where P is not positive definite.
  bool factor(const Symmetric3& p) {
    const double l00 = std::sqrt(p.xx), i0 = 1 / l00, l10 = p.xy * i0, l20 = p.xz * i0;
    const double l11 = std::sqrt(p.yy - l10 * l10), i1 = 1 / l11, l21 = (p.yz - l20 * l10) * i1;
    const double l22 = std::sqrt(p.zz - l20 * l20 - l21 * l21), i2 = 1 / l22;
    if (!(l00 > 0 && l11 > 0 && l22 > 0)) return false;  // also where a root had a negative argument
    const double v10 = -i1 * l10 * i0;
    *this = {i0, v10, i1, -i2 * (l20 * i0 + l21 * v10), -i2 * l21 * i1, i2};
    return true;
  }
  [[nodiscard]] Vec3 times(const Vec3& v) const {
    return {w00 * v.x, w10 * v.x + w11 * v.y, w20 * v.x + w21 * v.y + w22 * v.z};
  }
  [[nodiscard]] Vec3 transposed_times(const Vec3& v) const {
    return {w00 * v.x + w10 * v.y + w20 * v.z, w11 * v.y + w21 * v.z, w22 * v.z};
  }
  /// A Wᵀ.
  [[nodiscard]] Mat3 right_of(const Mat3& a) const {
    return Mat3{{a.c[0] * w00, a.c[0] * w10 + a.c[1] * w11, a.c[0] * w20 + a.c[1] * w21 + a.c[2] * w22}};
  }
  /// W A.
  [[nodiscard]] Mat3 left_of(const Mat3& a) const { return Mat3{{times(a.c[0]), times(a.c[1]), times(a.c[2])}}; }
  /// W D Wᵀ.
  [[nodiscard]] Mat3 both_sides_of(const Symmetric3& d) const {
    return right_of(left_of(Mat3{{Vec3{d.xx, d.xy, d.xz}, Vec3{d.xy, d.yy, d.yz}, Vec3{d.xz, d.yz, d.zz}}}));
  }
};

}  // namespace turgor
