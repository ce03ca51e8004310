// Forces of tetrahedra that keep lengths, areas and volumes (Morris 2006, section 4.1), several tetrahedra or
// cubes side by side. Internal to the module.
//
// Of each size l² with the rest size D², D the length of an edge or twice the area of a triangle, what is
// needed is the change r = (l − D)/l = q/(l² + l D) with q = l² − D², and q comes from displacements d alone:
// of an edge e = R + d, q = d·(R + e); of an area vector N = N₀ + δ, q = δ·(N₀ + N). Nothing near to each
// other is subtracted, so that single precision keeps small strains. The gradient of ½ κ (l − D)² is κ r e.
//
// With e₁, e₂, e₃ from one corner, N₁₂ = e₁ × e₂ and so on, the fourth triangle has N = N₁₂ + N₂₃ + N₃₁ and
// six times the volume is e₁·N₂₃. With g = κ r N of each triangle and p that of the volume,
//     ∂E/∂e₁ = Σ κ r e + p N₂₃ + e₂ × (g₁₂ + g) + (g₃₁ + g) × e₃   and so on in turn.
#pragma once

#include <utility>

#include "math/float_lanes.hpp"

namespace turgor::detail {

/// r of q and the squares l² and D². Where l vanishes so does the force: below a hundred-thousandth of D,
/// where single precision has no direction left, it fades.
template <class Real>
Real relative_change(const Real& q, const Real& square, const Real& rest_square) {
  const Real l2 = larger<Real>(square, rest_square * same<Real>(1e-10F));
  return q / (l2 + root(l2 * rest_square));
}

template <class Real>
struct TetraConstants {
  Triple<Real> r1, r2, r3;  ///< edges at rest from the first corner
  Real edge[6];             ///< κ of e₁, e₂, e₃, e₂ − e₁, e₃ − e₂, e₁ − e₃
  Real outer12, outer23, outer31, inner, volume;  ///< κ
};

/// An edge with the displacement d, at rest r: κ r e, and the largest change yet.
template <class Real>
Triple<Real> edge_gradient(const Triple<Real>& r, const Triple<Real>& d, const Real& k, Real& stretch) {
  const Triple<Real> e = r + d;
  const Real change = relative_change<Real>(dot(d, r + e), dot(e, e), dot(r, r));
  stretch = larger<Real>(change, stretch);
  return e * (k * change);
}

/// κ r of the area vector n, at rest n − change.
template <class Real>
Real area_change(const Triple<Real>& rest, const Triple<Real>& change, const Triple<Real>& n, const Real& k) {
  return k * relative_change<Real>(dot(change, rest + n), dot(n, n), dot(rest, rest));
}

/// Forces on the corners, in place of their displacements.
template <class Real>
void tetra_forces(const TetraConstants<Real>& c, Triple<Real> (&u)[4], Real& stretch) {
  using V = Triple<Real>;
  const V d1 = u[1] - u[0], d2 = u[2] - u[0], d3 = u[3] - u[0];
  const V e1 = c.r1 + d1, e2 = c.r2 + d2, e3 = c.r3 + d3;
  const V m12 = cross(c.r1, c.r2), m23 = cross(c.r2, c.r3), m31 = cross(c.r3, c.r1);
  const V s12 = cross_add(d1, c.r2, cross(e1, d2)), s23 = cross_add(d2, c.r3, cross(e2, d3)),
          s31 = cross_add(d3, c.r1, cross(e3, d1));
  const V n12 = m12 + s12, n23 = m23 + s23, n31 = m31 + s31;
  const V n = n12 + n23 + n31, g = n * area_change<Real>(m12 + m23 + m31, s12 + s23 + s31, n, c.inner);
  const V g12 = multiply_add(n12, area_change<Real>(m12, s12, n12, c.outer12), g),
          g23 = multiply_add(n23, area_change<Real>(m23, s23, n23, c.outer23), g),
          g31 = multiply_add(n31, area_change<Real>(m31, s31, n31, c.outer31), g);
  const Real p = c.volume * (dot(d1, n23) + dot(c.r1, s23));
  const V f12 = edge_gradient<Real>(c.r2 - c.r1, d2 - d1, c.edge[3], stretch),
          f23 = edge_gradient<Real>(c.r3 - c.r2, d3 - d2, c.edge[4], stretch),
          f31 = edge_gradient<Real>(c.r1 - c.r3, d1 - d3, c.edge[5], stretch);
  const V a1 = cross_add(
      e2, g12,
      cross_add(g31, e3,
                multiply_add(n23, p, edge_gradient<Real>(c.r1, d1, c.edge[0], stretch) + (f31 - f12))));
  const V a2 = cross_add(
      e3, g23,
      cross_add(g12, e1,
                multiply_add(n31, p, edge_gradient<Real>(c.r2, d2, c.edge[1], stretch) + (f12 - f23))));
  const V a3 = cross_add(
      e1, g31,
      cross_add(g23, e2,
                multiply_add(n12, p, edge_gradient<Real>(c.r3, d3, c.edge[2], stretch) + (f23 - f31))));
  u[0] = a1 + a2 + a3, u[1] = -a1, u[2] = -a2, u[3] = -a3;
}

/// The elements of a cube in the order of their constants.
struct CubeElements {
  static constexpr int axis = 0;       ///< 3 k + direction at the cut-off corner k
  static constexpr int diagonal = 12;  ///< pairs of middle corners: 01 02 03 12 13 23
  static constexpr int outer = 18;     ///< 3 k + normal at the cut-off corner k
  static constexpr int inner = 30;     ///< under the cut-off corner k
  static constexpr int volume = 34;    ///< at the cut-off corner k, then the middle one
  static constexpr int count = 39;
};

/// Corner c of a cube lies at x = c & 1, y = c >> 1 & 1, z = c >> 2. In a cube of the pattern 0 corners with
/// one or three bits are cut off, in one of the pattern 1 the others; four tetrahedra lie at them, each with
/// three edges along the axes, a fifth in the middle.
template <int pattern>
struct CubePattern {
  static constexpr int middle[4] = {pattern == 0 ? 0 : 1, pattern == 0 ? 3 : 2, pattern == 0 ? 5 : 4,
                                    pattern == 0 ? 6 : 7};
  static constexpr int cut[4] = {middle[0] ^ 7, middle[1] ^ 7, middle[2] ^ 7, middle[3] ^ 7};
  static constexpr int number_of(int middle_corner) {
    int n = 0;
    while (middle[n] != middle_corner) ++n;
    return n;
  }
  static constexpr int pair(int m, int n) {
    const int a = m < n ? m : n, b = m < n ? n : m;
    return a == 0 ? b - 1 : a + b;
  }
};

template <int n, class Body>
void unrolled(Body&& body) {
  [&]<std::size_t... i>(std::index_sequence<i...>) {
    (body.template operator()<static_cast<int>(i)>(), ...);
  }
  (std::make_index_sequence<static_cast<std::size_t>(n)>());
}

/// b − a, or with the axes mirrored that corner `from` has bits on.
template <int from, class Real>
Triple<Real> mirrored_difference(const Triple<Real>& b, const Triple<Real>& a) {
  return {(from & 1) != 0 ? a.x - b.x : b.x - a.x, (from & 2) != 0 ? a.y - b.y : b.y - a.y,
          (from & 4) != 0 ? a.z - b.z : b.z - a.z};
}
template <int from, class Real>
Triple<Real> mirrored(const Triple<Real>& a) {
  return {(from & 1) != 0 ? -a.x : a.x, (from & 2) != 0 ? -a.y : a.y, (from & 4) != 0 ? -a.z : a.z};
}
/// a ± b likewise.
template <int from, class Real>
void add_mirrored(Triple<Real>& a, const Triple<Real>& b) {
  a = {(from & 1) != 0 ? a.x - b.x : a.x + b.x, (from & 2) != 0 ? a.y - b.y : a.y + b.y,
       (from & 4) != 0 ? a.z - b.z : a.z + b.z};
}
template <int from, class Real>
void subtract_mirrored(Triple<Real>& a, const Triple<Real>& b) {
  add_mirrored<from ^ 7>(a, b);
}

/// Forces on the eight corners of cubes of edge 1, in place of their displacements. `constant.template
/// operator()<i>()` is κ of an element. Every tetrahedron at a corner is mirrored to (0, x, y, z).
template <int pattern, class Real>
class CubeForces {
  using V = Triple<Real>;
  using P = CubePattern<pattern>;
  using E = CubeElements;

