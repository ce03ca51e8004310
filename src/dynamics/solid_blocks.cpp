#include "dynamics/solid_blocks.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <numeric>
#include <type_traits>

#include "dynamics/bisect.hpp"
#include "dynamics/solid_elements.hpp"
#include "dynamics/solid_kernel.hpp"
#include "tissue/incidence.hpp"
#include "turgor/core/index.hpp"
#include "turgor/core/parallel.hpp"

namespace turgor {
namespace {

using namespace detail;

constexpr std::size_t kWidth = 8;  // slots of a group, whatever the lanes
constexpr std::size_t kAhead = 16, kGrain = 256;
// Of a block: displacements and forces of their points stay in the first level cache.
constexpr std::size_t kCubes = 512, kTetrahedra = 1024, kMostMembers = 2048;
constexpr std::size_t kTetraConstants = 20;

/// D², to which the constants of a cube's elements refer, in units of its edge.
double rest_square(int element) {
  using E = CubeElements;
  if (element < E::diagonal) return 1;
  if (element < E::outer) return 2;
  if (element < E::inner) return 1;
  if (element < E::volume) return 3;
  return element < E::volume + 4 ? 1 : 4;
}
int class_of(int element) {
  using E = CubeElements;
  int most = 0;
  for (const int first : {E::axis, E::diagonal, E::outer, E::inner, E::volume, E::volume + 4})
    if (element >= first) most = first;
  return most;
}

/// Of each tetrahedron, N·mm, to units of `size`.
void tetra_constants(const std::array<int, 4>& t, std::span<const Vec3> rest, const TetraShares& shares,
                     double size, std::span<double, kTetraConstants> to) {
  const auto x = [&](int corner) { return rest[at(t[at(corner)])] / size; };
  for (int c = 1; c < 4; ++c) {
    const Vec3 r = x(c) - x(0);
    for (int axis = 0; axis < 3; ++axis) to[at(3 * (c - 1) + axis)] = r[axis];
  }
  for (std::size_t i = 0; i < 6; ++i)
    to[9 + i] = shares.edge[i] / (squared_length(x(kTetraEdges[i][1]) - x(kTetraEdges[i][0])) * size);
  for (std::size_t i = 0; i < 4; ++i) {
    const auto& p = kTetraTriangles[i];
    to[15 + i] = shares.triangle[i] / (squared_length(cross(x(p[1]) - x(p[0]), x(p[2]) - x(p[0]))) * size);
  }
  const double six = 6 * signed_volume(x(0), x(1), x(2), x(3));
  to[19] = shares.volume / (six * six * size);
}

/// Edge of the cube that holds six of the solid's tetrahedra.
double mean_size(const Solid& solid, std::span<const Vec3> rest) {
  double volume = 0;
  for (const auto& t : solid.tetrahedra) volume += rest_volume(t, rest);
  return std::cbrt(6 * volume / static_cast<double>(solid.tetrahedra.size()));
}

/// Axes along b − a and, at right angles to it, towards c; the ones of space where there are no such.
Mat3 axes_of(const Vec3& a, const Vec3& b, const Vec3& c) {
  const Vec3 x = normalized(b - a), z = normalized(cross(x, c - a));
  const Mat3 axes{{x, cross(z, x), z}};
  return std::abs(axes.determinant() - 1) < 1e-6 ? axes : Mat3{};
}

template <class Quad>
void store(const Lanes& v, Quad& to) {
  if constexpr (std::is_same_v<Quad, TimeStepper::Workspace::Quad>) {
    store_lanes(to.v, v);
  } else {
    const HalfFloats half = __builtin_convertvector(v, HalfFloats);
    std::memcpy(to.v, &half, sizeof half);
  }
}

Lanes lanes_of(const Vec3& v) {
  return Lanes{v.x, v.y, v.z, 0};
}

/// A matrix that multiplies vectors in lanes.
struct LaneMatrix {
  Lanes c[3];

