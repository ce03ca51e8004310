#include "turgor/tissue/solid.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <tuple>

#include "turgor/core/index.hpp"
#include "turgor/core/parallel.hpp"
#include "turgor/tissue/network.hpp"

namespace turgor {
namespace {

constexpr std::size_t kPointGrain = 1024;
constexpr std::array<std::array<std::uint8_t, 2>, 6> kEdges = {
    {{0, 1}, {0, 2}, {0, 3}, {1, 2}, {1, 3}, {2, 3}}};
constexpr std::array<std::array<std::uint8_t, 3>, 4> kFaces = {{{0, 1, 2}, {0, 1, 3}, {0, 2, 3}, {1, 2, 3}}};

Error broken(std::string what, std::string remedy) {
  return {ErrorKind::bad_input, std::move(what), "solid", std::move(remedy)};
}

/// An edge or a triangle of one tetrahedron, corners ascending.
template <std::size_t corners>
struct Side {
  std::array<int, corners> p;
  int tetrahedron;

  bool operator<(const Side& other) const {
    return std::tie(p, tetrahedron) < std::tie(other.p, other.tetrahedron);
  }
};

/// The sides of all tetrahedra, ascending, tetrahedra that share one in order. Sorted by the first corner by
/// counting, within it by comparison: few meet at a point.
template <std::size_t corners, std::size_t sides>
std::vector<Side<corners>> sorted_sides(const std::vector<std::array<int, 4>>& tetrahedra,
                                        const std::array<std::array<std::uint8_t, corners>, sides>& table,
                                        std::size_t points) {
  const auto visit = [&](auto&& body) {
    for (std::size_t t = 0; t < tetrahedra.size(); ++t) {
      std::array<int, 4> p = tetrahedra[t];
      std::sort(p.begin(), p.end());
      for (const auto& side : table) {
        Side<corners> s{{}, static_cast<int>(t)};
        for (std::size_t c = 0; c < corners; ++c) s.p[c] = p[side[c]];
        body(s);
      }
    }
  };
  std::vector<std::size_t> offsets(points + 1, 0);
  visit([&](const Side<corners>& s) { ++offsets[at(s.p[0]) + 1]; });
  for (std::size_t p = 0; p < points; ++p) offsets[p + 1] += offsets[p];
  std::vector<Side<corners>> sorted(offsets.back());
  std::vector<std::size_t> next(offsets.begin(), offsets.end() - 1);
  visit([&](const Side<corners>& s) { sorted[next[at(s.p[0])]++] = s; });
  parallel_for(points, kPointGrain, [&](std::size_t begin, std::size_t end) {
    for (std::size_t p = begin; p < end; ++p)
      std::sort(sorted.data() + offsets[p], sorted.data() + offsets[p + 1]);
  });
  return sorted;
}

template <std::size_t corners>
std::vector<std::array<int, corners>> distinct(const std::vector<Side<corners>>& sorted) {
  std::vector<std::array<int, corners>> sides;
  for (const auto& s : sorted) {
    if (sides.empty() || sides.back() != s.p) sides.push_back(s.p);
  }
  return sides;
}

Result<void> check_indices(const std::vector<std::array<int, 4>>& tetrahedra, std::size_t points) {
  for (std::size_t t = 0; t < tetrahedra.size(); ++t) {
    const auto& p = tetrahedra[t];
    for (std::size_t c = 0; c < 4; ++c) {
      if (p[c] < 0 || at(p[c]) >= points) {
        return broken(fmt::format("tetrahedron {} has the corner {} of {} points", t, p[c], points),
                      "Point numbers start at 0");
      }
      if (std::find(p.begin(), p.begin() + static_cast<int>(c), p[c]) != p.begin() + static_cast<int>(c)) {
        return broken(fmt::format("tetrahedron {} has the corner {} twice", t, p[c]), "Remove it");
      }
    }
  }
  return {};
}

Result<std::vector<double>> volumes_of(const Solid& solid, std::span<const Vec3> rest) {
  TURGOR_CHECK(check_indices(solid.tetrahedra, rest.size()));
  std::vector<double> volumes;
  volumes.reserve(solid.tetrahedra.size());
  for (const auto& p : solid.tetrahedra) {
    volumes.push_back(signed_volume(rest[at(p[0])], rest[at(p[1])], rest[at(p[2])], rest[at(p[3])]));
    if (!(volumes.back() > 0) || !std::isfinite(volumes.back())) {
      return broken(
          fmt::format("the rest volume of tetrahedron {} is {} mm³", volumes.size() - 1, volumes.back()),
          "Swap two corners of an inverted one, remove a flat one");
    }
  }
  return volumes;
}

/// The sums of what the tetrahedra around each side give it: part(tetrahedron). Error where the sides are not
/// those of the tetrahedra in the order of make_solid().
template <std::size_t corners, std::size_t sides, class Part>
Result<std::vector<double>> sum_over_sides(const Solid& solid, std::size_t points,
                                           const std::vector<std::array<int, corners>>& of,
                                           const std::array<std::array<std::uint8_t, corners>, sides>& table,
                                           Part&& part) {
  std::vector<double> sums;
  sums.reserve(of.size());
  const auto sorted = sorted_sides(solid.tetrahedra, table, points);
  for (std::size_t i = 0; i < sorted.size(); ++i) {
    if (i == 0 || sorted[i].p != sorted[i - 1].p) {
      if (sums.size() == of.size() || of[sums.size()] != sorted[i].p) break;
      sums.push_back(0);
    }
    sums.back() += part(at(sorted[i].tetrahedron)) / static_cast<double>(sides);
  }
  if (sums.size() != of.size() || (!sorted.empty() && (of.empty() || of.back() != sorted.back().p)))
    return broken("the edges and triangles are not those of the tetrahedra",
                  "Make the solid by make_solid()");
  return sums;
}

Result<void> check_stiffness(std::span<const SolidStiffness> stiffness, std::size_t tetrahedra) {
  if (stiffness.size() != 1 && stiffness.size() != tetrahedra) {
    return broken(fmt::format("{} stiffnesses are given for {} tetrahedra", stiffness.size(), tetrahedra),
                  "Give one for each, or one for all");
  }
  for (std::size_t i = 0; i < stiffness.size(); ++i) {
    for (const double k : {stiffness[i].length, stiffness[i].area, stiffness[i].volume}) {
      if (!(std::isfinite(k) && k >= 0))
        return broken(fmt::format("stiffness {} is {} MPa", i, k),
                      "It must be a finite number of at least 0");
    }
  }
  return {};
}

Result<void> check_finite(const std::vector<double>& constants) {
  if (std::all_of(constants.begin(), constants.end(), [](double k) { return std::isfinite(k); })) return {};
  return broken("the constant of an element is too large to be computed", "Choose a smaller stiffness");
}

}  // namespace

Result<Solid> make_solid(std::vector<std::array<int, 4>> tetrahedra, int point_count, double lattice_mm) {
  if (tetrahedra.size() > at(std::numeric_limits<int>::max()) / 4) {
    return broken(fmt::format("{} tetrahedra have more than 2^31 − 1 corners", tetrahedra.size()),
                  "Use a coarser mesh");
  }
  if (!(std::isfinite(lattice_mm) && lattice_mm >= 0) || (lattice_mm > 0 && tetrahedra.size() % 5 != 0)) {
    return broken(fmt::format("{} tetrahedra are to be the cubes of a lattice with the edge {} mm",
                              tetrahedra.size(), lattice_mm),
                  "Give five a cube and an edge above 0, or 0 where there is no lattice");
  }
  const std::size_t points = point_count > 0 ? at(point_count) : 0;
  TURGOR_CHECK(check_indices(tetrahedra, points));
  Solid solid;
  solid.edges = distinct(sorted_sides(tetrahedra, kEdges, points));
  solid.triangles = distinct(sorted_sides(tetrahedra, kFaces, points));
  solid.edge_nmm.resize(solid.edges.size());
  solid.triangle_nmm.resize(solid.triangles.size());
  solid.tetrahedron_nmm.resize(tetrahedra.size());
  solid.tetrahedra = std::move(tetrahedra);
  solid.lattice_mm = lattice_mm;
  return solid;
}

SolidStiffness stiffness_of(const SolidMaterial& m) {
  const double mu = m.youngs_modulus_mpa / (2 * (1 + m.poissons_ratio));
  const double lambda = 2 * mu * m.poissons_ratio / (1 - 2 * m.poissons_ratio);
  SolidStiffness k;
  k.area = 15 * mu * m.area_share;
  k.length = 15 * mu - k.area;
  k.volume = std::max(0.0, lambda - k.length / 15 - 6 * k.area / 15);
  return k;
}

Result<void> set_stiffness(Solid& solid, std::span<const Vec3> rest,
                           std::span<const SolidStiffness> stiffness) {
  TURGOR_CHECK(check_stiffness(stiffness, solid.tetrahedra.size()));
  TURGOR_TRY(const std::vector<double> volumes, volumes_of(solid, rest));
  const auto of = [&](std::size_t t) -> const SolidStiffness& {
    return stiffness[stiffness.size() == 1 ? 0 : t];
  };
  TURGOR_TRY(std::vector<double> edges,
             sum_over_sides(solid, rest.size(), solid.edges, kEdges,
                            [&](std::size_t t) { return of(t).length * volumes[t]; }));
  TURGOR_TRY(std::vector<double> triangles,
             sum_over_sides(solid, rest.size(), solid.triangles, kFaces,
                            [&](std::size_t t) { return of(t).area * volumes[t]; }));
  std::vector<double> tetrahedra(volumes.size());
  for (std::size_t t = 0; t < volumes.size(); ++t) tetrahedra[t] = of(t).volume * volumes[t];
  for (const auto* constants : {&edges, &triangles, &tetrahedra}) TURGOR_CHECK(check_finite(*constants));
  solid.edge_nmm = std::move(edges);
  solid.triangle_nmm = std::move(triangles);
  solid.tetrahedron_nmm = std::move(tetrahedra);
  return {};
}

void add_mass(const Solid& solid, std::span<const Vec3> rest, double density_g_mm3,
              std::vector<double>& mass_g) {
  for (const auto& p : solid.tetrahedra) {
    const double volume = signed_volume(rest[at(p[0])], rest[at(p[1])], rest[at(p[2])], rest[at(p[3])]);
    for (const int corner : p) mass_g[at(corner)] += 0.25 * density_g_mm3 * volume;
  }
}

}  // namespace turgor
