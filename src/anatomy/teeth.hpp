// Teeth by their density, and the plane between the upper and the lower row.
#pragma once

#include <optional>

#include "anatomy/cranium.hpp"

namespace turgor {

/// 1 in the teeth (enamel and the denser dentine; fillings too).
LabelVolume find_teeth(const ScannedBody& body, const TissueLevels& levels, const Cranium& cranium);

/// The occlusal plane, normal upwards: where the density in and around the teeth, summed along planes of
/// every pitch to 30° and roll to 10°, has its deepest valley between two rows. None where there are not two
/// rows.
std::optional<Plane> find_occlusal_plane(const LabelVolume& teeth, const CtVolume& hu);

/// A surface for display: all teeth. Empty where there are none.
TriMesh teeth_surface(const ScannedBody& body, const LabelVolume& teeth, int triangles);

}  // namespace turgor