  explicit LaneMatrix(const Mat3& m) : c{lanes_of(m.c[0]), lanes_of(m.c[1]), lanes_of(m.c[2])} {}
  [[nodiscard]] Lanes times(double x, double y, double z) const { return (c[0] * x + c[1] * y) + c[2] * z; }
};

template <class Real>
TetraConstants<Real> load_tetra(const typename Pack<Real>::Scalar* from) {
  const auto next = [&] {
    const Real r = load<Real>(from);
    from += kWidth;
    return r;
  };
  const auto triple = [&] {
    const Real x = next(), y = next(), z = next();
    return Triple<Real>{x, y, z};
  };
  TetraConstants<Real> c;
  c.r1 = triple(), c.r2 = triple(), c.r3 = triple();
  for (Real& k : c.edge) k = next();
  c.outer12 = next(), c.outer23 = next(), c.outer31 = next(), c.inner = next(), c.volume = next();
  return c;
}

}  // namespace

/// One solid on its way into blocks of items, which are cubes or tetrahedra.
struct SolidBlocks::Draft {
  const Solid& solid;
  std::vector<TetraShares> shares;
  std::vector<double> fastest_square;  // of each tetrahedron
  std::optional<std::vector<LatticeCube>> cubes;
  double size_mm;
  std::vector<double> cube_constants;  // CubeElements::count each
  Kind kind = Kind::tetrahedra;
  std::size_t alike_constants = 0;  // of all cubes, where these are alike
  std::vector<int> local;           // numbers of points within a block, −1

  [[nodiscard]] int items() const {
    return static_cast<int>(cubes ? cubes->size() : solid.tetrahedra.size());
  }
  [[nodiscard]] std::span<const int> points(int item) const {
    if (cubes) return (*cubes)[at(item)].point;
    return solid.tetrahedra[at(item)];
  }
  [[nodiscard]] int pattern(int item) const { return cubes ? (*cubes)[at(item)].pattern : 0; }
  [[nodiscard]] std::vector<int> points(std::span<const int> piece) const {
    std::vector<int> all;
    for (const int i : piece) all.insert(all.end(), points(i).begin(), points(i).end());
    std::sort(all.begin(), all.end());
    all.erase(std::unique(all.begin(), all.end()), all.end());
    return all;
  }
  [[nodiscard]] double fastest(std::span<const int> piece) const {
    const std::size_t each = cubes ? 5 : 1;
    double most = 0;
    for (const int i : piece)
      for (std::size_t t = each * at(i); t < each * (at(i) + 1); ++t)
        most = std::max(most, fastest_square[t]);
    return most;
  }
};

SolidBlocks::SolidBlocks(const MotionModel& model) : exact_(model.exact_solids) {
  const auto& net = model.network;
  if (net.solids.empty()) return;
  rest_ = net.rest;
  std::vector<double> volume(rest_.size());  // around each point
  for (const Solid& solid : net.solids)
    for (const auto& t : solid.tetrahedra)
      for (const int p : t) volume[at(p)] += rest_volume(t, rest_);
  // Of a tetrahedron's part of a point.
  const auto inverse_mass = [&](int p, double own) {
    const bool held = !model.mobile.empty() && model.mobile[at(p)] == 0;
    return held ? 0.0 : volume[at(p)] / (net.mass_g[at(p)] * own);
  };
  for (const Solid& solid : net.solids) {
    auto shares = share_out(solid, rest_);
    if (!shares) stray_ = static_cast<int>(&solid - net.solids.data());
    if (!shares || solid.tetrahedra.empty()) continue;
    Draft draft{
        solid, *std::move(shares), {}, cubes_of(solid, rest_), solid.lattice_mm, {}, Kind::tetrahedra, 0, {}};
    draft.fastest_square.resize(draft.shares.size());
    parallel_for(draft.shares.size(), kGrain, [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i) {
        const auto& t = solid.tetrahedra[i];
        std::array<double, 4> inverse;
        for (std::size_t c = 0; c < 4; ++c) inverse[c] = inverse_mass(t[c], rest_volume(t, rest_));
        draft.fastest_square[i] = fastest_square(t, rest_, draft.shares[i], inverse);
      }
    });
    if (draft.cubes)
      prepare_cubes(draft);
    else
      draft.size_mm = mean_size(solid, rest_);
    lay_out(draft);
  }
  const auto list = make_incidence(static_cast<int>(rest_.size()), static_cast<int>(members_.size()),
                                   [&](int m) { return members_[at(m)]; });
  offsets_ = list.offsets;
  entries_ = list.entries;
}

