// Whether a body is a head, and which way it faces.
#pragma once

#include "anatomy/body_mask.hpp"

namespace turgor {

/// The cranial cavity and the face as seen from it.
struct Cranium {
  double cavity_ml = 0;
  Vec3 centre;   ///< of the cavity, patient mm
  Box3 cavity;   ///< bounds of the cavity along the axes of the scan, patient mm
  Vec3 to_face;  ///< unit vector from the cavity to the face
};

/// Finds the cavity as the soft tissue from which bone is seen in nearly every direction, which also holds
/// for a vault with a defect and for a scan that cuts the skull base. Errors: no vault (not a head), upside
/// down, turned to the back or to one side, face missing.
Result<Cranium> find_cranium(const ScannedBody& body, const TissueLevels& levels);

}  // namespace turgor
