#include "dynamics/stiffness_factors.hpp"

#include <Eigen/OrderingMethods>
#include <Eigen/SparseCholesky>
#include <algorithm>
#include <array>

#include "turgor/core/index.hpp"
#include "turgor/core/parallel.hpp"

namespace turgor {
namespace {

using Sparse = Eigen::SparseMatrix<double>;
using Triplets = std::vector<Eigen::Triplet<double>>;

// Right-hand sides that one pass over the factors solves.
constexpr std::size_t kSides = 8;
// A pivot that is left of so little of its diagonal is rounding.
constexpr double kLeastPivot = 1e-13;

/// Place of each row in the order of elimination.
std::vector<int> places(const StiffnessMatrix& matrix, std::span<const CoupledStiffness> coupled) {
  Triplets entries;
  for (int row = 0; row < matrix.rows(); ++row)
    for (int k = matrix.offsets()[at(row)]; k < matrix.offsets()[at(row) + 1]; ++k)
      entries.emplace_back(row, matrix.columns()[at(k)], 1.0);
  for (const CoupledStiffness& term : coupled)
    for (const int a : term.rows)
      for (const int b : term.rows) entries.emplace_back(a, b, 1.0);
  Sparse pattern(matrix.rows(), matrix.rows());
  pattern.setFromTriplets(entries.begin(), entries.end());
  Eigen::AMDOrdering<int>::PermutationType order;
  Eigen::AMDOrdering<int>()(pattern, order);
  std::vector<int> place(at(matrix.rows()));
  for (int k = 0; k < matrix.rows(); ++k) place[at(order.indices()[k])] = k;
  return place;
}

void add_lower(const Mat3& block, int row, int column, Triplets& entries) {
  for (int j = 0; j < 3; ++j) {
    for (int i = 0; i < 3; ++i) {
      if (3 * row + i >= 3 * column + j) entries.emplace_back(3 * row + i, 3 * column + j, block.c[at(j)][i]);
    }
  }
}

Sparse lower_triangle(const StiffnessMatrix& matrix, std::span<const CoupledStiffness> coupled,
                      const std::vector<int>& place) {
  Triplets entries;
  for (int row = 0; row < matrix.rows(); ++row) {
    for (int k = matrix.offsets()[at(row)]; k < matrix.offsets()[at(row) + 1]; ++k)
      add_lower(matrix.blocks()[at(k)], place[at(row)], place[at(matrix.columns()[at(k)])], entries);
  }
  for (const CoupledStiffness& term : coupled) {
    for (std::size_t a = 0; a < term.rows.size(); ++a) {
      for (std::size_t b = 0; b < term.rows.size(); ++b) {
        const double w = term.weights[a] * term.weights[b];
        const Mat3& s = term.stiffness;
        add_lower(Mat3{{s.c[0] * w, s.c[1] * w, s.c[2] * w}}, place[at(term.rows[a])],
                  place[at(term.rows[b])], entries);
      }
    }
  }
  Sparse out(3 * matrix.rows(), 3 * matrix.rows());
  out.setFromTriplets(entries.begin(), entries.end());
  return out;
}

using Row = std::array<double, kSides>;

}  // namespace

struct StiffnessFactors::Parts {
  std::vector<int> place;
  Eigen::SimplicialLDLT<Sparse, Eigen::Lower, Eigen::NaturalOrdering<int>> factors;

  void solve(std::vector<Row>& x) const {
    const Sparse& l = factors.matrixL().nestedExpression();  // strictly below the diagonal
    const auto& d = factors.vectorD();
    for (int j = 0; j < l.cols(); ++j) {
      const Row known = x[at(j)];
      for (Sparse::InnerIterator it(l, j); it; ++it) {
        Row& below = x[at(static_cast<int>(it.row()))];
        for (std::size_t s = 0; s < kSides; ++s) below[s] -= it.value() * known[s];
      }
    }
    for (int j = static_cast<int>(l.cols()) - 1; j >= 0; --j) {
      Row sum = x[at(j)];
      for (std::size_t s = 0; s < kSides; ++s) sum[s] /= d[j];
      for (Sparse::InnerIterator it(l, j); it; ++it) {
        const Row& below = x[at(static_cast<int>(it.row()))];
        for (std::size_t s = 0; s < kSides; ++s) sum[s] -= it.value() * below[s];
      }
      x[at(j)] = sum;
    }
  }
};

StiffnessFactors::StiffnessFactors(std::unique_ptr<Parts> parts) : parts_(std::move(parts)) {}
StiffnessFactors::StiffnessFactors(StiffnessFactors&&) noexcept = default;
StiffnessFactors& StiffnessFactors::operator=(StiffnessFactors&&) noexcept = default;
StiffnessFactors::~StiffnessFactors() = default;

std::optional<StiffnessFactors> StiffnessFactors::of(const StiffnessMatrix& matrix,
                                                     std::span<const CoupledStiffness> coupled) {
  auto parts = std::make_unique<Parts>();
  if (matrix.rows() == 0) return StiffnessFactors(std::move(parts));
  parts->place = places(matrix, coupled);
  const Sparse lower = lower_triangle(matrix, coupled, parts->place);
  parts->factors.compute(lower);
  if (parts->factors.info() != Eigen::Success) return std::nullopt;
  const Eigen::VectorXd diagonal = lower.diagonal();
  for (int j = 0; j < diagonal.size(); ++j) {
    if (!(parts->factors.vectorD()[j] > kLeastPivot * diagonal[j])) return std::nullopt;
  }
  return StiffnessFactors(std::move(parts));
}

void StiffnessFactors::solve(std::span<std::vector<Vec3>> sides) const {
  const std::vector<int>& place = parts_->place;
  if (place.empty()) return;
  parallel_for(sides.size(), kSides, [&](std::size_t begin, std::size_t end) {
    std::vector<Row> x(3 * place.size(), Row{});
    for (std::size_t row = 0; row < place.size(); ++row)
      for (std::size_t s = begin; s < end; ++s)
        for (int i = 0; i < 3; ++i) x[at(3 * place[row] + i)][s - begin] = sides[s][row][i];
    parts_->solve(x);
    for (std::size_t row = 0; row < place.size(); ++row)
      for (std::size_t s = begin; s < end; ++s)
        for (int i = 0; i < 3; ++i) sides[s][row][i] = x[at(3 * place[row] + i)][s - begin];
  });
}

}  // namespace turgor
