#include "turgor/calibration/parameter_grid.hpp"

#include <gtest/gtest.h>

#include <limits>

#include "turgor/core/random.hpp"

namespace turgor {
namespace {

std::size_t at(int i) {
  return static_cast<std::size_t>(i);
}

// Points strewn over a box from (-10, 5, 0) to (20, 11, 3), its corners among them.
std::vector<Vec3> strewn(int count) {
  const RandomStream random(7);
  std::vector<Vec3> points;
  for (int corner = 0; corner < 8; ++corner)
    points.push_back(
        {(corner & 1) != 0 ? 20.0 : -10.0, (corner & 2) != 0 ? 11.0 : 5.0, (corner & 4) != 0 ? 3.0 : 0.0});
  for (std::uint64_t i = 0; points.size() < at(count); i += 3)
    points.push_back(
        {-10 + 30 * random.uniform(i), 5 + 6 * random.uniform(i + 1), 3 * random.uniform(i + 2)});
  return points;
}

ParameterGrid grid_of(const Index3& nodes, const std::vector<Vec3>& points) {
  auto grid = make_parameter_grid(nodes, points);
  EXPECT_TRUE(grid) << (grid ? "" : grid.error().message());
  return grid ? *grid : ParameterGrid{};
}

std::vector<double> values_at(const ParameterGrid& grid, double (*f)(const Vec3&)) {
  std::vector<double> nodes;
  for (const Vec3& p : grid.positions) nodes.push_back(f(p));
  std::vector<double> out(grid.weights.rows());
  grid.weights.apply(nodes, out);
  return out;
}

TEST(ParameterGrid, WeightsOfEachPointSumToOne) {
  const auto grid = grid_of({9, 3, 3}, strewn(500));
  ASSERT_EQ(grid.weights.rows(), 500U);
  for (std::size_t row = 0; row < grid.weights.rows(); ++row) {
    double sum = 0;
    for (int i = grid.weights.offsets[row]; i < grid.weights.offsets[row + 1]; ++i) {
      EXPECT_GE(grid.weights.weights[at(i)], 0);
      sum += grid.weights.weights[at(i)];
    }
    EXPECT_NEAR(sum, 1, 1e-14);
    EXPECT_LE(grid.weights.offsets[row + 1] - grid.weights.offsets[row], 8);
  }
}

TEST(ParameterGrid, TrilinearFunctionsAreReproduced) {
  const auto points = strewn(300);
  const auto f = [](const Vec3& p) { return 2 + 3 * p.x - p.y + 0.5 * p.z + 0.1 * p.x * p.y * p.z; };
  const auto values = values_at(grid_of({5, 3, 2}, points), f);
  for (std::size_t i = 0; i < points.size(); ++i) EXPECT_NEAR(values[i], f(points[i]), 1e-11);
}

TEST(ParameterGrid, OneNodeAlongAnAxisIsConstantAlongIt) {
  const auto points = strewn(300);
  const auto grid = grid_of({4, 1, 1}, points);
  ASSERT_EQ(grid.places.size(), 4U);
  EXPECT_EQ(grid.positions[3], (Vec3{20, 8, 1.5}));
  const auto values = values_at(grid, [](const Vec3& p) { return 2 * p.x; });
  for (std::size_t i = 0; i < points.size(); ++i) EXPECT_NEAR(values[i], 2 * points[i].x, 1e-12);

  const auto homogeneous = grid_of({1, 1, 1}, points);
  EXPECT_EQ(homogeneous.weights.column_count, 1);
  EXPECT_EQ(homogeneous.weights.weights, std::vector<double>(points.size(), 1.0));
}

TEST(ParameterGrid, PointsOnNodesGetTheNodeAloneUpToTheUpperBound) {
  std::vector<Vec3> points;
  for (int k = 0; k < 3; ++k) {
    for (int j = 0; j < 3; ++j) {
      for (int i = 0; i < 9; ++i) points.push_back({0.1 * i, 0.3 * j, 0.7 * k});
    }
  }
  const auto grid = grid_of({9, 3, 3}, points);
  EXPECT_EQ(grid.places.size(), 81U);
  EXPECT_EQ(grid.weights.columns.size(), 81U);
  for (std::size_t i = 0; i < 81; ++i) EXPECT_EQ(grid.weights.columns[i], static_cast<int>(i));
  EXPECT_EQ(grid.places[9], (Index3{0, 1, 0})) << "x fastest";
}

TEST(ParameterGrid, NodesThatInfluenceNothingAreLeftOut) {
  // An L: the far upper corner of the box is empty.
  std::vector<Vec3> points;
  for (int i = 0; i <= 40; ++i) points.push_back({0.25 * i, 0, 0}), points.push_back({0, 0.25 * i, 0});
  const auto grid = grid_of({5, 5, 1}, points);
  EXPECT_EQ(grid.places.size(), 9U);
  for (const Index3& place : grid.places) EXPECT_TRUE(place[0] == 0 || place[1] == 0);
  const auto values = values_at(grid, [](const Vec3& p) { return p.x + p.y; });
  for (std::size_t i = 0; i < points.size(); ++i) EXPECT_NEAR(values[i], points[i].x + points[i].y, 1e-12);
}

TEST(ParameterGrid, AFlatBoxKeepsOneSideAndOnePointOneNode) {
  std::vector<Vec3> flat = strewn(100);
  for (Vec3& p : flat) p.z = 4;
  const auto grid = grid_of({3, 3, 3}, flat);
  EXPECT_EQ(grid.places.size(), 9U);
  for (const Index3& place : grid.places) EXPECT_EQ(place[2], 0);
  EXPECT_EQ(grid_of({9, 3, 3}, {{1, 2, 3}}).places.size(), 1U);
}

TEST(ParameterGrid, WhatCannotBeUsedIsAnError) {
  const std::vector<Vec3> points{{0, 0, 0}, {1, 1, 1}};
  constexpr double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(make_parameter_grid({0, 1, 1}, points));
  EXPECT_FALSE(make_parameter_grid({-3, -3, 1}, points));
  EXPECT_FALSE(make_parameter_grid({101, 100, 100}, points));
  EXPECT_FALSE(make_parameter_grid({2147483647, 2147483647, 2147483647}, points));
  EXPECT_FALSE(make_parameter_grid({2, 2, 2}, {}));
  EXPECT_FALSE(make_parameter_grid({2, 2, 2}, std::vector<Vec3>{{0, 0, nan}}));
  EXPECT_FALSE(make_parameter_grid({2, 2, 2}, std::vector<Vec3>{{-1.7e308, 0, 0}, {1.7e308, 0, 0}}));
  EXPECT_TRUE(make_parameter_grid({100, 100, 100}, points));
}

}  // namespace
}  // namespace turgor
