#include "imaging/marching_table.hpp"

#include <algorithm>
#include <limits>
#include <vector>

#include "turgor/math/vec.hpp"

namespace turgor::detail {
namespace {

using Edge = int;

/// Two axes besides `axis`, lower first.
constexpr int first_other(int axis) {
  return axis == 0 ? 1 : 0;
}
constexpr int second_other(int axis) {
  return axis == 2 ? 1 : 2;
}

/// The corner at the lower (end 0) or upper (end 1) end of an edge.
int edge_corner(Edge e, int end) {
  const int axis = e / 4;
  return (e & 1) << first_other(axis) | (e >> 1 & 1) << second_other(axis) | end << axis;
}

Vec3 corner_point(int c) {
  return {double(c & 1), double(c >> 1 & 1), double(c >> 2 & 1)};
}
Vec3 edge_point(Edge e) {
  return (corner_point(edge_corner(e, 0)) + corner_point(edge_corner(e, 1))) * 0.5;
}

bool inside(int number, int corner) {
  return number >> corner & 1;
}
bool crossed(int number, Edge e) {
  return inside(number, edge_corner(e, 0)) != inside(number, edge_corner(e, 1));
}
int inside_corner(int number, Edge e) {
  return edge_corner(e, inside(number, edge_corner(e, 0)) ? 0 : 1);
}

/// Whether the edge lies on the face of the cell at `side` of `axis`.
bool on_face(Edge e, int axis, int side) {
  return e / 4 != axis && (edge_corner(e, 0) >> axis & 1) == side;
}
bool share_face(Edge a, Edge b) {
  for (int axis = 0; axis < 3; ++axis) {
    for (int side = 0; side < 2; ++side) {
      if (on_face(a, axis, side) && on_face(b, axis, side)) return true;
    }
  }
  return false;
}

/// next[e] is the crossing that follows crossing e on its loop, -1 where the edge is not crossed.
using Successors = std::array<Edge, 12>;

/// Enters the segment between two crossings of a face, the inside to its left seen from within the cell.
void join(int number, Edge a, Edge b, const Vec3& outward, Successors& next) {
  const Vec3 along = edge_point(b) - edge_point(a);
  const Vec3 inwards = corner_point(inside_corner(number, a)) - edge_point(a);
  if (dot(outward, cross(along, inwards)) < 0) {
    next[static_cast<std::size_t>(a)] = b;
  } else {
    next[static_cast<std::size_t>(b)] = a;
  }
}

void join_face(int number, int axis, int side, Successors& next) {
  std::vector<Edge> crossings;
  for (Edge e = 0; e < 12; ++e) {
    if (on_face(e, axis, side) && crossed(number, e)) crossings.push_back(e);
  }
  Vec3 outward;
  outward[axis] = side ? 1 : -1;
  if (crossings.size() == 2) join(number, crossings[0], crossings[1], outward, next);
  if (crossings.size() != 4) return;
  for (std::size_t a = 0; a < 4; ++a) {
    for (std::size_t b = a + 1; b < 4; ++b) {
      if (inside_corner(number, crossings[a]) == inside_corner(number, crossings[b])) {
        join(number, crossings[a], crossings[b], outward, next);
      }
    }
  }
}

/// The way to cut loop[first..last] into triangles that has the fewest diagonals on faces of the cell.
struct Cut {
  int face_diagonals = 0;
  std::vector<Edge> triangles;
};

Cut best_cut(const std::vector<Edge>& loop, std::size_t first, std::size_t last) {
  if (last - first < 2) return {};
  Cut best{std::numeric_limits<int>::max(), {}};
  for (std::size_t apex = first + 1; apex < last; ++apex) {
    Cut left = best_cut(loop, first, apex), right = best_cut(loop, apex, last);
    const auto diagonal = [&](std::size_t a, std::size_t b) {
      return b - a > 1 && b - a + 1 < loop.size() && share_face(loop[a], loop[b]) ? 1 : 0;
    };
    const int cost =
        left.face_diagonals + right.face_diagonals + diagonal(first, apex) + diagonal(apex, last);
    if (cost >= best.face_diagonals) continue;
    best = {cost, {loop[first], loop[apex], loop[last]}};
    best.triangles.insert(best.triangles.end(), left.triangles.begin(), left.triangles.end());
    best.triangles.insert(best.triangles.end(), right.triangles.begin(), right.triangles.end());
  }
  return best;
}

MarchingCase make_case(int number) {
  Successors next;
  next.fill(-1);
  for (int axis = 0; axis < 3; ++axis) {
    for (int side = 0; side < 2; ++side) join_face(number, axis, side, next);
  }
  MarchingCase result;
  std::array<bool, 12> seen{};
  for (Edge start = 0; start < 12; ++start) {
    std::vector<Edge> loop;
    for (Edge e = start; next[static_cast<std::size_t>(e)] >= 0 && !seen[static_cast<std::size_t>(e)];
         e = next[static_cast<std::size_t>(e)]) {
      seen[static_cast<std::size_t>(e)] = true;
      loop.push_back(e);
    }
    if (loop.empty()) continue;
    const Cut cut = best_cut(loop, 0, loop.size() - 1);
    for (std::size_t t = 0; t < cut.triangles.size(); ++t) {
      result.edges[3u * result.triangles + t] = static_cast<std::uint8_t>(cut.triangles[t]);
    }
    result.triangles = static_cast<std::uint8_t>(result.triangles + cut.triangles.size() / 3);
  }
  return result;
}

MarchingTable make_table() {
  MarchingTable table;
  for (int number = 0; number < 256; ++number) table[static_cast<std::size_t>(number)] = make_case(number);
  return table;
}

}  // namespace

const MarchingTable& marching_table() {
  static const MarchingTable table = make_table();
  return table;
}

}  // namespace turgor::detail
