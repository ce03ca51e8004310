#include "dynamics/solid_elements.hpp"

#include <algorithm>
#include <bit>
#include <cmath>

#include "dynamics/solid_kernel.hpp"
#include "tissue/incidence.hpp"
#include "turgor/core/index.hpp"
#include "turgor/core/parallel.hpp"

namespace turgor::detail {
namespace {

constexpr std::size_t kGrain = 1024;
using Tetrahedron = std::array<int, 4>;

template <std::size_t n>
std::array<int, n> corners(const Tetrahedron& t, const int (&of)[n]) {
  std::array<int, n> p;
  for (std::size_t i = 0; i < n; ++i) p[i] = t[at(of[i])];
  std::sort(p.begin(), p.end());
  return p;
}

/// Elements of `n` points by the lowest of them.
template <std::size_t n>
class ElementFinder {
 public:
  ElementFinder(std::span<const std::array<int, n>> elements, int points) {
    sorted_.assign(elements.begin(), elements.end());
    for (auto& e : sorted_) std::sort(e.begin(), e.end());
    at_point_ =
        make_incidence(points, static_cast<int>(elements.size()), [&](int e) { return sorted_[at(e)][0]; });
  }
  /// −1: not there.
  [[nodiscard]] int number(const std::array<int, n>& sorted) const {
    for (int k = at_point_.offsets[at(sorted[0])]; k < at_point_.offsets[at(sorted[0]) + 1]; ++k)
      if (sorted_[at(at_point_.entries[at(k)])] == sorted) return at_point_.entries[at(k)];
    return -1;
  }

 private:
  std::vector<std::array<int, n>> sorted_;
  NetworkEnergy::Incidence at_point_;
};

/// For each tetrahedron its edges or triangles, for each of them the volume around it.
template <std::size_t n, std::size_t each>
struct Around {
  std::vector<std::array<int, each>> numbers;
  std::vector<double> volume;

