// A part of a scan as the cubes that a solid is made of: by its label, or by a threshold.
#pragma once

#include <optional>
#include <vector>

#include "turgor/core/error.hpp"
#include "turgor/geometry/voxel_solid.hpp"
#include "turgor/imaging/volume.hpp"

namespace turgor {

/// Which part, and how fine. Without `resolution` and `spacing_mm` the scan's own smallest spacing holds.
struct LabelOptions {
  std::vector<int> labels;          ///< any of these; or
  std::optional<int> above, below;  ///< HU: values from `above` and up to `below`
  int resolution = 0;               ///< voxels along the longest axis of the part's box
  double spacing_mm = 0;            ///< edge of a voxel
};

/// Cubes along the axes of the patient (LPS), whatever those of the scan: set where their centre has one of
/// the labels (that of the nearest voxel) or, by threshold, where the value interpolated there lies within.
/// All components are kept. Memory and time go with the cubes of the part's box.
/// Errors: neither or both asked for; resolution beyond 1 to VoxelOptions::max_resolution, a spacing that
/// leads there, or both; a label that no voxel has (names those there are); no voxel within the threshold
/// (names the range of values); a part too thin for the centre of any cube.
Result<VoxelGrid> label_voxels(const CtVolume& scan, const LabelOptions& options);

}  // namespace turgor
