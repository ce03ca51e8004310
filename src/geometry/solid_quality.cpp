#include "turgor/geometry/solid_quality.hpp"

#include <algorithm>
#include <cmath>

#include "turgor/core/index.hpp"
#include "turgor/core/parallel.hpp"

namespace turgor {
namespace {

struct Measure {
  double least_volume = std::numeric_limits<double>::infinity(), volume = 0;
  double greatest_cosine = -1, least_cosine = 1;  // of dihedral angles
  double least_ratio = 1, ratios = 0;
};

Measure combined(Measure a, const Measure& b) {
  a.least_volume = std::min(a.least_volume, b.least_volume), a.volume += b.volume;
  a.greatest_cosine = std::max(a.greatest_cosine, b.greatest_cosine);
  a.least_cosine = std::min(a.least_cosine, b.least_cosine);
  a.least_ratio = std::min(a.least_ratio, b.least_ratio), a.ratios += b.ratios;
  return a;
}

void measure(const std::array<Vec3, 4>& p, Measure& m) {
  const Vec3 b = p[1] - p[0], c = p[2] - p[0], d = p[3] - p[0];
  const double volume = dot(cross(b, c), d) / 6;
  m.least_volume = std::min(m.least_volume, volume), m.volume += volume;
  // Area vectors of the faces opposite to each corner, outwards.
  const std::array<Vec3, 4> n{cross(p[2] - p[1], p[3] - p[1]), cross(d, c), cross(b, d), cross(c, b)};
  double area = 0;
  for (std::size_t i = 0; i < 4; ++i) {
    area += 0.5 * length(n[i]);
    for (std::size_t j = 0; j < i; ++j) {
      const double lengths = length(n[i]) * length(n[j]);
      const double cosine = lengths > 0 ? std::clamp(-dot(n[i], n[j]) / lengths, -1.0, 1.0) : 1;
      m.greatest_cosine = std::max(m.greatest_cosine, cosine);
      m.least_cosine = std::min(m.least_cosine, cosine);
    }
  }
  const Vec3 to_centre =
      cross(c, d) * squared_length(b) + cross(d, b) * squared_length(c) + cross(b, c) * squared_length(d);
  const double inner = 3 * std::abs(volume) / area, outer = length(to_centre) / (12 * std::abs(volume));
  const double ratio = 3 * inner / outer;
  m.least_ratio = std::min(m.least_ratio, ratio > 0 ? ratio : 0.0), m.ratios += ratio > 0 ? ratio : 0.0;
}

}  // namespace

SolidQuality solid_quality(std::span<const Vec3> points, std::span<const std::array<int, 4>> tetrahedra) {
  if (tetrahedra.empty()) return {};
  const Measure all = parallel_reduce<Measure>(
      tetrahedra.size(), 4096, {},
      [&](std::size_t begin, std::size_t end) {
        Measure part;
        for (std::size_t t = begin; t < end; ++t) {
          const auto& corners = tetrahedra[t];
          measure({points[at(corners[0])], points[at(corners[1])], points[at(corners[2])],
                   points[at(corners[3])]},
                  part);
        }
        return part;
      },
      combined);
  return {all.least_volume,
          all.volume,
          degrees(std::acos(all.greatest_cosine)),
          degrees(std::acos(all.least_cosine)),
          all.least_ratio,
          all.ratios / static_cast<double>(tetrahedra.size())};
}

}  // namespace turgor
