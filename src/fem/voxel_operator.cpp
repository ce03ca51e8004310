#include "fem/voxel_operator.hpp"

#include <algorithm>
#include <cstring>

#include "turgor/core/parallel.hpp"

namespace turgor::detail {
namespace {

template <class T>
struct PackOf;
template <>
struct PackOf<float> {
  using Type = float __attribute__((vector_size(32)));
};
template <>
struct PackOf<double> {
  using Type = double __attribute__((vector_size(32)));
};
template <class T>
using Pack = typename PackOf<T>::Type;
template <class T>
inline constexpr int kWidth = static_cast<int>(32 / sizeof(T));

template <class T>
Pack<T> load(const T* from) {
  Pack<T> v;
  std::memcpy(&v, from, sizeof v);
  return v;
}
template <class T>
void store(T* to, const Pack<T>& v) {
  std::memcpy(to, &v, sizeof v);
}

// The last of `before`, then all but the last of `v`.
inline Pack<float> moved_on(const Pack<float>& before, const Pack<float>& v) {
  return __builtin_shufflevector(before, v, 7, 8, 9, 10, 11, 12, 13, 14);
}
inline Pack<double> moved_on(const Pack<double>& before, const Pack<double>& v) {
  return __builtin_shufflevector(before, v, 3, 4, 5, 6);
}

// Modes of the displacement to modes of the force, of as many cells as a pack holds; by component and mode.
template <class T>
inline __attribute__((always_inline)) void multiply(const CubeModes<T>& s, const CubeModes<T>& b,
                                                    const Pack<T>& mu, const Pack<T>& kappa,
                                                    Pack<T> (&m)[3][8]) {
  {
    const Pack<T> own = mu * s.axial + kappa * b.axial, pair = mu * s.axial_pair + kappa * b.axial_pair;
    const Pack<T> sum = (m[0][1] + m[1][2] + m[2][4]) * pair;
    m[0][1] = m[0][1] * own + sum, m[1][2] = m[1][2] * own + sum, m[2][4] = m[2][4] * own + sum;
  }
  {
    const Pack<T> own = mu * s.bending + kappa * b.bending,
                  pair = mu * s.bending_pair + kappa * b.bending_pair;
    const Pack<T> x = (m[1][3] + m[2][5]) * pair, y = (m[0][3] + m[2][6]) * pair,
                  z = (m[0][5] + m[1][6]) * pair;
    m[1][3] = m[1][3] * own + x, m[2][5] = m[2][5] * own + x;
    m[0][3] = m[0][3] * own + y, m[2][6] = m[2][6] * own + y;
    m[0][5] = m[0][5] * own + z, m[1][6] = m[1][6] * own + z;
  }
  {
    const Pack<T> shear = mu * s.shear + kappa * b.shear, hourglass = mu * s.hourglass + kappa * b.hourglass;
    m[0][2] = m[1][1] = (m[0][2] + m[1][1]) * shear;
    m[0][4] = m[2][1] = (m[0][4] + m[2][1]) * shear;
    m[1][4] = m[2][2] = (m[1][4] + m[2][2]) * shear;
    for (auto& of_component : m) of_component[7] = of_component[7] * hourglass;
  }
  {
    const Pack<T> own = mu * s.twist + kappa * b.twist, pair = mu * s.twist_pair + kappa * b.twist_pair;
    const Pack<T> sum = (m[0][6] + m[1][5] + m[2][3]) * pair;
    m[0][6] = m[0][6] * own + sum, m[1][5] = m[1][5] * own + sum, m[2][3] = m[2][3] * own + sum;
  }
}

// The rows of nodes around a row of cells, by bits y 1, z 2, and what of the last block belongs to the node
// after it.
template <class T>
struct Beam {
  const T* in[4][3];
  T* out[4][3];
  Pack<T> carry[4][3];

