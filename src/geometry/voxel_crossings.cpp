#include "geometry/voxel_crossings.hpp"

#include <atomic>

#include "turgor/core/parallel.hpp"

namespace turgor::detail {
namespace {

constexpr std::size_t kGrain = 1024;

// Both may come in any order: the bits do not depend on which thread was first.
void join(std::uint64_t& word, std::uint64_t bits) {
  const std::atomic_ref<std::uint64_t> shared(word);
  if ((shared.load(std::memory_order_relaxed) & bits) != bits)
    shared.fetch_or(bits, std::memory_order_relaxed);
}
void turn(std::uint64_t& word, std::uint64_t bits) {
  std::atomic_ref<std::uint64_t>(word).fetch_xor(bits, std::memory_order_relaxed);
}

template <int axis>
void cross(const Lattice& lattice, const Index3& triangle, const VoxelGrid& grid, CrossedLinks& links) {
  const LineCrossings<axis> crossings(lattice);
  crossings(triangle, [&](const Index3& at, bool) {
    const std::size_t word = grid.row_offset(at[1], at[2]) + static_cast<std::size_t>(at[0] / 64);
    const std::uint64_t bit = std::uint64_t{1} << (at[0] % 64);
    join(links.any[axis][word], bit);
    turn(links.odd[axis][word], bit);
  });
}

/// Sets voxels of one row from the one that holds coordinate `from` to the one that holds `to`.
void set_span(VoxelGrid& grid, int j, int k, int from, int to) {
  std::uint64_t* row = grid.row(j, k);
  for (int word = from / 64; word <= to / 64; ++word) {
    std::uint64_t bits = ~std::uint64_t{0};
    if (word == from / 64) bits &= ~std::uint64_t{0} << (from % 64);
    if (word == to / 64) bits &= ~std::uint64_t{0} >> (63 - to % 64);
    join(row[word], bits);
  }
}

/// A triangle cut to a slab has up to five corners.
struct Polygon {
  std::array<Vec3, 8> corners;
  int count = 0;
  void add(const Vec3& p) { corners[static_cast<std::size_t>(count++)] = p; }
  [[nodiscard]] const Vec3& operator[](int i) const { return corners[static_cast<std::size_t>(i)]; }
};

Vec3 cut(const Vec3& p, const Vec3& q, int axis, double at) {
  return lerp(p, q, (at - p[axis]) / (q[axis] - p[axis]));
}

/// Sutherland and Hodgman (1974) against one side of a slab: sign * (coordinate - at) ≥ 0 stays.
Polygon clipped(const Polygon& from, int axis, double at, double sign) {
  Polygon to;
  for (int i = 0; i < from.count; ++i) {
    const Vec3 &p = from[i], &q = from[i + 1 == from.count ? 0 : i + 1];
    const bool p_in = sign * (p[axis] - at) >= 0, q_in = sign * (q[axis] - at) >= 0;
    if (p_in) to.add(p);
    if (p_in != q_in) to.add(cut(p, q, axis, at));
  }
  return to;
}

/// Marks the voxels of slab k that the polygon, which lies in it, touches: row by row from its least to its
/// greatest x there. What is convex touches all voxels between.
void touch_slab(const Polygon& polygon, int k, VoxelGrid& grid) {
  Box3 box;
  for (int i = 0; i < polygon.count; ++i) box.extend(polygon[i]);
  const int first = static_cast<int>(box.lower.y), last = static_cast<int>(box.upper.y);
  if (first == last) {
    set_span(grid, first, k, static_cast<int>(box.lower.x), static_cast<int>(box.upper.x));
    return;
  }
  for (int j = first; j <= last; ++j) {
    double from = box.upper.x, to = box.lower.x;
    const auto reach = [&](double x) { from = std::min(from, x), to = std::max(to, x); };
    for (int i = 0; i < polygon.count; ++i) {
      const Vec3 &p = polygon[i], &q = polygon[i + 1 == polygon.count ? 0 : i + 1];
      if (p.y >= j && p.y <= j + 1) reach(p.x);
      if ((p.y < j) != (q.y < j)) reach(cut(p, q, 1, j).x);
      if ((p.y < j + 1) != (q.y < j + 1)) reach(cut(p, q, 1, j + 1).x);
    }
    if (from <= to) set_span(grid, j, k, static_cast<int>(from), static_cast<int>(to));
  }
}

void touch(const Lattice& lattice, const Index3& t, VoxelGrid& grid) {
  const LatticePoint &a = lattice.point(t[0]), &b = lattice.point(t[1]), &c = lattice.point(t[2]);
  LatticePoint low, high;
  for (std::size_t x = 0; x < 3; ++x) {
    low[x] = std::min({a[x], b[x], c[x]}) >> lattice.shift;
    high[x] = std::max({a[x], b[x], c[x]}) >> lattice.shift;
  }
  if (low[1] == high[1] && low[2] == high[2]) {
    set_span(grid, low[1], low[2], low[0], high[0]);
    return;
  }
  const double unit = std::ldexp(1, -lattice.shift);
  Polygon whole;
  for (const LatticePoint* p : {&a, &b, &c}) whole.add({(*p)[0] * unit, (*p)[1] * unit, (*p)[2] * unit});
  // What lies above each slab is cut further.
  for (int k = low[2]; k < high[2]; ++k) {
    const Polygon slab = clipped(whole, 2, k + 1, -1);
    if (slab.count > 0) touch_slab(slab, k, grid);
    whole = clipped(whole, 2, k + 1, 1);
  }
  if (whole.count > 0) touch_slab(whole, high[2], grid);
}

}  // namespace

void add_crossings(const Lattice& lattice, const std::vector<Index3>& triangles, const VoxelGrid& grid,
                   CrossedLinks& links) {
  for (std::size_t a = 0; a < 3; ++a)
    links.any[a].resize(grid.bits.size()), links.odd[a].resize(grid.bits.size());
  parallel_for(triangles.size(), kGrain, [&](std::size_t begin, std::size_t end) {
    for (std::size_t t = begin; t < end; ++t) {
      cross<0>(lattice, triangles[t], grid, links);
      cross<1>(lattice, triangles[t], grid, links);
      cross<2>(lattice, triangles[t], grid, links);
    }
  });
}

void add_touched(const Lattice& lattice, VoxelGrid& grid) {
  parallel_for(lattice.triangles.size(), kGrain, [&](std::size_t begin, std::size_t end) {
    for (std::size_t t = begin; t < end; ++t) touch(lattice, lattice.triangles[t], grid);
  });
}

}  // namespace turgor::detail
