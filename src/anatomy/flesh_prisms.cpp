#include "anatomy/flesh_prisms.hpp"

#include <algorithm>
#include <cmath>

#include "turgor/core/index.hpp"

namespace turgor {
namespace {

// Twice the vector area of the triangle at corner i.
Vec3 corner_area(const Polyhedron& surface, std::span<const int> p, std::size_t i) {
  const Vec3& here = surface.points[at(p[i])];
  return cross(surface.points[at(p[(i + 1) % p.size()])] - here,
               surface.points[at(p[(i + p.size() - 1) % p.size()])] - here);
}

bool is_convex_quadrilateral(const Polyhedron& surface, std::span<const int> p) {
  if (p.size() != 4) return false;
  const Vec3 normal = corner_area(surface, p, 0) + corner_area(surface, p, 2);
  for (std::size_t i = 0; i < 4; ++i) {
    if (!(dot(corner_area(surface, p, i), normal) > 0)) return false;
  }
  return true;
}

}  // namespace

namespace detail {

Polyhedron prism_bases(const Flesh& flesh) {
  Polyhedron bases;
  Polyhedron others;
  for (int i = 0; i < flesh.surface.polygon_count(); ++i) {
    const auto polygon = flesh.surface.polygon(i);
    const bool whole = polygon.size() == 3 || is_convex_quadrilateral(flesh.surface, polygon);
    (whole ? bases : others).add_polygon(polygon);
  }
  if (others.ends.empty()) return bases;
  others.points = flesh.surface.points;
  for (const Index3& t : triangulated(others).triangles) bases.add_polygon(t);
  return bases;
}

}  // namespace detail

double default_volume_modulus(const Polyhedron& source, double stiffness_n) {
  double sum = 0;
  const std::vector<Edge> all = edges(source);
  for (const auto& [a, b] : all) sum += distance(source.points[at(a)], source.points[at(b)]);
  const double mean = all.empty() ? 0 : sum / static_cast<double>(all.size());
  const double modulus = 2 * stiffness_n / (mean * mean);
  constexpr double most = 1e12;
  return std::isfinite(modulus) ? std::min(modulus, most) : 0;
}

int prism_count(const Flesh& flesh) {
  return detail::prism_bases(flesh).polygon_count() * (flesh.layers - 1);
}

int inverted_prisms(const Flesh& flesh, const std::vector<Vec3>& positions) {
  const Polyhedron bases = detail::prism_bases(flesh);
  int count = 0;
  for (int layer = 0; layer + 1 < flesh.layers; ++layer) {
    for (int i = 0; i < bases.polygon_count(); ++i) {
      bool sound = true;
      detail::visit_corners(flesh, bases.polygon(i), layer, [&](const std::array<int, 4>& t) {
        sound = sound && signed_volume(positions[at(t[0])], positions[at(t[1])], positions[at(t[2])],
                                       positions[at(t[3])]) > 0;
      });
      if (!sound) ++count;
    }
  }
  return count;
}

}  // namespace turgor
