#include "fem/dense_cells.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "fem/packed_lanes.hpp"
#include "turgor/core/index.hpp"
#include "turgor/core/parallel.hpp"

namespace turgor::detail {
namespace {

constexpr std::size_t kLanes = static_cast<std::size_t>(Pack<Floats>::lanes), kRows = kCubeUnknowns;
constexpr std::size_t kNumbers = kPackedSize<kRows> * kLanes;
constexpr std::size_t kGrain = 16;
// Of the greatest number of a matrix: less is rounding.
constexpr double kRigid = 1e-12;

// The gradients across each other, of two components along the axes of one another: their sum strains, their
// difference turns.
struct Pair {
  std::size_t a, b;
};
constexpr std::array<Pair, 3> kTurns{Pair{2, 8 + 1}, Pair{4, 16 + 1}, Pair{8 + 4, 16 + 2}};

// Modes, 8 c + number, with turns and strains in place of the gradients of kTurns; and the transpose.
template <class R>
void part_turns(R* m) {
  for (const Pair& p : kTurns) {
    const R a = m[p.a], b = m[p.b];
    m[p.a] = a + b, m[p.b] = a - b;
  }
}
template <class R>
void join_turns(R* m) {
  for (const Pair& p : kTurns) {
    const R sum = m[p.a], turn = m[p.b];
    m[p.a] = sum + turn, m[p.b] = sum - turn;
  }
}

template <class R>
void to_all_modes(R* x) {
  for (std::size_t c = 0; c < 3; ++c) {
    R v[8];
    std::copy_n(x + 8 * c, 8, v);
    to_modes(v);
    std::copy_n(v, 8, x + 8 * c);
  }
}
template <class R>
void from_all_modes(R* x) {
  for (std::size_t c = 0; c < 3; ++c) {
    R v[8];
    std::copy_n(x + 8 * c, 8, v);
    from_modes(v);
    std::copy_n(v, 8, x + 8 * c);
  }
}

// Rows of a matrix of corners to what they are of modes, strains and turns.
void change_basis(double (&rows)[kRows][kRows]) {
  for (auto& row : rows) {
    to_all_modes(row);
    part_turns(row);
    for (double& v : row) v /= 8;
    for (const Pair& p : kTurns) row[p.a] *= 0.5, row[p.b] *= 0.5;
  }
}

void transpose(double (&m)[kRows][kRows]) {
  for (std::size_t a = 0; a < kRows; ++a)
    for (std::size_t b = 0; b < a; ++b) std::swap(m[a][b], m[b][a]);
}

using Matrix = double[kRows][kRows];

double greatest_of(const Matrix& m) {
  double greatest = 0;
  for (std::size_t a = 0; a < kRows; ++a) greatest = std::max(greatest, std::abs(m[a][a]));
  return greatest;
}

// Whether translations cost no energy, that is, nothing of the cell is held.
bool moves_freely(const double* matrix) {
  double greatest = 0;
  for (std::size_t a = 0; a < kRows; ++a) greatest = std::max(greatest, matrix[(kRows + 1) * a]);
  for (std::size_t a = 0; a < kRows; ++a) {
    for (std::size_t c = 0; c < 3; ++c) {
      double sum = 0;
      for (std::size_t n = 0; n < 8; ++n) sum += matrix[kRows * a + 8 * c + n];
      if (std::abs(sum) > kRigid * greatest) return false;
    }
  }
  return true;
}

void pack(const double* matrix, bool moves, std::size_t lane, float* to) {
  Matrix m;
  std::copy_n(matrix, kRows * kRows, &m[0][0]);
  if (moves) {
    change_basis(m);
    transpose(m);
    change_basis(m);
  }
  const double nothing = moves ? kRigid * greatest_of(m) : 0;
  for (std::size_t a = 0; a < kRows; ++a)
    for (std::size_t b = a; b < kRows; ++b)
      to[packed<kRows>(a, b) * kLanes + lane] =
          std::abs(m[a][b]) < nothing ? 0.0F : static_cast<float>(m[a][b]);
}

}  // namespace

DenseBlocks::DenseBlocks(const DenseCells& cells) : cells_(&cells), first_(1, 0) {
  static_assert(kWide == kLanes);
  std::vector<std::uint8_t> moves(cells.cells.size());
  parallel_for(moves.size(), kGrain, [&](std::size_t begin, std::size_t end) {
    for (std::size_t c = begin; c < end; ++c)
      moves[c] = moves_freely(cells.matrix(cells.cells[c].matrix)) ? 1 : 0;
  });
  for (std::size_t k = 0; k + 1 < cells.layers.size(); ++k) {
    for (const bool of_modes : {true, false}) {
      Block block{0, {}, of_modes};
      for (int c = cells.layers[k]; c < cells.layers[k + 1]; ++c) {
        if ((moves[at(c)] != 0) != of_modes) continue;
        block.cells[block.count++] = c;
        if (block.count == kWide) blocks_.push_back(std::exchange(block, {0, {}, of_modes}));
      }
      if (block.count > 0) blocks_.push_back(block);
    }
    first_.push_back(blocks_.size());
  }
  matrices_.resize(blocks_.size() * kNumbers);
  parallel_for(blocks_.size(), kGrain, [&](std::size_t begin, std::size_t end) {
    std::fill(matrices_.data() + begin * kNumbers, matrices_.data() + end * kNumbers, 0.0F);
    for (std::size_t b = begin; b < end; ++b)
      for (std::size_t lane = 0; lane < blocks_[b].count; ++lane)
        pack(cells.matrix(cells.cells[at(blocks_[b].cells[lane])].matrix), blocks_[b].moves, lane,
             matrices_.data() + b * kNumbers);
  });
}

void DenseBlocks::add(int layer, const float* in, float* out) const {
  for (std::size_t b = first_[at(layer)]; b < first_[at(layer) + 1]; ++b) {
    const Block& block = blocks_[b];
    Floats x[kRows] = {}, y[kRows];
    const auto each = [&](auto&& action) {
      for (std::size_t lane = 0; lane < block.count; ++lane) {
        const DenseCell& cell = cells_->cells[at(block.cells[lane])];
        for (std::size_t i = 0; i < kRows; ++i) action(i, lane, cell.corners[i % 8].component(i / 8));
      }
    };
    each([&](std::size_t i, std::size_t lane, std::size_t value) { x[i][lane] = in[value]; });
    if (block.moves) {
      to_all_modes(x);
      part_turns(x);
    }
    multiply_packed<kRows>(matrices_.data() + b * kNumbers, x, y);
    if (block.moves) {
      join_turns(y);
      from_all_modes(y);
    }
    each([&](std::size_t i, std::size_t lane, std::size_t value) { out[value] += y[i][lane]; });
  }
}

}  // namespace turgor::detail
