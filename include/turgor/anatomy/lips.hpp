// The slit of the mouth: where the closed skin of a scan is parted into upper and lower lip.
#pragma once

#include <optional>
#include <vector>

#include "turgor/anatomy/landmarks.hpp"
#include "turgor/geometry/tri_mesh.hpp"

namespace turgor {

/// A plane through stomion and both corners of the mouth, used between the corners only.
struct LipSlit {
  Plane plane;        ///< normal upwards
  Vec3 left, right;   ///< cheilion, mm
  double back_y = 0;  ///< the slit ends in front of this

  [[nodiscard]] bool covers(const Vec3& p) const;
};

/// Nothing where a landmark of the mouth is missing. `lip_level_mm` moves the plane up or down to that z.
std::optional<LipSlit> find_lip_slit(const Landmarks& landmarks, std::optional<double> lip_level_mm = {});

/// Parts a skin surface along the slit. `side` receives +1 on the upper rim, -1 on the lower one, else 0.
TriMesh part_lips(const TriMesh& skin, const LipSlit& slit, double snap_mm, std::vector<int>* side);

/// Points near the slit moved apart by up to `gap_mm`, so that the nearest point of one lip is never taken on
/// the other.
std::vector<Vec3> spread_lips(const std::vector<Vec3>& points, const std::vector<int>& side,
                              const LipSlit& slit, double gap_mm);

}  // namespace turgor
