// Layered tissue over bone for tests and benchmarks: three sheets of columns (bone, SMAS, skin) on a curved
// patch.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>
#include <vector>

#include "turgor/tissue/network.hpp"

namespace turgor::support {

struct SlabOptions {
  int nx = 12, ny = 16;   ///< columns
  double spacing_mm = 3;  ///< between columns
  double layer_mm = 4;    ///< between sheets
  double radius_mm = 90;  ///< of the cylinder along y under the bone; 0: flat
  bool diagonals = true;  ///< both between any two neighbouring columns of one layer
  bool tripods =
      false;  ///< instead: from each point to two columns below, and in-sheet springs in the skin alone
  bool volumes = false;  ///< three tetrahedra per prism
  double membrane_n = 1, vertical_n = 1, diagonal_n = 0.5;
  double volume_modulus_mpa = 0.1;
  SpringLaw law = SpringLaw::linear;
  int dropped_edges = 0;  ///< edges of the triangulation left out, evenly spread
};

struct Slab {
  SpringNetwork network;
  int columns = 0;  ///< point of sheet s (0 bone, 1 SMAS, 2 skin) at column c: s · columns + c
  int nx = 0;
  [[nodiscard]] int point(int sheet, int column) const { return sheet * columns + column; }
};

inline void add_spring(SpringNetwork& net, int a, int b, double k, SpringLaw law, SpringKind kind) {
  net.springs.push_back({a, b, distance(net.rest[a], net.rest[b]), k, law, kind});
}

// Neighbouring columns share the diagonals of their common faces: each runs from the lower number up to the
// higher.
inline void add_prism(SpringNetwork& net, std::array<int, 3> low, int up, double modulus) {
  std::sort(low.begin(), low.end());
  const auto [i, j, k] = low;
  for (std::array<int, 4> t : {std::array{i, j, k, k + up}, std::array{i, j, j + up, k + up},
                               std::array{i, i + up, j + up, k + up}}) {
    double v = signed_volume(net.rest[t[0]], net.rest[t[1]], net.rest[t[2]], net.rest[t[3]]);
    if (v < 0) std::swap(t[2], t[3]), v = -v;
    net.volumes.push_back({{t[0], t[1], t[2], t[3]}, v, modulus});
  }
}

inline Slab make_slab(const SlabOptions& o) {
  Slab slab;
  slab.columns = o.nx * o.ny;
  slab.nx = o.nx;
  SpringNetwork& net = slab.network;
  for (int sheet = 0; sheet < 3; ++sheet) {
    for (int c = 0; c < slab.columns; ++c) {
      const double x = (c % o.nx - 0.5 * (o.nx - 1)) * o.spacing_mm, y = (c / o.nx) * o.spacing_mm;
      const double z = sheet * o.layer_mm, r = o.radius_mm;
      net.rest.push_back(r > 0 ? Vec3{(r + z) * std::sin(x / r), y, (r + z) * std::cos(x / r) - r}
                               : Vec3{x, y, z});
    }
  }
  net.mass_g.assign(net.rest.size(), 0.01);
  std::vector<std::pair<int, int>> edges;
  for (int c = 0; c < slab.columns; ++c) {
    const bool right = c % o.nx + 1 < o.nx, up = c / o.nx + 1 < o.ny;
    if (right) edges.emplace_back(c, c + 1);
    if (up) edges.emplace_back(c, c + o.nx);
    if (right && up) edges.emplace_back(c, c + o.nx + 1);
  }
  const int total = static_cast<int>(edges.size());
  std::vector<std::pair<int, int>> kept;
  for (int e = 0; e < total; ++e) {  // Bresenham: dropped_edges of them, evenly
    const bool dropped = (e + 1) * o.dropped_edges / total != e * o.dropped_edges / total;
    if (!dropped) kept.push_back(edges[e]);
  }
  const int n = slab.columns;
  for (int sheet = 1; sheet < 3; ++sheet) {
    for (const auto& [a, b] : kept) {
      if (o.tripods && sheet == 1) continue;
      add_spring(net, sheet * n + a, sheet * n + b, o.membrane_n, o.law, SpringKind::membrane);
      if (!o.diagonals) continue;
      add_spring(net, (sheet - 1) * n + a, sheet * n + b, o.diagonal_n, o.law, SpringKind::diagonal);
      add_spring(net, (sheet - 1) * n + b, sheet * n + a, o.diagonal_n, o.law, SpringKind::diagonal);
    }
    for (int c = 0; c < n; ++c) {
      add_spring(net, (sheet - 1) * n + c, sheet * n + c, o.vertical_n, o.law, SpringKind::vertical);
      if (!o.tripods) continue;
      const int beside = c % o.nx + 1 < o.nx ? c + 1 : c - 1, along = c + o.nx < n ? c + o.nx : c - o.nx;
      add_spring(net, (sheet - 1) * n + beside, sheet * n + c, o.diagonal_n, o.law, SpringKind::diagonal);
      add_spring(net, (sheet - 1) * n + along, sheet * n + c, o.diagonal_n, o.law, SpringKind::diagonal);
    }
  }
  for (int layer = 0; o.volumes && layer < 2; ++layer) {
    for (int c = 0; c + o.nx < n; ++c) {
      if (c % o.nx + 1 == o.nx) continue;
      const int p = layer * n + c;
      add_prism(net, {p, p + 1, p + o.nx + 1}, n, o.volume_modulus_mpa);
      add_prism(net, {p, p + o.nx, p + o.nx + 1}, n, o.volume_modulus_mpa);
    }
  }
  return slab;
}

/// The size of Duysak and Zhang's face (2005, section 4): 7,884 points in three sheets of 2,628, and 19,724
/// springs. Their count is twice the 7,234 edges of the skin (2,628 vertices, 4,606 triangles, one hole) plus
/// two springs per column: in-sheet springs in the two upper sheets, vertical ones, no diagonals. Such sheets
/// slide over the bone without any force at first order, so this network is for the chain; its equilibrium is
/// not unique.
inline SlabOptions duysak_zhang_size() {
  SlabOptions o;
  o.nx = 36;
  o.ny = 73;
  o.diagonals = false;
  o.dropped_edges = 433;
  return o;
}

/// The same counts, every point carried by a vertical spring and two diagonals, so that it has one
/// equilibrium.
inline SlabOptions duysak_zhang_size_braced() {
  SlabOptions o = duysak_zhang_size();
  o.diagonals = false;
  o.tripods = true;
  o.dropped_edges = 3711;
  return o;
}

}  // namespace turgor::support
