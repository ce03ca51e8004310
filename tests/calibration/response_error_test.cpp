#include <gtest/gtest.h>

#include <Eigen/Core>
#include <limits>
#include <numbers>

#include "calibration/misfit.hpp"

namespace turgor {
namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();

// The corners of a box of 2 × 4 × 6 about the origin.
std::vector<Vec3> corners() {
  std::vector<Vec3> out;
  for (int i = 0; i < 8; ++i)
    out.push_back({(i & 1) != 0 ? 1.0 : -1.0, (i & 2) != 0 ? 2.0 : -2.0, (i & 4) != 0 ? 3.0 : -3.0});
  return out;
}

ReferenceLoad load_of(const std::vector<Vec3>& places, const std::vector<double>& forces = {},
                      const std::vector<double>& weight = {}) {
  return {"pull", {places, forces}, weight};
}

double error_of(const ReferenceLoad& load, const Response& response, ErrorMeasure measure) {
  const auto error = response_error(load, response, measure);
  EXPECT_TRUE(error) << (error ? "" : error.error().message());
  return error ? *error : -1;
}

TEST(ResponseError, DistanceIsTheRootMeanSquareOverPoints) {
  const std::vector<Vec3> reference{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {5, 5, 5}};
  const Response response{{{3, 4, 0}, {1, 0, 0}, {0, 1, 1}, {5, 5, 5}}, {}};
  EXPECT_DOUBLE_EQ(error_of(load_of(reference), response, ErrorMeasure::distance), std::sqrt(26.0 / 4));
  EXPECT_DOUBLE_EQ(error_of(load_of(reference, {}, {3, 1, 0, 0}), response, ErrorMeasure::distance),
                   std::sqrt(75.0 / 4));
  EXPECT_DOUBLE_EQ(error_of(load_of(reference, {}, {3e300, 1e300, 0, 0}), response, ErrorMeasure::distance),
                   std::sqrt(75.0 / 4));
}

TEST(ResponseError, ShapeIsBlindToRigidMotion) {
  const auto motion = RigidTransform::rotate_about({5, 1, -2}, normalized(Vec3{1, 2, -3}), 2.5);
  Response response{corners(), {}};
  for (Vec3& p : response.position_mm) p = motion.point(p);
  EXPECT_NEAR(error_of(load_of(corners()), response, ErrorMeasure::shape), 0, 1e-14);
  EXPECT_GT(error_of(load_of(corners()), response, ErrorMeasure::distance), 1);
}

TEST(ResponseError, ShapeOfAStretchedAndTurnedBoxIsTheStretch) {
  const auto motion = RigidTransform::rotate_about({5, 1, -2}, normalized(Vec3{1, 2, -3}), 2.5);
  Response response{corners(), {}};
  for (Vec3& p : response.position_mm) p = motion.point({1.25 * p.x, p.y, p.z});
  EXPECT_NEAR(error_of(load_of(corners()), response, ErrorMeasure::shape), 0.25, 1e-13);
}

TEST(ResponseError, ShapeDoesNotMirror) {
  Response response{corners(), {}};
  for (Vec3& p : response.position_mm) p.x += 0.3 * p.y * p.z / 6;  // no plane of symmetry is left
  const ReferenceLoad load = load_of(response.position_mm);
  for (Vec3& p : response.position_mm) p.x = -p.x;
  EXPECT_GT(error_of(load, response, ErrorMeasure::shape), 0.1);
}

TEST(ResponseError, ShapeCountsWeightedPointsAlone) {
  Response response{corners(), {}};
  response.position_mm[0] = {50, 60, 70};
  for (Vec3& p : response.position_mm) p += Vec3{1, 2, 3};
  EXPECT_NEAR(error_of(load_of(corners(), {}, {0, 1, 1, 1, 1, 1, 1, 1}), response, ErrorMeasure::shape), 0,
              1e-14);
}

TEST(ResponseError, ShapeOfPointsInLineAndOfOnePoint) {
  const std::vector<Vec3> line{{0, 0, 0}, {1, 0, 0}, {2, 0, 0}};
  EXPECT_NEAR(error_of(load_of(line), {{{0, 0, 0}, {0, 2, 0}, {0, 4, 0}}, {}}, ErrorMeasure::shape),
              std::sqrt(2.0 / 3), 1e-14);
  EXPECT_EQ(error_of(load_of({{1, 2, 3}}), {{{7, 8, 9}}, {}}, ErrorMeasure::shape), 0);
}

TEST(ResponseError, ForceIsTheRootMeanSquareOfForces) {
  const Response response{corners(), {1, 2, 8}};
  EXPECT_DOUBLE_EQ(error_of(load_of(corners(), {1, 2, 3}), response, ErrorMeasure::force),
                   std::sqrt(25.0 / 3));
}

TEST(ResponseError, AResponseThatIsNotFiniteIsAFailure) {
  for (const double bad : {infinity, std::nan(""), 1e308}) {
    Response response{corners(), {bad}};
    response.position_mm[3].y = bad;
    for (const auto measure : {ErrorMeasure::distance, ErrorMeasure::shape, ErrorMeasure::force})
      EXPECT_EQ(error_of(load_of(corners(), {0}), response, measure), infinity) << name_of(measure);
  }
}

TEST(ResponseError, WhatCannotBeComparedIsAnError) {
  const Response response{corners(), {}};
  for (const auto measure : {ErrorMeasure::distance, ErrorMeasure::shape}) {
    EXPECT_FALSE(response_error(load_of({{0, 0, 0}}), response, measure));
    EXPECT_FALSE(response_error(load_of({}), {}, measure));
    EXPECT_FALSE(response_error(load_of(corners(), {}, {1, 1}), response, measure));
    EXPECT_FALSE(response_error(load_of(corners(), {}, {1, 1, 1, 1, 1, 1, 1, -1}), response, measure));
    EXPECT_FALSE(response_error(load_of(corners(), {}, std::vector<double>(8, 0.0)), response, measure));
    EXPECT_FALSE(response_error(load_of(corners(), {}, std::vector<double>(8, infinity)), response, measure));
  }
  EXPECT_FALSE(response_error(load_of(corners()), response, ErrorMeasure::force));
  EXPECT_FALSE(response_error(load_of(corners(), {1}), response, ErrorMeasure::force));
}

// A response of two parameters that bends, turns and pulls.
Response bent(double a, double b) {
  Response out{corners(), {a * b, a - b, a * a}};
  const auto motion = RigidTransform::rotate_about({1, 0, 0}, normalized(Vec3{1, 1, 1}), 0.4 * a * b);
  for (Vec3& p : out.position_mm)
    p = motion.point(p + Vec3{0.1 * a * p.y * p.y, 0.2 * b * p.x * p.z, 0.05 * a * b * p.z});
  return out;
}

DenseMatrix bent_jacobian(double a, double b) {
  constexpr double h = 1e-5;
  DenseMatrix out{bent(a, b).rows(), 2, {}};
  for (int column = 0; column < 2; ++column) {
    const double da = column == 0 ? h : 0, db = column == 1 ? h : 0;
    const Response more = bent(a + da, b + db), less = bent(a - da, b - db);
    for (std::size_t i = 0; i < more.position_mm.size(); ++i) {
      for (int k = 0; k < 3; ++k)
        out.values.push_back((more.position_mm[i][k] - less.position_mm[i][k]) / (2 * h));
    }
    for (std::size_t i = 0; i < more.force_n.size(); ++i)
      out.values.push_back((more.force_n[i] - less.force_n[i]) / (2 * h));
  }
  return out;
}

// Against finite differences of the error itself.
TEST(ResponseError, DerivativesAreExactForEachMeasure) {
  const ReferenceLoad load = load_of(corners(), {1, 2, 3}, {1, 2, 3, 4, 5, 6, 7, 0});
  constexpr double a = 0.7, b = 1.3, h = 1e-5;
  const DenseMatrix jacobian = bent_jacobian(a, b);
  for (const auto measure : {ErrorMeasure::distance, ErrorMeasure::shape, ErrorMeasure::force}) {
    const auto misfit = misfit_of(load, bent(a, b), measure);
    ASSERT_TRUE(misfit);
    const auto value = [&](double da, double db) { return error_of(load, bent(a + da, b + db), measure); };
    const Eigen::Vector2d expected((value(h, 0) - value(-h, 0)) / (2 * h),
                                   (value(0, h) - value(0, -h)) / (2 * h));
    const Eigen::Vector2d by_residual =
        misfit->jacobian(jacobian).transpose() * misfit->residual / misfit->error();
    const std::vector<double> seed = misfit->error_gradient(jacobian.rows);
    const Eigen::Vector2d by_seed =
        Eigen::Map<const Eigen::MatrixXd>(jacobian.values.data(), static_cast<Eigen::Index>(jacobian.rows), 2)
            .transpose() *
        Eigen::VectorXd::Map(seed.data(), static_cast<Eigen::Index>(seed.size()));
    EXPECT_LT((by_residual - expected).norm(), 1e-8 * expected.norm()) << name_of(measure);
    EXPECT_LT((by_seed - expected).norm(), 1e-8 * expected.norm()) << name_of(measure);
  }
}

// What rigid motion takes up is no part of the derivative of shape.
TEST(ResponseError, ShapeHasNoDerivativeAlongRigidMotion) {
  const auto misfit = misfit_of(load_of(corners(), {0, 0, 0}), bent(0.7, 1.3), ErrorMeasure::shape);
  ASSERT_TRUE(misfit);
  const auto places = bent(0.7, 1.3).position_mm;
  DenseMatrix turn{24 + 3, 1, {}};
  for (const Vec3& p : places) {
    const Vec3 d = cross(Vec3{1, -2, 3}, p) + Vec3{4, 5, 6};
    for (int k = 0; k < 3; ++k) turn.values.push_back(d[k]);
  }
  turn.values.insert(turn.values.end(), 3, 1.0);
  EXPECT_LT(misfit->jacobian(turn).norm(), 1e-13);
}

}  // namespace
}  // namespace turgor
