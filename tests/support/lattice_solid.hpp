// Boxes of a lattice of cubes as solids of five tetrahedra each, and the networks they make.
#pragma once

#include <array>
#include <vector>

#include "turgor/tissue/network.hpp"

namespace turgor::support {

struct Lattice {
  int nx = 1, ny = 1, nz = 1;  ///< cubes
  double edge_mm = 1;
  SolidMaterial material = {};

  /// Number of a lattice point.
  [[nodiscard]] int point(int i, int j, int k) const { return (k * (ny + 1) + j) * (nx + 1) + i; }
};

inline std::vector<Vec3> lattice_points(const Lattice& l) {
  std::vector<Vec3> points;
  for (int k = 0; k <= l.nz; ++k) {
    for (int j = 0; j <= l.ny; ++j) {
      for (int i = 0; i <= l.nx; ++i) points.push_back(Vec3{1.0 * i, 1.0 * j, 1.0 * k} * l.edge_mm);
    }
  }
  return points;
}

/// The tetrahedron of the four points whose coordinates add up to even numbers, and one at each other corner.
inline void add_cube(const Lattice& l, const std::vector<Vec3>& rest, const Index3& cube,
                     std::vector<std::array<int, 4>>& tetrahedra) {
  const auto corner = [&](int c) {
    return l.point(cube[0] + (c & 1), cube[1] + ((c >> 1) & 1), cube[2] + (c >> 2));
  };
  const auto add = [&](std::array<int, 4> p) {
    if (signed_volume(rest[p[0]], rest[p[1]], rest[p[2]], rest[p[3]]) < 0) std::swap(p[2], p[3]);
    tetrahedra.push_back(p);
  };
  const int odd = (cube[0] + cube[1] + cube[2]) % 2;
  const std::array<int, 4> inner = odd == 0 ? std::array{0, 3, 5, 6} : std::array{7, 4, 2, 1};
  add({corner(inner[0]), corner(inner[1]), corner(inner[2]), corner(inner[3])});
  for (const int opposite : inner) {
    const int tip = 7 - opposite;
    add({corner(tip), corner(tip ^ 1), corner(tip ^ 2), corner(tip ^ 4)});
  }
}

inline std::vector<std::array<int, 4>> lattice_tetrahedra(const Lattice& l) {
  const std::vector<Vec3> rest = lattice_points(l);
  std::vector<std::array<int, 4>> tetrahedra;
  for (int k = 0; k < l.nz; ++k) {
    for (int j = 0; j < l.ny; ++j) {
      for (int i = 0; i < l.nx; ++i) add_cube(l, rest, {i, j, k}, tetrahedra);
    }
  }
  return tetrahedra;
}

inline SpringNetwork lattice_network(const Lattice& l) {
  SpringNetwork network;
  network.rest = lattice_points(l);
  network.mass_g.assign(network.rest.size(), 0);
  Solid solid = *make_solid(lattice_tetrahedra(l), static_cast<int>(network.rest.size()), l.edge_mm);
  const SolidStiffness stiffness = stiffness_of(l.material);
  const bool stiff = static_cast<bool>(set_stiffness(solid, network.rest, {&stiffness, 1}));
  add_mass(solid, network.rest, l.material.density_g_mm3, network.mass_g);
  if (stiff) network.solids.push_back(std::move(solid));
  return network;
}

}  // namespace turgor::support
