// Following the rami of the mandible up to the joints, section by section.
#pragma once

#include "anatomy/mandible.hpp"

namespace turgor {

/// Marks all bone more than `band_mm` above the occlusal plane as kMandible or kSkull. The sections of the
/// mandible parallel to the plane are followed upwards from `body` (its bone below the plane): a section that
/// continues the last one and touches nothing else is mandible whole. Where it has run together with the
/// skull, as a condyle with its fossa, the columns over the last free section are cut at the joint: at the
/// dark seam between the two layers of cortical bone, or in the middle of the one bright layer that is left
/// when the joint space is narrower than a voxel. `rows` tells the voxels at the rows of teeth, which are
/// left out between -band and band. Other voxels keep their marker.
void mark_rami(const CtVolume& hu, const LabelVolume& bone, const LabelVolume& body, const LabelVolume& rows,
               const Plane& occlusal, double band_mm, LabelVolume& markers);

}  // namespace turgor