 public:
  template <class Constant>
  static void replace(V (&u)[8], Real& stretch, const Constant& constant) {
    V force[4];  // on the middle corners
    for (V& f : force) f = {same<Real>(0), same<Real>(0), same<Real>(0)};
    add_diagonals(u, force, stretch, constant);
    Middle middle;
    unrolled<4>([&]<int k>() { cut_off<k>(u, force, stretch, constant, middle); });
    const Real p = middle.change * constant.template operator()<E::volume + 4>();
    unrolled<4>([&]<int k>() {
      subtract_mirrored<P::cut[k]>(force[k], middle.normal[k] * p);
      u[P::middle[k]] = force[k];
    });
  }

 private:
  struct Middle {
    V normal[4];  ///< gradient of six times the volume of the middle tetrahedron, mirrored
    Real change;  ///< of six times that volume
  };

  template <class Constant>
  static void add_diagonals(const V (&u)[8], V (&force)[4], Real& stretch, const Constant& constant) {
    unrolled<6>([&]<int n>() {
      constexpr int a = n < 3 ? 0 : n < 5 ? 1 : 2, b = n < 3 ? n + 1 : n < 5 ? n - 1 : 3;
      constexpr int from = P::middle[a], along = from ^ P::middle[b];
      static_assert(P::pair(a, b) == n);
      const V d = mirrored_difference<from>(u[P::middle[b]], u[from]);
      const Real one = same<Real>(1), two = same<Real>(2);
      const V e = {(along & 1) != 0 ? d.x + one : d.x, (along & 2) != 0 ? d.y + one : d.y,
                   (along & 4) != 0 ? d.z + one : d.z};
      const Real sum = along == 3 ? d.x + d.y : along == 5 ? d.x + d.z : d.y + d.z;
      const Real change = relative_change<Real>((sum + sum) + dot(d, d), dot(e, e), two);
      stretch = larger<Real>(change, stretch);
      const V f = e * (change * constant.template operator()<E::diagonal + n>());
      add_mirrored<from>(force[a], f);
      subtract_mirrored<from>(force[b], f);
    });
  }

