// The element matrix of a cube, and those of cubes of cubes. Internal.
//
// With corners at (±1, ±1, ±1) the displacement is a sum of the modes 1, ξ, η, ξη, … ξηζ, numbered by the
// bits x 1, y 2, z 4 of the coordinates in them; their values at the corners are signs. Reflections of the
// cube leave its energy as it is, so a mode s of component c couples only with those of the same s xor
// bit(c): eight classes of three. Exchange of axes and freedom of rotation leave eight numbers:
//
//   class 0, (x ξ)(y η)(z ζ):         axial on the diagonal + axial_pair everywhere
//   class ξ, (x 1)(y ξη)(z ξζ):       bending on the diagonal of the last two + bending_pair; the first is
//   free class ξη, (x η)(y ξ)(z ξηζ):      shear times the sum of the first two; hourglass for the third
//   class ξηζ, (x ηζ)(y ξζ)(z ξη):    twist on the diagonal + twist_pair everywhere
#pragma once

#include <array>
#include <cstddef>

namespace turgor::detail {

/// By columns or rows alike, being symmetric; number 8 c + corner, corners by bits x 1, y 2, z 4.
inline constexpr int kCubeUnknowns = 24;
using CubeMatrix = std::array<double, static_cast<std::size_t>(kCubeUnknowns) * kCubeUnknowns>;

template <class T>
struct CubeModes {
  T axial, axial_pair, bending, bending_pair, shear, hourglass, twist, twist_pair;
};

/// Of the energy of a unit shear modulus and of a unit bulk modulus. The matrix of an isotropic cube is the
/// sum of them times its moduli.
struct CubeStiffness {
  CubeModes<double> shear, bulk;
};

/// The trilinear cube with mean dilatation: energy ∫ μ dev ε : dev ε + ½ K (mean tr ε)². `edge` in mm.
CubeStiffness cube_stiffness(double edge);
CubeMatrix matrix_of(const CubeModes<double>& modes);
CubeModes<double> modes_of(const CubeMatrix& matrix);
/// The coarse cube of eight such.
CubeStiffness coarsened(const CubeStiffness& stiffness);
/// coarse += Pᵀ fine P, P the trilinear interpolation from the corners of a cube to those of its child at
/// `child` (bits x 1, y 2, z 4).
void add_galerkin(const CubeMatrix& fine, int child, CubeMatrix& coarse);

}  // namespace turgor::detail
