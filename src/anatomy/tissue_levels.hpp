// Levels between air, soft tissue and bone from the histogram of a CT.
#pragma once

#include "turgor/anatomy/head.hpp"

namespace turgor {

/// Peaks of the histogram and the levels drawn from them, HU.
struct TissueLevels {
  double air = -1000;        ///< peak
  double soft = 40;          ///< peak of brain and muscle
  double soft_sigma = 15;    ///< noise about it
  double bone = 900;         ///< median of what is clearly bone
  double skin_level = -480;  ///< midway between air and soft tissue
  double bone_level = 250;
};

/// Air and soft tissue of the whole scan, and the skin level. Errors: nothing but air; no air at all.
Result<TissueLevels> measure_air_and_soft_tissue(const CtVolume& hu);

/// Adds bone, counted within `body` only. The bone level is a quarter of the way from soft tissue to bone,
/// which keeps thin bone closed (the surface itself later goes to the local midway), at least five standard
/// deviations of the noise above soft tissue, at most midway; or the given threshold where refinement is off.
/// Errors: less than `smallest_bone_ml` of bone.
Result<void> measure_bone(const CtVolume& hu, const LabelVolume& body, const HeadOptions& options,
                          TissueLevels& levels);

}  // namespace turgor
