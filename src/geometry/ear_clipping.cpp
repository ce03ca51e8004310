#include "geometry/ear_clipping.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

namespace turgor::detail {
namespace {

double squared_distance(const GridPoint& a, const GridPoint& b) {
  const double dx = static_cast<double>(a.x - b.x), dy = static_cast<double>(a.y - b.y);
  return dx * dx + dy * dy;
}

/// Whether segment pq crosses or touches ab elsewhere than at a common end.
bool blocks(const GridPoint& p, const GridPoint& q, const GridPoint& a, const GridPoint& b) {
  if (std::max(a.x, b.x) < std::min(p.x, q.x) || std::max(p.x, q.x) < std::min(a.x, b.x) ||
      std::max(a.y, b.y) < std::min(p.y, q.y) || std::max(p.y, q.y) < std::min(a.y, b.y)) {
    return false;
  }
  const auto between = [](const GridPoint& s, const GridPoint& e, const GridPoint& x) {
    return std::min(s.x, e.x) <= x.x && x.x <= std::max(s.x, e.x) && std::min(s.y, e.y) <= x.y &&
           x.y <= std::max(s.y, e.y);
  };
  const int pa = sign(orientation(p, q, a)), pb = sign(orientation(p, q, b));
  const int ap = sign(orientation(a, b, p)), aq = sign(orientation(a, b, q));
  if (pa * pb < 0 && ap * aq < 0) return true;
  for (const auto& [end, side] : {std::pair{&a, pa}, std::pair{&b, pb}}) {
    if (side == 0 && *end != p && *end != q && between(p, q, *end)) return true;
  }
  return false;
}

/// Whether the direction from corner b towards p points into the polygon, whose corner there is a, b, c.
bool in_cone(const GridPoint& a, const GridPoint& b, const GridPoint& c, const GridPoint& p) {
  if (orientation(a, b, c) > 0) return orientation(a, b, p) > 0 && orientation(b, c, p) > 0;
  return !(orientation(a, b, p) <= 0 && orientation(b, c, p) <= 0);
}

/// Position in `polygon` of the nearest corner that sees h from the side of smaller coordinates.
std::size_t bridge_end(const std::vector<GridPoint>& grid, const std::vector<int>& polygon,
                       const GridPoint& h) {
  const auto at = [&](std::size_t i) { return grid[static_cast<std::size_t>(polygon[i % polygon.size()])]; };
  const std::size_t n = polygon.size();
  std::vector<std::pair<double, std::size_t>> candidates;
  for (std::size_t i = 0; i < n; ++i) {
    if (at(i) < h) candidates.emplace_back(squared_distance(at(i), h), i);
  }
  // Smallest first, without sorting those never looked at.
  const auto farther = std::greater<>{};
  std::make_heap(candidates.begin(), candidates.end(), farther);
  while (!candidates.empty()) {
    std::pop_heap(candidates.begin(), candidates.end(), farther);
    const std::size_t i = candidates.back().second;
    candidates.pop_back();
    if (!in_cone(at(i + n - 1), at(i), at(i + 1), h)) continue;
    bool seen = true;
    for (std::size_t j = 0; j < n && seen; ++j) seen = !blocks(h, at(i), at(j), at(j + 1));
    if (seen) return i;
  }
  // Only where the hole crosses the outer loop: any bridge closes the surface.
  std::size_t nearest = 0;
  for (std::size_t i = 1; i < n; ++i) {
    if (squared_distance(at(i), h) < squared_distance(at(nearest), h)) nearest = i;
  }
  return nearest;
}

/// The corners of a polygon as a ring that shrinks, with its reflex corners in a uniform grid.
class Ring {
 public:
  Ring(const std::vector<GridPoint>& grid, const std::vector<int>& polygon) : grid_(grid), polygon_(polygon) {
    const std::size_t n = polygon.size();
    next_.resize(n), previous_.resize(n), cut_.assign(n, false);
    for (std::size_t i = 0; i < n; ++i) next_[i] = (i + 1) % n, previous_[i] = (i + n - 1) % n;
    build_cells();
  }

  [[nodiscard]] std::size_t next(std::size_t i) const { return next_[i]; }
  [[nodiscard]] std::size_t previous(std::size_t i) const { return previous_[i]; }
  [[nodiscard]] Index3 triangle(std::size_t i) const {
    return {polygon_[previous_[i]], polygon_[i], polygon_[next_[i]]};
  }
  [[nodiscard]] Wide turn(std::size_t i) const { return orientation(at(previous_[i]), at(i), at(next_[i])); }