void SolidBlocks::push_constant(double k) {
  if (exact_)
    double_.push_back(k);
  else
    single_.push_back(static_cast<float>(k));
}

void SolidBlocks::prepare_cubes(Draft& draft) {
  ++lattices_;
  constexpr std::size_t n = CubeElements::count;
  auto& k = draft.cube_constants;
  k.resize(n * draft.cubes->size());
  parallel_for(draft.cubes->size(), kGrain, [&](std::size_t begin, std::size_t end) {
    for (std::size_t c = begin; c < end; ++c) {
      const std::span to = std::span(k).subspan(n * c, n);
      add_to_cube((*draft.cubes)[c], std::span(draft.shares).subspan(5 * c).first<5>(), to);
      for (std::size_t e = 0; e < n; ++e) to[e] /= rest_square(static_cast<int>(e)) * draft.size_mm;
    }
  });
  bool alike = true;
  for (std::size_t i = 0; i < k.size() && alike; ++i) {
    const double first = k[at(class_of(static_cast<int>(i % n)))];
    alike = std::abs(k[i] - first) <= 1e-12 * first;
  }
  draft.kind = alike ? Kind::alike_cubes : Kind::cubes;
  if (!alike) return;
  draft.alike_constants = constants();
  for (int e = 0; e < CubeElements::count; ++e) push_constant(k[at(class_of(e))]);
}

void SolidBlocks::lay_out(Draft& draft) {
  std::vector<int> items(at(draft.items()));
  std::iota(items.begin(), items.end(), 0);
  draft.local.assign(rest_.size(), -1);
  const std::size_t most = draft.cubes ? kCubes : kTetrahedra;
  const auto middle = [&](int item) {
    Vec3 sum;
    for (const int p : draft.points(item)) sum += rest_[at(p)];
    return sum;
  };
  const auto fits = [&](std::span<const int> piece) {
    return piece.size() <= most && draft.points(piece).size() <= kMostMembers;
  };
  bisect(std::span(items), middle, fits, [&](std::span<const int> piece) { lay_out_block(draft, piece); });
}

std::array<int, 3> SolidBlocks::far_corners(std::span<const int> points) const {
  const auto farthest = [&](auto&& measure) {
    return *std::max_element(points.begin(), points.end(),
                             [&](int p, int q) { return measure(p) < measure(q); });
  };
  const Vec3& a = rest_[at(points[0])];
  const int second = farthest([&](int p) { return squared_length(rest_[at(p)] - a); });
  const Vec3& b = rest_[at(second)];
  return {points[0], second, farthest([&](int p) { return squared_length(cross(rest_[at(p)] - a, b - a)); })};
}

void SolidBlocks::lay_out_block(Draft& draft, std::span<const int> piece) {
  const std::vector<int> points = draft.points(piece);
  Block block{draft.kind, members_.size(), points.size(),        corners_.size(),    constants(),
              {0, 0},     draft.size_mm,   draft.fastest(piece), far_corners(points)};
  if (draft.kind == Kind::alike_cubes) block.first_constant = draft.alike_constants;
  members_.insert(members_.end(), points.begin(), points.end());
  for (std::size_t i = 0; i < points.size(); ++i) draft.local[at(points[i])] = static_cast<int>(i);
  for (int pattern = 0; pattern < 2; ++pattern) {
    std::vector<int> items;
    for (const int i : piece)
      if (draft.pattern(i) == pattern) items.push_back(i);
    // Slots side by side are of eighths of the block, so that they add to points of their own.
    const std::size_t groups = (items.size() + kWidth - 1) / kWidth;
    block.groups[pattern] = groups;
    for (std::size_t g = 0; g < groups; ++g) {
      std::array<int, kWidth> slots;
      for (std::size_t s = 0; s < kWidth; ++s)
        slots[s] = s * groups + g < items.size() ? items[s * groups + g] : -1;
      lay_out_group(draft, slots);
    }
  }
  blocks_.push_back(block);
}

