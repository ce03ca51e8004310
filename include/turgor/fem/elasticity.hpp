// What holds, loads and makes up an elastic body, and what comes of it. Solved by fem/voxel_elasticity.hpp on
// the cubes of a lattice and by fem/mesh_elasticity.hpp on any mesh.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "turgor/fem/elastic_material.hpp"
#include "turgor/math/vec.hpp"
#include "turgor/tissue/network.hpp"

namespace turgor {

/// Material of each element: its moduli (c20 too) are those of its material times its factor.
struct ElasticBody {
  std::vector<ElasticMaterial> materials{ElasticMaterial{}};
  std::vector<std::uint8_t> material;  ///< number of each element's; empty: all of the first
  std::vector<double> modulus_factor;  ///< of each element, > 0; empty: 1

  [[nodiscard]] ElasticMaterial of(std::size_t element) const {
    ElasticMaterial m = materials[material.empty() ? 0 : material[element]];
    if (!modulus_factor.empty())
      m.youngs_modulus_mpa *= modulus_factor[element], m.c20_mpa *= modulus_factor[element];
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

/// What holds a body. `contacts` (tissue/network.hpp, point = node, at most one a node, in any order): rigid
/// planes that nodes stay before, each pressed with its stiffness, free to slide along it, and drawn back
/// with its adhesion where that is above 0. The half-space is that of the deformed position, rest +
/// displacement.
struct ElasticSupports {
  std::vector<NodeSupport> nodes;
  std::vector<Contact> contacts;
};

struct NodeForce {
  int node = 0;
  Vec3 force_n;
};

/// On a face of four nodes, at rest; of three where the last corner is named twice. `traction_mpa` acts as it
/// stands; `pressure_mpa` pushes against the side from which the corners are seen to go anticlockwise.
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

/// Of laws that are not linear, and of contacts that open and close: Newton's method on the energy with a
/// line search, the prescribed displacements and the load applied in so many parts.
struct NewtonOptions {
  int load_steps = 1;          ///< ≥ 1; halved further where a part does not converge
  int max_newton_steps = 100;  ///< of all parts together, ≥ 1
};

struct ElasticSolution {
  std::vector<Vec3> displacement_mm;  ///< of each node
  /// What supports and contacts do to each node, zero elsewhere: K u − f for small displacements.
  std::vector<Vec3> reaction_n;
  double strain_energy_nmm = 0;  ///< without contacts
  int newton_steps = 0;          ///< 0: one linear system
  int iterations = 0;            ///< of linear systems; 0: solved directly
  /// Norm of the forces on the components that are not held, in double precision, relative to its value when
  /// they have no displacement; with Newton's method relative to the norm of the reactions and loads, if that
  /// is larger.
  double relative_residual = 0;
  /// Whether that is as small as asked for, or as the rounding of the displacements lets it be (slender
  /// bodies: a beam of 400 by 2 by 2 cubes stops at 2e-6).
  bool converged = true;
};

}  // namespace turgor