  [[nodiscard]] bool is_ear(std::size_t i) const {
    if (turn(i) <= 0) return false;
    const GridPoint a = at(previous_[i]), b = at(i), c = at(next_[i]);
    const auto [x0, x1] = std::minmax({a.x, b.x, c.x});
    const auto [y0, y1] = std::minmax({a.y, b.y, c.y});
    for (std::size_t row = cell(y0, lower_.y); row <= cell(y1, lower_.y); ++row) {
      for (std::size_t column = cell(x0, lower_.x); column <= cell(x1, lower_.x); ++column) {
        for (const std::size_t j : cells_[row * side_ + column]) {
          if (cut_[j] || turn(j) > 0) continue;
          const GridPoint p = at(j);
          if (p != a && p != b && p != c && in_triangle(p, a, b, c)) return false;
        }
      }
    }
    return true;
  }

  void cut(std::size_t i) {
    cut_[i] = true;
    next_[previous_[i]] = next_[i];
    previous_[next_[i]] = previous_[i];
  }

 private:
  [[nodiscard]] const GridPoint& at(std::size_t i) const {
    return grid_[static_cast<std::size_t>(polygon_[i])];
  }
  [[nodiscard]] std::size_t cell(std::int64_t coordinate, std::int64_t from) const {
    return static_cast<std::size_t>((coordinate - from) / width_);
  }
  void build_cells() {
    GridPoint upper = lower_ = at(0);
    for (std::size_t i = 0; i < polygon_.size(); ++i) {
      lower_ = {std::min(lower_.x, at(i).x), std::min(lower_.y, at(i).y)};
      upper = {std::max(upper.x, at(i).x), std::max(upper.y, at(i).y)};
    }
    side_ = 1 + static_cast<std::size_t>(std::sqrt(static_cast<double>(polygon_.size())));
    width_ = std::max(upper.x - lower_.x, upper.y - lower_.y) / static_cast<std::int64_t>(side_) + 1;
    cells_.resize(side_ * side_);
    // A corner that is convex now stays so while ears are cut, hence only the others can ever lie in an ear.
    for (std::size_t i = 0; i < polygon_.size(); ++i) {
      if (turn(i) <= 0) cells_[cell(at(i).y, lower_.y) * side_ + cell(at(i).x, lower_.x)].push_back(i);
    }
  }

  const std::vector<GridPoint>& grid_;
  const std::vector<int>& polygon_;
  std::vector<std::size_t> next_, previous_;
  std::vector<bool> cut_;
  std::vector<std::vector<std::size_t>> cells_;
  GridPoint lower_;
  std::size_t side_ = 1;
  std::int64_t width_ = 1;
};

}  // namespace

std::vector<int> with_bridges(const std::vector<GridPoint>& grid, const std::vector<int>& outer,
                              std::vector<std::vector<int>> holes) {
  // In order of their least corners, so that no hole still waiting can stand in the way of a bridge.
  const auto coordinates = [&](int p) { return grid[static_cast<std::size_t>(p)]; };
  for (auto& hole : holes) {
    std::rotate(hole.begin(),
                std::min_element(hole.begin(), hole.end(),
                                 [&](int a, int b) { return coordinates(a) < coordinates(b); }),
                hole.end());
  }
  std::stable_sort(holes.begin(), holes.end(),
                   [&](const auto& a, const auto& b) { return coordinates(a[0]) < coordinates(b[0]); });
  std::vector<int> polygon = outer;
  for (const auto& hole : holes) {
    const std::size_t end = bridge_end(grid, polygon, coordinates(hole[0]));
    std::vector<int> detour(hole);
    detour.push_back(hole[0]);
    detour.push_back(polygon[end]);
    polygon.insert(polygon.begin() + static_cast<std::ptrdiff_t>(end) + 1, detour.begin(), detour.end());
  }
  return polygon;
}

std::vector<Index3> clip_ears(const std::vector<GridPoint>& grid, const std::vector<int>& polygon) {
  std::vector<Index3> triangles;
  if (polygon.size() < 3) return triangles;
  Ring ring(grid, polygon);
  triangles.reserve(polygon.size() - 2);
  std::size_t left = polygon.size(), since_last_ear = 0, i = 0;
  while (left > 3) {
    const bool stuck = since_last_ear >= left;
    if (stuck) {
      // Widest turn of what is left.
      std::size_t best = i;
      for (std::size_t j = ring.next(i); j != i; j = ring.next(j)) {
        if (ring.turn(j) > ring.turn(best)) best = j;
      }
      i = best;
    }
    if (stuck || ring.is_ear(i)) {
      triangles.push_back(ring.triangle(i));
      ring.cut(i);
      --left;
      since_last_ear = 0;
      i = ring.next(ring.next(i));  // not the neighbour: fans make slivers
    } else {
      ++since_last_ear;
      i = ring.next(i);
    }
  }
  triangles.push_back(ring.triangle(i));
  return triangles;
}

}  // namespace turgor::detail