// Slots that fill up a group have no stiffness, and all corners in one point.
void SolidBlocks::lay_out_group(const Draft& draft, std::span<const int, 8> slots) {
  const std::size_t corners = draft.cubes ? 8 : 4;
  for (std::size_t c = 0; c < corners; ++c)
    for (const int item : slots)
      corners_.push_back(static_cast<std::uint16_t>(item < 0 ? 0 : draft.local[at(draft.points(item)[c])]));
  if (draft.kind == Kind::alike_cubes) return;
  const std::size_t count = draft.cubes ? at(CubeElements::count) : kTetraConstants;
  std::vector<std::array<double, kWidth>> columns(count);
  for (std::size_t s = 0; s < kWidth; ++s) {
    std::vector<double> own(count);
    if (slots[s] < 0 && !draft.cubes)
      own[0] = own[4] = own[8] = 1;  // edges along the axes
    else if (slots[s] >= 0 && draft.cubes)
      std::copy_n(&draft.cube_constants[count * at(slots[s])], count, own.begin());
    else if (slots[s] >= 0)
      tetra_constants(draft.solid.tetrahedra[at(slots[s])], rest_, draft.shares[at(slots[s])], draft.size_mm,
                      std::span<double, kTetraConstants>(own.data(), kTetraConstants));
    for (std::size_t i = 0; i < count; ++i) columns[i][s] = own[i];
  }
  for (const auto& column : columns)
    for (const double k : column) push_constant(k);
}

template <class Scalar>
const Scalar* SolidBlocks::constants_from(std::size_t first) const {
  if constexpr (std::is_same_v<Scalar, float>)
    return single_.data() + first;
  else
    return double_.data() + first;
}

template <class Real, class Quad>
void SolidBlocks::add_tetrahedra(const Block& block, const Quad* u, Quad* force, Real& stretch) const {
  const std::uint16_t* corner = corners_.data() + block.first_corner;
  const auto* k = constants_from<typename Pack<Real>::Scalar>(block.first_constant);
  for (std::size_t g = 0; g < block.groups[0]; ++g, corner += 4 * kWidth, k += kTetraConstants * kWidth) {
    for (std::size_t s = 0; s < kWidth; s += at(Pack<Real>::lanes)) {
      Triple<Real> x[4];
      for (std::size_t c = 0; c < 4; ++c) x[c] = turgor::gather<Real>(u, corner + c * kWidth + s);
      tetra_forces(load_tetra<Real>(k + s), x, stretch);
      for (std::size_t c = 0; c < 4; ++c) scatter<Real>(force, corner + c * kWidth + s, x[c]);
    }
  }
}

template <class Real, int pattern, class Quad>
void SolidBlocks::add_cubes(const Block& block, const Quad* u, Quad* force, Real& stretch) const {
  const bool alike = block.kind == Kind::alike_cubes;
  const std::size_t before = pattern == 0 ? 0 : block.groups[0];
  const std::uint16_t* corner = corners_.data() + block.first_corner + before * 8 * kWidth;
  const std::size_t stride = alike ? 0 : at(CubeElements::count) * kWidth;
  const auto* k = constants_from<typename Pack<Real>::Scalar>(block.first_constant) + before * stride;
  for (std::size_t g = 0; g < block.groups[pattern]; ++g, corner += 8 * kWidth, k += stride) {
    for (std::size_t s = 0; s < kWidth; s += at(Pack<Real>::lanes)) {
      Triple<Real> x[8];
      for (std::size_t c = 0; c < 8; ++c) x[c] = turgor::gather<Real>(u, corner + c * kWidth + s);
      if (alike)
        CubeForces<pattern, Real>::replace(x, stretch, [&]<int e>() { return same<Real>(k[e]); });
      else
        CubeForces<pattern, Real>::replace(x, stretch, [&]<int e>() { return load<Real>(k + e * 8 + s); });
      for (std::size_t c = 0; c < 8; ++c) scatter<Real>(force, corner + c * kWidth + s, x[c]);
    }
  }
}

