#include "turgor/geometry/tetra_embedding.hpp"

#include <gtest/gtest.h>

#include <limits>

#include "shapes.hpp"
#include "turgor/core/parallel.hpp"
#include "turgor/geometry/voxel_solid.hpp"

namespace turgor {
namespace {

using Tetra = std::array<int, 4>;

SolidMesh solid_ball(int resolution) {
  VoxelOptions options;
  options.resolution = resolution;
  auto voxels = voxelise(testing::sphere(30, 4, {5, -20, 900}), options);
  return *solid_of(*voxels);
}

/// Spread through a box about the ball, within it and beside it.
std::vector<Vec3> cloud(std::size_t count) {
  const RandomStream random(7);
  std::vector<Vec3> points;
  for (std::size_t i = 0; i < count; ++i) {
    const auto coordinate = [&](std::uint64_t k) { return 80 * (random.uniform(3 * i + k) - 0.5); };
    points.push_back(Vec3{5, -20, 900} + Vec3{coordinate(0), coordinate(1), coordinate(2)});
  }
  return points;
}

std::vector<Vec3> carried(const TetraEmbedding& embedding, std::span<const Vec3> values) {
  std::vector<Vec3> out(embedding.places().size());
  embedding.apply(values, out);
  return out;
}

const std::vector<Vec3> corners{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};

TEST(TetraEmbedding, CarriesAffineMotionsExactlyInsideAndOutside) {
  const SolidMesh solid = solid_ball(12);
  const auto targets = cloud(3000);
  const auto embedding = TetraEmbedding::bind(solid.points, solid.tetrahedra, targets);
  ASSERT_TRUE(embedding) << embedding.error().message();
  const Mat3 matrix{{Vec3{1.2, 0.3, -0.1}, {-0.4, 0.8, 0.2}, {0.5, 0, 1.1}}};
  const auto affine = [&](const Vec3& p) { return matrix * p + Vec3{3, 4, -5}; };
  std::vector<Vec3> moved;
  for (const Vec3& p : solid.points) moved.push_back(affine(p));
  const auto found = carried(*embedding, moved);
  for (std::size_t i = 0; i < targets.size(); ++i) EXPECT_LT(distance(found[i], affine(targets[i])), 1e-9);
}

TEST(TetraEmbedding, TellsInsideFromOutside) {
  const SolidMesh solid = solid_ball(12);
  const auto targets = cloud(2000);
  const auto embedding = TetraEmbedding::bind(solid.points, solid.tetrahedra, targets);
  ASSERT_TRUE(embedding);
  int within = 0;
  for (std::size_t i = 0; i < targets.size(); ++i) {
    const auto& place = embedding->places()[i];
    EXPECT_EQ(embedding->corners()[i], solid.tetrahedra[static_cast<std::size_t>(place.tetrahedron)]);
    double sum = 0;
    for (const double w : place.weights) sum += w;
    EXPECT_NEAR(sum, 1, 1e-12);
    const bool positive = *std::min_element(place.weights.begin(), place.weights.end()) >= -1e-9;
    EXPECT_EQ(positive, place.outside_mm == 0);
    const double from_centre = distance(targets[i], {5, -20, 900});
    EXPECT_TRUE(from_centre > 29 || place.outside_mm == 0);
    EXPECT_TRUE(from_centre < 40 || place.outside_mm > 0);
    within += positive;
  }
  EXPECT_GT(within, 200);
  EXPECT_LT(within, 1800);
}

/// Distance of a point to a tetrahedron, at most a sample too far.
double distance_by_sampling(const std::array<Vec3, 4>& c, const Vec3& p) {
  constexpr int n = 24;
  double least = 1e300;
  for (int i = 0; i <= n; ++i) {
    for (int j = 0; i + j <= n; ++j) {
      for (int k = 0; i + j + k <= n; ++k) {
        const Vec3 q = (c[0] * i + c[1] * j + c[2] * k + c[3] * (n - i - j - k)) / n;
        least = std::min(least, distance(p, q));
      }
    }
  }
  return least;
}

TEST(TetraEmbedding, TakesTheNearestTetrahedronByTrueDistance) {
  const SolidMesh solid = solid_ball(4);
  const auto targets = cloud(12);
  const auto embedding = TetraEmbedding::bind(solid.points, solid.tetrahedra, targets);
  ASSERT_TRUE(embedding);
  for (std::size_t i = 0; i < targets.size(); ++i) {
    double least = 1e300;
    for (const Tetra& t : solid.tetrahedra) {
      std::array<Vec3, 4> c;
      for (std::size_t k = 0; k < 4; ++k) c[k] = solid.points[static_cast<std::size_t>(t[k])];
      least = std::min(least, distance_by_sampling(c, targets[i]));
    }
    const double found = embedding->places()[i].outside_mm;
    EXPECT_LE(found, least + 1e-12);
    EXPECT_NEAR(found, least, 0.8);  // samples lie 0.9 mm apart at most
  }
}

TEST(TetraEmbedding, GivesSharedFacesToTheLowestNumber) {
  // Two tetrahedra over the face 1 2 3, in either order.
  std::vector<Vec3> points = corners;
  points.push_back({1, 1, 1});
  const std::vector<Vec3> targets{
      Vec3{1, 1, 1} / 3.0, {1, 0, 0}, {0.5, 0.5, 0}, {0.5, 0.5, 0.5}, {0.1, 0.1, 0.1}};
  for (const auto& order :
       {std::array{Tetra{0, 1, 2, 3}, Tetra{4, 1, 3, 2}}, std::array{Tetra{4, 1, 3, 2}, Tetra{0, 1, 2, 3}}}) {
    const auto embedding = TetraEmbedding::bind(points, order, targets);
    ASSERT_TRUE(embedding);
    for (std::size_t i = 0; i < 3; ++i) {
      EXPECT_EQ(embedding->places()[i].tetrahedron, 0);
      EXPECT_EQ(embedding->places()[i].outside_mm, 0);
    }
    EXPECT_EQ(order[static_cast<std::size_t>(embedding->places()[3].tetrahedron)][0], 4);
    EXPECT_EQ(order[static_cast<std::size_t>(embedding->places()[4].tetrahedron)][0], 0);
  }
}

TEST(TetraEmbedding, GivesTheLowestNumberAlsoToWhatRoundingMoved) {
  const SolidMesh solid = solid_ball(7);
  const RandomStream random(5);
  std::vector<Vec3> targets;
  for (const Tetra& t : solid.tetrahedra) {
    Vec3 sum;
    for (const int k : {2, 0, 3}) targets.push_back((sum += solid.points[static_cast<std::size_t>(t[k])]));
    targets[targets.size() - 2] /= 2;
    targets.back() /= 3;
  }
  for (std::size_t i = 0; i < targets.size(); ++i) targets[i] += testing::random_direction(random, i) * 1e-11;
  const auto embedding = TetraEmbedding::bind(solid.points, solid.tetrahedra, targets);
  ASSERT_TRUE(embedding);
  for (std::size_t i = 0; i < targets.size(); i += 13) {
    const auto& place = embedding->places()[i];
    EXPECT_EQ(place.outside_mm, 0);
    for (std::size_t t = 0; t < static_cast<std::size_t>(place.tetrahedron); ++t) {
      const auto other = TetraEmbedding::bind(solid.points, std::span(solid.tetrahedra).subspan(t, 1),
                                              std::span(targets).subspan(i, 1));
      ASSERT_GT(other->places()[0].outside_mm, 0) << i << ' ' << t;
    }
  }
}

TEST(TetraEmbedding, MeasuresDistancesToFacesEdgesAndCorners) {
  const std::vector<Vec3> targets{{0.2, 0.2, -2}, {0.5, -3, -4}, {-1, -2, -2}, {1, 1, 1}};
  for (const Tetra& t : {Tetra{0, 1, 2, 3}, Tetra{0, 2, 1, 3}}) {  // either facing
    const auto embedding = TetraEmbedding::bind(corners, std::vector{t}, targets);
    ASSERT_TRUE(embedding);
    const auto outside = [&](std::size_t i) { return embedding->places()[i].outside_mm; };
    EXPECT_NEAR(outside(0), 2, 1e-12);
    EXPECT_NEAR(outside(1), 5, 1e-12);
    EXPECT_NEAR(outside(2), 3, 1e-12);
    EXPECT_NEAR(outside(3), 2 / std::sqrt(3.0), 1e-12);
    EXPECT_NEAR(embedding->places()[0].weights[3], -2, 1e-12);
  }
}

TEST(TetraEmbedding, PassesOverFlatTetrahedra) {
  std::vector<Vec3> points = corners;
  points.push_back({1, 1, 0});
  points.push_back({1, 1, 1e-12});
  const std::vector<Vec3> targets{{0.9, 0.9, 0}, {0.1, 0.1, 0}};
  const std::vector<Tetra> tetrahedra{{0, 1, 2, 4}, {1, 1, 2, 3}, {0, 1, 2, 5}, {0, 1, 2, 3}};
  const auto embedding = TetraEmbedding::bind(points, tetrahedra, targets);
  ASSERT_TRUE(embedding);
  for (const auto& place : embedding->places()) EXPECT_EQ(place.tetrahedron, 3);
  const auto none = TetraEmbedding::bind(points, std::span(tetrahedra).first(3), targets);
  ASSERT_FALSE(none);
  EXPECT_NE(none.error().message().find("flat"), std::string::npos);
}

TEST(TetraEmbedding, RefusesWildInput) {
  const std::vector<Tetra> one{{0, 1, 2, 3}};
  const auto fails = [&](std::span<const Vec3> points, std::span<const Tetra> tetrahedra,
                         std::span<const Vec3> targets) {
    const auto embedding = TetraEmbedding::bind(points, tetrahedra, targets);
    return !embedding && embedding.error().kind == ErrorKind::bad_input && !embedding.error().what.empty();
  };
  EXPECT_TRUE(fails(corners, {}, corners));
  EXPECT_TRUE(fails({}, one, corners));
  EXPECT_TRUE(fails(corners, std::vector{Tetra{0, 1, 2, 4}}, corners));
  EXPECT_TRUE(fails(corners, std::vector{Tetra{0, -1, 2, 3}}, corners));
  for (const double wild :
       {std::numeric_limits<double>::quiet_NaN(), 1e308, -std::numeric_limits<double>::infinity()}) {
    std::vector<Vec3> bad = corners;
    bad[2].y = wild;
    EXPECT_TRUE(fails(bad, one, corners));
    EXPECT_TRUE(fails(corners, one, bad));
  }
  for (const double scale : {1e-60, 1e28}) {  // no overflow, no NaN
    std::vector<Vec3> points = corners, targets{{0.2, 0.2, 0.2}, {5, 5, 5}};
    for (Vec3& p : points) p *= scale;
    for (Vec3& p : targets) p *= scale;
    const auto embedding = TetraEmbedding::bind(points, one, targets);
    ASSERT_TRUE(embedding);
    EXPECT_NEAR(embedding->places()[0].weights[0], 0.4, 1e-12);
    EXPECT_NEAR(embedding->places()[1].outside_mm / (14 / std::sqrt(3.0) * scale), 1, 1e-9);
  }
  const auto nothing = TetraEmbedding::bind(corners, one, {});
  ASSERT_TRUE(nothing);
  EXPECT_TRUE(nothing->places().empty());
}

TEST(TetraEmbedding, HasTheSameBitsOnAnyNumberOfThreads) {
  const SolidMesh solid = solid_ball(20);
  const auto targets = cloud(5000);
  const auto run = [&](int threads) {
    set_thread_count(threads);
    const auto embedding = TetraEmbedding::bind(solid.points, solid.tetrahedra, targets);
    auto out = carried(*embedding, solid.points);
    set_thread_count(0);
    return out;
  };
  EXPECT_TRUE(run(1) == run(2));
}

}  // namespace
}  // namespace turgor
