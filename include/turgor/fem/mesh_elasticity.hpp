// Elasticity of any mesh of hexahedra, prisms and tetrahedra, for all laws, assembled and solved directly:
// the second route by which the voxel solver is checked, the reference for layered tissue, and for bodies
// whose elements follow their surface. For thousands of elements.
//
// Hexahedra take the mean of θ (fem/elastic_material.hpp) over the element: B-bar for small strains (Hughes
// 1980), mean dilatation for large ones (Simo, Taylor and Pister 1985). Prisms and tetrahedra, which would
// still lock that way, take it over the elements of their material around each point, as nodal pressures do
// (Bonet and Burton 1998).
#pragma once

#include <array>
#include <span>
#include <vector>

#include "turgor/core/context.hpp"
#include "turgor/fem/elasticity.hpp"

namespace turgor {

/// Corners in the order of VTK. Elements are numbered hexahedra first, then prisms, then tetrahedra.
struct ElementMesh {
  std::vector<Vec3> points;  ///< mm
  std::vector<std::array<int, 8>> hexahedra;
  std::vector<std::array<int, 6>> prisms;  ///< a triangle, anticlockwise seen from the other one, and that
  std::vector<std::array<int, 4>> tetrahedra;

  [[nodiscard]] std::size_t size() const { return hexahedra.size() + prisms.size() + tetrahedra.size(); }
};

struct MeshElasticityOptions {
  double relative_residual = 1e-9;  ///< > 0; of Newton's method
  NewtonOptions newton;
};

/// `start`: displacements to begin from; the whole load is then tried at once. Linear laws without contacts
/// are one system. Contacts hold a piece across their planes alone. Not converged: `converged` is false, the
/// best state found comes back and the context is warned with what stood in the way. Errors: no elements; an
/// index out of range; an element whose map is not one to one; a material, support, contact, load or start
/// that cannot be used; a piece that nothing holds against rigid motion; cancelled. Points of no element
/// stay.
Result<ElasticSolution> solve_mesh(const ElementMesh& mesh, const ElasticBody& body,
                                   const ElasticSupports& supports, const ElasticLoad& load,
                                   const MeshElasticityOptions& options, Context& context,
                                   std::span<const Vec3> start = {});
/// Cauchy stress and the law's strain measure (ε, S − 1, E, or ln V of neo-Hookean and Mooney-Rivlin laws),
/// one for each element. Errors: of mesh and body as above; another number of displacements than points.
Result<std::vector<ElementStress>> mesh_stress(const ElementMesh& mesh, const ElasticBody& body,
                                               std::span<const Vec3> displacement_mm);
/// Energy in N·mm and its exact gradient, N: the forces that hold the body in this displacement. Errors as
/// above; an element turned over, where its law has no energy.
struct ElasticForces {
  double energy_nmm = 0;
  std::vector<Vec3> force_n;
};
Result<ElasticForces> mesh_forces(const ElementMesh& mesh, const ElasticBody& body,
                                  std::span<const Vec3> displacement_mm);
/// What the load puts on each point, N.
Result<std::vector<Vec3>> mesh_load(const ElementMesh& mesh, const ElasticBody& body,
                                    const ElasticLoad& load);

}  // namespace turgor
