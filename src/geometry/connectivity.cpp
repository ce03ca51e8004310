#include "geometry/connectivity.hpp"

#include <algorithm>
#include <cstdint>

#include "turgor/core/parallel.hpp"

namespace turgor::detail {
namespace {

constexpr std::size_t grain = 16384;

/// Turns counts shifted by one place into offsets.
void accumulate_counts(std::vector<int>& counts) {
  for (std::size_t i = 1; i < counts.size(); ++i) counts[i] += counts[i - 1];
}

}  // namespace

Lists corners_by_point(std::size_t points, const std::vector<Index3>& triangles) {
  Lists lists;
  lists.offsets.assign(points + 1, 0);
  lists.items.resize(triangles.size() * 3);
  for (const Index3& t : triangles) {
    for (const int p : t) ++lists.offsets[static_cast<std::size_t>(p) + 1];
  }
  accumulate_counts(lists.offsets);
  std::vector<int> next(lists.offsets.begin(), lists.offsets.end() - 1);
  int corner = 0;
  for (const Index3& t : triangles) {
    for (const int p : t)
      lists.items[static_cast<std::size_t>(next[static_cast<std::size_t>(p)]++)] = corner++;
  }
  return lists;
}

Lists half_edges_by_edge(std::size_t points, const std::vector<Index3>& triangles) {
  // Buckets by the smaller point, each sorted by (larger point, half-edge).
  std::vector<int> start(points + 1, 0);
  for (const Index3& t : triangles) {
    for (std::size_t k = 0; k < 3; ++k) ++start[static_cast<std::size_t>(std::min(t[k], t[(k + 1) % 3])) + 1];
  }
  accumulate_counts(start);
  std::vector<std::uint64_t> keys(triangles.size() * 3);
  {
    std::vector<int> next(start.begin(), start.end() - 1);
    std::uint32_t half_edge = 0;
    for (const Index3& t : triangles) {
      for (std::size_t k = 0; k < 3; ++k) {
        const auto [low, high] = std::minmax(t[k], t[(k + 1) % 3]);
        const auto slot = static_cast<std::size_t>(next[static_cast<std::size_t>(low)]++);
        keys[slot] = static_cast<std::uint64_t>(high) << 32 | half_edge++;
      }
    }
  }
  parallel_for(points, grain, [&](std::size_t begin, std::size_t end) {
    for (std::size_t p = begin; p < end; ++p) std::sort(keys.begin() + start[p], keys.begin() + start[p + 1]);
  });
  Lists edges;
  edges.items.resize(keys.size());
  edges.offsets.reserve(keys.size() / 2 + 2);
  edges.offsets.push_back(0);
  for (std::size_t p = 0; p < points; ++p) {
    for (int i = start[p]; i < start[p + 1]; ++i) {
      const std::uint64_t key = keys[static_cast<std::size_t>(i)];
      edges.items[static_cast<std::size_t>(i)] = static_cast<int>(key & 0xffffffffU);
      const bool last = i + 1 == start[p + 1] || keys[static_cast<std::size_t>(i) + 1] >> 32 != key >> 32;
      if (last) edges.offsets.push_back(i + 1);
    }
  }
  return edges;
}

TriMesh without_unused_points(TriMesh mesh) {
  std::vector<int> map(mesh.points.size(), -1);
  for (const Index3& t : mesh.triangles) {
    for (const int p : t) map[static_cast<std::size_t>(p)] = 0;
  }
  int count = 0;
  for (std::size_t p = 0; p < map.size(); ++p) {
    if (map[p] < 0) continue;
    mesh.points[static_cast<std::size_t>(count)] = mesh.points[p];
    map[p] = count++;
  }
  mesh.points.resize(static_cast<std::size_t>(count));
  for (Index3& t : mesh.triangles) {
    for (int& p : t) p = map[static_cast<std::size_t>(p)];
  }
  return mesh;
}

}  // namespace turgor::detail

namespace turgor {

std::vector<bool> boundary_points(const TriMesh& mesh) {
  const detail::Lists edges = detail::half_edges_by_edge(mesh.points.size(), mesh.triangles);
  std::vector<bool> boundary(mesh.points.size(), false);
  for (std::size_t e = 0; e < edges.size(); ++e) {
    if (edges[e].size() != 1) continue;
    const int h = edges[e][0];
    boundary[static_cast<std::size_t>(detail::corner_point(mesh.triangles, h))] = true;
    boundary[static_cast<std::size_t>(detail::corner_point(mesh.triangles, detail::next_corner(h)))] = true;
  }
  return boundary;
}

}  // namespace turgor
