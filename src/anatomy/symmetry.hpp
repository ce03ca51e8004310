// The midsagittal plane from the symmetry of a surface.
#pragma once

#include "turgor/geometry/tri_mesh.hpp"

namespace turgor {

/// The plane about which the mirrored surface lies closest to itself, starting from `start` (off by up to
/// about 20° and 15 mm). Iterated nearest points with distance along the normal (Chen and Medioni 1992) and
/// weights that let asymmetric parts, up to about a third of the surface, count for nothing (Tukey's
/// biweight). The normal keeps to the side of `start`.
Plane find_symmetry_plane(const TriMesh& surface, const Plane& start);

}  // namespace turgor
