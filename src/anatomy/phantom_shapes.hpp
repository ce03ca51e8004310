// The phantom's parts as implicit fields, in the reference pose: adult size, mean soft tissue, neutral jaw.
#pragma once

#include <vector>

#include "anatomy/implicit.hpp"

namespace turgor::phantom {

using implicit::Field;
using implicit::ShapePtr;

/// What differs between phantoms in the shapes themselves; everything else is a map of space
/// (phantom_pose.hpp).
struct Fit {
  double joint_gap = 2.2;     ///< mm between condyle and fossa
  double occlusal_gap = 1.3;  ///< mm between upper and lower teeth
};

// The frame: Frankfurt plane at z = 0, ear canals at y ≈ 3; so skin glabella lies at y ≈ −98, the vertex at z
// ≈ 128, the chin's lower edge at z ≈ −97.

/// Height of the upper teeth's edges at depth y: a plane that rises to the back.
[[nodiscard]] constexpr double occlusal_height(double y) {
  return -49.0 + 0.1 * (y + 92);
}
inline constexpr double occlusal_slope = 0.1;

inline constexpr Vec3 condyle_centre{49, -12, -3};
inline constexpr Vec3 condyle_radii{9, 4.4, 5.2};
inline constexpr Vec3 eye_centre{31.5, -72.5, 14};
inline constexpr double eye_radius = 12;

/// Outside of the brain case.
[[nodiscard]] ShapePtr cranium();
/// The space of the brain.
[[nodiscard]] ShapePtr brain_space();
[[nodiscard]] ShapePtr condyle(double grown_by);

/// The knots of one side, the first in the midplane, carried on to the other side: first the right end, last
/// the left.
template <class K, class Mirror>
std::vector<K> both_sides(const std::vector<K>& knots, const Mirror& mirror) {
  std::vector<K> out;
  for (std::size_t i = knots.size(); i-- > 1;) out.push_back(mirror(knots[i]));
  out.insert(out.end(), knots.begin(), knots.end());
  return out;
}
[[nodiscard]] inline ShapePtr bow(const std::vector<implicit::Knot>& half, int pieces = 2) {
  return implicit::sweep(both_sides(half, [](implicit::Knot k) { return k.point.x = -k.point.x, k; }),
                         pieces);
}
[[nodiscard]] inline ShapePtr bow_wall(const std::vector<implicit::WallKnot>& half, double roundness) {
  return implicit::wall(both_sides(half, [](implicit::WallKnot k) { return k.x = -k.x, k; }), roundness);
}

/// Bone around the roots of the left side's teeth.
[[nodiscard]] std::vector<ShapePtr> upper_sockets();
[[nodiscard]] std::vector<ShapePtr> lower_sockets(const Fit& fit);

[[nodiscard]] Field skull_bone(const Fit& fit);
[[nodiscard]] Field mandible_bone(const Fit& fit);
[[nodiscard]] Field upper_teeth(const Fit& fit);
[[nodiscard]] Field lower_teeth(const Fit& fit);

/// The closed outside.
[[nodiscard]] Field skin();
/// Nose, mouth, throat, sinuses, ear canals, and the slit between the lips.
[[nodiscard]] Field air_spaces();
[[nodiscard]] Field muscles();
[[nodiscard]] Field cartilage();
[[nodiscard]] Field head_holder();

}  // namespace turgor::phantom
