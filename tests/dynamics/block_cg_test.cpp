#include "dynamics/block_cg.hpp"

#include <gtest/gtest.h>

#include <Eigen/Sparse>
#include <Eigen/SparseCholesky>
#include <cmath>
#include <limits>

#include "dynamics/point_clusters.hpp"
#include "math/lanes.hpp"
#include "support/layered_slab.hpp"
#include "turgor/core/parallel.hpp"
#include "turgor/core/random.hpp"

namespace turgor {
namespace {

// A slab of several domains, shaken, its bone held.
struct System {
  NetworkEnergy energy;
  StiffnessMatrix matrix;
  std::vector<int> clusters;
  std::vector<Vec3> b;
};

System make_system(double projection, double amplitude_mm) {
  support::SlabOptions options;
  options.nx = 24;
  options.ny = 40;
  options.volumes = true;
  const support::Slab slab = support::make_slab(options);
  NetworkEnergy energy = *NetworkEnergy::prepare(slab.network);
  PrescribedMotion motion;
  for (int c = 0; c < slab.columns; ++c) motion.fixed.push_back(c);
  PointClusters free = cluster_free_points(slab.network, energy, motion, BlockCg::kClusterPoints);
  StiffnessMatrix matrix(energy, free.points);
  const RandomStream random(2);
  std::vector<Vec3> x = slab.network.rest, b(free.points.size());
  const auto vector = [&](std::size_t i) {
    return Vec3{random.normal(3 * i), random.normal(3 * i + 1), random.normal(3 * i + 2)};
  };
  for (std::size_t i = 0; i < x.size(); ++i) x[i] += vector(i) * amplitude_mm;
  for (std::size_t i = 0; i < b.size(); ++i) b[i] = vector(i + 100'000);
  ElementStiffness k;
  energy.linearise(x, projection, k);
  matrix.assemble(energy, k);
  return {std::move(energy), std::move(matrix), std::move(free.offsets), std::move(b)};
}

Eigen::SparseMatrix<double> sparse(const StiffnessMatrix& matrix) {
  std::vector<Eigen::Triplet<double>> entries;
  for (int i = 0; i < matrix.rows(); ++i) {
    for (int k = matrix.offsets()[i]; k < matrix.offsets()[i + 1]; ++k) {
      for (int r = 0; r < 3; ++r) {
        for (int c = 0; c < 3; ++c) {
          entries.emplace_back(3 * i + r, 3 * matrix.columns()[k] + c,
                               matrix.blocks()[k].c[static_cast<std::size_t>(c)][r]);
        }
      }
    }
  }
  Eigen::SparseMatrix<double> m(3 * matrix.rows(), 3 * matrix.rows());
  m.setFromTriplets(entries.begin(), entries.end());
  return m;
}

TEST(BlockCg, AgreesWithASparseDirectSolver) {
  const System s = make_system(1.0, 0.3);
  BlockCg cg(s.matrix, s.clusters);
  ASSERT_TRUE(cg.factor(s.matrix, 0));
  std::vector<Vec3> x(s.b.size());
  Context context;
  const CgResult result = cg.solve(s.b, 1e-12, 2000, context, x);
  EXPECT_EQ(result.outcome, CgOutcome::converged);
  EXPECT_LT(result.iterations, 200) << "the preconditioner works";
  const Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>> direct(sparse(s.matrix));
  Eigen::VectorXd b(3 * static_cast<Eigen::Index>(s.b.size()));
  for (std::size_t i = 0; i < s.b.size(); ++i) {
    for (int k = 0; k < 3; ++k) b[3 * static_cast<Eigen::Index>(i) + k] = s.b[i][k];
  }
  const Eigen::VectorXd expected = direct.solve(b);
  double largest = 0;
  for (std::size_t i = 0; i < x.size(); ++i) {
    for (int k = 0; k < 3; ++k) {
      const auto at = 3 * static_cast<Eigen::Index>(i) + k;
      largest = std::max(largest, std::abs(x[i][k] - expected[at]));
    }
  }
  // Blocks in single precision and a millionth more stiffness on the diagonal bound the agreement.
  EXPECT_LT(largest, 1e-4 * expected.lpNorm<Eigen::Infinity>());
}

TEST(BlockCg, CoupledRowsJoinTheMatrix) {
  const System s = make_system(1.0, 0.3);
  const int last = s.matrix.rows() - 1;  // across domains, and two rows of one cluster
  const Mat3 stiffness{{Vec3{5, 1, 0}, Vec3{1, 3, -1}, Vec3{0, -1, 2}}};
  const std::array coupled = {CoupledStiffness{{last, 0, 1, last / 2}, {0.1, 0.3, 0.4, 0.2}, stiffness},
                              CoupledStiffness{{7}, {1.0}, stiffness}};
  BlockCg cg(s.matrix, s.clusters);
  ASSERT_TRUE(cg.factor(s.matrix, 0, coupled));
  std::vector<Vec3> x(s.b.size());
  Context context;
  ASSERT_EQ(cg.solve(s.b, 1e-12, 2000, context, x).outcome, CgOutcome::converged);
  std::vector<Vec3> product(x.size());
  for (int i = 0; i <= last; ++i) {
    for (int k = s.matrix.offsets()[i]; k < s.matrix.offsets()[i + 1]; ++k)
      product[static_cast<std::size_t>(i)] +=
          s.matrix.blocks()[k] * x[static_cast<std::size_t>(s.matrix.columns()[k])];
  }
  for (const CoupledStiffness& term : coupled) {
    Vec3 mean;
    for (std::size_t i = 0; i < term.rows.size(); ++i)
      mean += x[static_cast<std::size_t>(term.rows[i])] * term.weights[i];
    for (std::size_t i = 0; i < term.rows.size(); ++i)
      product[static_cast<std::size_t>(term.rows[i])] += term.stiffness * mean * term.weights[i];
  }
  for (std::size_t i = 0; i < x.size(); ++i) EXPECT_LT(distance(product[i], s.b[i]), 1e-3) << i;
}

TEST(BlockCg, DampingAddsToTheDiagonal) {
  const System s = make_system(1.0, 0.1);
  BlockCg cg(s.matrix, s.clusters);
  std::vector<Vec3> x(s.b.size());
  Context context;
  double mean = 0;
  for (int i = 0; i < s.matrix.rows(); ++i) {
    const Mat3& d = s.matrix.blocks()[s.matrix.diagonal()[i]];
    mean += (d.c[0].x + d.c[1].y + d.c[2].z) / (3.0 * s.matrix.rows());
  }
  ASSERT_TRUE(cg.factor(s.matrix, 1e6));
  cg.solve(s.b, 1e-12, 2000, context, x);
  for (std::size_t i = 0; i < x.size(); ++i) EXPECT_LT(distance(x[i] * (1e6 * mean), s.b[i]), 1e-4);
}

TEST(BlockCg, ReportsNegativeCurvatureAndStillDescends) {
  const System s = make_system(0.0, 0.9);
  BlockCg cg(s.matrix, s.clusters);
  std::vector<Vec3> x(s.b.size());
  Context context;
  if (cg.factor(s.matrix, 0)) {
    EXPECT_EQ(cg.solve(s.b, 1e-10, 2000, context, x).outcome, CgOutcome::indefinite);
    double slope = 0;
    for (std::size_t i = 0; i < x.size(); ++i) slope += dot(x[i], s.b[i]);
    EXPECT_GE(slope, 0);
  } else {
    // A diagonal block that is not positive definite says the same earlier.
    EXPECT_TRUE(cg.factor(s.matrix, 100));
  }
}

TEST(BlockCg, StopsAtItsLimitAndOnRequest) {
  const System s = make_system(1.0, 0.3);
  BlockCg cg(s.matrix, s.clusters);
  ASSERT_TRUE(cg.factor(s.matrix, 0));
  std::vector<Vec3> x(s.b.size());
  Context context;
  const CgResult limited = cg.solve(s.b, 1e-12, 3, context, x);
  EXPECT_EQ(limited.outcome, CgOutcome::iteration_limit);
  EXPECT_EQ(limited.iterations, 3);
  Context stopped({}, {}, [] { return true; });
  EXPECT_EQ(cg.solve(s.b, 1e-14, 2000, stopped, x).outcome, CgOutcome::cancelled);
}

TEST(BlockCg, HasTheSameBitsOnOneAndTwoThreads) {
  const System s = make_system(1.0, 0.3);
  const auto run = [&](int threads) {
    set_thread_count(threads);
    BlockCg cg(s.matrix, s.clusters);
    EXPECT_TRUE(cg.factor(s.matrix, 0));
    std::vector<Vec3> x(s.b.size());
    Context context;
    cg.solve(s.b, 1e-9, 2000, context, x);
    return x;
  };
  const std::vector<Vec3> one = run(1), two = run(2);
  set_thread_count(0);
  EXPECT_TRUE(one == two);
}

TEST(Lanes, ExponentialIsThatOfTheLibraryToRoundOff) {
  for (double x = -720; x <= 0; x += 0.37) {
    const double got = exp_of_negative(broadcast(x))[1], expected = x > -700 ? std::exp(x) : 0.0;
    EXPECT_NEAR(got, expected, 1e-15 * expected) << x;
  }
  EXPECT_EQ(exp_of_negative(broadcast(0))[0], 1.0);
  EXPECT_EQ(exp_of_negative(broadcast(-std::numeric_limits<double>::infinity()))[2], 0.0);
}

TEST(Lanes, SquareRootIsTheIeeeOne) {
  for (double x = 0; x < 50; x += 0.173) EXPECT_EQ(sqrt(broadcast(x))[3], std::sqrt(x));
}

}  // namespace
}  // namespace turgor
