// Coarse cells with matrices of their own, as they are multiplied.
#include "fem/dense_cells.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "turgor/core/random.hpp"
#include "turgor/math/vec.hpp"

namespace turgor::detail {
namespace {

constexpr std::size_t kCells = 19;  // in two layers, the blocks of neither full

// Cells that share no node; every third is held: its matrix is of no form.
DenseCells cells_apart() {
  DenseCells dense;
  dense.layers = {0, 11, static_cast<int>(kCells)};
  dense.matrices.resize(kCells * kCubeUnknowns * kCubeUnknowns);
  const RandomStream random(3);
  const CubeStiffness cube = cube_stiffness(2);
  const CubeMatrix shear = matrix_of(cube.shear), bulk = matrix_of(cube.bulk);
  for (std::size_t c = 0; c < kCells; ++c) {
    double* m = dense.matrices.data() + c * shear.size();
    for (std::size_t e = 0; e < shear.size(); ++e) {
      const std::size_t a = e / kCubeUnknowns, b = e % kCubeUnknowns;
      const double free = 0.3 * shear[e] + 40 * bulk[e];
      m[e] = c % 3 == 0 ? random.uniform(c * 1000 + std::max(a, b) * 24 + std::min(a, b)) - 0.5 : free;
    }
    DenseCell cell{0, 0, c < 11 ? 0 : 1, static_cast<int>(c), {}};
    for (std::uint32_t n = 0; n < 8; ++n)
      cell.corners[n] = {static_cast<std::uint32_t>(c * kCubeUnknowns) + 3 * n, 1};
    dense.cells.push_back(cell);
  }
  return dense;
}

std::vector<float> product(const DenseCells& dense, const std::vector<float>& in) {
  std::vector<float> out(in.size(), 0.0F);
  const DenseBlocks blocks(dense);
  for (const int layer : {0, 1}) blocks.add(layer, in.data(), out.data());
  return out;
}

TEST(DenseBlocks, MultiplyAsTheirMatricesDo) {
  const DenseCells dense = cells_apart();
  const RandomStream random(7);
  std::vector<float> in(kCells * kCubeUnknowns);
  for (std::size_t i = 0; i < in.size(); ++i) in[i] = static_cast<float>(random.uniform(i) - 0.5);
  const std::vector<float> out = product(dense, in);
  for (std::size_t c = 0; c < kCells; ++c) {
    const auto value = [&](std::size_t unknown) {
      return dense.cells[c].corners[unknown % 8].component(unknown / 8);
    };
    for (std::size_t a = 0; a < kCubeUnknowns; ++a) {
      double sum = 0, size = 0;
      for (std::size_t b = 0; b < kCubeUnknowns; ++b) {
        const double term =
            dense.matrix(static_cast<int>(c))[kCubeUnknowns * a + b] * static_cast<double>(in[value(b)]);
        sum += term, size += std::abs(term);
      }
      EXPECT_NEAR(static_cast<double>(out[value(a)]), sum, 1e-5 * size) << c << " " << a;
    }
  }
}

// A slender body bends so softly that rounding here would be stiffer.
TEST(DenseBlocks, RigidMotionsOfFreeCellsCostNothing) {
  const DenseCells dense = cells_apart();
  const Vec3 move{0.7, -0.3, 0.4}, turn{0.25, -0.5, 0.125};
  std::vector<float> in(kCells * kCubeUnknowns);
  for (std::size_t c = 0; c < kCells; ++c) {
    for (int n = 0; n < 8; ++n) {
      const Vec3 place{(n & 1) * 2.0, ((n >> 1) & 1) * 2.0, (n >> 2) * 2.0}, u = move + cross(turn, place);
      for (std::size_t a = 0; a < 3; ++a)
        in[dense.cells[c].corners[static_cast<std::size_t>(n)].component(a)] =
            static_cast<float>(u[static_cast<int>(a)]);
    }
  }
  const std::vector<float> out = product(dense, in);
  for (std::size_t c = 0; c < kCells; ++c)
    for (std::size_t i = 0; c % 3 != 0 && i < kCubeUnknowns; ++i)
      EXPECT_NEAR(static_cast<double>(out[c * kCubeUnknowns + i]), 0, 1e-5) << c << " " << i;
}

}  // namespace
}  // namespace turgor::detail
