// Elasticity of the cubes of a lattice, for all laws, with sliding on rigid planes: the constitutive
// reference of a voxel solid, on the same points as its tetrahedra.
//
// Trilinear hexahedra whose dilatation is its mean over the element (B-bar; Nagtegaal, Parks and Rice 1974,
// Hughes 1980), which do not lock as Poisson's ratio goes to ½. Conjugate gradients in double precision,
// preconditioned by a geometric multigrid cycle in single precision: no matrix of the cubes is stored, coarse
// lattices have the Galerkin products of their cells, Chebyshev polynomials of the fourth kind smooth (Lottes
// 2023), and the coarsest is solved directly. Contacts are closed and opened, and laws that are not linear
// solved, by Newton's method on the energy; the dilatation of large strains is its mean too (Simo, Taylor and
// Pister 1985). The same bits on any number of threads.
#pragma once

#include <memory>
#include <span>
#include <vector>

#include "turgor/core/context.hpp"
#include "turgor/fem/elasticity.hpp"
#include "turgor/geometry/solid_mesh.hpp"

namespace turgor {

struct VoxelElasticityOptions {
  double relative_residual = 1e-6;  ///< > 0; see ElasticSolution
  int max_iterations = 500;         ///< ≥ 1; of each Newton step where a law is not linear
  /// Of the two finest levels, before and after; 0: chosen by Poisson's ratio, for a residual of 1e-6.
  int smoothing_steps = 0;
  NewtonOptions newton;
};

class VoxelElasticity {
 public:
  /// `solid`: the cubes of a lattice; `body`: one element a cube. Two supports of one node hold both their
  /// components, the later one's value counts. Errors: not a lattice; a material, factor or support that
  /// cannot be used; a piece that is not held against rigid motion, by name and place; cancelled.
  static Result<VoxelElasticity> prepare(const SolidMesh& solid, ElasticBody body,
                                         const ElasticSupports& supports,
                                         const VoxelElasticityOptions& options, Context& context);
  VoxelElasticity(VoxelElasticity&&) noexcept;
  VoxelElasticity& operator=(VoxelElasticity&&) noexcept;
  ~VoxelElasticity();

  /// Other values for what is held, in the order of the supports given to prepare().
  Result<void> set_displacements(std::span<const Vec3> displacement_mm);
  /// Other planes, stiffness and adhesion for the same nodes, in the order of the contacts given to
  /// prepare().
  Result<void> set_contacts(std::span<const Contact> contacts);
  /// `start`: the displacement of each node to begin from, such as that of another load; one that turns cubes
  /// over is left aside. Not converged within the iterations allowed: `converged` is false and the context
  /// warned. Contacts without adhesion count as holding the body, though a load may yet lift it off: then it
  /// does not converge. Errors: a load that cannot be used;
  /// cancelled.
  [[nodiscard]] Result<ElasticSolution> solve(const ElasticLoad& load, Context& context,
                                              std::span<const Vec3> start = {}) const;
  /// One for each cube: of laws that are not linear the Cauchy stress and the law's strain, as mesh_stress().
  /// Errors: another number of displacements than points; not finite; a cube turned over.
  [[nodiscard]] Result<std::vector<ElementStress>> stress(std::span<const Vec3> displacement_mm) const;
  /// The energy's gradient at every node (K u under Hooke's law), N: the forces that hold the body in this
  /// displacement. Errors as above.
  [[nodiscard]] Result<std::vector<Vec3>> internal_forces(std::span<const Vec3> displacement_mm) const;

 private:
  struct Parts;
  explicit VoxelElasticity(std::unique_ptr<Parts> parts);
  std::unique_ptr<Parts> parts_;
};

}  // namespace turgor
