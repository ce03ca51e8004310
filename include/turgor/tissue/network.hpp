// The spring network: points, springs and volumes, and the laws of their materials (models.md 1 and 2).
#pragma once

#include <cstdint>
#include <string_view>
#include <vector>

#include "turgor/core/error.hpp"
#include "turgor/math/vec.hpp"

namespace turgor {

/// f(s) of strain s = max(L, L0) / min(L, L0) - 1 ≥ 0 (Pieper 1989, section 3.2.1).
enum class SpringLaw : std::uint8_t { linear, exponential, logarithmic, square };

/// Where in layered tissue a spring lies (Pieper 1989, section 5.6).
enum class SpringKind : std::uint8_t { membrane, plate, vertical, diagonal, suture, fibre };

struct Spring {
  int a = 0, b = 0;            ///< ends, point numbers
  double rest_length_mm = 1;   ///< > 0
  double stiffness_n = 1;      ///< force at strain 1 under the linear law, N; ≥ 0
  SpringLaw law = SpringLaw::linear;
  SpringKind kind = SpringKind::membrane;
};

/// A tetrahedron whose volume is kept: energy ½ k V0 ((V − V0)/V0)², k in MPa (a bulk modulus).
struct VolumeElement {
  int p[4] = {0, 0, 0, 0};     ///< positive volume at rest
  double rest_volume_mm3 = 1;  ///< > 0
  double modulus_mpa = 0;
};

/// The immutable recipe. Running state (positions, velocities) lives with the solvers.
/// Invariant (see validate): indices in range, a != b, rest lengths and volumes > 0, all finite.
struct SpringNetwork {
  std::vector<Vec3> rest;                ///< mm
  std::vector<double> mass_g;            ///< per point
  std::vector<Spring> springs;
  std::vector<VolumeElement> volumes;
};

Result<void> validate(const SpringNetwork& network);

/// Signed tension along the spring, N (positive pulls the ends together), its energy in N·mm, and dT/dL in N/mm:
/// the exact derivatives of one energy, E(L0) = 0.
struct SpringResponse {
  double energy, tension, slope;
};
SpringResponse respond(const Spring& spring, double length_mm);


}  // namespace turgor
