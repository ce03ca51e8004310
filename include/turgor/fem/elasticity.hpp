// What holds, loads and makes up an elastic body of hexahedra, and what comes of it. Small displacements from
// the rest positions; solved by fem/voxel_elasticity.hpp and fem/hexahedral_elasticity.hpp.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "turgor/fem/elastic_material.hpp"
#include "turgor/math/vec.hpp"

namespace turgor {

/// Material of each element: Young's modulus is that of its material times its factor.
struct ElasticBody {
  std::vector<ElasticMaterial> materials{ElasticMaterial{}};
  std::vector<std::uint8_t> material;  ///< number of each element's; empty: all of the first
  std::vector<double> modulus_factor;  ///< of each element, > 0; empty: 1

  [[nodiscard]] ElasticMaterial of(std::size_t element) const {
    ElasticMaterial m = materials[material.empty() ? 0 : material[element]];
    if (!modulus_factor.empty()) m.youngs_modulus_mpa *= modulus_factor[element];
    return m;
  }
};

/// Holds components of a node's displacement at given values: all three to fix it, one to let it slide on a
/// plane across that axis, two to let it slide along the third.
struct NodeSupport {
  int node = 0;
  std::array<bool, 3> held{true, true, true};
  Vec3 displacement_mm;  ///< of the held components
};

struct NodeForce {
  int node = 0;
  Vec3 force_n;
};

/// On a face of four nodes, at rest. `traction_mpa` acts as it stands; `pressure_mpa` pushes against the side
/// from which the corners are seen to go anticlockwise.
struct SurfaceLoad {
  std::array<int, 4> corners{};
  Vec3 traction_mpa;
  double pressure_mpa = 0;
};

struct ElasticLoad {
  std::vector<NodeForce> forces;
  std::vector<SurfaceLoad> surfaces;
  Vec3 gravity_mm_ms2;  ///< acceleration; the earth's is 0.00981
};

/// Means over an element.
struct ElementStress {
  SymmetricTensor strain;  ///< of the symmetric gradient of the displacement
  SymmetricTensor stress_mpa;
};

struct ElasticSolution {
  std::vector<Vec3> displacement_mm;  ///< of each node
  /// What the supports do to each node: K u − f, zero at components that are not held.
  std::vector<Vec3> reaction_n;
  double strain_energy_nmm = 0;
  int iterations = 0;  ///< 0: solved directly
  /// ‖f − K u‖ over the components that are not held, in double precision, relative to its value when they
  /// have no displacement.
  double relative_residual = 0;
  /// Whether that is as small as asked for, or as the rounding of the displacements lets it be (slender
  /// bodies: a beam of 400 by 2 by 2 cubes stops at 2e-6).
  bool converged = true;
};

}  // namespace turgor
