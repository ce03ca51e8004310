// The air inside a head.
#pragma once

#include "anatomy/cranium.hpp"

namespace turgor {

/// Surface of nose, mouth, sinuses and pharynx, pointing out of the air; open where the scan cuts it. The
/// cells of the mastoids and the ear canals are left out. Empty where there is no such air.
TriMesh airway_surface(const ScannedBody& body, const TissueLevels& levels, const Cranium& cranium,
                       int triangles);

}  // namespace turgor
