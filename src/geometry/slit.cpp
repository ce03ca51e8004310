// Opening a slit in a surface along a plane.
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <unordered_map>

#include "geometry/connectivity.hpp"
#include "turgor/geometry/mesh_edit.hpp"

namespace turgor {
namespace {

using InPatch = std::function<bool(const Vec3&)>;

std::uint64_t edge_key(int a, int b) {
  const auto [low, high] = std::minmax(a, b);
  return static_cast<std::uint64_t>(high) << 32 | static_cast<std::uint32_t>(low);
}

/// A surface being slit. `side` is 0 for points on the plane within the patch, else +1 or -1.
struct Slitting {
  TriMesh mesh;
  std::vector<int> side;
  std::vector<double> height;
};

/// Whether the triangles at `point` keep their direction and some of their area when it moves to `place`, and
/// none comes to lie in the plane.
bool may_move(const Slitting& s, std::span<const int> corners, const Vec3& place) {
  for (const int c : corners) {
    const int b = detail::corner_point(s.mesh.triangles, detail::next_corner(c));
    const int d = detail::corner_point(s.mesh.triangles, detail::previous_corner(c));
    if (s.side[static_cast<std::size_t>(b)] == 0 && s.side[static_cast<std::size_t>(d)] == 0) return false;
    const Vec3 e = s.mesh.points[static_cast<std::size_t>(d)] - s.mesh.points[static_cast<std::size_t>(b)];
    const Vec3& from = s.mesh.points[static_cast<std::size_t>(detail::corner_point(s.mesh.triangles, c))];
    const Vec3 before = cross(e, from - s.mesh.points[static_cast<std::size_t>(b)]);
    const Vec3 after = cross(e, place - s.mesh.points[static_cast<std::size_t>(b)]);
    if (dot(before, after) <= 0.1 * squared_length(before)) return false;
  }
  return true;
}

/// Sides of all points; those in the patch and near the plane are moved onto it, nearest first.
Slitting snapped(const TriMesh& mesh, const Plane& plane, const InPatch& in_patch, double snap) {
  Slitting s{mesh, std::vector<int>(mesh.points.size()), std::vector<double>(mesh.points.size())};
  std::vector<int> close;
  for (std::size_t i = 0; i < mesh.points.size(); ++i) {
    s.height[i] = plane.signed_distance(mesh.points[i]);
    s.side[i] = s.height[i] > 0 ? 1 : -1;
    if (std::abs(s.height[i]) <= snap && in_patch(mesh.points[i])) close.push_back(static_cast<int>(i));
  }
  std::stable_sort(close.begin(), close.end(), [&](int a, int b) {
    return std::abs(s.height[static_cast<std::size_t>(a)]) < std::abs(s.height[static_cast<std::size_t>(b)]);
  });
  const detail::Lists corners = detail::corners_by_point(mesh.points.size(), mesh.triangles);
  for (const int point : close) {
    const auto i = static_cast<std::size_t>(point);
    const Vec3 place = s.mesh.points[i] - plane.normal * s.height[i];
    if (!may_move(s, corners[i], place)) continue;
    s.mesh.points[i] = place;
    s.height[i] = 0;
    s.side[i] = 0;
  }
  return s;
}

/// Cuts triangles along the plane within the patch. Each edge that crosses it there gets a point; a triangle
/// of which only one edge does is parted towards the opposite corner, so the surface stays whole at the ends
/// of the cut.
class Splitter {
 public:
  Splitter(Slitting& s, const InPatch& in_patch) : s_(s), in_patch_(in_patch) {}

  void run() {
    std::vector<Index3> triangles;
    triangles.reserve(s_.mesh.triangles.size() + 64);
    for (const Index3& t : s_.mesh.triangles) split(t, triangles);
    s_.mesh.triangles = std::move(triangles);
  }

