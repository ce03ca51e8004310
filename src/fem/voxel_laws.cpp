#include "fem/voxel_laws.hpp"

#include <Eigen/Eigenvalues>
#include <array>
#include <bit>
#include <cstring>
#include <numeric>
#include <utility>

#include "fem/law_response.hpp"
#include "fem/packed_lanes.hpp"
#include "turgor/core/parallel.hpp"

namespace turgor::detail {
namespace {

constexpr std::size_t kPoints = 8, kCorners = 8;
// Stiffness of a cube's modes against which it may bend downwards, relative to its shear modulus: its
// neighbours hold it.
constexpr double kBearable = 0.1;
constexpr double kGauss = 0.57735026918962576;  // 1/√3

template <class R>
inline constexpr std::size_t kLanes = static_cast<std::size_t>(Pack<R>::lanes);

constexpr double gauss_power(unsigned mode) {
  double p = 1;
  for (int i = std::popcount(mode); i > 0; --i) p *= kGauss;
  return p;
}

using Doubles = double __attribute__((vector_size(64)));

// Values of neighbouring nodes, and what is added to them.
template <class R>
R load_values(const double* from) {
  if constexpr (std::is_same_v<R, Floats>) {
    Doubles v;
    std::memcpy(&v, from, sizeof v);
    return __builtin_convertvector(v, Floats);
  } else {
    return load<R>(from);
  }
}
template <class R>
void add_values(const R& v, double* to) {
  using Wide = std::conditional_t<std::is_same_v<R, Floats>, Doubles, Lanes>;
  Wide sum;
  std::memcpy(&sum, to, sizeof sum);
  sum += __builtin_convertvector(v, Wide);
  std::memcpy(to, &sum, sizeof sum);
}

// Where the corners of a run of cells begin: corner bits x 1, y 2, z 4.
struct Corners {
  std::size_t start[3][kCorners];

  Corners(const VoxelRows& rows, int j, int k, int x) {
    for (int q = 0; q < 4; ++q) {
      const NodeRow& row = rows.node_row(j + (q & 1), k + (q >> 1));
      for (int c = 0; c < 3; ++c) {
        const std::size_t at = row.offset + static_cast<std::size_t>(c * row.count + x - row.first);
        start[c][2 * q] = at, start[c][2 * q + 1] = at + 1;
      }
    }
  }
};

template <class R>
using Modes = R[3][kCorners];

template <class R>
void load_modes(const Corners& corners, std::size_t lane, const double* u, Modes<R>& m) {
  for (int c = 0; c < 3; ++c) {
    for (std::size_t n = 0; n < kCorners; ++n) m[c][n] = load_values<R>(u + corners.start[c][n] + lane);
    to_modes(m[c]);
  }
}

// Adds what modes mean at the corners.
template <class R>
void add_modes(const Corners& corners, std::size_t lane, Modes<R>& m, double* out) {
  for (int c = 0; c < 3; ++c) {
    from_modes(m[c]);
    for (std::size_t n = 0; n < kCorners; ++n) add_values(m[c][n], out + corners.start[c][n] + lane);
  }
}

// Displacement gradients at the points; `scale` of modes.
template <class R>
void gradients(const Modes<R>& m, const R& scale, Tensor<R> (&h)[kPoints]) {
  for (int c = 0; c < 3; ++c) {
    for (int i = 0; i < 3; ++i) {
      R v[kPoints] = {};
      for (unsigned s = 0; s < 8; ++s)
        if (((s >> i) & 1) == 0) v[s] = m[c][s | 1U << i] * (scale * number<R>(gauss_power(s)));
      from_modes(v);
      for (std::size_t g = 0; g < kPoints; ++g) h[g](c, i) = v[g];
    }
  }
}

// The transpose: forces of stresses at the points on the modes, added.
template <class R>
void add_stresses(const Tensor<R> (&p)[kPoints], const R& scale, Modes<R>& m) {
  for (int c = 0; c < 3; ++c) {
    for (int i = 0; i < 3; ++i) {
      R v[kPoints];
      for (std::size_t g = 0; g < kPoints; ++g) v[g] = p[g](c, i);
      to_modes(v);
      for (unsigned s = 0; s < 8; ++s)
        if (((s >> i) & 1) == 0) m[c][s | 1U << i] += v[s] * (scale * number<R>(gauss_power(s)));
    }
  }
}

// A law in all lanes at once.
template <ElasticLaw law, class R>
class LanePoint : public LawPoint<law, R> {
 public:
  using LawPoint<law, R>::LawPoint;
  // Whether a lane has no energy.
  [[nodiscard]] bool turned(std::size_t lane) const {
    if constexpr (law == ElasticLaw::neo_hookean || law == ElasticLaw::mooney_rivlin)
      return !(static_cast<double>(this->theta()[lane]) > kLeastVolumeRatio - 1) ||
             !(static_cast<double>(this->theta()[lane]) < 1e30);
    return false;
  }
};

// The corotational law is worked out a lane at a time.
template <class R>
class LanePoint<ElasticLaw::corotational, R> {
 public:
  using Scalar = typename Pack<R>::Scalar;

