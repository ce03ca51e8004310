#include "turgor/geometry/surface_query.hpp"

#include <gtest/gtest.h>
#include <xmmintrin.h>

#include <algorithm>

#include "geometry/triangle_math.hpp"
#include "shapes.hpp"
#include "turgor/core/parallel.hpp"

namespace turgor {
namespace {

using testing::random_direction;
using testing::sphere;

Vec3 place(const TriMesh& mesh, int triangle, double u, double v) {
  const Index3& t = mesh.triangles[static_cast<std::size_t>(triangle)];
  const auto p = [&](int k) { return mesh.points[static_cast<std::size_t>(t[static_cast<std::size_t>(k)])]; };
  return p(0) * (1 - u - v) + p(1) * u + p(2) * v;
}

/// Every triangle tried, in double precision.
std::vector<double> slow_hits(const TriMesh& mesh, const Vec3& o, const Vec3& d) {
  std::vector<double> hits;
  for (const Index3& t : mesh.triangles) {
    const Vec3 a = mesh.points[static_cast<std::size_t>(t[0])],
               b = mesh.points[static_cast<std::size_t>(t[1])],
               c = mesh.points[static_cast<std::size_t>(t[2])];
    const Vec3 n = cross(b - a, c - a);
    const double slope = dot(n, d);
    if (slope == 0) continue;
    const double distance_to_plane = dot(n, a - o) / slope;
    const Vec3 p = o + d * distance_to_plane;
    const bool within = dot(cross(b - a, p - a), n) >= 0 && dot(cross(c - b, p - b), n) >= 0 &&
                        dot(cross(a - c, p - c), n) >= 0;
    if (within && distance_to_plane > 0) hits.push_back(distance_to_plane);
  }
  std::sort(hits.begin(), hits.end());
  return hits;
}

double slow_distance(const TriMesh& mesh, const Vec3& p) {
  double least = 1e300;
  for (const Index3& t : mesh.triangles) {
    least = std::min(least, detail::closest_on_triangle(p, mesh.points[static_cast<std::size_t>(t[0])],
                                                        mesh.points[static_cast<std::size_t>(t[1])],
                                                        mesh.points[static_cast<std::size_t>(t[2])])
                                .squared_distance);
  }
  return std::sqrt(least);
}

TEST(ClosestOnTriangle, IsNoFartherThanAnyOfADenseSetOfItsPoints) {
  const RandomStream random(5);
  for (std::uint64_t trial = 0; trial < 200; ++trial) {
    const auto point = [&](std::uint64_t k) {
      return Vec3{random.normal(12 * trial + k), random.normal(12 * trial + k + 1),
                  random.normal(12 * trial + k + 2)};
    };
    const Vec3 a = point(0), b = point(3), c = point(6), p = point(9) * 2.0;
    const auto closest = detail::closest_on_triangle(p, a, b, c);
    EXPECT_LT(distance(closest.point, a * (1 - closest.u - closest.v) + b * closest.u + c * closest.v),
              1e-12);
    EXPECT_GE(std::min({closest.u, closest.v, 1 - closest.u - closest.v}), -1e-12);
    for (int i = 0; i <= 40; ++i) {
      for (int j = 0; i + j <= 40; ++j) {
        EXPECT_GE(distance(p, a + (b - a) * (i / 40.0) + (c - a) * (j / 40.0)),
                  std::sqrt(closest.squared_distance) - 1e-12);
      }
    }
  }
}

TEST(SurfaceQuery, RaysAgreeWithTryingEveryTriangle) {
  const TriMesh mesh =
      testing::noisy(append(sphere(60, 3, {20, -10, 400}), testing::torus(50, 12, 40, 20)), 0.5, 3);
  const SurfaceQuery query(mesh);
  const RandomStream random(1);
  for (std::uint64_t i = 0; i < 2000; ++i) {
    const Vec3 o = Vec3{0, 0, 200} + random_direction(random, 2 * i) * 300.0,
               d = random_direction(random, 2 * i + 1);
    const auto slow = slow_hits(mesh, o, d);
    const auto all = query.all_hits(o, d);
    const auto first = query.first_hit(o, d);
    ASSERT_EQ(all.size(), slow.size()) << i;
    ASSERT_EQ(first.has_value(), !slow.empty());
    for (std::size_t k = 0; k < all.size(); ++k) {
      EXPECT_NEAR(all[k].distance, slow[k], 1e-9);
      EXPECT_LT(distance(place(mesh, all[k].triangle, all[k].u, all[k].v), o + d * slow[k]), 1e-9);
    }
    if (first) {
      EXPECT_EQ(first->distance, all[0].distance);
      EXPECT_EQ(first->triangle, all[0].triangle);
    }
  }
}

TEST(SurfaceQuery, NearAndFarLimitHitsExactly) {
  const TriMesh mesh = testing::box({-1, -1, -1}, {1, 1, 1});
  const SurfaceQuery query(mesh);
  const Vec3 o{0.3, 0.2, -5}, d{0, 0, 1};
  EXPECT_NEAR(query.first_hit(o, d)->distance, 4, 1e-12);
  EXPECT_NEAR(query.first_hit(o, d, 4)->distance, 6, 1e-12);
  EXPECT_NEAR(query.first_hit(o, d, 3.999999)->distance, 4, 1e-12);
  EXPECT_FALSE(query.first_hit(o, d, 0, 4).has_value());
  EXPECT_TRUE(query.first_hit(o, d, 0, 4.000001).has_value());
  EXPECT_EQ(query.all_hits(o, d, 0, 6.1).size(), 2U);
  EXPECT_EQ(query.all_hits(o, d, 4, 6).size(), 0U);
  EXPECT_FALSE(query.first_hit(o, {0, 0, -1}).has_value());
}

TEST(SurfaceQuery, ARayThroughAnEdgeOrACornerCountsOnce) {
  const TriMesh mesh = sphere(10, 3);
  const SurfaceQuery query(mesh);
  for (std::size_t i = 0; i < mesh.points.size(); ++i) {
    const Vec3 d = normalized(mesh.points[i]);
    EXPECT_EQ(query.all_hits({}, d).size(), 1U) << "corner " << i;
  }
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    const Index3& t = mesh.triangles[i];
    const Vec3 middle =
        (mesh.points[static_cast<std::size_t>(t[0])] + mesh.points[static_cast<std::size_t>(t[1])]) * 0.5;
    const Vec3 d = normalized(middle);
    const auto hits = query.all_hits(d * -30.0, d);
    ASSERT_EQ(hits.size(), 2U) << "edge of triangle " << i;
    EXPECT_NEAR(hits[1].distance, 30 + length(middle), 1e-9);
  }
}

TEST(SurfaceQuery, FarAwayRaysKeepTheirPrecision) {
  const TriMesh mesh = sphere(10, 5);
  const SurfaceQuery query(mesh);
  const Vec3 d = normalized(Vec3{-1, 0.01, 0.02});
  const auto slow = slow_hits(mesh, d * -1e6, d);
  ASSERT_EQ(slow.size(), 2U);
  EXPECT_NEAR(query.first_hit(d * -1e6, d)->distance, slow[0], 1e-6);
  EXPECT_EQ(query.all_hits(d * -1e6, d).size(), 2U);
}

TEST(SurfaceQuery, NearestPointAgreesWithTryingEveryTriangle) {
  const TriMesh mesh = testing::noisy(sphere(60, 3, {20, -10, 400}), 1.0, 3);
  const SurfaceQuery query(mesh);
  const RandomStream random(9);
  for (std::uint64_t i = 0; i < 500; ++i) {
    const Vec3 p = Vec3{20, -10, 400} + random_direction(random, i) * (200 * random.uniform(i));
    const auto found = query.nearest(p);
    ASSERT_TRUE(found);
    const double slow = slow_distance(mesh, p);
    EXPECT_NEAR(found->distance, slow, 1e-11);
    EXPECT_NEAR(distance(found->point, p), slow, 1e-10);
    EXPECT_LT(distance(found->point, place(mesh, found->triangle, found->u, found->v)), 1e-10);
    EXPECT_FALSE(query.nearest(p, slow - 1e-6).has_value());
    EXPECT_TRUE(query.nearest(p, slow + 1e-6).has_value());
  }
}

TEST(SurfaceQuery, AnswersNameTheSurface) {
  const TriMesh a = sphere(1, 2), b = sphere(1, 2, {10, 0, 0});
  const SurfaceQuery query(std::vector<const TriMesh*>{&a, &b});
  EXPECT_EQ(query.nearest({8, 0, 0})->surface, 1);
  EXPECT_EQ(query.nearest({3, 0, 0})->surface, 0);
  const auto hits = query.all_hits({-5, 0.1, 0.2}, {1, 0, 0});
  ASSERT_EQ(hits.size(), 4U);
  EXPECT_EQ(hits[1].surface, 0);
  EXPECT_EQ(hits[2].surface, 1);
  EXPECT_TRUE(query.inside({10, 0.1, 0}));
  EXPECT_FALSE(query.inside({5, 0, 0}));
}

TEST(SurfaceQuery, InsideAgreesWithTheDistanceFromTheCentre) {
  const TriMesh ball = sphere(10, 4);
  const SurfaceQuery query(ball);
  const RandomStream random(4);
  for (std::uint64_t i = 0; i < 2000; ++i) {
    const double r = 20 * random.uniform(7 * i);
    if (std::abs(r - 10) < 0.1) continue;
    EXPECT_EQ(query.inside(random_direction(random, i) * r), r < 10);
  }
  // Straight below the corners of the mesh, where rays meet edges.
  for (const Vec3& p : ball.points) EXPECT_TRUE(query.inside(p * 0.5));
  const TriMesh shell = append(sphere(10, 3), testing::reversed(sphere(5, 3)));
  const SurfaceQuery hollow(shell);
  EXPECT_FALSE(hollow.inside({0, 0, 0}));
  EXPECT_TRUE(hollow.inside({0, 7, 0}));
}

TEST(SurfaceQuery, WithoutTrianglesFindsNothing) {
  const SurfaceQuery query(TriMesh{});
  EXPECT_FALSE(query.first_hit({}, {0, 0, 1}).has_value());
  EXPECT_FALSE(query.nearest({}).has_value());
  EXPECT_FALSE(query.inside({}));
  const double bad = std::numeric_limits<double>::quiet_NaN();
  const SurfaceQuery ball(sphere(1, 1));
  EXPECT_FALSE(ball.first_hit({bad, 0, 0}, {0, 0, 1}).has_value());
  EXPECT_FALSE(ball.nearest({bad, 0, 0}).has_value());
}

TEST(SurfaceQuery, AnswersAreTheSameBitsOnAnyNumberOfThreads) {
  const TriMesh mesh = testing::noisy(sphere(60, 6), 0.2, 3);
  const auto ask = [&](int threads) {
    set_thread_count(threads);
    const SurfaceQuery query(mesh);
    const RandomStream random(2);
    std::vector<double> answers(4000 * 6);
    parallel_for(4000, 100, [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i) {
        const Vec3 o = random_direction(random, 2 * i) * 100.0, d = random_direction(random, 2 * i + 1);
        double* out = &answers[i * 6];
        if (const auto hit = query.first_hit(o, d))
          out[0] = hit->distance, out[1] = hit->triangle, out[2] = hit->u;
        if (const auto near = query.nearest(o))
          out[3] = near->distance, out[4] = near->triangle, out[5] = near->v;
      }
    });
    set_thread_count(0);
    return answers;
  };
  const auto one = ask(1);
  EXPECT_EQ(one, ask(2));
  EXPECT_EQ(one, ask(0));
}

TEST(SurfaceQuery, LeavesTheFloatingPointModeAlone) {
  const unsigned before = _mm_getcsr() & 0xffc0U;
  const SurfaceQuery query(sphere(1, 4));
  EXPECT_TRUE(query.first_hit({}, {0, 0, 1}).has_value());
  EXPECT_EQ(_mm_getcsr() & 0xffc0U, before);
  std::vector<unsigned> modes(64, 0);
  parallel_for(64, 1, [&](std::size_t begin, std::size_t) { modes[begin] = _mm_getcsr() & 0xffc0U; });
  for (const unsigned mode : modes) EXPECT_EQ(mode, before);
}

TEST(SurfaceQuery, CanBeMoved) {
  SurfaceQuery a(sphere(1, 2));
  SurfaceQuery b(std::move(a));
  EXPECT_TRUE(b.inside({}));
  a = std::move(b);
  EXPECT_TRUE(a.inside({}));
}

}  // namespace
}  // namespace turgor