 private:
  /// Number of the point where edge ab crosses the plane, or -1 where it does not or not in the patch.
  int cut(int a, int b) {
    const auto i = static_cast<std::size_t>(std::min(a, b)), j = static_cast<std::size_t>(std::max(a, b));
    if (s_.side[i] * s_.side[j] >= 0) return -1;
    const auto [entry, is_new] = cuts_.try_emplace(edge_key(a, b), -1);
    if (is_new) {
      const double t = std::clamp(s_.height[i] / (s_.height[i] - s_.height[j]), 0.0, 1.0);
      const Vec3 place = lerp(s_.mesh.points[i], s_.mesh.points[j], t);
      if (in_patch_(place)) {
        entry->second = static_cast<int>(s_.mesh.points.size());
        s_.mesh.points.push_back(place);
        s_.side.push_back(0);
        s_.height.push_back(0);
      }
    }
    return entry->second;
  }

  void split(const Index3& t, std::vector<Index3>& out) {
    const std::array<int, 3> cuts{cut(t[0], t[1]), cut(t[1], t[2]), cut(t[2], t[0])};
    const auto count = std::count_if(cuts.begin(), cuts.end(), [](int c) { return c >= 0; });
    if (count == 0) {
      out.push_back(t);
      return;
    }
    for (std::size_t k = 0; k < 3; ++k) {
      const int a = t[k], b = t[(k + 1) % 3], c = t[(k + 2) % 3], ab = cuts[k], ca = cuts[(k + 2) % 3];
      if (count == 1 && ab >= 0) {
        out.push_back({a, ab, c});
        out.push_back({ab, b, c});
        return;
      }
      if (count == 2 && ab >= 0 && ca >= 0) {
        out.push_back({a, ab, ca});
        if (span(ab, c) <= span(b, ca)) {
          out.push_back({ab, b, c});
          out.push_back({ab, c, ca});
        } else {
          out.push_back({ab, b, ca});
          out.push_back({b, c, ca});
        }
        return;
      }
    }
  }
  [[nodiscard]] double span(int a, int b) const {
    return squared_length(s_.mesh.points[static_cast<std::size_t>(a)] -
                          s_.mesh.points[static_cast<std::size_t>(b)]);
  }

