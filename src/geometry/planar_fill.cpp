#include "geometry/planar_fill.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <numbers>
#include <span>

#include "geometry/delaunay_flips.hpp"
#include "geometry/ear_clipping.hpp"
#include "geometry/grid_points.hpp"

namespace turgor::detail {
namespace {

using Loop = std::vector<int>;

double signed_area(const std::vector<Vec2>& points, const Loop& loop) {
  double twice = 0;
  const Vec2& o = points[static_cast<std::size_t>(loop[0])];
  for (std::size_t i = 0; i < loop.size(); ++i) {
    const Vec2& a = points[static_cast<std::size_t>(loop[i])];
    const Vec2& b = points[static_cast<std::size_t>(loop[(i + 1) % loop.size()])];
    twice += (a[0] - o[0]) * (b[1] - o[1]) - (a[1] - o[1]) * (b[0] - o[0]);
  }
  return twice / 2;
}

/// +1 inside, -1 outside, 0 on the loop (crossing number, exact).
int inside_loop(const std::vector<GridPoint>& grid, const Loop& loop, const GridPoint& p) {
  bool odd = false;
  for (std::size_t i = 0; i < loop.size(); ++i) {
    GridPoint a = grid[static_cast<std::size_t>(loop[i])];
    GridPoint b = grid[static_cast<std::size_t>(loop[(i + 1) % loop.size()])];
    if (std::max(a.y, b.y) < p.y || std::min(a.y, b.y) > p.y) continue;
    if (a.y > b.y) std::swap(a, b);
    const int side = sign(orientation(a, b, p));
    if (side == 0 && std::min(a.x, b.x) <= p.x && p.x <= std::max(a.x, b.x)) return 0;
    if (a.y <= p.y && p.y < b.y && side > 0) odd = !odd;
  }
  return odd ? 1 : -1;
}

/// Whether `inner` lies in `outer`, judged at the first of its points that is not on it.
bool contains(const std::vector<GridPoint>& grid, const Loop& outer, const Loop& inner) {
  for (const int p : inner) {
    const int where = inside_loop(grid, outer, grid[static_cast<std::size_t>(p)]);
    if (where != 0) return where > 0;
  }
  return false;
}

/// One piece of the region: an outer loop and the holes directly in it.
struct Piece {
  Loop outer;
  double area;
  std::vector<Loop> holes;
};

/// Outer loops with their holes; holes in nothing come back in `orphans`.
std::vector<Piece> nest(const std::vector<Vec2>& points, const std::vector<GridPoint>& grid,
                        const std::vector<Loop>& loops, std::vector<Loop>& orphans) {
  std::vector<Piece> pieces;
  std::vector<Loop> holes;
  for (const Loop& loop : loops) {
    const double area = signed_area(points, loop);
    if (area < 0) {
      holes.push_back(loop);
    } else {
      pieces.push_back({loop, area, {}});
    }
  }
  for (Loop& hole : holes) {
    Piece* home = nullptr;
    for (Piece& piece : pieces) {
      if (home && home->area <= piece.area) continue;
      if (contains(grid, piece.outer, hole)) home = &piece;
    }
    if (home) {
      home->holes.push_back(std::move(hole));
    } else {
      orphans.push_back(std::move(hole));
    }
  }
  return pieces;
}

/// Clockwise angle in (0, 2 pi] from the direction back along `in` to that of `out`.
double clockwise_turn(const Vec2& in, const Vec2& out) {
  const Vec2 back{-in[0], -in[1]};
  const double cross_z = back[0] * out[1] - back[1] * out[0],
               dot_product = back[0] * out[0] + back[1] * out[1];
  const double angle = -std::atan2(cross_z, dot_product);
  return angle > 0 ? angle : angle + 2 * std::numbers::pi;
}

}  // namespace

std::vector<std::vector<int>> trace_loops(const std::vector<Vec2>& points,
                                          const std::vector<DirectedEdge>& edges) {
  std::map<int, std::vector<std::size_t>> leaving;
  for (std::size_t e = 0; e < edges.size(); ++e) leaving[edges[e].from].push_back(e);
  const auto direction = [&](const DirectedEdge& e) {
    const Vec2 &a = points[static_cast<std::size_t>(e.from)], &b = points[static_cast<std::size_t>(e.to)];
    return Vec2{b[0] - a[0], b[1] - a[1]};
  };
  std::vector<bool> used(edges.size(), false);
  std::vector<Loop> loops;
  for (std::size_t first = 0; first < edges.size(); ++first) {
    if (used[first]) continue;
    Loop loop;
    std::size_t e = first;
    bool closed = false;
    while (!closed) {
      used[e] = true;
      loop.push_back(edges[e].from);
      const auto out = leaving.find(edges[e].to);
      std::size_t best = edges.size();
      double least = std::numeric_limits<double>::infinity();
      if (out != leaving.end()) {
        for (const std::size_t candidate : out->second) {
          if (used[candidate] && candidate != first) continue;
          // The next edge of the piece of region on the left.
          const double turn =
              out->second.size() == 1 ? 0 : clockwise_turn(direction(edges[e]), direction(edges[candidate]));
          if (turn < least) least = turn, best = candidate;
        }
      }
      if (best == edges.size()) break;
      closed = best == first;
      e = best;
    }
    if (closed && loop.size() >= 3) loops.push_back(std::move(loop));
  }
  return loops;
}

std::vector<Index3> fill_loops(const std::vector<Vec2>& points, const std::vector<std::vector<int>>& loops) {
  const std::vector<GridPoint> grid = on_grid(points);
  std::vector<Loop> orphans;
  std::vector<Index3> triangles;
  const auto fill = [&](const Loop& outer, const std::vector<Loop>& holes) {
    const std::vector<Index3> part = clip_ears(grid, with_bridges(grid, outer, holes));
    triangles.insert(triangles.end(), part.begin(), part.end());
  };
  for (const Piece& piece : nest(points, grid, loops, orphans)) fill(piece.outer, piece.holes);
  for (const Loop& loop : orphans) {
    const std::size_t start = triangles.size();
    fill(Loop(loop.rbegin(), loop.rend()), {});
    for (std::size_t i = start; i < triangles.size(); ++i) std::swap(triangles[i][1], triangles[i][2]);
  }
  flip_to_delaunay(points, triangles);
  return triangles;
}

}  // namespace turgor::detail
