// A triangle whose area is kept: its shape and the response of its material. Internal to the module.
#pragma once

#include <array>
#include <cmath>

#include "turgor/tissue/network_energy.hpp"

namespace turgor {

/// Where the area is 0 there is no normal.
struct TriangleShape {
  std::array<Vec3, 3> edge;  ///< opposite to each corner, anticlockwise
  Vec3 normal;               ///< unit, or zero
  double area;
};

inline TriangleShape shape_of(const Vec3& a, const Vec3& b, const Vec3& c) {
  const std::array<Vec3, 3> edge = {c - b, a - c, b - a};
  const Vec3 doubled = cross(edge[0], edge[1]);
  const double l = length(doubled);
  return {edge, l > 0 ? doubled * (1.0 / l) : Vec3{}, 0.5 * l};
}

/// ∂A/∂x of the corner opposite to `edge`, mm.
inline Vec3 area_gradient(const Vec3& normal, const Vec3& edge) {
  return cross(normal, edge) * 0.5;
}

/// Energy in N·mm, dE/dA in N/mm, d²E/dA² in N/mm³.
struct AreaResponse {
  double energy, stress, slope;
};
inline AreaResponse respond(const AreaElement& element, double area_mm2) {
  const double k = element.stiffness_nmm, rest = element.rest_area_mm2, strain = (area_mm2 - rest) / rest;
  return {0.5 * k * strain * strain, k * strain / rest, k / rest / rest};
}

/// The eigenvalues ±√3/2 of ∂²A within the plane, whatever the triangle: each twofold, of displacements that
/// turn and scale an equilateral triangle, and of their mirror images.
inline constexpr double kAreaEigenvalue = 0.8660254037844386;

/// The stiffness of a triangle in parts, after projection:
///
///     K_ab = stretch g_a g_bᵀ + bend (e_a · e_b) n nᵀ ∓ twist [n]× + spread (δ_ab − 1/3)(1 − n nᵀ)
///
/// The nearest semi-definite matrix to σ M, M with the eigenvalues ±λ, is ½ (σ M + |σ| λ P), P the projection
/// onto their vectors: within the plane everything but translations.
struct AreaParts {
  double stretch, bend, twist, spread;
};
inline AreaParts parts_of(const AreaStiffness& area, double projection) {
  return {area.stretch, area.bend < 0 ? area.bend * (1 - projection) : area.bend,
          0.5 * (1 - 0.5 * projection) * area.stress,
          0.5 * projection * std::abs(area.stress) * kAreaEigenvalue};
}

/// Adds the block of corners a and b, given their gradients.
inline void add_area_block(const AreaStiffness& area, const AreaParts& parts, int a, int b, const Vec3& g_a,
                           const Vec3& g_b, Mat3& m) {
  const Vec3& n = area.normal;
  const double isotropic = parts.spread * (a == b ? 2.0 / 3 : -1.0 / 3);
  const Vec3 left = g_a * parts.stretch,
             normal = n * (parts.bend * dot(area.edge[a], area.edge[b]) - isotropic);
  const double follows = a == b ? 0.0 : b == (a + 1) % 3 ? -parts.twist : parts.twist;
  const Vec3 w = n * follows;
  const bool has_plane = n != Vec3{};
  m.c[0] += left * g_b.x + normal * n.x + Vec3{has_plane ? isotropic : 0.0, w.z, -w.y};
  m.c[1] += left * g_b.y + normal * n.y + Vec3{-w.z, has_plane ? isotropic : 0.0, w.x};
  m.c[2] += left * g_b.z + normal * n.z + Vec3{w.y, -w.x, has_plane ? isotropic : 0.0};
}

}  // namespace turgor
