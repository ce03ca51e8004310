#include "anatomy/symmetry.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "turgor/core/parallel.hpp"
#include "turgor/geometry/surface_query.hpp"

namespace turgor {
namespace {

constexpr std::size_t kSamples = 2000;
constexpr int kMostIterations = 25;
constexpr double kFarthestPairMm = 20;

struct Pair {
  Vec3 point;           ///< on the surface, from the centre
  double residual = 0;  ///< of its mirror image, along the normal of the surface nearest to that
  Vec3 normal;
  bool found = false;
};

Vec3 mirrored(const Vec3& p, const Vec3& n, double offset) {
  return p - n * (2 * (dot(n, p) - offset));
}

std::vector<Pair> pair_up(const TriMesh& surface, const SurfaceQuery& query, const std::vector<Vec3>& samples,
                          const Vec3& centre, const Vec3& n, double offset) {
  std::vector<Pair> pairs(samples.size());
  parallel_for(samples.size(), 64, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      const Vec3 image = mirrored(samples[i], n, offset);
      const auto nearest = query.nearest(image + centre, kFarthestPairMm);
      if (!nearest) continue;
      const Vec3 normal = normalized(
          triangle_normal(surface, surface.triangles[static_cast<std::size_t>(nearest->triangle)]));
      pairs[i] = {samples[i], dot(normal, image + centre - nearest->point), normal, true};
    }
  });
  std::erase_if(pairs, [](const Pair& p) { return !p.found; });
  return pairs;
}

double spread_of(const std::vector<Pair>& pairs) {
  std::vector<double> sizes;
  sizes.reserve(pairs.size());
  for (const Pair& p : pairs) sizes.push_back(std::abs(p.residual));
  const auto middle = sizes.begin() + static_cast<std::ptrdiff_t>(sizes.size() / 2);
  std::nth_element(sizes.begin(), middle, sizes.end());
  return 1.4826 * *middle;
}

/// Gauss-Newton step of the two tilts of the normal (about the middle) and the offset.
std::array<double, 3> step(const std::vector<Pair>& pairs, const Vec3& n, double offset, const Vec3& u,
                           const Vec3& v) {
  const double cut = std::max(1.0, 4.0 * spread_of(pairs));
  Mat3 normal_matrix{{Vec3{1e-9, 0, 0}, Vec3{0, 1e-9, 0}, Vec3{0, 0, 1e-9}}};
  Vec3 gradient;
  for (const Pair& p : pairs) {
    const double t = p.residual / cut;
    if (std::abs(t) >= 1) continue;
    const double weight = (1 - t * t) * (1 - t * t);
    const double h = dot(n, p.point) - offset;
    // Derivatives of the mirror image p - 2 (n·p - offset) n.
    const Vec3 by_u = (n * dot(u, p.point) + u * h) * -2.0;
    const Vec3 by_v = (n * dot(v, p.point) + v * h) * -2.0;
    const Vec3 jacobian{dot(p.normal, by_u), dot(p.normal, by_v), dot(p.normal, n * 2.0)};
    for (int a = 0; a < 3; ++a)
      normal_matrix.c[static_cast<std::size_t>(a)] += jacobian * (weight * jacobian[a]);
    gradient += jacobian * (weight * p.residual);
  }
  if (std::abs(normal_matrix.determinant()) < 1e-12) return {0, 0, 0};
  const Vec3 solution = normal_matrix.inverse() * gradient;
  return {-solution.x, -solution.y, -solution.z};
}

}  // namespace

Plane find_symmetry_plane(const TriMesh& surface, const Plane& start) {
  if (surface.empty()) return start;
  const SurfaceQuery query(surface);
  const Vec3 centre = bounds(surface).centre();
  const std::size_t stride = std::max<std::size_t>(1, surface.points.size() / kSamples);
  std::vector<Vec3> samples;
  for (std::size_t p = 0; p < surface.points.size(); p += stride)
    samples.push_back(surface.points[p] - centre);

  Vec3 n = start.normal;
  double offset = start.offset - dot(n, centre);
  for (int iteration = 0; iteration < kMostIterations; ++iteration) {
    const std::vector<Pair> pairs = pair_up(surface, query, samples, centre, n, offset);
    if (pairs.size() < 100) return start;
    const Vec3 u = any_orthogonal(n), v = cross(n, u);
    const auto [du, dv, dn] = step(pairs, n, offset, u, v);
    n = normalized(n + u * du + v * dv);
    offset += dn;
    if (std::abs(du) + std::abs(dv) < 1e-4 && std::abs(dn) < 0.01) break;
  }
  if (!is_finite(n) || !std::isfinite(offset) || dot(n, start.normal) < 0.7) return start;
  return {n, offset + dot(n, centre)};
}

}  // namespace turgor