  Around(const Solid& solid, std::span<const std::array<int, n>> elements, std::span<const double> volumes,
         int points, const int (&of)[each][n])
      : numbers(solid.tetrahedra.size()), volume(elements.size()) {
    const ElementFinder<n> finder(elements, points);
    parallel_for(numbers.size(), kGrain, [&](std::size_t begin, std::size_t end) {
      for (std::size_t t = begin; t < end; ++t)
        for (std::size_t i = 0; i < each; ++i)
          numbers[t][i] = finder.number(corners(solid.tetrahedra[t], of[i]));
    });
    for (std::size_t t = 0; t < numbers.size(); ++t)
      for (const int e : numbers[t])
        if (e >= 0) volume[at(e)] += volumes[t];
  }
  [[nodiscard]] bool all_have_some() const {
    return std::all_of(volume.begin(), volume.end(), [](double v) { return v > 0; });
  }
  void share(std::span<const double> constants, std::size_t t, double own,
             std::array<double, each>& to) const {
    for (std::size_t i = 0; i < each; ++i) {
      const int e = numbers[t][i];
      to[i] = e >= 0 ? constants[at(e)] * (own / volume[at(e)]) : 0;
    }
  }
};

/// Roots of the constants times the gradients of all strains, to the roots of the masses: 12 numbers each.
using Modes = std::array<std::array<double, 12>, 11>;

void set_row(std::array<double, 12>& row, int corner, const Vec3& gradient, double factor) {
  for (int i = 0; i < 3; ++i) row[at(3 * corner + i)] = gradient[i] * factor;
}

Modes modes_of(const Tetrahedron& t, std::span<const Vec3> rest, const TetraShares& shares,
               const std::array<double, 4>& inverse_mass) {
  Modes modes{};
  std::array<double, 4> root;
  for (std::size_t c = 0; c < 4; ++c) root[c] = std::sqrt(inverse_mass[c]);
  const auto x = [&](int corner) { return rest[at(t[at(corner)])]; };
  for (std::size_t i = 0; i < 6; ++i) {
    const int a = kTetraEdges[i][0], b = kTetraEdges[i][1];
    const Vec3 e = x(b) - x(a), gradient = e * (std::sqrt(shares.edge[i]) / squared_length(e));
    set_row(modes[i], a, gradient, -root[at(a)]);
    set_row(modes[i], b, gradient, root[at(b)]);
  }
  for (std::size_t i = 0; i < 4; ++i) {
    const auto& p = kTetraTriangles[i];
    const Vec3 n = cross(x(p[1]) - x(p[0]), x(p[2]) - x(p[0]));
    const double k = std::sqrt(shares.triangle[i]) / squared_length(n);
    for (int c = 0; c < 3; ++c)
      set_row(modes[6 + i], p[c], cross(n, x(p[(c + 2) % 3]) - x(p[(c + 1) % 3])) * k, root[at(p[c])]);
  }
  const auto g = volume_gradient(x(1) - x(0), x(2) - x(0), x(3) - x(0));
  for (int c = 0; c < 4; ++c)
    set_row(modes[10], c, g[at(c)] * (std::sqrt(shares.volume) / rest_volume(t, rest)), root[at(c)]);
  return modes;
}

using Roles = std::array<int, 4>;

/// Which corner of its cube a point is, −1 where it is none.
int role_of(const Vec3& x, const Vec3& lowest, double spacing) {
  int role = 0;
  for (int axis = 0; axis < 3; ++axis) {
    const double place = (x[axis] - lowest[axis]) / spacing, nearest = std::round(place);
    if (!(std::abs(place - nearest) <= 1e-9) || (nearest != 0 && nearest != 1)) return -1;
    if (nearest == 1) role |= 1 << axis;
  }
  return role;
}

/// Whether the tetrahedron is a cube's middle one in a pattern, or lies at one of its corners.
bool is_middle(const Roles& corner, int pattern) {
  return std::all_of(corner.begin(), corner.end(),
                     [&](int c) { return std::popcount(static_cast<unsigned>(c)) % 2 == pattern; });
}
bool is_cut_off(const Roles& corner, int pattern) {
  unsigned cut = 0, all = 0;
  for (const int c : corner) {
    all |= 1U << c;
    if (std::popcount(static_cast<unsigned>(c)) % 2 != pattern) cut |= 1U << c;
  }
  if (std::popcount(cut) != 1) return false;
  const int c = std::countr_zero(cut);
  return all == (cut | 1U << (c ^ 1) | 1U << (c ^ 2) | 1U << (c ^ 4));
}

/// The pattern of five tetrahedra, −1 where it is none: each other than the middle one has a corner to
/// itself.
int pattern_of(const std::array<Roles, 5>& corner) {
  for (const int pattern : {0, 1}) {
    const auto middle = [&](const Roles& c) { return is_middle(c, pattern); };
    const auto cut_off = [&](const Roles& c) { return is_cut_off(c, pattern); };
    if (std::count_if(corner.begin(), corner.end(), middle) == 1 &&
        std::count_if(corner.begin(), corner.end(), cut_off) == 4)
      return pattern;
  }
  return -1;
}

std::optional<LatticeCube> cube_of(std::span<const Tetrahedron, 5> tetrahedra, std::span<const Vec3> rest,
                                   double spacing) {
  LatticeCube cube{};
  cube.point.fill(-1);
  Box3 box;
  for (const auto& t : tetrahedra)
    for (const int p : t) box.extend(rest[at(p)]);
  for (std::size_t t = 0; t < 5; ++t) {
    for (std::size_t i = 0; i < 4; ++i) {
      const int p = tetrahedra[t][i], role = role_of(rest[at(p)], box.lower, spacing);
      if (role < 0 || (cube.point[at(role)] >= 0 && cube.point[at(role)] != p)) return std::nullopt;
      cube.point[at(role)] = p;
      cube.corner[t][i] = role;
    }
  }
  cube.pattern = pattern_of(cube.corner);
  const bool whole = std::find(cube.point.begin(), cube.point.end(), -1) == cube.point.end();
  if (cube.pattern < 0 || !whole) return std::nullopt;
  return cube;
}

template <int pattern>
void add_tetrahedron(const Roles& corner, const TetraShares& shares, std::span<double> to) {
  using P = CubePattern<pattern>;
  const auto is_cut = [](int c) { return std::popcount(static_cast<unsigned>(c)) % 2 != pattern; };
  const auto number = [](int cut) { return P::number_of(cut ^ 7); };
  for (std::size_t i = 0; i < 6; ++i) {
    const int a = corner[at(kTetraEdges[i][0])], b = corner[at(kTetraEdges[i][1])];
    const int along = std::countr_zero(static_cast<unsigned>(a ^ b));
    const int element = is_cut(a) || is_cut(b)
                            ? CubeElements::axis + 3 * number(is_cut(a) ? a : b) + along
                            : CubeElements::diagonal + P::pair(P::number_of(a), P::number_of(b));
    to[at(element)] += shares.edge[i];
  }
  for (std::size_t i = 0; i < 4; ++i) {
    int cut = -1, all = 0;
    for (const int n : kTetraTriangles[i]) {
      if (is_cut(corner[at(n)])) cut = corner[at(n)];
      all ^= corner[at(n)];
    }
    // Three middle corners: the four cancel out, so the missing one is left. At a corner c with c ^ i and
    // c ^ j, c ^ all = i ^ j, which leaves the bit of the normal out.
    const int element = cut < 0 ? CubeElements::inner + P::number_of(all)
                                : CubeElements::outer + 3 * number(cut) +
                                      std::countr_zero(static_cast<unsigned>(cut ^ all ^ 7));
    to[at(element)] += shares.triangle[i];
  }
  const auto cut = std::find_if(corner.begin(), corner.end(), is_cut);
  to[at(CubeElements::volume + (cut == corner.end() ? 4 : number(*cut)))] += shares.volume;
}

}  // namespace

double rest_volume(const Tetrahedron& t, std::span<const Vec3> rest) {
  return signed_volume(rest[at(t[0])], rest[at(t[1])], rest[at(t[2])], rest[at(t[3])]);
}

std::optional<std::vector<TetraShares>> share_out(const Solid& solid, std::span<const Vec3> rest) {
  std::vector<double> volumes;
  for (const Tetrahedron& t : solid.tetrahedra) volumes.push_back(rest_volume(t, rest));
  const int points = static_cast<int>(rest.size());
  const Around<2, 6> edges(solid, std::span(solid.edges), volumes, points, kTetraEdges);
  const Around<3, 4> triangles(solid, std::span(solid.triangles), volumes, points, kTetraTriangles);
  if (!edges.all_have_some() || !triangles.all_have_some()) return std::nullopt;
  std::vector<TetraShares> shares(volumes.size());
  for (std::size_t t = 0; t < shares.size(); ++t) {
    edges.share(solid.edge_nmm, t, volumes[t], shares[t].edge);
    triangles.share(solid.triangle_nmm, t, volumes[t], shares[t].triangle);
    shares[t].volume = solid.tetrahedron_nmm[t];
  }
  return shares;
}

// The eigenvalues of M^-½ K M^-½ above zero are those of the products G of all modes with one another, and
// the highest is at most (Σ λ⁴)^¼, the root of the Frobenius norm of G².
double fastest_square(const Tetrahedron& tetrahedron, std::span<const Vec3> rest, const TetraShares& shares,
                      const std::array<double, 4>& inverse_mass) {
  const Modes modes = modes_of(tetrahedron, rest, shares, inverse_mass);
  constexpr std::size_t n = modes.size();
  double g[n][n];
  for (std::size_t i = 0; i < n; ++i) {
    for (std::size_t j = 0; j <= i; ++j) {
      double sum = 0;
      for (std::size_t k = 0; k < 12; ++k) sum += modes[i][k] * modes[j][k];
      g[i][j] = g[j][i] = sum;
    }
  }
  double norm = 0;
  for (std::size_t i = 0; i < n; ++i) {
    for (std::size_t j = 0; j <= i; ++j) {
      double sum = 0;
      for (std::size_t k = 0; k < n; ++k) sum += g[i][k] * g[j][k];
      norm += (i == j ? 1 : 2) * sum * sum;
    }
  }
  return std::sqrt(std::sqrt(norm));
}

std::optional<std::vector<LatticeCube>> cubes_of(const Solid& solid, std::span<const Vec3> rest) {
  if (!(solid.lattice_mm > 0) || solid.tetrahedra.size() % 5 != 0) return std::nullopt;
  std::vector<LatticeCube> cubes(solid.tetrahedra.size() / 5);
  const int bad = parallel_reduce(
      cubes.size(), kGrain, 0,
      [&](std::size_t begin, std::size_t end) {
        for (std::size_t c = begin; c < end; ++c) {
          const auto cube =
              cube_of(std::span(solid.tetrahedra).subspan(5 * c).first<5>(), rest, solid.lattice_mm);
          if (!cube) return 1;
          cubes[c] = *cube;
        }
        return 0;
      },
      [](int a, int b) { return a + b; });
  if (bad > 0) return std::nullopt;
  return cubes;
}

void add_to_cube(const LatticeCube& cube, std::span<const TetraShares, 5> shares,
                 std::span<double> elements) {
  for (std::size_t t = 0; t < 5; ++t) {
    if (cube.pattern == 0)
      add_tetrahedron<0>(cube.corner[t], shares[t], elements);
    else
      add_tetrahedron<1>(cube.corner[t], shares[t], elements);
  }
}

}  // namespace turgor::detail
