#include <gtest/gtest.h>

#include <algorithm>

#include "geometry/planar_fill.hpp"
#include "shapes.hpp"
#include "turgor/geometry/mesh_edit.hpp"

namespace turgor {
namespace {

using testing::box;
using testing::reversed;
using testing::sphere;

/// Both halves are closed, lie on their side, and add up to the whole.
void expect_halves(const TriMesh& mesh, const Plane& plane, double snap = 1e-6) {
  const TriMesh above = clip(mesh, plane, true, snap),
                below = clip(mesh, {-plane.normal, -plane.offset}, true, snap);
  double total = 0;
  for (const auto& [half, sign] : {std::pair{&above, 1.0}, std::pair{&below, -1.0}}) {
    EXPECT_TRUE(validate(*half));
    const Topology found = topology(*half);
    EXPECT_EQ(found.boundary_edges, 0);
    EXPECT_EQ(found.non_manifold_edges, 0);
    for (const Vec3& p : half->points) EXPECT_GE(sign * plane.signed_distance(p), -1e-12);
    total += enclosed_volume(*half);
  }
  EXPECT_NEAR(total, enclosed_volume(mesh), 1e-9 * std::abs(enclosed_volume(mesh)) + 10 * snap);
  double in_plane = 0;
  for (const Index3& t : mesh.triangles) {
    const bool flat = std::all_of(t.begin(), t.end(), [&](int p) {
      return std::abs(plane.signed_distance(mesh.points[static_cast<std::size_t>(p)])) <= snap;
    });
    if (flat) in_plane += length(triangle_normal(mesh, t)) / 2;
  }
  const double open = surface_area(clip(mesh, plane, false, snap)) +
                      surface_area(clip(mesh, {-plane.normal, -plane.offset}, false, snap));
  EXPECT_NEAR(open + in_plane, surface_area(mesh), 1e-9 * surface_area(mesh) + 10 * snap);
}

double cap_area(const TriMesh& mesh, const Plane& plane) {
  return surface_area(clip(mesh, plane, true)) - surface_area(clip(mesh, plane, false));
}

TEST(Clip, HalvesOfASphereAddUpForPlanesInAnyPosition) {
  const TriMesh mesh = sphere(10, 4, {3, -2, 1});
  const RandomStream random(8);
  for (std::uint64_t i = 0; i < 50; ++i) {
    const Vec3 n = testing::random_direction(random, i);
    expect_halves(mesh, Plane::through(Vec3{3, -2, 1} + n * (20 * random.uniform(i) - 10), n));
  }
}

TEST(Clip, CapOfASphereHasTheAreaOfItsCircle) {
  const TriMesh mesh = sphere(10, 6);
  EXPECT_NEAR(cap_area(mesh, {{0, 0.6, 0.8}, 6}), std::numbers::pi * 64, 0.2);
  // A spherical cap of height 4.
  EXPECT_NEAR(enclosed_volume(clip(mesh, {{0, 0.6, 0.8}, 6}, true)), std::numbers::pi * 16 * (30 - 4) / 3,
              0.5);
}

TEST(Clip, APlaneThroughThePointsOfTheMeshLeavesNoSlivers) {
  const TriMesh mesh = sphere(10, 4);
  // The octahedron's equators run exactly through points and edges.
  for (const Vec3& n : {Vec3{0, 0, 1}, Vec3{1, 0, 0}, Vec3{0, -1, 0}}) {
    expect_halves(mesh, {n, 0});
    EXPECT_EQ(clip(mesh, {n, 0}, false).triangles.size(), mesh.triangles.size() / 2);
    EXPECT_GT(testing::least_area(clip(mesh, {n, 0}, true)), 1e-3);
  }
  for (std::size_t i = 0; i < 50; ++i) {
    const Vec3 n = normalized(Vec3{1, 2, -0.7});
    expect_halves(mesh, Plane::through(mesh.points[i * 7], n));
  }
}

TEST(Clip, SnappingKeepsNeighboursOfThePlaneFromMakingSlivers) {
  const TriMesh mesh = sphere(10, 4);
  const Plane plane{{0, 0, 1}, 0.01};
  EXPECT_LT(testing::least_area(clip(mesh, plane, false)), 1e-2);
  const TriMesh snapped = clip(mesh, plane, true, 0.05);
  EXPECT_GT(testing::least_area(snapped), 5e-2);
  EXPECT_TRUE(topology(snapped).closed());
}

TEST(Clip, TorusGivesTwoLoopsOrARingByTheDirectionOfThePlane) {
  const TriMesh mesh = testing::torus(20, 5, 90, 45);
  expect_halves(mesh, Plane::through({0.1, 0.2, 0}, normalized(Vec3{1, 0.3, 0})));
  expect_halves(mesh, Plane::through({0, 0, 1.3}, {0, 0, 1}));
  expect_halves(mesh, Plane::through({0, 0, 0}, {0, 0, 1}));
  expect_halves(mesh, Plane::through({0, 0, 0}, {1, 0, 0}));
  // Two discs, and a ring.
  EXPECT_NEAR(cap_area(mesh, {{1, 0, 0}, 0}), 2 * std::numbers::pi * 25, 1);
  EXPECT_NEAR(cap_area(mesh, {{0, 0, 1}, 0}), std::numbers::pi * (625 - 225), 3);
  // Villarceau's plane touches the torus at two points, where the section crosses itself.
  const double tilt = std::asin(5.0 / 20);
  expect_halves(mesh, {{std::sin(tilt), 0, std::cos(tilt)}, 0});
}

TEST(Clip, NestedShellsGiveRingsWithinRings) {
  TriMesh mesh;
  double r = 10;
  for (int i = 0; i < 5; ++i, r -= 1.7) {
    mesh = append(mesh, i % 2 == 0 ? sphere(r, 4) : reversed(sphere(r, 4)));
  }
  // Holes beside each other, too.
  mesh =
      append(mesh, append(reversed(sphere(0.3, 2, {9, 0.7, 0.1})), reversed(sphere(0.3, 2, {9, -0.7, 0}))));
  const RandomStream random(3);
  for (std::uint64_t i = 0; i < 20; ++i) {
    const Vec3 n = testing::random_direction(random, i);
    expect_halves(mesh, {n, 6 * random.uniform(i) - 3});
  }
  expect_halves(mesh, {{0, 0, 1}, 0});
  const double rings = 100 - 8.3 * 8.3 + 6.6 * 6.6 - 4.9 * 4.9 + 3.2 * 3.2 - 2 * 0.09;
  EXPECT_NEAR(cap_area(mesh, {{0, 0, 1}, 0.0}), std::numbers::pi * rings, 1.5);
}

TEST(Clip, BoxesWithCoplanarSidesAreCutCleanly) {
  const TriMesh mesh = box({0, 0, 0}, {2, 3, 4});
  expect_halves(mesh, {{0, 0, 1}, 1.5});
  expect_halves(mesh, {{0, 0, 1}, 0});
  expect_halves(mesh, {{0, 0, 1}, 4});
  EXPECT_TRUE(clip(mesh, {{0, 0, 1}, 4}, true).empty());
  EXPECT_NEAR(enclosed_volume(clip(mesh, {{0, 0, 1}, 0}, true)), 24, 1e-12);
  EXPECT_TRUE(clip(mesh, {{0, 0, 1}, 5}, true).empty());
  EXPECT_EQ(clip(mesh, {{0, 0, 1}, -5}, true).triangles, mesh.triangles);
  // An L whose inner step lies in the plane.
  const TriMesh steps = append(box({0, 0, 0}, {1, 1, 1}), box({3, 0, 0}, {4, 1, 2}));
  expect_halves(steps, {{0, 0, 1}, 1});
}

TEST(Clip, ARidgeThatTouchesThePlaneWithinTheSectionDoesNotJoinTheCap) {
  // A roof upside down inside a box: its ridge lies in the cutting plane, the material above it is hollow.
  TriMesh tent;
  tent.points = {{0, -1, 0}, {0, 1, 0}, {1, 0, 1}, {-1, 0, 1}};
  tent.triangles = {{0, 2, 1}, {0, 1, 3}, {0, 3, 2}, {1, 2, 3}};
  if (enclosed_volume(tent) < 0) tent = reversed(tent);
  const TriMesh mesh = append(box({-3, -3, -3}, {3, 3, 3}), reversed(tent));
  expect_halves(mesh, {{0, 0, 1}, 0});
}

TEST(Clip, OpenSurfacesAreCutAndTheirOpenChainsStayOpen) {
  const TriMesh mesh = testing::sheet(10, 10);
  const TriMesh half = clip(mesh, {{1, 0, 0}, 3.37}, true);
  EXPECT_NEAR(surface_area(half), 66.3, 1e-9);
  EXPECT_EQ(topology(half).non_manifold_edges, 0);
  for (const Vec3& p : half.points) EXPECT_GE(p.x, 3.37 - 1e-12);
}

TEST(FillLoops, CombsWithManyHolesAreFilledExactlyAndWithoutOverlap) {
  // A comb with a hundred teeth and square holes between: far from convex.
  std::vector<detail::Vec2> points;
  std::vector<std::vector<int>> loops(1);
  const auto add = [&](std::vector<int>& loop, double x, double y) {
    loop.push_back(static_cast<int>(points.size()));
    points.push_back({x, y});
  };
  double area = 0;
  const int teeth = 100;
  add(loops[0], 0, 0);
  add(loops[0], 2 * teeth, 0);
  for (int i = teeth - 1; i >= 0; --i) {
    for (const auto& [x, y] : {std::pair{2.0, 2.0}, {1.5, 12.0}, {1.0, 2.0}}) add(loops[0], 2 * i + x, y);
    area += 5;
  }
  add(loops[0], 0, 2);
  area += 2.0 * teeth * 2;
  for (int i = 0; i < teeth; ++i) {
    std::vector<int>& hole = loops.emplace_back();
    for (const auto& [x, y] : {std::pair{0.5, 0.5}, {0.5, 1.5}, {1.5, 1.5}, {1.5, 0.5}})
      add(hole, 2 * i + x, y);
    area -= 1;
  }
  const auto triangles = detail::fill_loops(points, loops);
  EXPECT_EQ(triangles.size(), points.size() - 2 + 2 * static_cast<std::size_t>(teeth));
  double sum = 0;
  for (const Index3& t : triangles) {
    const auto& a = points[static_cast<std::size_t>(t[0])];
    const auto& b = points[static_cast<std::size_t>(t[1])];
    const auto& c = points[static_cast<std::size_t>(t[2])];
    const double part = ((b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])) / 2;
    EXPECT_GT(part, -1e-12);
    sum += part;
  }
  EXPECT_NEAR(sum, area, 1e-9);
}

TEST(FillLoops, ASelfCrossingLoopStillClosesTheSurface) {
  const std::vector<detail::Vec2> points{{0, 0}, {4, 4}, {4, 0}, {0, 4}, {-3, 2}};
  const auto triangles = detail::fill_loops(points, {{0, 1, 2, 3, 4}});
  TriMesh cap;
  for (const auto& p : points) cap.points.push_back({p[0], p[1], 0});
  cap.triangles = triangles;
  EXPECT_EQ(triangles.size(), 3U);
  EXPECT_EQ(topology(cap).boundary_edges, 5);
  EXPECT_EQ(topology(cap).non_manifold_edges, 0);
}

}  // namespace
}  // namespace turgor
