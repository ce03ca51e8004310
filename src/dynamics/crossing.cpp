#include "dynamics/crossing.hpp"

#include <algorithm>
#include <cmath>

namespace turgor {
namespace {

// Neighbouring triangles overlap by this part of their size, so that nothing slips between them.
constexpr double kOverlap = 1e-6;

double value(const std::array<double, 4>& c, double t) {
  return c[0] + t * (c[1] + t * (c[2] + t * c[3]));
}

/// Between a and b, where the polynomial is monotone and changes sign.
double bisect(const std::array<double, 4>& c, double a, double b) {
  const bool rising = value(c, a) < 0;
  for (int i = 0; i < 60 && a < b; ++i) {
    const double middle = 0.5 * (a + b);
    if (middle <= a || middle >= b) break;
    ((value(c, middle) < 0) == rising ? a : b) = middle;
  }
  return 0.5 * (a + b);
}

/// Rising places within (0, 1) where the derivative is zero.
int turning_points(const std::array<double, 4>& c, std::array<double, 2>& t) {
  const double q = 3 * c[3], p = 2 * c[2], r = c[1];
  int count = 0;
  const auto add = [&](double x) {
    if (x > 0 && x < 1) t[static_cast<std::size_t>(count++)] = x;
  };
  const double discriminant = p * p - 4 * q * r;
  if (!(discriminant > 0)) return 0;
  const double s = -0.5 * (p + std::copysign(std::sqrt(discriminant), p));
  if (q != 0) add(s / q);
  if (s != 0) add(r / s);
  if (count == 2 && t[0] > t[1]) std::swap(t[0], t[1]);
  return count;
}

std::array<Vec3, 4> between(const std::array<Vec3, 4>& from, const std::array<Vec3, 4>& to, double t) {
  std::array<Vec3, 4> x;
  for (std::size_t i = 0; i < 4; ++i) x[i] = lerp(from[i], to[i], t);
  return x;
}

/// Where the point is in the plane of the triangle, where that is within it.
std::optional<Crossing> crossing_at(const std::array<Vec3, 4>& x, double time) {
  const Vec3 ab = x[2] - x[1], ac = x[3] - x[1], ap = x[0] - x[1], normal = cross(ab, ac);
  const double square = squared_length(normal);
  if (!(square > 0)) return std::nullopt;
  const double v = dot(cross(ap, ac), normal) / square, w = dot(cross(ab, ap), normal) / square;
  const double u = 1 - v - w;
  if (!(u >= -kOverlap && v >= -kOverlap && w >= -kOverlap)) return std::nullopt;
  return Crossing{time, {1, -u, -v, -w}, normal / std::sqrt(square)};
}

}  // namespace

Roots cubic_roots(const std::array<double, 4>& c) {
  std::array<double, 2> turns{};
  const int count = turning_points(c, turns);
  Roots roots;
  double a = 0;
  for (int i = 0; i <= count; ++i) {
    const double b = i < count ? turns[static_cast<std::size_t>(i)] : 1;
    const double at_a = value(c, a), at_b = value(c, b);
    if ((at_a < 0) != (at_b < 0)) roots.t[static_cast<std::size_t>(roots.count++)] = bisect(c, a, b);
    a = b;
  }
  return roots;
}

std::optional<Crossing> first_crossing(const std::array<Vec3, 4>& from, const std::array<Vec3, 4>& to,
                                       double slack) {
  // The point's height over the plane times twice the area: (x − a) · ((b − a) × (c − a)).
  const Vec3 p0 = from[0] - from[1], b0 = from[2] - from[1], c0 = from[3] - from[1];
  const Vec3 p1 = to[0] - to[1] - p0, b1 = to[2] - to[1] - b0, c1 = to[3] - to[1] - c0;
  const Vec3 n0 = cross(b0, c0), n1 = cross(b0, c1) + cross(b1, c0), n2 = cross(b1, c1);
  const std::array<double, 4> height = {dot(p0, n0), dot(p1, n0) + dot(p0, n1), dot(p1, n1) + dot(p0, n2),
                                        dot(p1, n2)};
  if (height[0] <= 0 && height[0] >= -slack * length(n0)) {
    const auto start = crossing_at(from, 0);
    if (start && value(height, 1) < height[0]) return start;
  }
  const Roots roots = cubic_roots(height);
  bool in_front = height[0] > 0;
  for (int i = 0; i < roots.count; ++i, in_front = !in_front) {
    const double t = roots.t[static_cast<std::size_t>(i)];
    if (!in_front) continue;
    if (const auto crossing = crossing_at(between(from, to, t), t)) return crossing;
  }
  return std::nullopt;
}

}  // namespace turgor