  LanePoint(const Tensor<R>& h, const LawModuli<R>& moduli) {
    points_.reserve(kLanes<R>);
    for (std::size_t lane = 0; lane < kLanes<R>; ++lane)
      points_.emplace_back(one(h, lane), LawModuli<double>{static_cast<double>(moduli.shear[lane]),
                                                           static_cast<double>(moduli.c20[lane])});
  }
  [[nodiscard]] bool turned(std::size_t lane) const { return !points_[lane].valid(); }
  [[nodiscard]] R energy() const {
    R r;
    for (std::size_t i = 0; i < kLanes<R>; ++i) r[i] = static_cast<Scalar>(points_[i].energy());
    return r;
  }
  [[nodiscard]] R theta() const {
    R r;
    for (std::size_t i = 0; i < kLanes<R>; ++i) r[i] = static_cast<Scalar>(points_[i].theta());
    return r;
  }
  [[nodiscard]] Tensor<R> stress() const {
    return tensors([&](std::size_t lane) { return points_[lane].stress(); });
  }
  [[nodiscard]] Tensor<R> theta_gradient() const {
    return tensors([&](std::size_t lane) { return points_[lane].theta_gradient(); });
  }
  [[nodiscard]] Tensor<R> tangent(const Tensor<R>& df, const R& pressure) const {
    return tensors([&](std::size_t lane) {
      return points_[lane].tangent(one(df, lane), static_cast<double>(pressure[lane]));
    });
  }

 private:
  static Tensor<double> one(const Tensor<R>& t, std::size_t lane) {
    return Tensor<double>::each([&](int i) { return static_cast<double>(t.m[i][lane]); });
  }
  template <class Value>
  [[nodiscard]] static Tensor<R> tensors(Value&& value) {
    Tensor<R> r;
    for (std::size_t lane = 0; lane < kLanes<R>; ++lane) {
      const Tensor<double> t = value(lane);
      for (int i = 0; i < 9; ++i) r.m[i][lane] = static_cast<Scalar>(t.m[i]);
    }
    return r;
  }
  std::vector<LawPoint<ElasticLaw::corotational, double>> points_;
};

// Moduli of lanes, 0 where they follow another law; and 1 where they do not.
template <class R>
struct LaneModuli {
  LawModuli<R> shape;
  R bulk, there;

