// Where triangles cross the grid lines through voxel centres, exactly. Internal.
#pragma once

#include <algorithm>
#include <cmath>

#include "geometry/voxel_lattice.hpp"

namespace turgor::detail {

/// The grid is taken to lie an infinitesimal aside, (e, e², e³), so that no centre lies on a triangle and no
/// grid line meets an edge (Edelsbrunner and Mücke 1990, "Simulation of simplicity"). A crossing then belongs
/// to one triangle only, and the three axes agree on every voxel.
template <int axis>
class LineCrossings {
  static constexpr std::size_t u = axis, v = (axis + 1) % 3, w = (axis + 2) % 3;

 public:
  explicit LineCrossings(const Lattice& lattice) : lattice_(lattice) {}

  /// Calls visit(voxel, forward) for every crossing of the triangle: between the centres of `voxel` and of
  /// the next along the axis; forward where the triangle faces up the axis.
  template <class Visit>
  void operator()(const Index3& t, Visit&& visit) const {
    const LatticePoint &a = lattice_.point(t[0]), &b = lattice_.point(t[1]), &c = lattice_.point(t[2]);
    const int v0 = first(std::min({a[v], b[v], c[v]})), v1 = last(std::max({a[v], b[v], c[v]}));
    if (v0 > v1) return;
    const int w0 = first(std::min({a[w], b[w], c[w]})), w1 = last(std::max({a[w], b[w], c[w]}));
    if (w0 > w1) return;
    const std::int64_t normal = product(a, b, c, v, w);
    if (normal == 0) return;
    for (int k = w0; k <= w1; ++k) {
      for (int j = v0; j <= v1; ++j) {
        const std::int64_t pv = lattice_.centre(j), pw = lattice_.centre(k);
        if (left(a, b, pv, pw) != (normal > 0) || left(b, c, pv, pw) != (normal > 0) ||
            left(c, a, pv, pw) != (normal > 0))
          continue;
        Index3 voxel{};
        voxel[u] = below(a, b, c, normal, pv, pw), voxel[v] = j, voxel[w] = k;
        visit(voxel, normal > 0);
      }
    }
  }

 private:
  /// First and last line that may meet coordinates from or to x. A line at x itself is decided by left().
  [[nodiscard]] int first(std::int32_t x) const {
    const std::int64_t unit = std::int64_t{1} << lattice_.shift;
    return static_cast<int>((x - unit / 2 + unit - 1) >> lattice_.shift);
  }
  [[nodiscard]] int last(std::int32_t x) const {
    return static_cast<int>((x - (std::int64_t{1} << (lattice_.shift - 1))) >> lattice_.shift);
  }
  static std::int64_t product(const LatticePoint& a, const LatticePoint& b, const LatticePoint& c,
                              std::size_t r, std::size_t s) {
    return std::int64_t{b[r] - a[r]} * (c[s] - a[s]) - std::int64_t{b[s] - a[s]} * (c[r] - a[r]);
  }
  /// Whether the line through (pv, pw), moved a little aside, passes left of the edge from a to b.
  static bool left(const LatticePoint& a, const LatticePoint& b, std::int64_t pv, std::int64_t pw) {
    const std::int64_t dv = std::int64_t{b[v]} - a[v], dw = std::int64_t{b[w]} - a[w];
    const std::int64_t side = dv * (pw - a[w]) - dw * (pv - a[v]);
    if (side != 0) return side > 0;
    if constexpr (axis == 1) return dv != 0 ? dv > 0 : dw < 0;  // here w is x, which moves most
    return dw != 0 ? dw < 0 : dv > 0;
  }
  /// The last voxel on the line whose centre, moved a little aside, lies below the triangle's plane.
  [[nodiscard]] int below(const LatticePoint& a, const LatticePoint& b, const LatticePoint& c,
                          std::int64_t normal, std::int64_t pv, std::int64_t pw) const {
    const std::int64_t nv = product(a, b, c, w, u), nw = product(a, b, c, u, v);
    const Wide rest = static_cast<Wide>(nv) * (pv - a[v]) + static_cast<Wide>(nw) * (pw - a[w]);
    const double rise = static_cast<double>(rest) / static_cast<double>(normal);
    const double half = std::ldexp(1, lattice_.shift - 1);
    const double place = (static_cast<double>(a[u]) - rise - half) / (2 * half);
    const double nearest = std::nearbyint(place);
    if (std::abs(place - nearest) > 1e-5) return static_cast<int>(std::floor(place));
    const int i = static_cast<int>(nearest);
    Wide side = static_cast<Wide>(normal) * (lattice_.centre(i) - a[u]) + rest;
    if (side == 0) {
      const std::array<std::int64_t, 3> n = axis == 0   ? std::array{normal, nv, nw}
                                            : axis == 1 ? std::array{nw, normal, nv}
                                                        : std::array{nv, nw, normal};
      side = n[0] != 0 ? n[0] : n[1] != 0 ? n[1] : n[2];
    }
    return (side > 0) == (normal > 0) ? i - 1 : i;
  }

  const Lattice& lattice_;
};

/// Links between neighbouring voxels, bit i of row (j, k) for the link from voxel (i, j, k) up the axis.
struct CrossedLinks {
  std::array<std::vector<std::uint64_t>, 3> any;  ///< crossed at all
  std::array<std::vector<std::uint64_t>, 3> odd;  ///< crossed an odd number of times
};

/// Adds the crossings of the triangles to links laid out as the bits of `grid`.
void add_crossings(const Lattice& lattice, const std::vector<Index3>& triangles, const VoxelGrid& grid,
                   CrossedLinks& links);

/// Sets every voxel that a triangle touches.
void add_touched(const Lattice& lattice, VoxelGrid& grid);

}  // namespace turgor::detail
