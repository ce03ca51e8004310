// Voxel masks: thresholds, components, distance and morphology.
#pragma once

#include "turgor/core/context.hpp"
#include "turgor/imaging/volume.hpp"

namespace turgor {

/// 1 where lower ≤ value ≤ upper.
LabelVolume threshold(const CtVolume& volume, int lower, int upper);

/// Face-connected components of the non-zero voxels.
struct Components {
  Volume<std::int32_t> labels;      ///< 0 outside, 1, 2, … by falling size
  std::vector<std::size_t> sizes;   ///< voxels; sizes[0] belongs to label 1
};
Components connected_components(const LabelVolume& mask);
/// The n-th largest component (1-based) as a mask.
LabelVolume component_mask(const Components& components, int label);

/// Voxels not reachable from the border of the volume through zero voxels become 1 (holes filled in 3D).
LabelVolume fill_holes(const LabelVolume& mask);

/// Exact Euclidean distance in mm from each voxel centre to the nearest voxel centre with mask != 0 (spacing
/// honoured), by the separable transform of Felzenszwalb and Huttenlocher (2012). Capped at `max_mm`.
Volume<float> distance_to(const LabelVolume& mask, double max_mm = 1e9);
/// Ball of `radius_mm`, by the distance transform.
LabelVolume dilate(const LabelVolume& mask, double radius_mm);
LabelVolume erode(const LabelVolume& mask, double radius_mm);
LabelVolume close_gaps(const LabelVolume& mask, double radius_mm);
LabelVolume open_gaps(const LabelVolume& mask, double radius_mm);

}  // namespace turgor
