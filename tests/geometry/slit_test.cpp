#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <set>

#include "shapes.hpp"
#include "turgor/geometry/mesh_edit.hpp"

namespace turgor {
namespace {

using testing::sphere;

struct Slit {
  TriMesh mesh;
  std::vector<int> side, twin;
};

Slit slit(const TriMesh& mesh, const Plane& plane, const std::function<bool(const Vec3&)>& patch,
          double snap) {
  Slit s;
  s.mesh = cut_slit(mesh, plane, patch, snap, &s.side, &s.twin);
  return s;
}

/// Boundary edges as pairs of points.
std::vector<std::pair<int, int>> boundary(const TriMesh& mesh) {
  std::map<std::pair<int, int>, int> count;
  for (const Index3& t : mesh.triangles) {
    for (std::size_t k = 0; k < 3; ++k) ++count[std::minmax(t[k], t[(k + 1) % 3])];
  }
  std::vector<std::pair<int, int>> edges;
  for (const auto& [edge, n] : count) {
    if (n == 1) edges.push_back(edge);
  }
  return edges;
}

/// A single opening: one boundary ring, its rims twins of each other, its two ends joined.
void expect_one_opening(const Slit& s, const TriMesh& before, const Plane& plane) {
  ASSERT_EQ(s.side.size(), s.mesh.points.size());
  ASSERT_EQ(s.twin.size(), s.mesh.points.size());
  EXPECT_TRUE(validate(s.mesh));
  EXPECT_EQ(topology(s.mesh).non_manifold_edges, 0);
  EXPECT_EQ(topology(s.mesh).components, topology(before).components);
  int upper = 0;
  for (std::size_t i = 0; i < s.side.size(); ++i) {
    EXPECT_EQ(s.side[i] == 0, s.twin[i] < 0);
    if (s.side[i] == 0) continue;
    const auto other = static_cast<std::size_t>(s.twin[i]);
    EXPECT_EQ(s.twin[other], static_cast<int>(i));
    EXPECT_EQ(s.side[other], -s.side[i]);
    EXPECT_EQ(s.mesh.points[other], s.mesh.points[i]);
    EXPECT_NEAR(plane.signed_distance(s.mesh.points[i]), 0, 1e-12);
    upper += s.side[i] > 0 ? 1 : 0;
  }
  const auto edges = boundary(s.mesh);
  // n points on each rim and the two ends: 2 (n + 1) edges.
  EXPECT_EQ(edges.size(), static_cast<std::size_t>(2 * (upper + 1)));
  std::set<int> ends;
  for (const auto& [a, b] : edges) {
    const int sa = s.side[static_cast<std::size_t>(a)], sb = s.side[static_cast<std::size_t>(b)];
    EXPECT_FALSE(sa * sb < 0) << "an edge joins the rims";
    if (sa == 0) ends.insert(a);
    if (sb == 0) ends.insert(b);
  }
  EXPECT_EQ(ends.size(), 2U);
  // Triangles at the rims lie on their own side.
  for (const Index3& t : s.mesh.triangles) {
    double height = 0;
    int side = 0;
    for (const int p : t) {
      const double h = plane.signed_distance(s.mesh.points[static_cast<std::size_t>(p)]);
      if (std::abs(h) > std::abs(height)) height = h;
      side += s.side[static_cast<std::size_t>(p)];
    }
    if (side != 0) {
      EXPECT_GT(side * height, 0);
    }
  }
}

TEST(CutSlit, OpensTheFrontOfASphereBetweenTwoEnds) {
  const TriMesh mesh = sphere(10, 4);
  const Plane plane{normalized(Vec3{0.05, 0.1, 1}), 0.7};
  const auto patch = [](const Vec3& p) { return p.y < 0 && std::abs(p.x) < 4; };
  const Slit s = slit(mesh, plane, patch, 0);
  expect_one_opening(s, mesh, plane);
  EXPECT_NEAR(surface_area(s.mesh), surface_area(mesh), 1e-9);
  EXPECT_GT(std::count(s.side.begin(), s.side.end(), 1), 5);
  // Points keep their numbers.
  for (std::size_t i = 0; i < mesh.points.size(); ++i) EXPECT_EQ(s.mesh.points[i], mesh.points[i]);
  for (std::size_t i = 0; i < s.side.size(); ++i) {
    if (s.side[i] != 0) {
      EXPECT_TRUE(patch(s.mesh.points[i]));
    }
  }
}

TEST(CutSlit, SnappingMovesPointsOntoThePlaneAndLeavesNoSlivers) {
  const TriMesh mesh = sphere(10, 5);
  const Plane plane{{0, 0, 1}, 0.45};
  const auto patch = [](const Vec3& p) { return p.y < 0 && std::abs(p.x) < 5; };
  const Slit sharp = slit(mesh, plane, patch, 0), snapped = slit(mesh, plane, patch, 0.12);
  expect_one_opening(sharp, mesh, plane);
  expect_one_opening(snapped, mesh, plane);
  EXPECT_LT(snapped.mesh.points.size(), sharp.mesh.points.size());
  EXPECT_GT(testing::least_area(snapped.mesh), 2 * testing::least_area(sharp.mesh));
  EXPECT_NEAR(surface_area(snapped.mesh), surface_area(mesh), 1e-3 * surface_area(mesh));
  for (std::size_t i = 0; i < mesh.points.size(); ++i) {
    EXPECT_LE(distance(snapped.mesh.points[i], mesh.points[i]), 0.12);
    if (!patch(mesh.points[i])) {
      EXPECT_EQ(snapped.mesh.points[i], mesh.points[i]);
    }
  }
}

TEST(CutSlit, RunsAlongEdgesThatLieInThePlaneAlready) {
  const TriMesh mesh = sphere(10, 4);
  const Plane plane{{0, 0, 1}, 0};
  const Slit s = slit(
      mesh, plane, [](const Vec3& p) { return p.y < -1; }, 0);
  expect_one_opening(s, mesh, plane);
  EXPECT_EQ(s.mesh.triangles.size(), mesh.triangles.size());
}

TEST(CutSlit, ManyPlanesAllOpenOneSlit) {
  const TriMesh mesh = testing::noisy(sphere(10, 4), 0.03, 2);
  const RandomStream random(6);
  for (std::uint64_t i = 0; i < 100; ++i) {
    const Vec3 n = testing::random_direction(random, i), across = any_orthogonal(n);
    const Plane plane{n, 4 * random.uniform(i) - 2};
    // A generous half: the slit runs half-way round.
    const Slit s = slit(
        mesh, plane, [&](const Vec3& p) { return dot(p, across) > 1; }, i % 2 ? 0.1 : 0.0);
    expect_one_opening(s, mesh, plane);
  }
}

TEST(CutSlit, ThatGoesAllTheWayRoundPartsTheSurface) {
  const TriMesh mesh = sphere(10, 3);
  const Slit s = slit(
      mesh, {{0, 0, 1}, 1.23}, [](const Vec3&) { return true; }, 0.01);
  EXPECT_EQ(topology(s.mesh).components, 2);
  EXPECT_EQ(topology(s.mesh).non_manifold_edges, 0);
}

TEST(CutSlit, ReachingTheBoundaryOpensIt) {
  const TriMesh mesh = testing::sheet(10, 10);
  const Plane plane{{0, 1, 0}, 4.3};
  const Slit s = slit(
      mesh, plane, [](const Vec3& p) { return p.x < 5; }, 0.01);
  EXPECT_EQ(topology(s.mesh).components, 1);
  EXPECT_NEAR(surface_area(s.mesh), 100, 1e-9);
  const auto at_boundary = std::count_if(s.mesh.points.begin(), s.mesh.points.end(),
                                         [](const Vec3& p) { return p.x == 0 && p.y == 4.3; });
  EXPECT_EQ(at_boundary, 2);
}

TEST(CutSlit, OutsideThePatchChangesNothing) {
  const TriMesh mesh = sphere(10, 3);
  const Slit s = slit(
      mesh, {{0, 0, 1}, 1.23}, [](const Vec3&) { return false; }, 1);
  EXPECT_EQ(s.mesh.points, mesh.points);
  EXPECT_EQ(s.mesh.triangles, mesh.triangles);
  EXPECT_EQ(std::count(s.side.begin(), s.side.end(), 0), static_cast<long>(mesh.points.size()));
}

}  // namespace
}  // namespace turgor
