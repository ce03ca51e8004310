// Skull and mandible as voxel labels.
#pragma once

#include <optional>

#include "anatomy/cranium.hpp"

namespace turgor {

enum BoneLabel : std::uint8_t {
  kNoBone = 0,
  kSkull = 1,     ///< with the upper teeth, and with vertebrae where they touch
  kMandible = 2,  ///< with the lower teeth
  kRamus = 3,     ///< rami of a mandible whose body the scan does not show
};

struct BoneLabels {
  LabelVolume labels;  ///< of the voxels at or above the bone level; loose crumbs are 0
  LabelVolume teeth;
  MandibleState mandible_state = MandibleState::absent;
  std::optional<Plane> occlusal_plane;
  double loose_ml = 0;  ///< of bone in no label: hyoid, vertebrae, crumbs
};

/// Splits the bone of a head. The mandible is the component that looks like one; where none does because it
/// touches the skull, it is parted from it by density (see flood_by_density) from markers on either side of
/// the occlusal plane, and where there are no two rows of teeth, from the pieces that a rising threshold
/// leaves. Errors: no bone forms a skull.
Result<BoneLabels> label_bones(const ScannedBody& body, const TissueLevels& levels, const Cranium& cranium,
                               const HeadOptions& options, Context& context);

}  // namespace turgor