  Beam(const VoxelRows& rows, int j, int k, int first, const T* from, T* to) {
    for (int q = 0; q < 4; ++q) {
      const NodeRow& row = rows.node_row(j + (q & 1), k + (q >> 1));
      for (int c = 0; c < 3; ++c) {
        const std::size_t start = row.offset + static_cast<std::size_t>(c * row.count + first - row.first);
        in[q][c] = from + start, out[q][c] = to + start, carry[q][c] = Pack<T>{};
      }
    }
  }
  void flush(std::size_t at) {
    for (int q = 0; q < 4; ++q) {
      for (int c = 0; c < 3; ++c) {
        out[q][c][at] += carry[q][c][kWidth<T> - 1];
        carry[q][c] = Pack<T>{};
      }
    }
  }
};

template <class T>
inline __attribute__((always_inline)) void cells(const CubeModes<T>& s, const CubeModes<T>& b,
                                                 const Pack<T>& mu, const Pack<T>& kappa, std::size_t at,
                                                 Beam<T>& beam) {
  Pack<T> m[3][8];
  for (int c = 0; c < 3; ++c) {
    Pack<T> t[8];
    for (int q = 0; q < 4; ++q) {
      const Pack<T> low = load(beam.in[q][c] + at), high = load(beam.in[q][c] + at + 1);
      t[2 * q] = high + low, t[2 * q + 1] = high - low;
    }
    for (int i = 0; i < 2; ++i) {
      const Pack<T> sum0 = t[2 + i] + t[i], slope0 = t[2 + i] - t[i];
      const Pack<T> sum1 = t[6 + i] + t[4 + i], slope1 = t[6 + i] - t[4 + i];
      m[c][i] = sum1 + sum0, m[c][4 + i] = sum1 - sum0;
      m[c][2 + i] = slope1 + slope0, m[c][6 + i] = slope1 - slope0;
    }
  }
  multiply(s, b, mu, kappa, m);
  for (int c = 0; c < 3; ++c) {
    Pack<T> t[8];
    const bool moves[2] = {true, false};  // mode 1 of each component is free: no force
    for (int i = 0; i < 2; ++i) {
      const Pack<T> constant = moves[i] ? Pack<T>{} : m[c][i];
      const Pack<T> low0 = constant - m[c][4 + i], low1 = constant + m[c][4 + i];
      const Pack<T> high0 = m[c][2 + i] - m[c][6 + i], high1 = m[c][2 + i] + m[c][6 + i];
      t[i] = low0 - high0, t[2 + i] = low0 + high0;
      t[4 + i] = low1 - high1, t[6 + i] = low1 + high1;
    }
    for (int q = 0; q < 4; ++q) {
      const Pack<T> low = t[2 * q] - t[2 * q + 1], high = t[2 * q] + t[2 * q + 1];
      T* to = beam.out[q][c] + at;
      store(to, load(to) + (low + moved_on(beam.carry[q][c], high)));
      beam.carry[q][c] = high;
    }
  }
}

template <class T>
void row_of_cells(const CubeModes<T>& s, const CubeModes<T>& b, const T* shear, const T* bulk,
                  const std::uint8_t* used, int count, Beam<T>& beam) {
  bool carries = false;
  for (int x = 0; x < count; x += kBlockCells) {
    const auto at = static_cast<std::size_t>(x);
    if (used[at / kBlockCells] == 0) {
      if (carries) beam.flush(at);
      carries = false;
      continue;
    }
    for (std::size_t i = at; i < at + kBlockCells; i += kWidth<T>)
      cells<T>(s, b, load(shear + i), load(bulk + i), i, beam);
    carries = true;
  }
}

// 1/64 from the basis of modes being used unscaled, both ways.
template <class T>
CubeModes<T> scaled(const CubeModes<double>& m) {
  const auto f = [](double x) { return static_cast<T>(x / 64); };
  return {f(m.axial), f(m.axial_pair), f(m.bending), f(m.bending_pair),
          f(m.shear), f(m.hourglass),  f(m.twist),   f(m.twist_pair)};
}

}  // namespace

template <class T>
VoxelOperator<T>::VoxelOperator(const VoxelRows& rows, const CubeStiffness& stiffness,
                                const std::vector<T>& shear, const std::vector<T>& bulk,
                                const DenseBlocks* dense)
    : rows_(&rows),
      shear_(scaled<T>(stiffness.shear)),
      bulk_(scaled<T>(stiffness.bulk)),
      shear_of_(&shear),
      bulk_of_(&bulk),
      dense_(dense),
      used_(rows.cell_count / kBlockCells) {
  for (std::size_t i = 0; i < rows.cell_count; ++i)
    if (shear[i] != T(0) || bulk[i] != T(0)) used_[i / kBlockCells] = 1;
}

template <class T>
void VoxelOperator<T>::layer(int k, const T* in, T* out) const {
  for (int j = 0; j < rows_->cells[1]; ++j) {
    const CellRow& row = rows_->cell_row(j, k);
    if (row.end == row.first) continue;
    Beam<T> beam(*rows_, j, k, row.first, in, out);
    const int count = row.end - row.first;
    row_of_cells(shear_, bulk_, shear_of_->data() + row.offset, bulk_of_->data() + row.offset,
                 used_.data() + row.offset / kBlockCells, count, beam);
    // A row of nodes goes on after its last block of cells only where a cell ends there.
    for (int q = 0; q < 4; ++q) {
      const NodeRow& nodes = rows_->node_row(j + (q & 1), k + (q >> 1));
      if (row.end >= nodes.first + nodes.count) continue;
      for (int c = 0; c < 3; ++c) beam.out[q][c][count] += beam.carry[q][c][kWidth<T> - 1];
    }
  }
  if constexpr (std::is_same_v<T, float>)
    if (dense_ != nullptr) dense_->add(k, in, out);
}

template <class T>
void VoxelOperator<T>::apply(const T* in, T* out, const PlaneDone& done) const {
  in_slabs(*rows_, out, done, [&](int k) { layer(k, in, out); });
}

template class VoxelOperator<float>;
template class VoxelOperator<double>;

}  // namespace turgor::detail
