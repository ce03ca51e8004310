// Voxel masks: thresholds, components, distance and morphology.
#pragma once

#include "turgor/core/context.hpp"
#include "turgor/imaging/volume.hpp"

namespace turgor {

/// 1 where lower ≤ value ≤ upper.
LabelVolume threshold(const CtVolume& volume, int lower, int upper);

/// Face-connected components of the non-zero voxels.
struct Components {
  Volume<std::int32_t> labels;     ///< 0 outside, 1, 2, … by falling size
  std::vector<std::size_t> sizes;  ///< voxels; sizes[0] belongs to label 1
};
Components connected_components(const LabelVolume& mask);
/// The n-th largest component (1-based) as a mask.
LabelVolume component_mask(const Components& components, int label);
/// The largest component alone; quicker than by way of Components. All zero where the mask is.
LabelVolume largest_component(const LabelVolume& mask);
/// The components of at least `least_voxels` voxels.
LabelVolume remove_small_components(const LabelVolume& mask, std::size_t least_voxels);
/// The voxels of the mask that are face-connected to one of the seed voxels (seeds outside mask or volume
/// count for nothing): a flood fill.
LabelVolume reachable_from(const LabelVolume& mask, const std::vector<Index3>& seeds);

/// Voxels not reachable from the border of the volume through zero voxels become 1 (holes filled in 3D).
LabelVolume fill_holes(const LabelVolume& mask);

/// Exact Euclidean distance in mm from each voxel centre to the nearest voxel centre with mask != 0 (spacing
/// honoured), by the separable transform of Felzenszwalb and Huttenlocher (2012). Capped at `max_mm`.
Volume<float> distance_to(const LabelVolume& mask, double max_mm = 1e9);
/// By a ball of `radius_mm`: a voxel centre at exactly that distance belongs to it. Beyond the end of the
/// volume there is nothing for dilation and everything for erosion, so a body cut off by the scan is not
/// eroded from the cut, and close_gaps contains the mask, open_gaps is contained in it. No change where the
/// radius is 0 or less.
LabelVolume dilate(const LabelVolume& mask, double radius_mm);
LabelVolume erode(const LabelVolume& mask, double radius_mm);
LabelVolume close_gaps(const LabelVolume& mask, double radius_mm);
LabelVolume open_gaps(const LabelVolume& mask, double radius_mm);

/// Length in mm of the shortest path within the mask (steps to the 26 neighbours) from the nearest voxel with
/// seeds != 0; seeds outside the mask count for nothing. Capped at `max_mm`, also where no path leads.
/// Without voxels where the sizes differ.
Volume<float> geodesic_distance(const LabelVolume& mask, const LabelVolume& seeds, double max_mm = 1e9);
/// Each voxel of the mask takes the label of the seed that is nearest by such a path (the smaller label where
/// two are equally near); 0 outside the mask and further than `max_mm`. Gives back to pieces what an erosion
/// took from them.
LabelVolume grow_labels(const LabelVolume& mask, const LabelVolume& seeds, double max_mm = 1e9);

}  // namespace turgor
