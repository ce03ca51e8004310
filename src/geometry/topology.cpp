// Edges, components and neighbours of a surface.
#include <algorithm>
#include <numeric>

#include "geometry/connectivity.hpp"
#include "turgor/core/parallel.hpp"
#include "turgor/geometry/tri_mesh.hpp"

namespace turgor {
namespace {

/// Root point of each point's component (the lowest point number in it), by union of triangle corners.
std::vector<int> component_roots(const TriMesh& mesh) {
  std::vector<int> parent(mesh.points.size());
  std::iota(parent.begin(), parent.end(), 0);
  const auto find = [&](int i) {
    while (parent[static_cast<std::size_t>(i)] != i) {
      int& up = parent[static_cast<std::size_t>(i)];
      up = parent[static_cast<std::size_t>(up)];
      i = up;
    }
    return i;
  };
  for (const Index3& t : mesh.triangles) {
    for (const int other : {t[1], t[2]}) {
      const int a = find(t[0]), b = find(other);
      parent[static_cast<std::size_t>(std::max(a, b))] = std::min(a, b);
    }
  }
  for (std::size_t i = 0; i < parent.size(); ++i) parent[i] = find(static_cast<int>(i));
  return parent;
}

}  // namespace

Topology topology(const TriMesh& mesh) {
  Topology result;
  const std::vector<int> roots = component_roots(mesh);
  std::vector<bool> seen(mesh.points.size(), false);
  for (const Index3& t : mesh.triangles) {
    const auto root = static_cast<std::size_t>(roots[static_cast<std::size_t>(t[0])]);
    if (!seen[root]) ++result.components;
    seen[root] = true;
  }
  const detail::Lists edges = detail::half_edges_by_edge(mesh.points.size(), mesh.triangles);
  for (std::size_t e = 0; e < edges.size(); ++e) {
    const auto around = edges[e];
    if (around.size() == 1) {
      ++result.boundary_edges;
    } else if (around.size() > 2 || detail::corner_point(mesh.triangles, around[0]) ==
                                        detail::corner_point(mesh.triangles, around[1])) {
      ++result.non_manifold_edges;
    }
  }
  return result;
}

std::vector<int> triangle_components(const TriMesh& mesh) {
  const std::vector<int> roots = component_roots(mesh);
  std::vector<double> area(mesh.points.size(), 0);
  for (const Index3& t : mesh.triangles) {
    area[static_cast<std::size_t>(roots[static_cast<std::size_t>(t[0])])] += length(triangle_normal(mesh, t));
  }
  std::vector<bool> used(mesh.points.size(), false);
  for (const Index3& t : mesh.triangles) {
    used[static_cast<std::size_t>(roots[static_cast<std::size_t>(t[0])])] = true;
  }
  std::vector<int> order;
  for (std::size_t p = 0; p < used.size(); ++p) {
    if (used[p]) order.push_back(static_cast<int>(p));
  }
  std::stable_sort(order.begin(), order.end(), [&](int a, int b) {
    return area[static_cast<std::size_t>(a)] > area[static_cast<std::size_t>(b)];
  });
  std::vector<int> number(mesh.points.size(), -1);
  for (std::size_t i = 0; i < order.size(); ++i)
    number[static_cast<std::size_t>(order[i])] = static_cast<int>(i);
  std::vector<int> component(mesh.triangles.size());
  for (std::size_t i = 0; i < component.size(); ++i) {
    const auto point = static_cast<std::size_t>(mesh.triangles[i][0]);
    component[i] = number[static_cast<std::size_t>(roots[point])];
  }
  return component;
}

PointAdjacency point_adjacency(const TriMesh& mesh) {
  const std::size_t points = mesh.points.size();
  const detail::Lists corners = detail::corners_by_point(points, mesh.triangles);
  // Each corner contributes its two neighbours; sorted and made unique in place, then packed.
  std::vector<int> loose(corners.items.size() * 2), count(points, 0);
  parallel_for(points, 4096, [&](std::size_t begin, std::size_t end) {
    for (std::size_t p = begin; p < end; ++p) {
      const auto first = loose.begin() + 2 * static_cast<std::ptrdiff_t>(corners.offsets[p]);
      auto last = first;
      for (const int c : corners[p]) {
        *last++ = detail::corner_point(mesh.triangles, detail::next_corner(c));
        *last++ = detail::corner_point(mesh.triangles, detail::previous_corner(c));
      }
      std::sort(first, last);
      count[p] = static_cast<int>(std::unique(first, last) - first);
    }
  });
  PointAdjacency adjacency;
  adjacency.offsets.assign(points + 1, 0);
  for (std::size_t p = 0; p < points; ++p) adjacency.offsets[p + 1] = adjacency.offsets[p] + count[p];
  adjacency.neighbours.resize(static_cast<std::size_t>(adjacency.offsets[points]));
  parallel_for(points, 4096, [&](std::size_t begin, std::size_t end) {
    for (std::size_t p = begin; p < end; ++p) {
      std::copy_n(loose.begin() + 2 * static_cast<std::ptrdiff_t>(corners.offsets[p]), count[p],
                  adjacency.neighbours.begin() + adjacency.offsets[p]);
    }
  });
  return adjacency;
}

}  // namespace turgor
