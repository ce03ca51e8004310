// What a plan prescribes for the tissue.
#pragma once

#include <utility>
#include <vector>

#include "turgor/dynamics/prescribed_motion.hpp"
#include "turgor/world/patient_case.hpp"

namespace turgor {

struct TissueMotion {
  /// Inner ends on moved bone move with it; those on unmoved bone and the rim of the region stay.
  PrescribedMotion motion;
  std::vector<int> free_columns;  ///< whose inner ends nothing holds: bone may push them
  /// Inner ends of free columns that lie on moved bone and where it takes them: lips and cheeks over teeth.
  std::vector<std::pair<int, Vec3>> mucosa;
};

/// Error: nothing moves.
Result<TissueMotion> tissue_motion(const PatientCase& patient);

}  // namespace turgor
