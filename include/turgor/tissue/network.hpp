// The tissue model: points, springs, volumes, areas and solids, and the laws of their materials (models.md 1
// and 2).
#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <vector>

#include "turgor/core/error.hpp"
#include "turgor/math/vec.hpp"
#include "turgor/tissue/solid.hpp"

namespace turgor {

/// f(s) of strain s = max(L, L0) / min(L, L0) - 1 ≥ 0 (Pieper 1989, section 3.2.1), and `collagen`, which
/// carries no compression: crimped fibres that straighten evenly between the strains 0 and w =
/// kCollagenRecruitment, f(s) = s²/(2w), and all carry beyond, f(s) = s − w/2. In parallel with a linear
/// spring of shorter rest length, elastin, it gives the J-shaped law of skin (the thesis, figure 2-1).
/// `hookean` is linear in the strain of engineers, (L − L0)/L0, in tension and compression alike: the force
/// that keeps distances in Morris (2006), section 4.1.
enum class SpringLaw : std::uint8_t { linear, exponential, logarithmic, square, collagen, hookean };

inline constexpr std::array kSpringLaws = {SpringLaw::linear, SpringLaw::exponential, SpringLaw::logarithmic,
                                           SpringLaw::square, SpringLaw::collagen,    SpringLaw::hookean};
inline constexpr double kCollagenRecruitment = 0.1;

/// Where in layered tissue a spring lies (Pieper 1989, section 5.6).
enum class SpringKind : std::uint8_t { membrane, plate, vertical, diagonal, suture, fibre };

struct Spring {
  int a = 0, b = 0;           ///< ends, point numbers
  double rest_length_mm = 1;  ///< > 0
  double stiffness_n = 1;     ///< force at strain 1 under the linear law, N; ≥ 0
  SpringLaw law = SpringLaw::linear;
  SpringKind kind = SpringKind::membrane;
};

/// A tetrahedron whose volume is kept: energy ½ k V0 ((V − V0)/V0)², k in MPa (a bulk modulus), V signed, so
/// that an inverted element is pushed back. That energy is finite at V = 0; `inversion_guard_mpa` = g > 0
/// adds ⅓ g V0 (j − V/V0)³/j² below V/V0 = j = kGuardFrom: pressure −g at V = 0, growing without bound
/// beyond. It is smooth (C²) and finite for every V, so that a solve may start from an inverted state; it
/// resists inversion, it does not exclude it.
struct VolumeElement {
  int p[4] = {0, 0, 0, 0};         ///< positive volume at rest
  double rest_volume_mm3 = 1;      ///< > 0
  double modulus_mpa = 0;          ///< ≥ 0
  double inversion_guard_mpa = 0;  ///< ≥ 0; 0: none

  static constexpr double kGuardFrom = 0.2;
};

/// A triangle whose area is kept: energy ½ k ((A − A0)/A0)² (Morris 2006, section 4.1). A flat one, of area
/// 0, has no direction to grow in: no force.
struct AreaElement {
  int p[3] = {0, 0, 0};
  double rest_area_mm2 = 1;  ///< > 0
  double stiffness_nmm = 0;  ///< k, ≥ 0
};

/// A half-space that one point stays in, as free tissue stays outside bone: energy ½ k d² of the distance
/// d = n·x − offset where d < 0, and ½ k' d² where d > 0: k' = 0 lets the point go, k' > 0 lets it slide
/// along the plane alone, as wet mucosa does. Without friction.
struct Contact {
  int point = 0;
  Vec3 normal{0, 0, 1};  ///< n, unit, into the free half-space
  double offset_mm = 0;
  double stiffness_n_mm = 0;  ///< k, N/mm, ≥ 0
  double adhesion_n_mm = 0;   ///< k', N/mm, ≥ 0
};

/// The immutable recipe. Running state (positions, velocities) lives with the solvers.
/// Invariant (see validate): indices in range, a != b, normals of length 1, rest lengths and volumes > 0, all
/// finite, coordinates within kFarthestMm.
struct SpringNetwork {
  std::vector<Vec3> rest;      ///< mm
  std::vector<double> mass_g;  ///< per point
  std::vector<Spring> springs;
  std::vector<VolumeElement> volumes;
  std::vector<AreaElement> areas;
  std::vector<Solid> solids;      ///< their points among those above
  std::vector<Contact> contacts;  ///< by rising point, at most one each
};

/// Coordinates reach no farther, mm: a thousand kilometres, so that no sum of squares overflows.
inline constexpr double kFarthestMm = 1e9;
inline bool is_within_reach(const Vec3& p) {
  return std::abs(p.x) <= kFarthestMm && std::abs(p.y) <= kFarthestMm && std::abs(p.z) <= kFarthestMm;
}

/// Errors name the first spring, volume, area, solid or point that breaks the invariant.
Result<void> validate(const SpringNetwork& network);

/// Signed tension along the spring, N (positive pulls the ends together), its energy in N·mm, and dT/dL in
/// N/mm: the exact derivatives of one energy, E(L0) = 0. Finite for every finite length ≥ 0: beyond the
/// strain kStrainLimit the tension goes on along its tangent.
struct SpringResponse {
  double energy, tension, slope;
};
SpringResponse respond(const Spring& spring, double length_mm);

/// Fifty-one times its length, or a fifty-first of it: far outside tissue, and e^50 still squares to a finite
/// number.
inline constexpr double kStrainLimit = 50.0;

/// Energy in N·mm, its derivative dE/dV in MPa (negative when compressed) and d²E/dV² in MPa/mm³.
struct VolumeResponse {
  double energy, mean_stress, slope;
};
VolumeResponse respond(const VolumeElement& element, double volume_mm3);

/// ∂V/∂x of the four corners of a tetrahedron with edges e1, e2, e3 from its first, mm²; V = e1 · second.
inline std::array<Vec3, 4> volume_gradient(const Vec3& e1, const Vec3& e2, const Vec3& e3) {
  const Vec3 g1 = cross(e2, e3) / 6.0, g2 = cross(e3, e1) / 6.0, g3 = cross(e1, e2) / 6.0;
  return {-(g1 + g2 + g3), g1, g2, g3};
}

/// ⅙ (b − a)·((c − a) × (d − a)).
inline double signed_volume(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d) {
  return dot(b - a, cross(c - a, d - a)) / 6.0;
}

}  // namespace turgor
