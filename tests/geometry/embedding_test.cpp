#include "turgor/geometry/embedding.hpp"

#include <gtest/gtest.h>

#include <algorithm>

#include "shapes.hpp"
#include "turgor/core/parallel.hpp"
#include "turgor/geometry/mesh_edit.hpp"
#include "turgor/geometry/surface_query.hpp"

namespace turgor {
namespace {

using testing::sphere;

template <class Field>
std::vector<Vec3> sampled(const std::vector<Vec3>& points, Field&& field) {
  std::vector<Vec3> values;
  for (const Vec3& p : points) values.push_back(field(p));
  return values;
}

double largest_difference(const std::vector<Vec3>& a, const std::vector<Vec3>& b) {
  EXPECT_EQ(a.size(), b.size());
  double largest = 0;
  for (std::size_t i = 0; i < a.size(); ++i) largest = std::max(largest, distance(a[i], b[i]));
  return largest;
}

/// A head-sized ball with irregular triangles, reduced to about what is simulated.
struct Pair {
  TriMesh fine = testing::noisy(sphere(90, 6, {0, 20, 900}), 0.05, 3);
  TriMesh coarse = decimate(fine, 3000);
};

TEST(SurfaceEmbedding, CarriesAConstantDisplacementExactly) {
  const Pair pair;
  const SurfaceEmbedding embedding(pair.coarse, pair.fine.points, 5, 5);
  const Vec3 shift{0.1, -3.7, 12.3};
  const auto moved = embedding.displacements(std::vector<Vec3>(pair.coarse.points.size(), shift));
  for (const Vec3& d : moved) EXPECT_LT(distance(d, shift), 1e-9);
  const auto still = embedding.displacements(std::vector<Vec3>(pair.coarse.points.size()));
  EXPECT_EQ(still, std::vector<Vec3>(pair.fine.points.size()));
}

TEST(SurfaceEmbedding, CarriesALinearFieldAlmostExactlyAlongTheSurface) {
  const TriMesh coarse = testing::noisy(testing::sheet(12, 100), 0, 1);
  TriMesh fine = testing::sheet(90, 100);
  const SurfaceEmbedding embedding(coarse, fine.points, 5, 5);
  const auto field = [](const Vec3& p) { return Vec3{0.1 * p.x - 0.2 * p.y, 0.3 * p.y + 1, 0.05 * p.x}; };
  // The change of normals plays no part: the fine points lie in the surface.
  EXPECT_LT(
      largest_difference(embedding.displacements(sampled(coarse.points, field)), sampled(fine.points, field)),
      1e-3);
}

TEST(SurfaceEmbedding, CarriesARigidMotionOfACurvedSurfaceAlsoForPointsBesideIt) {
  const Pair pair;
  TriMesh beside = pair.fine;
  const auto normals = point_normals(pair.fine);
  for (std::size_t i = 0; i < beside.points.size(); ++i)
    beside.points[i] += normals[i] * (2.0 * std::sin(static_cast<double>(i)));
  const SurfaceEmbedding embedding(pair.coarse, beside.points, 5, 5);
  const auto turn = RigidTransform::rotate_about({0, 0, 850}, {1, 0, 0}, radians(20));
  const auto field = [&](const Vec3& p) { return turn.point(p) - p; };
  const auto found = embedding.displacements(sampled(pair.coarse.points, field));
  EXPECT_LT(largest_difference(found, sampled(beside.points, field)), 0.06);
}

TEST(SurfaceEmbedding, ShowsFewerCreasesThanBarycentricInterpolation) {
  const TriMesh coarse = sphere(90, 4), fine = sphere(90, 6);
  const SurfaceEmbedding embedding(coarse, fine.points, 5, 5);
  // A bump some coarse edges wide.
  const auto field = [](const Vec3& p) {
    return Vec3{0, 0, 8 * std::exp(-squared_length(p - Vec3{0, -90, 0}) / 400)};
  };
  const auto coarse_field = sampled(coarse.points, field);
  const auto smooth_result = embedding.displacements(coarse_field);
  std::vector<Vec3> linear;
  for (const auto& b : embedding.bindings()) {
    const Index3& t = coarse.triangles[static_cast<std::size_t>(b.triangle)];
    const auto value = [&](std::size_t k) { return coarse_field[static_cast<std::size_t>(t[k])]; };
    linear.push_back(value(0) * (1.0 - static_cast<double>(b.u) - static_cast<double>(b.v)) +
                     value(1) * static_cast<double>(b.u) + value(2) * static_cast<double>(b.v));
  }
  // The umbrella of the displacement stands for its second derivative; creases are its peaks.
  const PointAdjacency adjacency = point_adjacency(fine);
  const auto roughness = [&](const std::vector<Vec3>& d) {
    double sum = 0;
    const auto truth = sampled(fine.points, field);
    for (std::size_t p = 0; p < d.size(); ++p) {
      Vec3 mean;
      for (int i = adjacency.offsets[p]; i < adjacency.offsets[p + 1]; ++i) {
        const auto q = static_cast<std::size_t>(adjacency.neighbours[static_cast<std::size_t>(i)]);
        mean += d[q] - truth[q];
      }
      sum += squared_length(mean / static_cast<double>(adjacency.offsets[p + 1] - adjacency.offsets[p]) -
                            (d[p] - truth[p]));
    }
    return std::sqrt(sum);
  };
  EXPECT_LT(roughness(smooth_result), 0.4 * roughness(linear));
  EXPECT_LT(largest_difference(smooth_result, sampled(fine.points, field)), 0.3);
}

TEST(SurfaceEmbedding, FadesToNothingBeyondItsReach) {
  const TriMesh coarse = testing::sheet(10, 50);
  std::vector<Vec3> points;
  for (int i = 0; i <= 30; ++i) points.push_back({25.3, 24.1, static_cast<double>(i)});
  const SurfaceEmbedding embedding(coarse, points, 5, 10);
  const auto moved = embedding.displacements(std::vector<Vec3>(coarse.points.size(), Vec3{1, 0, 0}));
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (points[i].z <= 5) {
      EXPECT_EQ(moved[i], (Vec3{1, 0, 0}));
    }
    if (points[i].z >= 15) {
      EXPECT_EQ(moved[i], Vec3{});
    }
    if (i > 0) {
      EXPECT_LE(moved[i].x, moved[i - 1].x);
    }
  }
  EXPECT_NEAR(moved[10].x, 0.5, 1e-6);
}

TEST(SurfaceEmbedding, PointsBeyondARimAreNotExtrapolated) {
  const TriMesh coarse = testing::sheet(10, 50);
  const std::vector<Vec3> points{{60, 25, 0}, {58, 58, 1}};
  const SurfaceEmbedding embedding(coarse, points, 30, 1);
  // Steep near the rim: taken on linearly it would reach 3 and more.
  const auto moved = embedding.displacements(sampled(coarse.points, [](const Vec3& p) {
    return Vec3{0, 0, std::max(0.0, p.x - 40) / 10};
  }));
  EXPECT_LT(std::abs(moved[0].z), 1.5);
  EXPECT_LT(std::abs(moved[1].z), 1.6);
}

TEST(SurfaceEmbedding, TheRimsOfASlitMoveApart) {
  const TriMesh whole = sphere(90, 4);
  const Plane plane{{0, 0, 1}, 2};
  std::vector<int> side;
  const TriMesh coarse = cut_slit(
      whole, plane, [](const Vec3& p) { return p.y < -70; }, 1, &side);
  const TriMesh fine = sphere(90, 6);
  const SurfaceEmbedding embedding(coarse, fine.points, 5, 5);
  // All below the slit moves down by 5, all above stays.
  std::vector<Vec3> opening(coarse.points.size());
  for (std::size_t i = 0; i < opening.size(); ++i) {
    if (side[i] < 0 || (side[i] == 0 && coarse.points[i].z < 2)) opening[i] = {0, 0, -5};
  }
  const auto moved = embedding.displacements(opening);
  int above = 0, below = 0;
  for (std::size_t i = 0; i < moved.size(); ++i) {
    const Vec3& p = fine.points[i];
    if (p.y > -85 || std::abs(p.z - 2) > 15) continue;  // away from the ends of the slit
    // Points nearer to the plane than the coarse surface is to the fine one may belong to either rim.
    if (p.z > 2.3) {
      ++above;
      EXPECT_LT(length(moved[i]), 1e-4) << p.z;
    } else if (p.z < 1.7) {
      ++below;
      EXPECT_NEAR(moved[i].z, -5, 1e-4) << p.z;
    }
  }
  EXPECT_GT(above, 50);
  EXPECT_GT(below, 50);
}

TEST(SurfaceEmbedding, BindsToTheNearestPoint) {
  const Pair pair;
  const SurfaceEmbedding embedding(pair.coarse, pair.fine.points, 1, 50);
  const SurfaceQuery query(pair.coarse);
  for (std::size_t i = 0; i < pair.fine.points.size(); i += 7) {
    const auto nearest = query.nearest(pair.fine.points[i]);
    ASSERT_EQ(embedding.bindings()[i].triangle, nearest->triangle);
    EXPECT_NEAR(embedding.bindings()[i].distance, nearest->distance, 1e-5);
  }
}

TEST(SurfaceEmbedding, GivesTheSameBitsOnAnyNumberOfThreads) {
  const Pair pair;
  const auto field = sampled(pair.coarse.points, [](const Vec3& p) {
    return Vec3{std::sin(p.x), p.y, 0.1 * p.z};
  });
  set_thread_count(1);
  const auto one = SurfaceEmbedding(pair.coarse, pair.fine.points, 5, 5).displacements(field);
  set_thread_count(0);
  EXPECT_EQ(SurfaceEmbedding(pair.coarse, pair.fine.points, 5, 5).displacements(field), one);
}

TEST(SurfaceEmbedding, AnEmptySurfaceMovesNothing) {
  const SurfaceEmbedding embedding(TriMesh{}, {{1, 2, 3}}, 5, 5);
  EXPECT_EQ(embedding.displacements({}), std::vector<Vec3>(1));
}

}  // namespace
}  // namespace turgor
