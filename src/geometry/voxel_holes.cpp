// Holes of a surface, and cones over them.
#include <algorithm>
#include <numeric>

#include "geometry/voxel_fill.hpp"
#include "turgor/core/index.hpp"
#include "turgor/core/parallel.hpp"
#include "turgor/geometry/polyhedron.hpp"

namespace turgor::detail {
namespace {

/// Keeps one of each edge that occurs an odd number of times in the sorted list.
void keep_odd(std::vector<Edge>& edges) {
  std::size_t kept = 0;
  for (std::size_t i = 0; i < edges.size();) {
    std::size_t end = i + 1;
    while (end < edges.size() && edges[end] == edges[i]) ++end;
    if ((end - i) % 2 == 1) edges[kept++] = edges[i];
    i = end;
  }
  edges.resize(kept);
}

/// Edges that an odd number of triangles use, by their points' numbers.
std::vector<Edge> odd_edges(const Lattice& lattice) {
  // Bucketed by the smaller point: a bucket holds about three, and is searched from end to end.
  std::vector<int> begin(lattice.points.size() + 1);
  const auto for_each = [&](auto&& visit) {
    for (const Index3& t : lattice.triangles) {
      for (std::size_t e = 0; e < 3; ++e) {
        const int a = t[e], b = t[e == 2 ? 0 : e + 1];
        if (a != b) visit(std::min(a, b), std::max(a, b));
      }
    }
  };
  for_each([&](int a, int) { ++begin[at(a) + 1]; });
  std::partial_sum(begin.begin(), begin.end(), begin.begin());
  std::vector<int> ends(at(begin.back())), next(begin.begin(), begin.end() - 1);
  for_each([&](int a, int b) { ends[at(next[at(a)]++)] = b; });
  return parallel_reduce<std::vector<Edge>>(
      lattice.points.size(), 8192, {},
      [&](std::size_t from, std::size_t to) {
        std::vector<Edge> odd;
        for (std::size_t a = from; a < to; ++a) {
          const auto first = ends.begin() + begin[a], last = ends.begin() + begin[a + 1];
          std::sort(first, last);
          for (auto i = first; i != last;) {
            const auto end = std::find_if(i, last, [&](int b) { return b != *i; });
            if ((end - i) % 2 == 1) odd.push_back({static_cast<int>(a), *i});
            i = end;
          }
        }
        return odd;
      },
      [](std::vector<Edge> all, const std::vector<Edge>& part) {
        all.insert(all.end(), part.begin(), part.end());
        return all;
      });
}

/// The ends of edges, those at one place side by side.
std::vector<int> ends_by_place(const Lattice& lattice, const std::vector<Edge>& edges) {
  std::vector<int> ends;
  for (const Edge& e : edges) ends.insert(ends.end(), e.begin(), e.end());
  std::sort(ends.begin(), ends.end(), [&](int a, int b) {
    const LatticePoint &p = lattice.point(a), &q = lattice.point(b);
    return p != q ? p < q : a < b;
  });
  ends.erase(std::unique(ends.begin(), ends.end()), ends.end());
  return ends;
}

/// The edges between places instead of numbers: what coincides cancels.
std::vector<Edge> by_place(const Lattice& lattice, std::vector<Edge> edges) {
  std::vector<int> place(lattice.points.size());
  int same = -1;
  for (const int p : ends_by_place(lattice, edges)) {
    if (same < 0 || lattice.point(p) != lattice.point(same)) same = p;
    place[at(p)] = same;
  }
  for (Edge& e : edges) {
    e = {place[at(e[0])], place[at(e[1])]};
    if (e[0] > e[1]) std::swap(e[0], e[1]);
  }
  std::erase_if(edges, [](const Edge& e) { return e[0] == e[1]; });
  std::sort(edges.begin(), edges.end());
  keep_odd(edges);
  return edges;
}

/// Which edges hang together, by disjoint sets of their points.
std::vector<std::vector<Edge>> joined(const std::vector<Edge>& edges) {
  std::vector<int> points;
  for (const Edge& e : edges) points.insert(points.end(), e.begin(), e.end());
  std::sort(points.begin(), points.end());
  points.erase(std::unique(points.begin(), points.end()), points.end());
  const auto number = [&](int p) {
    return static_cast<int>(std::lower_bound(points.begin(), points.end(), p) - points.begin());
  };
  std::vector<int> root(points.size());
  std::iota(root.begin(), root.end(), 0);
  const auto find = [&](int p) {
    while (root[at(p)] != p) p = root[at(p)] = root[at(root[at(p)])];
    return p;
  };
  for (const Edge& e : edges) root[at(find(number(e[0])))] = find(number(e[1]));
  std::vector<std::vector<Edge>> groups(points.size());
  for (const Edge& e : edges) groups[at(find(number(e[0])))].push_back(e);
  std::erase_if(groups, [](const std::vector<Edge>& group) { return group.empty(); });
  return groups;
}

double lid_area(const Hole& hole) {
  const auto from_middle = [&](const LatticePoint& p) {
    return Vec3{1.0 * p[0] - hole.middle[0], 1.0 * p[1] - hole.middle[1], 1.0 * p[2] - hole.middle[2]};
  };
  double area = 0;
  for (const auto& [a, b] : hole.edges) area += 0.5 * length(cross(from_middle(a), from_middle(b)));
  return area;
}

}  // namespace

std::vector<Hole> find_holes(const Lattice& lattice) {
  std::vector<Hole> holes;
  for (const std::vector<Edge>& group : joined(by_place(lattice, odd_edges(lattice)))) {
    Hole hole;
    hole.low = hole.high = lattice.point(group[0][0]);
    std::array<std::int64_t, 3> sum{};
    for (const Edge& e : group) {
      hole.edges.push_back({lattice.point(e[0]), lattice.point(e[1])});
      for (const LatticePoint& p : hole.edges.back()) {
        for (std::size_t a = 0; a < 3; ++a) {
          hole.low[a] = std::min(hole.low[a], p[a]), hole.high[a] = std::max(hole.high[a], p[a]);
          sum[a] += p[a];
        }
      }
    }
    for (std::size_t a = 0; a < 3; ++a)
      hole.middle[a] = static_cast<std::int32_t>(sum[a] / static_cast<std::int64_t>(2 * group.size()));
    hole.width = std::sqrt(lid_area(hole));
    holes.push_back(std::move(hole));
  }
  std::stable_sort(holes.begin(), holes.end(),
                   [](const Hole& a, const Hole& b) { return a.width > b.width; });
  return holes;
}

std::vector<std::array<int, 2>> coinciding_points(const Lattice& lattice) {
  const std::vector<int> ends = ends_by_place(lattice, odd_edges(lattice));
  std::vector<std::array<int, 2>> pairs;
  for (std::size_t i = 1; i < ends.size(); ++i) {
    if (lattice.point(ends[i - 1]) == lattice.point(ends[i])) pairs.push_back({ends[i - 1], ends[i]});
  }
  return pairs;
}

void close_hole(const Hole& hole, Lattice& lattice) {
  const auto tip = static_cast<int>(lattice.points.size());
  lattice.points.push_back(hole.middle);
  for (const auto& edge : hole.edges) {
    const auto base = static_cast<int>(lattice.points.size());
    lattice.points.insert(lattice.points.end(), edge.begin(), edge.end());
    lattice.triangles.push_back({tip, base, base + 1});
  }
}

}  // namespace turgor::detail
