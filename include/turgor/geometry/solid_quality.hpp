// How well shaped the tetrahedra of a solid are.
#pragma once

#include <array>
#include <span>

#include "turgor/math/vec.hpp"

namespace turgor {

/// Of the regular tetrahedron: 70.53° and a ratio of 1. Slivers have angles near 0° or 180°, and a ratio near
/// 0.
struct SolidQuality {
  double least_volume = 0;        ///< mm³, signed; with none of them, zeros throughout
  double volume = 0;              ///< mm³, all together
  double least_dihedral_deg = 0;  ///< angle between two faces of one tetrahedron
  double greatest_dihedral_deg = 0;
  double least_radius_ratio = 0;  ///< thrice the inscribed by the circumscribed sphere's radius
  double mean_radius_ratio = 0;
};

/// The same bits for any number of threads. Indices must be valid. Flat tetrahedra have a ratio of 0.
SolidQuality solid_quality(std::span<const Vec3> points, std::span<const std::array<int, 4>> tetrahedra);

}  // namespace turgor