template <class Real, class Quad>
double SolidBlocks::sum_block(const Block& block, std::span<const Vec3> position, Quad* force) const {
  Quad u[kMostMembers];
  const std::span<const int> members = std::span(members_).subspan(block.first_member, block.members);
  force += block.first_member;
  const auto [a, b, c] = block.corner;
  const Mat3 turn = axes_of(position[at(a)], position[at(b)], position[at(c)]) *
                    axes_of(rest_[at(a)], rest_[at(b)], rest_[at(c)]).transposed();
  const LaneMatrix forth(turn), back(turn.transposed());
  const Vec3 origin = position[at(a)];
  const Lanes rest_origin = lanes_of(rest_[at(a)]);
  const double scale = 1 / block.size_mm;
  for (std::size_t i = 0; i < members.size(); ++i) {
    if (i + kAhead < members.size()) {
      __builtin_prefetch(&position[at(members[i + kAhead])]);
      __builtin_prefetch(&rest_[at(members[i + kAhead])]);
    }
    const Vec3 x = position[at(members[i])] - origin;
    store((back.times(x.x, x.y, x.z) - (lanes_of(rest_[at(members[i])]) - rest_origin)) * scale, u[i]);
    force[i] = {};
  }
  Real stretch = same<Real>(0);
  if (block.kind == Kind::tetrahedra) {
    add_tetrahedra<Real>(block, u, force, stretch);
  } else {
    add_cubes<Real, 0>(block, u, force, stretch);
    add_cubes<Real, 1>(block, u, force, stretch);
  }
  for (std::size_t i = 0; i < members.size(); ++i) {
    const auto& f = force[i].v;
    store(forth.times(f[0], f[1], f[2]), force[i]);
  }
  // Gradients of areas grow as lengths do, those of volumes as their squares; r = 1 − D/l.
  const double shrink = 1 - static_cast<double>(largest_lane(stretch)), growth = 1 / (shrink * shrink);
  return block.fastest_square * growth * growth;
}

template <class Real, class Quad>
double SolidBlocks::sum_as(std::span<const Vec3> position, std::vector<Quad>& force) const {
  force.resize(members_.size());
  return parallel_reduce(
      blocks_.size(), 1, 0.0,
      [&](std::size_t begin, std::size_t end) {
        double fastest = 0;
        for (std::size_t b = begin; b < end; ++b)
          fastest = std::max(fastest, sum_block<Real>(blocks_[b], position, force.data()));
        return fastest;
      },
      [](double a, double b) { return std::max(a, b); });
}

double SolidBlocks::sum(std::span<const Vec3> position, Workspace& w) const {
  return exact_ ? sum_as<Lanes>(position, w.exact_solid_force) : sum_as<Floats>(position, w.solid_force);
}

SolidBlocks::Reader SolidBlocks::reader(const Workspace& w) const {
  Reader r;
  r.offsets_ = offsets_.data(), r.entries_ = entries_.data();
  if (exact_)
    r.exact_ = w.exact_solid_force.data();
  else
    r.single_ = w.solid_force.data();
  return r;
}

template double SolidBlocks::sum_as<Twin<float, 8>>(std::span<const Vec3>,
                                                    std::vector<Workspace::QuadOf<float>>&) const;
template double SolidBlocks::sum_as<Twin<double, 4>>(std::span<const Vec3>,
                                                     std::vector<Workspace::Quad>&) const;

}  // namespace turgor
