// Finding the mandible among bones, and markers from which it is parted where it touches the skull.
#pragma once

#include "anatomy/bone_labels.hpp"
#include "anatomy/coarse_grid.hpp"

namespace turgor {

bool has_volume_of_mandible(std::size_t voxels, const Grid& grid);

/// Whether the piece (mask) is a mandible: an arch, wide and open to the back, with a chin in front, well
/// below the middle of the cranial cavity.
bool looks_like_mandible(const LabelVolume& piece, const Cranium& cranium);

/// Markers kSkull and kMandible for flood_by_density, on either side of the plane between the rows of teeth,
/// the rami followed up to the joints (ramus_track.hpp). None where no chin lies below the plane.
std::optional<LabelVolume> markers_by_occlusal_plane(const CtVolume& hu, const LabelVolume& bone,
                                                     const LabelVolume& teeth, const Plane& plane,
                                                     const Cranium& cranium);

/// The same from the pieces of the first threshold, rising from the bone level, at which a piece looks like a
/// mandible. None where that never happens.
std::optional<LabelVolume> markers_by_rising_threshold(const CtVolume& hu, const LabelVolume& bone,
                                                       const TissueLevels& levels, const Cranium& cranium);

/// Markers kSkull and kRamus for a scan that ends above the body of the mandible: sections of the rami in the
/// lowest slices, on either side, behind the teeth. None where there are none.
std::optional<LabelVolume> markers_of_rami(const LabelVolume& bone, const LabelVolume& teeth,
                                           const Cranium& cranium);

}  // namespace turgor
