// Cutting a surface with a plane and closing the section.
#include <algorithm>
#include <cstdint>
#include <unordered_map>

#include "geometry/connectivity.hpp"
#include "geometry/planar_fill.hpp"
#include "turgor/geometry/mesh_edit.hpp"

namespace turgor {
namespace {

/// The kept part as it grows, with a flag for points on the plane.
struct Part {
  TriMesh mesh;
  std::vector<bool> on_plane;

  int add(const Vec3& p, bool on) {
    mesh.points.push_back(p);
    on_plane.push_back(on);
    return static_cast<int>(mesh.points.size()) - 1;
  }
};

/// Cuts triangles at the plane. `side` is +1, 0 or -1 for each point of the surface.
Part positive_part(const TriMesh& mesh, const Plane& plane, double snap) {
  Part part;
  std::vector<int> side(mesh.points.size()), map(mesh.points.size(), -1);
  std::vector<double> height(mesh.points.size());
  for (std::size_t i = 0; i < side.size(); ++i) {
    height[i] = plane.signed_distance(mesh.points[i]);
    side[i] = height[i] > snap ? 1 : height[i] < -snap ? -1 : 0;
    if (side[i] > 0) map[i] = part.add(mesh.points[i], false);
    if (side[i] == 0) map[i] = part.add(mesh.points[i] - plane.normal * height[i], true);
  }
  std::unordered_map<std::uint64_t, int> cuts;
  const auto cut = [&](int a, int b) {
    const auto [low, high] = std::minmax(a, b);
    const auto [entry, is_new] =
        cuts.try_emplace(static_cast<std::uint64_t>(high) << 32 | static_cast<std::uint32_t>(low), 0);
    if (is_new) {
      const auto i = static_cast<std::size_t>(low), j = static_cast<std::size_t>(high);
      entry->second =
          part.add(lerp(mesh.points[i], mesh.points[j], height[i] / (height[i] - height[j])), true);
    }
    return entry->second;
  };
  for (const Index3& t : mesh.triangles) {
    int polygon[4], corners = 0;
    bool positive = false;
    for (std::size_t k = 0; k < 3; ++k) {
      const auto a = static_cast<std::size_t>(t[k]), b = static_cast<std::size_t>(t[(k + 1) % 3]);
      positive = positive || side[a] > 0;
      if (side[a] >= 0 && corners < 4) polygon[corners++] = map[a];
      if (side[a] * side[b] < 0 && corners < 4) polygon[corners++] = cut(t[k], t[(k + 1) % 3]);
    }
    if (!positive || corners < 3) continue;
    const auto at = [&](int i) { return part.mesh.points[static_cast<std::size_t>(polygon[i])]; };
    // A quadrilateral is parted by its shorter diagonal.
    if (corners == 4 && squared_length(at(1) - at(3)) < squared_length(at(0) - at(2))) {
      std::rotate(polygon, polygon + 1, polygon + 4);
    }
    part.mesh.triangles.push_back({polygon[0], polygon[1], polygon[2]});
    if (corners == 4) part.mesh.triangles.push_back({polygon[0], polygon[2], polygon[3]});
  }
  return part;
}

/// Edges in the plane, each with how often it runs from its smaller to its larger point, less the other way.
struct PlaneEdge {
  int low, high, excess;
};
std::vector<PlaneEdge> plane_edges(const Part& part) {
  std::vector<PlaneEdge> edges;
  for (const Index3& t : part.mesh.triangles) {
    for (std::size_t k = 0; k < 3; ++k) {
      const int a = t[k], b = t[(k + 1) % 3];
      if (!part.on_plane[static_cast<std::size_t>(a)] || !part.on_plane[static_cast<std::size_t>(b)])
        continue;
      edges.push_back({std::min(a, b), std::max(a, b), a < b ? 1 : -1});
    }
  }
  std::stable_sort(edges.begin(), edges.end(), [](const PlaneEdge& a, const PlaneEdge& b) {
    return a.low != b.low ? a.low < b.low : a.high < b.high;
  });
  std::size_t count = 0;
  for (const PlaneEdge& e : edges) {
    if (count > 0 && edges[count - 1].low == e.low && edges[count - 1].high == e.high) {
      edges[count - 1].excess += e.excess;
    } else {
      edges[count++] = e;
    }
  }
  edges.resize(count);
  return edges;
}

/// Triangles over the section, facing against the plane's normal; in the part's point numbers.
std::vector<Index3> section_triangles(const Part& part, const Plane& plane,
                                      const std::vector<PlaneEdge>& edges) {
  // The cap runs along each open edge against the triangle that is there.
  std::vector<detail::DirectedEdge> open;
  std::vector<int> local(part.mesh.points.size(), -1), global;
  const Vec3 x = any_orthogonal(plane.normal), y = cross(x, plane.normal);
  std::vector<detail::Vec2> points;
  const auto number = [&](int p) {
    int& n = local[static_cast<std::size_t>(p)];
    if (n < 0) {
      n = static_cast<int>(global.size());
      global.push_back(p);
      const Vec3& q = part.mesh.points[static_cast<std::size_t>(p)];
      points.push_back({dot(q, x), dot(q, y)});
    }
    return n;
  };
  for (const PlaneEdge& e : edges) {
    for (int i = 0; i < std::abs(e.excess); ++i) {
      if (e.excess > 0) {
        open.push_back({number(e.high), number(e.low)});
      } else {
        open.push_back({number(e.low), number(e.high)});
      }
    }
  }
  std::vector<Index3> triangles = detail::fill_loops(points, detail::trace_loops(points, open));
  for (Index3& t : triangles) {
    for (int& p : t) p = global[static_cast<std::size_t>(p)];
  }
  return triangles;
}

}  // namespace

TriMesh clip(const TriMesh& mesh, const Plane& plane, bool cap, double snap_mm) {
  Part part = positive_part(mesh, plane, std::max(snap_mm, 0.0));
  if (cap) {
    const std::vector<PlaneEdge> edges = plane_edges(part);
    const std::vector<Index3> section = section_triangles(part, plane, edges);
    part.mesh.triangles.insert(part.mesh.triangles.end(), section.begin(), section.end());
    // A ridge that only touches the plane already has its two triangles: the cap must not join it there.
    const bool ridges =
        std::any_of(edges.begin(), edges.end(), [](const PlaneEdge& e) { return e.excess == 0; });
    if (ridges && topology(part.mesh).non_manifold_edges > 0)
      part.mesh = detail::separated_sheets(std::move(part.mesh));
  }
  return detail::without_unused_points(std::move(part.mesh));
}

}  // namespace turgor
