// Making a surface manifold by taking apart the sheets that meet in an edge or a point.
#include <algorithm>
#include <cmath>
#include <numeric>

#include "geometry/connectivity.hpp"

namespace turgor::detail {
namespace {

/// Removes pairs of triangles over the same three points with opposite orientation.
void cancel_facing_pairs(std::vector<Index3>& triangles) {
  struct Key {
    Index3 sorted;
    bool even;
    std::size_t triangle;
  };
  std::vector<Key> keys(triangles.size());
  for (std::size_t i = 0; i < triangles.size(); ++i) {
    Index3 t = triangles[i];
    int swaps = 0;
    for (const auto& [a, b] : {std::pair<std::size_t, std::size_t>{0, 1}, {1, 2}, {0, 1}}) {
      if (t[a] > t[b]) std::swap(t[a], t[b]), ++swaps;
    }
    keys[i] = {t, swaps % 2 == 0, i};
  }
  std::sort(keys.begin(), keys.end(), [](const Key& a, const Key& b) {
    return a.sorted != b.sorted ? a.sorted < b.sorted : a.triangle < b.triangle;
  });
  std::vector<bool> drop(triangles.size(), false);
  for (std::size_t i = 0; i < keys.size();) {
    std::size_t end = i + 1;
    while (end < keys.size() && keys[end].sorted == keys[i].sorted) ++end;
    for (const bool even : {true, false}) {
      // As many of this orientation go as there are of the other.
      auto others = std::count_if(keys.begin() + static_cast<std::ptrdiff_t>(i),
                                  keys.begin() + static_cast<std::ptrdiff_t>(end),
                                  [even](const Key& k) { return k.even != even; });
      for (std::size_t j = i; j < end && others > 0; ++j) {
        if (keys[j].even == even) drop[keys[j].triangle] = true, --others;
      }
    }
    i = end;
  }
  std::size_t kept = 0;
  for (std::size_t i = 0; i < triangles.size(); ++i) {
    if (!drop[i]) triangles[kept++] = triangles[i];
  }
  triangles.resize(kept);
}

struct Wing {
  double angle;
  int half_edge;
  bool forward;
};

/// Where several sheets meet in one edge: the triangles sorted by angle about it.
std::vector<Wing> wings_about(const TriMesh& mesh, std::span<const int> half_edges) {
  const auto point = [&](int corner) {
    return mesh.points[static_cast<std::size_t>(corner_point(mesh.triangles, corner))];
  };
  const Vec3 origin = point(half_edges[0]);
  const Vec3 axis = normalized(point(next_corner(half_edges[0])) - origin);
  const Vec3 x = length(axis) > 0 ? any_orthogonal(axis) : Vec3{1, 0, 0};
  const Vec3 y = cross(axis, x);
  const int start = corner_point(mesh.triangles, half_edges[0]);
  std::vector<Wing> wings;
  for (const int h : half_edges) {
    const Vec3 d = point(previous_corner(h)) - origin;
    wings.push_back({std::atan2(dot(d, y), dot(d, x)), h, corner_point(mesh.triangles, h) == start});
  }
  std::stable_sort(wings.begin(), wings.end(),
                   [](const Wing& a, const Wing& b) { return a.angle < b.angle; });
  return wings;
}

/// Joins each backward wing with the next forward one anticlockwise: between them lies solid, since a forward
/// triangle's normal points on anticlockwise. So bodies that touch come apart and none is cut.
void pair_wings(const std::vector<Wing>& wings, std::vector<int>& partner) {
  const std::size_t n = wings.size();
  std::vector<bool> used(n, false);
  for (bool progress = true; progress;) {
    progress = false;
    for (std::size_t i = 0; i < n; ++i) {
      if (used[i] || wings[i].forward) continue;
      std::size_t j = (i + 1) % n;
      while (j != i && used[j]) j = (j + 1) % n;
      if (j == i || !wings[j].forward) continue;
      used[i] = used[j] = progress = true;
      partner[static_cast<std::size_t>(wings[i].half_edge)] = wings[j].half_edge;
      partner[static_cast<std::size_t>(wings[j].half_edge)] = wings[i].half_edge;
    }
  }
}

/// Partner of each half-edge across its edge, or -1.
std::vector<int> pair_half_edges(const TriMesh& mesh, const Lists& edges) {
  std::vector<int> partner(mesh.triangles.size() * 3, -1);
  for (std::size_t e = 0; e < edges.size(); ++e) {
    const auto around = edges[e];
    if (around.size() > 2) {
      pair_wings(wings_about(mesh, around), partner);
    } else if (around.size() == 2 &&
               corner_point(mesh.triangles, around[0]) != corner_point(mesh.triangles, around[1])) {
      partner[static_cast<std::size_t>(around[0])] = around[1];
      partner[static_cast<std::size_t>(around[1])] = around[0];
    }
  }
  return partner;
}

int find_root(std::vector<int>& parent, int i) {
  while (parent[static_cast<std::size_t>(i)] != i) {
    parent[static_cast<std::size_t>(i)] =
        parent[static_cast<std::size_t>(parent[static_cast<std::size_t>(i)])];
    i = parent[static_cast<std::size_t>(i)];
  }
  return i;
}

void join(std::vector<int>& parent, int a, int b) {
  a = find_root(parent, a), b = find_root(parent, b);
  parent[static_cast<std::size_t>(std::max(a, b))] = std::min(a, b);
}

/// Gives each class of joined corners a point of its own; the first keeps the old one.
void double_points(TriMesh& mesh, const std::vector<int>& partner, std::vector<int>& origin) {
  std::vector<int> parent(mesh.triangles.size() * 3);
  std::iota(parent.begin(), parent.end(), 0);
  for (std::size_t h = 0; h < partner.size(); ++h) {
    const int other = partner[h], self = static_cast<int>(h);
    if (other < self) continue;
    join(parent, self, next_corner(other));
    join(parent, next_corner(self), other);
  }
  std::vector<int> point_of_class(parent.size(), -1);
  std::vector<bool> taken(mesh.points.size(), false);
  std::vector<Index3> renumbered = mesh.triangles;
  for (std::size_t c = 0; c < parent.size(); ++c) {
    int& point = point_of_class[static_cast<std::size_t>(find_root(parent, static_cast<int>(c)))];
    if (point < 0) {
      const int old = corner_point(mesh.triangles, static_cast<int>(c));
      point = old;
      if (taken[static_cast<std::size_t>(old)]) {
        point = static_cast<int>(mesh.points.size());
        mesh.points.push_back(Vec3(mesh.points[static_cast<std::size_t>(old)]));
        origin.push_back(old);
      }
      taken[static_cast<std::size_t>(old)] = true;
    }
    renumbered[c / 3][c % 3] = point;
  }
  mesh.triangles = std::move(renumbered);
}

/// Where one fan passes twice through the same edge, doubling points cannot part the two passages: all but
/// the first get a new point in the middle of the edge. Returns whether anything was done.
bool part_double_edges(TriMesh& mesh, std::vector<int>& origin) {
  const Lists edges = half_edges_by_edge(mesh.points.size(), mesh.triangles);
  const std::vector<int> partner = pair_half_edges(mesh, edges);
  std::vector<bool> touched(mesh.triangles.size(), false);
  bool done = false;
  for (std::size_t e = 0; e < edges.size(); ++e) {
    const auto around = edges[e];
    const int first_partner = partner[static_cast<std::size_t>(around[0])];
    if (around.size() < 2 || (around.size() == 2 && first_partner == around[1])) continue;
    done = true;
    for (const int h : around.subspan(1)) {
      const int other = partner[static_cast<std::size_t>(h)];
      const auto triangle = static_cast<std::size_t>(h / 3);
      const auto opposite = static_cast<std::size_t>((other < 0 ? h : other) / 3);
      // A triangle changed already in this round has its turn in the next.
      if (h == first_partner || touched[triangle] || touched[opposite]) continue;
      const int a = corner_point(mesh.triangles, h), b = corner_point(mesh.triangles, next_corner(h));
      const int middle = static_cast<int>(mesh.points.size());
      mesh.points.push_back(
          (mesh.points[static_cast<std::size_t>(a)] + mesh.points[static_cast<std::size_t>(b)]) * 0.5);
      origin.push_back(a);
      for (const int side : {h, other}) {
        if (side < 0) continue;
        Index3& t = mesh.triangles[static_cast<std::size_t>(side / 3)];
        const auto k = static_cast<std::size_t>(next_corner(side) % 3);
        Index3 rest = t;
        t[k] = middle;
        rest[static_cast<std::size_t>(side % 3)] = middle;
        touched[static_cast<std::size_t>(side / 3)] = true;
        mesh.triangles.push_back(rest);
      }
    }
  }
  return done;
}

}  // namespace

TriMesh separated_sheets(TriMesh mesh, std::vector<int>* origin) {
  cancel_facing_pairs(mesh.triangles);
  std::vector<int> from(mesh.points.size());
  std::iota(from.begin(), from.end(), 0);
  double_points(mesh, pair_half_edges(mesh, half_edges_by_edge(mesh.points.size(), mesh.triangles)), from);
  while (part_double_edges(mesh, from)) {
  }
  if (origin) *origin = std::move(from);
  return mesh;
}

}  // namespace turgor::detail