  LaneModuli(const double* shear, const double* c20, const double* bulk_of, const std::uint8_t* law_of,
             std::uint8_t law) {
    for (std::size_t i = 0; i < kLanes<R>; ++i) there[i] = law_of[i] == law ? 1 : 0;
    shape = {load_values<R>(shear) * there, load_values<R>(c20) * there};
    bulk = load_values<R>(bulk_of) * there;
  }
};

template <class R>
Tensor<R> masked(const Tensor<R>& h, const R& there) {
  return h * there;
}

template <class R>
double sum_of(const R& v) {
  double sum = 0;
  for (std::size_t i = 0; i < kLanes<R>; ++i) sum += static_cast<double>(v[i]);
  return sum;
}

// Eight points in a row, none of which can be made without what it is at.
template <ElasticLaw law, class R, std::size_t... g>
std::array<LanePoint<law, R>, kPoints> points_of(const Tensor<R> (&h)[kPoints], const LaneModuli<R>& moduli,
                                                 std::index_sequence<g...>) {
  return {LanePoint<law, R>(masked(h[g], moduli.there), moduli.shape)...};
}
template <ElasticLaw law, class R>
std::array<LanePoint<law, R>, kPoints> points_of(const Tensor<R> (&h)[kPoints], const LaneModuli<R>& moduli) {
  return points_of<law, R>(h, moduli, std::make_index_sequence<kPoints>{});
}
template <class Points>
auto mean_theta(const Points& points) {
  auto sum = points[0].theta();
  for (std::size_t g = 1; g < kPoints; ++g) sum = sum + points[g].theta();
  return sum * number<decltype(sum)>(1.0 / kPoints);
}

// Adds the energy and forces of the lanes of one law, or counts those without one.
template <ElasticLaw law>
void add_forces(const Tensor<Lanes> (&h)[kPoints], const LaneModuli<Lanes>& moduli, double spacing,
                Modes<Lanes>& force, VoxelLaws::Energy& energy) {
  const auto points = points_of<law, Lanes>(h, moduli);
  for (std::size_t lane = 0; lane < kLanes<Lanes>; ++lane) {
    bool turned = false;
    for (const auto& p : points) turned = turned || p.turned(lane);
    energy.inverted += turned ? 1 : 0;
  }
  const double volume = spacing * spacing * spacing, weight = volume / kPoints;
  const Lanes theta = mean_theta(points), pressure = moduli.bulk * theta;
  Lanes shape = {};
  Tensor<Lanes> stress[kPoints];
  for (std::size_t g = 0; g < kPoints; ++g) {
    shape += points[g].energy();
    stress[g] =
        scaled_sum(Tensor<Lanes>(points[g].theta_gradient()), pressure, Tensor<Lanes>(points[g].stress()));
  }
  energy.strain += weight * sum_of(shape) + 0.5 * volume * sum_of(pressure * theta);
  add_stresses(stress, number<Lanes>(weight / (4 * spacing)), force);
}

constexpr std::size_t of_tangent(int a, int b) {  // of 45
  return packed<9>(static_cast<std::size_t>(a < b ? a : b), static_cast<std::size_t>(a < b ? b : a));
}

// Which moments of the tangent at the points each packed number is the sum of, and times what.
struct StiffnessTable {
  struct Entry {
    std::uint16_t first, end;
    float factor;
  };
  std::array<Entry, VoxelLaws::kPacked> entries{};
  std::vector<std::uint16_t> terms;  // 8 · number of the tangent's component + sign pattern

