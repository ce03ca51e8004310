// A solid among the tissue of a scene: voxels of a surface as tetrahedra, what they are made of, and the
// surface that is shown of them (Morris 2006, sections 2 and 4).
#pragma once

#include <memory>
#include <vector>

#include "turgor/core/context.hpp"
#include "turgor/geometry/solid_skin.hpp"
#include "turgor/geometry/tetra_embedding.hpp"
#include "turgor/geometry/voxel_solid.hpp"
#include "turgor/tissue/solid.hpp"
#include "turgor/world/solid_constants.hpp"

namespace turgor {

/// How the shown surface follows the tetrahedra.
enum class SkinBinding {
  frames,       ///< by frames at the solid's surface points (Morris 2006, section 4.2)
  barycentric,  ///< by the tetrahedra that hold its points
};

struct SolidOptions {
  VoxelOptions voxels;
  SolidMaterial material;
  SkinBinding binding = SkinBinding::barycentric;
  int neighbours = SolidSkin::kNeighbours;  ///< of `frames`
};

/// Immutable but for what edits change: which points are mobile, and how stiff the elements are.
struct SolidPart {
  SolidOptions options;
  SolidMesh mesh;                           ///< at rest
  std::vector<char> mobile;                 ///< one a point
  std::vector<double> stiffness;            ///< factor of the material's, one a tetrahedron
  SolidConstants constants;                 ///< calibrated, in place of the material's; else empty
  Solid elements;                           ///< over the mesh's points
  std::vector<double> mass_g;               ///< one a point
  TriMesh skin;                             ///< the shown surface at rest
  std::shared_ptr<const SolidSkin> frames;  ///< one of these two
  std::shared_ptr<const TetraEmbedding> barycentric;

  /// The shown surface where the solid's points are at `positions`.
  [[nodiscard]] TriMesh shown(std::span<const Vec3> positions) const;
};

/// Elements, masses and the skin's binding for a mesh whose points stand at `positions` while its shown
/// surface stands at `skin_now`. `part` brings options, mesh, skin and stiffness.
Result<void> complete_solid_part(SolidPart& part, std::span<const Vec3> positions, const TriMesh& skin_now);
/// Errors: those of voxelise(); a material out of range; a surface too large.
Result<SolidPart> make_solid_part(const TriMesh& surface, const SolidOptions& options,
                                  const Context& context);
/// Constants anew after `stiffness` or `constants` has changed. On error the elements stay as they were.
Result<void> refresh_elements(SolidPart& part);

}  // namespace turgor
