// Linear elasticity of any hexahedra, assembled and solved directly: the second route by which the voxel
// solver is checked, and for bodies whose elements follow their surface. For thousands of elements.
//
// Isoparametric trilinear hexahedra, 2×2×2 Gauss points, dilatation replaced by its mean over the element
// (B-bar, Hughes 1980).
#pragma once

#include <array>
#include <span>
#include <vector>

#include "turgor/core/context.hpp"
#include "turgor/fem/elasticity.hpp"

namespace turgor {

/// Corners in the order of VTK and Abaqus: anticlockwise below, then above.
struct HexahedralMesh {
  std::vector<Vec3> points;  ///< mm
  std::vector<std::array<int, 8>> elements;
};

/// Errors: no elements; an index out of range; an element whose map is not one to one; a material or support
/// that cannot be used; a piece that is not held against rigid motion; cancelled. Points of no element stay.
Result<ElasticSolution> solve_hexahedra(const HexahedralMesh& mesh, const ElasticBody& body,
                                        std::span<const NodeSupport> supports, const ElasticLoad& load,
                                        Context& context);
/// One for each element. Errors: of mesh and body as above; another number of displacements than points.
Result<std::vector<ElementStress>> hexahedra_stress(const HexahedralMesh& mesh, const ElasticBody& body,
                                                    std::span<const Vec3> displacement_mm);
/// K u of every point, N. Errors as above.
Result<std::vector<Vec3>> hexahedra_forces(const HexahedralMesh& mesh, const ElasticBody& body,
                                           std::span<const Vec3> displacement_mm);
/// What the load puts on each point, N. Errors: of mesh and body; an index out of range; a number that is not
/// finite.
Result<std::vector<Vec3>> hexahedra_load(const HexahedralMesh& mesh, const ElasticBody& body,
                                         const ElasticLoad& load);

}  // namespace turgor