  StiffnessTable() {
    for (unsigned p = 0; p < VoxelLaws::kModes; ++p) {
      for (unsigned q = p; q < VoxelLaws::kModes; ++q) {
        const unsigned s = p % 7 + 1, t = q % 7 + 1;
        Entry& entry = entries[packed<VoxelLaws::kModes>(p, q)];
        entry.first = static_cast<std::uint16_t>(terms.size());
        for (unsigned i = 0; i < 3; ++i)
          for (unsigned j = 0; j < 3; ++j)
            if (((s >> i) & (t >> j) & 1) != 0)
              terms.push_back(static_cast<std::uint16_t>(
                  8 * of_tangent(static_cast<int>(3 * (p / 7) + i), static_cast<int>(3 * (q / 7) + j)) +
                  ((s ^ 1U << i) ^ (t ^ 1U << j))));
        entry.end = static_cast<std::uint16_t>(terms.size());
        entry.factor = static_cast<float>(gauss_power(s) * gauss_power(t) / (kGauss * kGauss));
      }
    }
  }
};

// Adds the second derivatives of the lanes of one law.
template <ElasticLaw law>
void add_stiffness(const Tensor<Floats> (&h)[kPoints], const LaneModuli<Floats>& moduli, double spacing,
                   const StiffnessTable& table, Floats (&matrix)[VoxelLaws::kPacked]) {
  const auto points = points_of<law, Floats>(h, moduli);
  const Floats pressure = moduli.bulk * mean_theta(points);
  Floats moments[45][kPoints];
  Tensor<Floats> theta_gradient[kPoints];
  for (std::size_t g = 0; g < kPoints; ++g) {
    theta_gradient[g] = points[g].theta_gradient();
    for (int b = 0; b < 9; ++b) {
      const auto df = Tensor<Floats>::each([&](int i) { return number<Floats>(i == b ? 1 : 0); });
      const Tensor<Floats> column = points[g].tangent(df, pressure);
      for (int a = 0; a <= b; ++a) moments[of_tangent(a, b)][g] = column.m[a];
    }
  }
  const double volume = spacing * spacing * spacing, slope = 1 / (4 * spacing);
  const Floats scale = number<Floats>(volume / kPoints * slope * slope);
  for (auto& of_component : moments) to_modes(of_component);
  for (std::size_t e = 0; e < VoxelLaws::kPacked; ++e) {
    const StiffnessTable::Entry& entry = table.entries[e];
    Floats sum = {};
    for (std::size_t t = entry.first; t < entry.end; ++t)
      sum += moments[table.terms[t] / 8][table.terms[t] % 8];
    matrix[e] += sum * (scale * entry.factor);
  }
  Modes<Floats> b = {};
  add_stresses(theta_gradient, number<Floats>(volume / kPoints * slope), b);
  const Floats stiff = moduli.bulk * number<Floats>(1 / volume);
  for (std::size_t p = 0; p < VoxelLaws::kModes; ++p) {
    const Floats of_row = b[p / 7][p % 7 + 1] * stiff;
    for (std::size_t q = p; q < VoxelLaws::kModes; ++q)
      matrix[packed<VoxelLaws::kModes>(p, q)] += of_row * b[q / 7][q % 7 + 1];
  }
}

// The smallest pivot of Gauss's elimination of eight matrices, with a shift of their diagonals.
Floats least_pivot(const float* matrix, const Floats& shift) {
  constexpr std::size_t n = VoxelLaws::kModes;
  Floats a[VoxelLaws::kPacked];
  std::memcpy(a, matrix, sizeof a);
  Floats least = number<Floats>(1e30);
  for (std::size_t p = 0; p < n; ++p) a[packed<VoxelLaws::kModes>(p, p)] += shift;
  for (std::size_t p = 0; p < n; ++p) {
    const Floats pivot = a[packed<VoxelLaws::kModes>(p, p)];
    for (std::size_t lane = 0; lane < kBlockCells; ++lane) least[lane] = std::min(least[lane], pivot[lane]);
    const Floats inverse = number<Floats>(1) / pivot;
    for (std::size_t q = p + 1; q < n; ++q) {
      const Floats factor = a[packed<VoxelLaws::kModes>(p, q)] * inverse;
      for (std::size_t r = q; r < n; ++r)
        a[packed<VoxelLaws::kModes>(q, r)] -= factor * a[packed<VoxelLaws::kModes>(p, r)];
    }
  }
  return least;
}

// The matrix of one of eight cubes with the absolute values of its eigenvalues.
void convexify_packed(std::size_t lane, float* matrix) {
  constexpr auto n = static_cast<Eigen::Index>(VoxelLaws::kModes);
  Eigen::Matrix<double, n, n> whole;
  const auto number = [&](Eigen::Index p, Eigen::Index q) -> float& {
    return matrix[packed<VoxelLaws::kModes>(static_cast<std::size_t>(p), static_cast<std::size_t>(q)) *
                      kBlockCells +
                  lane];
  };
  for (Eigen::Index p = 0; p < n; ++p)
    for (Eigen::Index q = p; q < n; ++q) whole(q, p) = static_cast<double>(number(p, q));
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix<double, n, n>> eigen(whole);
  whole =
      eigen.eigenvectors() * eigen.eigenvalues().cwiseAbs().asDiagonal() * eigen.eigenvectors().transpose();
  for (Eigen::Index p = 0; p < n; ++p)
    for (Eigen::Index q = p; q < n; ++q) number(p, q) = static_cast<float>(whole(q, p));
}

template <ElasticLaw law>
bool has(std::uint8_t laws) {
  return ((laws >> static_cast<int>(law)) & 1) != 0;
}

template <class Function>
void for_laws(std::uint8_t laws, Function&& f) {
  if (has<ElasticLaw::linear>(laws)) f.template operator()<ElasticLaw::linear>();
  if (has<ElasticLaw::corotational>(laws)) f.template operator()<ElasticLaw::corotational>();
  if (has<ElasticLaw::st_venant_kirchhoff>(laws)) f.template operator()<ElasticLaw::st_venant_kirchhoff>();
  if (has<ElasticLaw::neo_hookean>(laws)) f.template operator()<ElasticLaw::neo_hookean>();
  if (has<ElasticLaw::mooney_rivlin>(laws)) f.template operator()<ElasticLaw::mooney_rivlin>();
}

}  // namespace

VoxelLaws::VoxelLaws(const VoxelNumbering& numbering, const ElasticBody& body, double spacing)
    : rows_(&numbering.rows), spacing_(spacing) {
  const std::size_t cells = numbering.rows.cell_count;
  for (auto* v : {&shear_, &bulk_, &c20_}) v->assign(cells, 0);
  law_.assign(cells, 0);
  laws_in_.assign(cells / kBlockCells, 0);
  for (std::size_t c = 0; c < numbering.cubes.size(); ++c) {
    const ElasticMaterial m = body.of(c);
    const std::size_t cell = numbering.cell(c);
    shear_[cell] = m.shear_modulus(), bulk_[cell] = m.bulk_modulus(), c20_[cell] = m.c20_mpa;
    law_[cell] = static_cast<std::uint8_t>(static_cast<int>(m.law) + 1);
    laws_in_[cell / kBlockCells] |= static_cast<std::uint8_t>(1U << static_cast<unsigned>(m.law));
  }
  for (const std::uint8_t laws : laws_in_) number_.push_back(laws != 0 ? static_cast<int>(blocks_++) : -1);
}

// block(first cell, where its corners begin, its laws, its number)
template <class Block>
void VoxelLaws::for_blocks(int k, Block&& block) const {
  for (int j = 0; j < rows_->cells[1]; ++j) {
    const CellRow& row = rows_->cell_row(j, k);
    for (int x = row.first; x < row.end; x += kBlockCells) {
      const std::size_t cell = row.offset + static_cast<std::size_t>(x - row.first), b = cell / kBlockCells;
      if (number_[b] >= 0)
        block(cell, Corners(*rows_, j, k, x), laws_in_[b], static_cast<std::size_t>(number_[b]));
    }
  }
}

VoxelLaws::Energy VoxelLaws::forces(const double* u, double* out) const {
  std::vector<Energy> parts(static_cast<std::size_t>(rows_->cells[2]));
  const Lanes slope = number<Lanes>(1 / (4 * spacing_));
  in_slabs(
      *rows_, out, [](std::size_t, std::size_t, std::size_t) {},
      [&](int k) {
        Energy& energy = parts[static_cast<std::size_t>(k)];
        for_blocks(k, [&](std::size_t cell, const Corners& corners, std::uint8_t laws, std::size_t) {
          for (std::size_t lane = 0; lane < kBlockCells; lane += kLanes<Lanes>) {
            Modes<Lanes> modes, force = {};
            Tensor<Lanes> h[kPoints];
            load_modes<Lanes>(corners, lane, u, modes);
            gradients<Lanes>(modes, slope, h);
            const std::size_t at = cell + lane;
            for_laws(laws, [&]<ElasticLaw law>() {
              const LaneModuli<Lanes> moduli(&shear_[at], &c20_[at], &bulk_[at], &law_[at],
                                             static_cast<std::uint8_t>(static_cast<int>(law) + 1));
              add_forces<law>(h, moduli, spacing_, force, energy);
            });
            add_modes<Lanes>(corners, lane, force, out);
          }
        });
      });
  Energy total;
  for (const Energy& e : parts) total.strain += e.strain, total.inverted += e.inverted;
  return total;
}

void VoxelLaws::linearise(const double* u, Matrices& matrices) const {
  static const StiffnessTable table;
  const Lanes slope = number<Lanes>(1 / (4 * spacing_));
  parallel_for(static_cast<std::size_t>(rows_->cells[2]), 1, [&](std::size_t k, std::size_t) {
    for_blocks(static_cast<int>(k),
               [&](std::size_t cell, const Corners& corners, std::uint8_t laws, std::size_t number) {
                 Tensor<Floats> h[kPoints];
                 for (std::size_t lane = 0; lane < kBlockCells; lane += kLanes<Lanes>) {
                   Modes<Lanes> modes;
                   Tensor<Lanes> half[kPoints];
                   load_modes<Lanes>(corners, lane, u, modes);
                   gradients<Lanes>(modes, slope, half);
                   for (std::size_t g = 0; g < kPoints; ++g)
                     for (int i = 0; i < 9; ++i)
                       for (std::size_t l = 0; l < kLanes<Lanes>; ++l)
                         h[g].m[i][lane + l] = static_cast<float>(half[g].m[i][l]);
                 }
                 Floats matrix[kPacked] = {};
                 for_laws(laws, [&]<ElasticLaw law>() {
                   const LaneModuli<Floats> moduli(&shear_[cell], &c20_[cell], &bulk_[cell], &law_[cell],
                                                   static_cast<std::uint8_t>(static_cast<int>(law) + 1));
                   add_stiffness<law>(h, moduli, spacing_, table, matrix);
                 });
                 std::memcpy(matrices.data() + number * kPacked * kBlockCells, matrix, sizeof matrix);
               });
  });
}

std::size_t VoxelLaws::convexify(Matrices& matrices) const {
  std::vector<std::size_t> changed(static_cast<std::size_t>(rows_->cells[2]));
  parallel_for(changed.size(), 1, [&](std::size_t k, std::size_t) {
    for_blocks(static_cast<int>(k), [&](std::size_t cell, const Corners&, std::uint8_t, std::size_t number) {
      float* matrix = matrices.data() + number * kPacked * kBlockCells;
      Floats shift;
      for (std::size_t i = 0; i < kBlockCells; ++i)
        shift[i] = static_cast<float>(kBearable * shear_[cell + i] / spacing_);
      const Floats pivot = least_pivot(matrix, shift);
      for (std::size_t lane = 0; lane < kBlockCells; ++lane) {
        if (law_[cell + lane] == 0 || pivot[lane] > 0) continue;
        convexify_packed(lane, matrix);
        ++changed[k];
      }
    });
  });
  return std::accumulate(changed.begin(), changed.end(), std::size_t{0});
}

void VoxelLaws::apply(const Matrices& matrices, const double* in, double* out, const PlaneDone& done) const {
  in_slabs(*rows_, out, done, [&](int k) {
    for_blocks(k, [&](std::size_t, const Corners& corners, std::uint8_t, std::size_t number) {
      Modes<Floats> m;
      Floats x[kModes], y[kModes];
      load_modes<Floats>(corners, 0, in, m);
      for (std::size_t i = 0; i < kModes; ++i) x[i] = m[i / 7][i % 7 + 1];
      multiply_packed<kModes>(matrices.data() + number * kPacked * kBlockCells, x, y);
      for (auto& of_component : m) of_component[0] = Floats{};
      for (std::size_t i = 0; i < kModes; ++i) m[i / 7][i % 7 + 1] = y[i];
      add_modes<Floats>(corners, 0, m, out);
    });
  });
}

}  // namespace turgor::detail
