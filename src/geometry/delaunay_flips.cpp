#include "geometry/delaunay_flips.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <unordered_map>

namespace turgor::detail {
namespace {

struct EdgeUse {
  int triangles[2]{-1, -1};
  bool crowded = false;  ///< more than two triangles: left alone
};

class Flipper {
 public:
  Flipper(const std::vector<Vec2>& points, std::vector<Index3>& triangles)
      : points_(points), triangles_(triangles) {
    for (std::size_t t = 0; t < triangles.size(); ++t) {
      for (std::size_t k = 0; k < 3; ++k)
        add(triangles[t][k], triangles[t][(k + 1) % 3], static_cast<int>(t));
    }
  }

  void run() {
    std::vector<std::pair<int, int>> queue;
    for (const Index3& t : triangles_) {
      for (std::size_t k = 0; k < 3; ++k) {
        if (t[k] < t[(k + 1) % 3]) queue.emplace_back(t[k], t[(k + 1) % 3]);
      }
    }
    // Lawson's flips end by themselves in exact arithmetic; the limit is for rounding.
    std::size_t budget = 100 * triangles_.size() + 100;
    while (!queue.empty() && budget-- > 0) {
      const auto [a, b] = queue.back();
      queue.pop_back();
      flip(a, b, queue);
    }
  }

 private:
  static std::uint64_t key(int a, int b) {
    const auto [low, high] = std::minmax(a, b);
    return static_cast<std::uint64_t>(high) << 32 | static_cast<std::uint32_t>(low);
  }
  void add(int a, int b, int triangle) {
    EdgeUse& use = edges_[key(a, b)];
    if (use.triangles[0] < 0) {
      use.triangles[0] = triangle;
    } else if (use.triangles[1] < 0) {
      use.triangles[1] = triangle;
    } else {
      use.crowded = true;
    }
  }
  void replace(int a, int b, int old_triangle, int new_triangle) {
    EdgeUse& use = edges_[key(a, b)];
    for (int& t : use.triangles) {
      if (t == old_triangle) {
        t = new_triangle;
        return;
      }
    }
  }
  [[nodiscard]] Vec2 from(int a, int b) const {
    const Vec2 &p = points_[static_cast<std::size_t>(a)], &q = points_[static_cast<std::size_t>(b)];
    return {q[0] - p[0], q[1] - p[1]};
  }
  static double cross2(const Vec2& a, const Vec2& b) { return a[0] * b[1] - a[1] * b[0]; }
  static double dot2(const Vec2& a, const Vec2& b) { return a[0] * b[0] + a[1] * b[1]; }

  /// Corner of the triangle that holds the directed edge a, b; -1 where it runs the other way.
  [[nodiscard]] int opposite(int triangle, int a, int b) const {
    const Index3& t = triangles_[static_cast<std::size_t>(triangle)];
    for (std::size_t k = 0; k < 3; ++k) {
      if (t[k] == a && t[(k + 1) % 3] == b) return t[(k + 2) % 3];
    }
    return -1;
  }

  void flip(int a, int b, std::vector<std::pair<int, int>>& queue) {
    const auto found = edges_.find(key(a, b));
    if (found == edges_.end() || found->second.crowded || found->second.triangles[1] < 0) return;
    int left = found->second.triangles[0], right = found->second.triangles[1];
    if (opposite(left, a, b) < 0) std::swap(left, right);
    const int c = opposite(left, a, b), d = opposite(right, b, a);
    if (c < 0 || d < 0 || c == d || edges_.contains(key(c, d)) || !wanted(a, b, c, d)) return;
    edges_.erase(found);
    triangles_[static_cast<std::size_t>(left)] = {c, d, b};
    triangles_[static_cast<std::size_t>(right)] = {d, c, a};
    add(c, d, left);
    add(c, d, right);
    replace(a, d, right, right);
    replace(c, a, left, right);
    replace(d, b, right, left);
    for (const auto& edge : {std::pair{a, c}, {c, b}, {b, d}, {d, a}}) queue.push_back(edge);
  }

  /// The quadrilateral a, d, b, c is strictly convex and the angles at c and d together exceed a straight
  /// one.
  [[nodiscard]] bool wanted(int a, int b, int c, int d) const {
    const Vec2 ca = from(c, a), cb = from(c, b), da = from(d, a), db = from(d, b), cd = from(c, d);
    const double scale = dot2(cd, cd) + dot2(from(a, b), from(a, b));
    const double margin = 1e-10 * scale;
    // After the flip both triangles must be anticlockwise with some area.
    if (cross2(cd, cb) <= margin || cross2(from(d, c), da) <= margin) return false;
    const double sin_c = cross2(ca, cb), cos_c = dot2(ca, cb), sin_d = cross2(db, da), cos_d = dot2(db, da);
    return sin_c * cos_d + cos_c * sin_d < -1e-10 * scale * scale;
  }

  const std::vector<Vec2>& points_;
  std::vector<Index3>& triangles_;
  std::unordered_map<std::uint64_t, EdgeUse> edges_;
};

}  // namespace

void flip_to_delaunay(const std::vector<Vec2>& points, std::vector<Index3>& triangles) {
  Flipper(points, triangles).run();
}

}  // namespace turgor::detail
