// Solids of tetrahedra that keep their lengths, areas and volumes: Morris (2006), "Automatic Preparation,
// Calibration, and Simulation of Deformable Objects", section 4.1, after Teschner et al. (2004); models.md 2.
#pragma once

#include <array>
#include <span>
#include <vector>

#include "turgor/core/error.hpp"
#include "turgor/math/vec.hpp"

namespace turgor {

/// Energies ½ k_d ((|e| − D0)/D0)² of each edge, ½ k_a ((A − A0)/A0)² of each triangle and
/// ½ k_v ((V − V0)/V0)² of each tetrahedron, V signed; D0, A0 and V0 are those of the rest positions of the
/// network that the solid is part of. Constants in N·mm, ≥ 0, one for each element.
struct Solid {
  std::vector<std::array<int, 4>> tetrahedra;  ///< points of the network; of positive volume at rest
  std::vector<std::array<int, 2>> edges;       ///< each once, first < second
  std::vector<Index3> triangles;               ///< each once
  std::vector<double> edge_nmm, triangle_nmm, tetrahedron_nmm;  ///< k_d, k_a, k_v
  /// Above 0: tetrahedra 5 c to 5 c + 4 are the cube c of a lattice with this edge, in the patterns of
  /// SolidMesh, its points in the order of the lattice. Lets solvers use the lattice's rest sizes.
  double lattice_mm = 0;
};

/// Edges and triangles found, ascending, constants 0. Errors: an index out of range, or named twice by a
/// tetrahedron; more than 2^31 − 1 corners; a lattice without five tetrahedra a cube.
Result<Solid> make_solid(std::vector<std::array<int, 4>> tetrahedra, int point_count, double lattice_mm = 0);

/// What a solid is made of, in the words of engineers.
struct SolidMaterial {
  double youngs_modulus_mpa = 0.015;  ///< > 0; the whole face (Nazari et al. 2010)
  double poissons_ratio = 0.45;       ///< 0 to below 0.5
  double density_g_mm3 = 1.04e-3;     ///< > 0
  double area_share = 0.2;            ///< 0 to 1: of the shear stiffness that triangles carry, not edges
};

/// Constants over the rest volume that an element stands for, MPa: k_d = length · V, and so on.
struct SolidStiffness {
  double length = 0, area = 0, volume = 0;
};
/// The guess before calibration: elements whose edges point every way alike have, for small strains, the
/// energy of linear elasticity ½ (2 μ ε:ε + λ tr² ε). With ⟨(n·εn)²⟩ = (2 ε:ε + tr²)/15 of edges and
/// ⟨(tr − n·εn)²⟩ = (2 ε:ε + 6 tr²)/15 of triangles: length + area = 15 μ, and
/// volume = λ − length/15 − 6 area/15. That is at least 0 from Poisson's ratio (1 + 5 s)/(4 + 10 s) on, s the
/// share of areas (1/4 without them, 1/3 at 0.2): below, volumes have the constant 0 and the shear modulus
/// alone is that of the material.
SolidStiffness stiffness_of(const SolidMaterial& material);

/// Fills the constants: each element stands for its part of the tetrahedra around it (a sixth for each edge,
/// a quarter for each triangle), each with its own stiffness. `stiffness`: one for each tetrahedron, or one
/// for all. On error nothing changes. Errors: another number of them; one that is not finite or below 0; a
/// rest volume that is not above 0; edges or triangles that make_solid() did not find.
Result<void> set_stiffness(Solid& solid, std::span<const Vec3> rest,
                           std::span<const SolidStiffness> stiffness);
/// Adds to the mass of each point, g: a quarter of each tetrahedron around it.
void add_mass(const Solid& solid, std::span<const Vec3> rest, double density_g_mm3,
              std::vector<double>& mass_g);

}  // namespace turgor
