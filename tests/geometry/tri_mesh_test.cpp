#include "turgor/geometry/tri_mesh.hpp"

#include <gtest/gtest.h>

#include <limits>
#include <set>

#include "geometry/connectivity.hpp"
#include "shapes.hpp"
#include "turgor/core/parallel.hpp"

namespace turgor {
namespace {

using testing::box;
using testing::sphere;

TEST(TriMesh, MeasuresOfABoxAreExact) {
  const TriMesh mesh = box({1, 2, 3}, {3, 5, 7});
  EXPECT_DOUBLE_EQ(surface_area(mesh), 52);
  EXPECT_NEAR(enclosed_volume(mesh), 24, 1e-12);
  EXPECT_NEAR(enclosed_volume(testing::reversed(mesh)), -24, 1e-12);
  EXPECT_EQ(bounds(mesh).lower, (Vec3{1, 2, 3}));
  EXPECT_EQ(bounds(mesh).upper, (Vec3{3, 5, 7}));
}

TEST(TriMesh, SphereMeasuresApproachTheClosedForm) {
  const TriMesh mesh = sphere(10, 6, {100, -50, 900});
  EXPECT_NEAR(enclosed_volume(mesh), 4.0 / 3 * std::numbers::pi * 1000,
              4.0 / 3 * std::numbers::pi * 1000 * 1e-3);
  EXPECT_NEAR(surface_area(mesh), 4 * std::numbers::pi * 100, 4 * std::numbers::pi * 100 * 1e-3);
}

TEST(TriMesh, ValidateNamesTheFault) {
  TriMesh mesh = box({0, 0, 0}, {1, 1, 1});
  EXPECT_TRUE(validate(mesh));
  mesh.triangles[4][1] = 8;
  EXPECT_NE(validate(mesh).error().what.find("triangle 4 names point 8 of 8"), std::string::npos);
  mesh.triangles[4][1] = mesh.triangles[4][0];
  EXPECT_NE(validate(mesh).error().what.find("triangle 4 names a point twice"), std::string::npos);
  mesh.points[3].y = std::numeric_limits<double>::quiet_NaN();
  EXPECT_NE(validate(mesh).error().what.find("point 3"), std::string::npos);
}

TEST(PointNormals, OfASpherePointOutwardAndUnusedPointsHaveNone) {
  TriMesh mesh = sphere(3, 4, {1, 2, 3});
  mesh.points.push_back({9, 9, 9});
  const auto normals = point_normals(mesh);
  for (std::size_t i = 0; i + 1 < normals.size(); ++i) {
    EXPECT_GT(dot(normals[i], normalized(mesh.points[i] - Vec3{1, 2, 3})), 0.999);
  }
  EXPECT_EQ(normals.back(), Vec3{});
}

TEST(PointNormals, AtACornerOfABoxDoNotDependOnHowSidesAreCutIntoTriangles) {
  const TriMesh mesh = box({0, 0, 0}, {1, 1, 1});
  const auto normals = point_normals(mesh);
  for (std::size_t i = 0; i < 8; ++i) {
    EXPECT_LT(distance(normals[i], normalized(mesh.points[i] - Vec3{0.5, 0.5, 0.5})), 1e-12);
  }
}

TEST(Topology, CountsComponentsBoundariesAndFaults) {
  TriMesh mesh = append(sphere(1, 2), testing::sheet(3, 5));
  Topology found = topology(mesh);
  EXPECT_EQ(found.components, 2);
  EXPECT_EQ(found.boundary_edges, 12);
  EXPECT_EQ(found.non_manifold_edges, 0);
  EXPECT_FALSE(found.closed());
  EXPECT_TRUE(topology(sphere(1, 2)).closed());
  std::swap(mesh.triangles[0][1], mesh.triangles[0][2]);
  EXPECT_EQ(topology(mesh).non_manifold_edges, 3);
  TriMesh fin = sphere(1, 1);
  fin.points.push_back({3, 3, 3});
  fin.triangles.push_back(
      {fin.triangles[0][0], fin.triangles[0][1], static_cast<int>(fin.points.size()) - 1});
  EXPECT_EQ(topology(fin).non_manifold_edges, 1);
  EXPECT_EQ(topology(fin).boundary_edges, 2);
  EXPECT_EQ(topology(TriMesh{}).components, 0);
}

TEST(TriangleComponents, AreNumberedByFallingArea) {
  const TriMesh mesh = append(append(sphere(1, 2), sphere(5, 2, {20, 0, 0})), sphere(2, 2, {-20, 0, 0}));
  const auto component = triangle_components(mesh);
  const std::size_t each = mesh.triangles.size() / 3;
  EXPECT_EQ(component[0], 2);
  EXPECT_EQ(component[each], 0);
  EXPECT_EQ(component[2 * each + 5], 1);
}

TEST(Submesh, KeepsOrderAndTellsWherePointsWent) {
  const TriMesh mesh = append(sphere(1, 1), sphere(2, 1, {9, 0, 0}));
  const auto component = triangle_components(mesh);
  std::vector<bool> keep(component.size());
  for (std::size_t i = 0; i < keep.size(); ++i) keep[i] = component[i] == 0;
  std::vector<int> map;
  const TriMesh part = submesh(mesh, keep, &map);
  EXPECT_EQ(part.points.size(), mesh.points.size() / 2);
  EXPECT_TRUE(topology(part).closed());
  for (std::size_t i = 0; i < map.size(); ++i) {
    if (map[i] >= 0) {
      EXPECT_EQ(part.points[static_cast<std::size_t>(map[i])], mesh.points[i]);
    }
  }
  EXPECT_EQ(map[0], -1);
}

TEST(PointAdjacency, MatchesASetBuiltTheSlowWay) {
  const TriMesh mesh = append(sphere(1, 3), testing::sheet(4, 1));
  const auto adjacency = point_adjacency(mesh);
  std::vector<std::set<int>> slow(mesh.points.size());
  for (const Index3& t : mesh.triangles) {
    for (const int a : t) {
      for (const int b : t) {
        if (a != b) slow[static_cast<std::size_t>(a)].insert(b);
      }
    }
  }
  for (std::size_t p = 0; p < slow.size(); ++p) {
    const std::vector<int> fast(adjacency.neighbours.begin() + adjacency.offsets[p],
                                adjacency.neighbours.begin() + adjacency.offsets[p + 1]);
    EXPECT_EQ(fast, std::vector<int>(slow[p].begin(), slow[p].end()));
  }
}

TEST(SeparatedSheets, TakesApartTwoBoxesThatShareAnEdgeAndKeepsThemClosed) {
  // Diagonal neighbours: the edge x = 1, y = 1 is common.
  TriMesh mesh = append(box({0, 0, 0}, {1, 1, 1}), box({1, 1, 0}, {2, 2, 1}));
  for (Index3& t : mesh.triangles) {
    for (int& p : t) {
      if (p == 8) p = 3;
      if (p == 12) p = 7;
    }
  }
  mesh = detail::without_unused_points(mesh);
  ASSERT_EQ(mesh.points.size(), 14U);
  ASSERT_EQ(topology(mesh).non_manifold_edges, 1);
  std::vector<int> origin;
  const TriMesh apart = detail::separated_sheets(mesh, &origin);
  EXPECT_EQ(apart.points.size(), 16U);
  EXPECT_TRUE(topology(apart).closed());
  EXPECT_EQ(topology(apart).components, 2);
  for (std::size_t i = 0; i < origin.size(); ++i) {
    EXPECT_EQ(apart.points[i], mesh.points[static_cast<std::size_t>(origin[i])]);
  }
}

TEST(SeparatedSheets, RemovesTrianglesThatFaceEachOther) {
  TriMesh mesh = sphere(1, 1);
  const Index3 t = mesh.triangles[3];
  mesh.triangles.push_back({t[0], t[1], t[2]});
  mesh.triangles.push_back({t[1], t[0], t[2]});
  const TriMesh repaired = detail::separated_sheets(mesh);
  EXPECT_EQ(repaired.triangles.size(), sphere(1, 1).triangles.size());
  EXPECT_TRUE(topology(repaired).closed());
}

TEST(TriMesh, MeasuresAreTheSameBitsOnAnyNumberOfThreads) {
  const TriMesh mesh = testing::noisy(sphere(80, 6), 0.1, 7);
  set_thread_count(1);
  const double area = surface_area(mesh), volume = enclosed_volume(mesh);
  const auto normals = point_normals(mesh);
  set_thread_count(0);
  EXPECT_EQ(surface_area(mesh), area);
  EXPECT_EQ(enclosed_volume(mesh), volume);
  EXPECT_EQ(point_normals(mesh), normals);
}

}  // namespace
}  // namespace turgor
