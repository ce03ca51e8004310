#include "turgor/anatomy/landmarks.hpp"

namespace turgor {

// Definitions after Swennen, Schutyser and Hausamen (2005), Three-Dimensional Cephalometry.
const std::vector<LandmarkKind>& landmark_kinds() {
  static const std::vector<LandmarkKind> kinds{
      {"nasion", "N", "deepest point of the nasal root, on the bone in the midline", true, "soft_nasion"},
      {"ans", "ANS", "tip of the anterior nasal spine", true, "subnasale"},
      {"a_point", "A", "deepest midline point between nasal spine and upper incisors", true, "soft_a_point"},
      {"b_point", "B", "deepest midline point between lower incisors and chin", true, "soft_b_point"},
      {"pogonion", "Pog", "foremost point of the bony chin", true, "soft_pogonion"},
      {"menton", "Me", "lowest midline point of the mandible", true, "soft_menton"},
      {"upper_incisor", "UI", "edge of the upper central incisors", true, "labrale_superius"},
      {"lower_incisor", "LI", "edge of the lower central incisors", true, "labrale_inferius"},
      {"gonion_left", "Go-L", "lowest, hindmost point of the left angle of the mandible", true, ""},
      {"gonion_right", "Go-R", "lowest, hindmost point of the right angle of the mandible", true, ""},
      {"condylion_left", "Co-L", "uppermost, hindmost point of the left condyle", true, ""},
      {"condylion_right", "Co-R", "uppermost, hindmost point of the right condyle", true, ""},
      {"orbitale_left", "Or-L", "lowest point of the left infraorbital rim", true, ""},
      {"orbitale_right", "Or-R", "lowest point of the right infraorbital rim", true, ""},
      {"zygion_left", "Zy-L", "outermost point of the left zygomatic arch", true, ""},
      {"zygion_right", "Zy-R", "outermost point of the right zygomatic arch", true, ""},
      {"soft_nasion", "N'", "deepest point of the nasal root, on the skin in the midline", false, "nasion"},
      {"pronasale", "Prn", "tip of the nose", false, ""},
      {"subnasale", "Sn", "where the nose meets the upper lip, in the midline", false, "ans"},
      {"soft_a_point", "A'", "deepest midline point of the upper lip", false, "a_point"},
      {"labrale_superius", "Ls", "foremost midline point of the upper lip", false, "upper_incisor"},
      {"stomion", "Sto", "where the lips meet in the midline", false, ""},
      {"labrale_inferius", "Li", "foremost midline point of the lower lip", false, "lower_incisor"},
      {"soft_b_point", "B'", "deepest midline point between lower lip and chin", false, "b_point"},
      {"soft_pogonion", "Pog'", "foremost midline point of the chin's skin", false, "pogonion"},
      {"soft_menton", "Me'", "lowest midline point of the chin's skin", false, "menton"},
      {"cheilion_left", "Ch-L", "left corner of the mouth", false, ""},
      {"cheilion_right", "Ch-R", "right corner of the mouth", false, ""},
      {"alare_left", "Al-L", "outermost point of the left wing of the nose", false, ""},
      {"alare_right", "Al-R", "outermost point of the right wing of the nose", false, ""},
  };
  return kinds;
}

const LandmarkKind* find_landmark_kind(std::string_view name) {
  for (const LandmarkKind& kind : landmark_kinds()) {
    if (kind.name == name) return &kind;
  }
  return nullptr;
}

}  // namespace turgor
