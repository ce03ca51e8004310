// Cephalometric landmarks on bone and skin.
#pragma once

#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "turgor/math/vec.hpp"

namespace turgor {

/// One kind of landmark. Declared once; files, commands and reports use these names.
struct LandmarkKind {
  std::string_view name;   ///< as in commands: "pogonion", "soft_pogonion", "gonion_left"
  std::string_view label;  ///< as on pictures: "Pog", "Pog'", "Go"
  std::string_view meaning;
  bool on_bone;
  std::string_view twin;  ///< the soft landmark over a hard one and the reverse; empty: none
};

/// Hard: nasion, ans, a_point, b_point, pogonion, menton, upper_incisor, lower_incisor, gonion_left/right,
/// condylion_left/right, orbitale_left/right, zygion_left/right. Soft: soft_nasion, pronasale, subnasale,
/// labrale_superius, stomion, labrale_inferius, soft_b_point (mentolabial fold), soft_pogonion, soft_menton,
/// cheilion_left/right, alare_left/right, soft_a_point.
const std::vector<LandmarkKind>& landmark_kinds();
const LandmarkKind* find_landmark_kind(std::string_view name);

struct Landmark {
  Vec3 point;              ///< mm, LPS
  bool corrected = false;  ///< set by the user rather than found
};

/// By name; a landmark that the scan does not show is absent.
using Landmarks = std::map<std::string, Landmark, std::less<>>;

}  // namespace turgor
