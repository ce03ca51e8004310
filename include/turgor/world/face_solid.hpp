// The soft tissue of the face as cubes along the patient's axes: skin minus bone minus air.
#pragma once

#include <cstdint>
#include <vector>

#include "turgor/anatomy/head.hpp"
#include "turgor/anatomy/layered_tissue.hpp"
#include "turgor/core/context.hpp"
#include "turgor/geometry/solid_mesh.hpp"

namespace turgor {

/// What a node of the cubes lies on.
enum class FaceNode : std::uint8_t {
  inner,  ///< tissue all around
  skin,
  free,  ///< air of mouth and nose, the slit between the lips, or where the tissue looked at ends within more
  bone,
  rim,  ///< the region's edge towards tissue that stays
};

struct FaceSolid {
  SolidMesh mesh;                     ///< cubes of a lattice, one face-connected piece
  std::vector<FaceNode> nodes;        ///< of each point
  std::vector<double> bone_area_mm2;  ///< of each point: its share of the cubes' faces towards bone
  std::vector<float> depth_mm;        ///< of each cube's centre below the skin

  [[nodiscard]] int cubes() const { return static_cast<int>(mesh.tetrahedra.size() / 5); }
};

/// Cubes whose centre lies within the skin and the region of the layered tissue, in neither bone nor airway,
/// before the bone as seen from the nearest skin, and no deeper than rays of the layered tissue may reach;
/// where those met no bone, no deeper than they were made. Between the lips a layer is left out, so that they
/// share no node. The lattice lies so that the slit runs through the middle of cubes. Errors: a spacing
/// outside kLeastSpacing to kGreatestSpacing; no tissue; more cubes than can be numbered; cancelled.
Result<FaceSolid> build_face_solid(const Head& head, const LayeredTissue& tissue, double spacing_mm,
                                   Context& context);
inline constexpr double kLeastCubeMm = 0.5, kGreatestCubeMm = 10;

}  // namespace turgor