  Slitting& s_;
  const InPatch& in_patch_;
  std::unordered_map<std::uint64_t, int> cuts_;
};

/// +1 or -1 for a triangle on one side of the plane, 0 for one that the plane crosses outside the patch. A
/// triangle wholly in the plane goes with the negative side.
std::vector<int> triangle_sides(const Slitting& s) {
  std::vector<int> sides(s.mesh.triangles.size());
  for (std::size_t i = 0; i < sides.size(); ++i) {
    int above = 0, below = 0;
    for (const int p : s.mesh.triangles[i]) {
      above += s.side[static_cast<std::size_t>(p)] > 0 ? 1 : 0;
      below += s.side[static_cast<std::size_t>(p)] < 0 ? 1 : 0;
    }
    sides[i] = above > 0 && below > 0 ? 0 : above > 0 ? 1 : -1;
  }
  return sides;
}

/// Marks the half-edges that lie in the plane between a triangle above and one below.
std::vector<bool> slit_half_edges(const Slitting& s, const std::vector<int>& sides) {
  std::vector<bool> slit(s.mesh.triangles.size() * 3, false);
  const detail::Lists edges = detail::half_edges_by_edge(s.mesh.points.size(), s.mesh.triangles);
  for (std::size_t e = 0; e < edges.size(); ++e) {
    const auto around = edges[e];
    if (around.size() != 2) continue;
    const int a = detail::corner_point(s.mesh.triangles, around[0]);
    const int b = detail::corner_point(s.mesh.triangles, detail::next_corner(around[0]));
    if (s.side[static_cast<std::size_t>(a)] != 0 || s.side[static_cast<std::size_t>(b)] != 0) continue;
    const int product =
        sides[static_cast<std::size_t>(around[0] / 3)] * sides[static_cast<std::size_t>(around[1] / 3)];
    if (product < 0)
      slit[static_cast<std::size_t>(around[0])] = slit[static_cast<std::size_t>(around[1])] = true;
  }
  return slit;
}

/// The corners at one point in sectors: those joined by edges that are not slit. Returns a sector for each
/// corner.
std::vector<int> sectors_at(const TriMesh& mesh, const std::vector<bool>& slit, std::span<const int> corners,
                            int& count) {
  std::vector<int> sector(corners.size(), -1);
  count = 0;
  std::vector<std::size_t> open;
  for (std::size_t seed = 0; seed < corners.size(); ++seed) {
    if (sector[seed] >= 0) continue;
    sector[seed] = count;
    open.push_back(seed);
    while (!open.empty()) {
      const int c = corners[open.back()];
      open.pop_back();
      // Neighbours share the edge to the next or to the previous point.
      for (const bool forward : {true, false}) {
        const int across = forward ? detail::next_corner(c) : detail::previous_corner(c);
        const int half_edge = forward ? c : across;
        if (slit[static_cast<std::size_t>(half_edge)]) continue;
        const int far = detail::corner_point(mesh.triangles, across);
        for (std::size_t j = 0; j < corners.size(); ++j) {
          if (sector[j] >= 0) continue;
          const int d = forward ? detail::previous_corner(corners[j]) : detail::next_corner(corners[j]);
          if (detail::corner_point(mesh.triangles, d) != far) continue;
          sector[j] = count;
          open.push_back(j);
        }
      }
    }
    ++count;
  }
  return sector;
}

/// Doubles the points of the slit that part the triangles around them: the positive side keeps the point.
void open_slit(Slitting& s, std::vector<int>& rim, std::vector<int>& twin) {
  const std::vector<int> sides = triangle_sides(s);
  const std::vector<bool> slit = slit_half_edges(s, sides);
  const detail::Lists corners = detail::corners_by_point(s.mesh.points.size(), s.mesh.triangles);
  const std::size_t points = s.mesh.points.size();
  rim.assign(points, 0);
  twin.assign(points, -1);
  const TriMesh whole = s.mesh;
  for (std::size_t p = 0; p < points; ++p) {
    if (s.side[p] != 0) continue;
    const auto around = corners[p];
    int count = 0;
    const std::vector<int> sector = sectors_at(whole, slit, around, count);
    if (count < 2) continue;
    // A sector belongs to the side of its triangles along the slit.
    std::vector<int> balance(static_cast<std::size_t>(count), 0);
    for (std::size_t i = 0; i < around.size(); ++i) {
      const bool on_slit = slit[static_cast<std::size_t>(around[i])] ||
                           slit[static_cast<std::size_t>(detail::previous_corner(around[i]))];
      if (on_slit)
        balance[static_cast<std::size_t>(sector[i])] += sides[static_cast<std::size_t>(around[i] / 3)];
    }
    const auto below = [&](int which) { return balance[static_cast<std::size_t>(which)] < 0; };
    const auto lower = std::count_if(balance.begin(), balance.end(), [](int b) { return b < 0; });
    if (lower == 0 || lower == count) continue;
    const int copy = static_cast<int>(s.mesh.points.size());
    s.mesh.points.push_back(Vec3(whole.points[p]));
    for (std::size_t i = 0; i < around.size(); ++i) {
      if (!below(sector[i])) continue;
      s.mesh.triangles[static_cast<std::size_t>(around[i] / 3)][static_cast<std::size_t>(around[i] % 3)] =
          copy;
    }
    rim[p] = 1, twin[p] = copy;
    rim.push_back(-1), twin.push_back(static_cast<int>(p));
  }
}

}  // namespace

TriMesh cut_slit(const TriMesh& mesh, const Plane& plane, const InPatch& in_patch, double snap_mm,
                 std::vector<int>* side_of_point, std::vector<int>* twin) {
  Slitting s = snapped(mesh, plane, in_patch, std::max(snap_mm, 0.0));
  Splitter(s, in_patch).run();
  std::vector<int> rim, other;
  open_slit(s, rim, other);
  if (side_of_point) *side_of_point = std::move(rim);
  if (twin) *twin = std::move(other);
  return std::move(s.mesh);
}

}  // namespace turgor
