// What the tetrahedra of a solid carry of its elements, how fast they swing, and the cubes of a lattice that
// they make up. Internal to the module.
#pragma once

#include <array>
#include <optional>
#include <span>
#include <vector>

#include "turgor/tissue/network.hpp"

namespace turgor::detail {

/// Corners of the edges and triangles of a tetrahedron, in the order of solid_kernel.hpp.
inline constexpr int kTetraEdges[6][2] = {{0, 1}, {0, 2}, {0, 3}, {1, 2}, {2, 3}, {3, 1}};
inline constexpr int kTetraTriangles[4][3] = {{0, 1, 2}, {0, 2, 3}, {0, 3, 1}, {1, 2, 3}};

/// Parts of the constants of a tetrahedron's elements, N·mm.
struct TetraShares {
  std::array<double, 6> edge;
  std::array<double, 4> triangle;
  double volume;
};
double rest_volume(const std::array<int, 4>& tetrahedron, std::span<const Vec3> rest);
/// Of each tetrahedron: elements are shared out by volume at rest. Nothing where an edge or triangle
/// is of no tetrahedron, or named twice.
std::optional<std::vector<TetraShares>> share_out(const Solid& solid, std::span<const Vec3> rest);

/// A bound of ω² of one tetrahedron alone, at rest, its corners with the inverse masses: that of a whole
/// network whose masses are shared out to its elements is no higher than that of the fastest (Irons 1970).
double fastest_square(const std::array<int, 4>& tetrahedron, std::span<const Vec3> rest,
                      const TetraShares& shares, const std::array<double, 4>& inverse_mass);

/// Five tetrahedra of a lattice: its corner c lies at x = c & 1, y = c >> 1 & 1, z = c >> 2.
struct LatticeCube {
  int pattern;                               ///< of solid_kernel.hpp
  std::array<int, 8> point;                  ///< of each corner
  std::array<std::array<int, 4>, 5> corner;  ///< that each tetrahedron has
};
/// Nothing where the solid is not said to be a lattice, or is not one to 1e-9 of its edge.
std::optional<std::vector<LatticeCube>> cubes_of(const Solid& solid, std::span<const Vec3> rest);

/// Adds the shares of a cube's five tetrahedra to its elements, in the order of CubeElements.
void add_to_cube(const LatticeCube& cube, std::span<const TetraShares, 5> shares, std::span<double> elements);

}  // namespace turgor::detail
