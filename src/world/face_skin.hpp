// The layered tissue's skin carried by the cubes of a face.
#pragma once

#include <span>
#include <vector>

#include "turgor/anatomy/layered_tissue.hpp"
#include "turgor/world/face_solid.hpp"

namespace turgor {

/// Displacement of each point of the layered tissue's surface, from that of each node: moving least squares
/// of first order over the nodes nearby, which evens out the steps of the cubes. The two lips do not pull at
/// each other; the rim stays.
std::vector<Vec3> carry_skin(const FaceSolid& face, const LayeredTissue& tissue,
                             std::span<const Vec3> displacement_mm);

}  // namespace turgor
