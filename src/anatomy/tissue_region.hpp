// The part of the skin that gets tissue, parted at the mouth and evenly triangulated. Internal to anatomy.
#pragma once

#include "turgor/anatomy/layered_tissue.hpp"
#include "turgor/anatomy/lips.hpp"

namespace turgor {

struct TissueRegion {
  FaceRegion limits;
  TriMesh surface;
  std::vector<bool> rim;      ///< points where tissue goes on beyond the region: they are held
  std::vector<int> lip_side;  ///< per point: -1 lower rim, +1 upper rim of the mouth slit, 0 elsewhere
  std::optional<LipSlit> slit;
  double lip_level_mm = 0;
  int skin_points_above_bone = 0;
};

Result<TissueRegion> find_tissue_region(const Head& head, const Landmarks& landmarks,
                                        const TissueOptions& options, Context& context);

}  // namespace turgor