  static Real axis_gradient(const V& d, const Real& dx, const V& e, const Real& k, Real& stretch) {
    const Real change = relative_change<Real>((dx + dx) + dot(d, d), dot(e, e), same<Real>(1));
    stretch = larger<Real>(change, stretch);
    return k * change;
  }
  static V add_outer(const V& s, const Real& sx, const V& n, const Real& k, const V& g) {
    return multiply_add(n, k * relative_change<Real>((sx + sx) + dot(s, s), dot(n, n), same<Real>(1)), g);
  }

  // The tetrahedron at the corner k that is cut off; its displacement becomes its force.
  template <int k, class Constant>
  static void cut_off(V (&u)[8], V (&force)[4], Real& stretch, const Constant& constant, Middle& middle) {
    constexpr int a = P::cut[k];
    constexpr int b1 = P::number_of(a ^ 1), b2 = P::number_of(a ^ 2), b3 = P::number_of(a ^ 4);
    const Real one = same<Real>(1);
    const V ones = {one, one, one};
    const V d1 = mirrored_difference<a>(u[a ^ 1], u[a]), d2 = mirrored_difference<a>(u[a ^ 2], u[a]),
            d3 = mirrored_difference<a>(u[a ^ 4], u[a]);
    const V e1 = {d1.x + one, d1.y, d1.z}, e2 = {d2.x, d2.y + one, d2.z}, e3 = {d3.x, d3.y, d3.z + one};
    // eᵢ × eⱼ less the axis that it is at rest.
    const auto turned = [](const Real& p, const Real& q, const Real& r, const Real& t) {
      return multiply_subtract<Real>(p, q, r * t);
    };
    const auto along = [](const Real& p, const Real& q, const Real& r, const Real& t, const Real& rest) {
      return multiply_subtract<Real>(p, q, multiply_subtract<Real>(r, t, rest));
    };
    const V s12 = {turned(d1.y, d2.z, d1.z, e2.y), turned(d1.z, d2.x, e1.x, d2.z),
                   along(d1.x, e2.y, d1.y, d2.x, d2.y)};
    const V s23 = {along(d2.y, e3.z, d2.z, d3.y, d3.z), turned(d2.z, d3.x, d2.x, e3.z),
                   turned(d2.x, d3.y, e2.y, d3.x)};
    const V s31 = {turned(d3.y, d1.z, e3.z, d1.y), along(d3.z, e1.x, d3.x, d1.z, d1.x),
                   turned(d3.x, d1.y, d3.y, e1.x)};

    const V n12 = {s12.x, s12.y, s12.z + one}, n23 = {s23.x + one, s23.y, s23.z},
            n31 = {s31.x, s31.y + one, s31.z};
    const V s = s12 + s23 + s31, n = s + ones;
    const V g = n * (constant.template operator()<E::inner + k>() *
                     relative_change<Real>(dot(s, n + ones), dot(n, n), same<Real>(3)));
    const V g23 = add_outer(s23, s23.x, n23, constant.template operator()<E::outer + 3 * k>(), g),
            g31 = add_outer(s31, s31.y, n31, constant.template operator()<E::outer + 3 * k + 1>(), g),
            g12 = add_outer(s12, s12.z, n12, constant.template operator()<E::outer + 3 * k + 2>(), g);
    const Real p = constant.template operator()<E::volume + k>() * (dot(d1, n23) + s23.x);
    const Real c1 = axis_gradient(d1, d1.x, e1, constant.template operator()<E::axis + 3 * k>(), stretch),
               c2 = axis_gradient(d2, d2.y, e2, constant.template operator()<E::axis + 3 * k + 1>(), stretch),
               c3 = axis_gradient(d3, d3.z, e3, constant.template operator()<E::axis + 3 * k + 2>(), stretch);
    const V a1 = cross_add(e2, g12, cross_add(g31, e3, multiply_add(n23, p, e1 * c1)));
    const V a2 = cross_add(e3, g23, cross_add(g12, e1, multiply_add(n31, p, e2 * c2)));
    const V a3 = cross_add(e1, g31, cross_add(g23, e2, multiply_add(n12, p, e3 * c3)));
    subtract_mirrored<a>(force[b1], a1);
    subtract_mirrored<a>(force[b2], a2);
    subtract_mirrored<a>(force[b3], a3);
    middle.normal[k] = n;
    if constexpr (k == 0) {  // the far corner is at (1, 1, 1), (0, 1, 1) from the first of the triangle
      const V d = mirrored_difference<a>(u[a ^ 7], u[a ^ 1]);
      middle.change = dot(d, n) + (s.y + s.z);
    }
    u[a] = mirrored<a>(a1 + a2 + a3);
  }
};

}  // namespace turgor::detail
