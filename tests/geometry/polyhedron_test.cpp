#include "turgor/geometry/polyhedron.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <functional>
#include <limits>
#include <numbers>
#include <string>

#include "shapes.hpp"
#include "support/grid_surface.hpp"
#include "turgor/geometry/subdivide.hpp"

namespace turgor {
namespace {

using support::make_grid;

Polyhedron cube() {
  Polyhedron cube;
  for (const double z : {-1.0, 1.0}) {
    for (const double y : {-1.0, 1.0}) {
      for (const double x : {-1.0, 1.0}) cube.points.push_back({x, y, z});
    }
  }
  for (const std::array<int, 4>& q :
       {std::array{0, 2, 3, 1}, std::array{4, 5, 7, 6}, std::array{0, 1, 5, 4}, std::array{2, 6, 7, 3},
        std::array{0, 4, 6, 2}, std::array{1, 3, 7, 5}}) {
    cube.add_polygon(q);
  }
  return cube;
}

TEST(Polyhedron, ValidateNamesTheFault) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const struct {
    std::function<void(Polyhedron&)> damage;
    std::string says;
  } cases[] = {
      {[&](Polyhedron& p) { p.points[3].y = nan; }, "point 3 is not a finite number"},
      {[](Polyhedron& p) { p.corners[5] = 9; }, "polygon 1 names point 9 of 8"},
      {[](Polyhedron& p) { p.corners[5] = -1; }, "polygon 1 names point -1 of 8"},
      {[](Polyhedron& p) { p.corners[6] = p.corners[4]; }, "polygon 1 names point 4 twice"},
      {[](Polyhedron& p) { p.ends[1] = 5; }, "polygon 1 has 1 corners"},
      {[](Polyhedron& p) { p.ends[2] = 2; }, "polygon 2 ends at corner 2"},
      {[](Polyhedron& p) { p.ends[5] = 2'000'000'000; }, "polygon 5 ends at corner 2000000000"},
      {[](Polyhedron& p) { p.ends.pop_back(); }, "4 corners belong to no polygon"},
      {[](Polyhedron& p) {
         p.lines = {{0, 8}};
       },
       "line 0 names point 8 of 8"},
      {[](Polyhedron& p) {
         p.lines = {{0, 1}, {2, 2}};
       },
       "line 1 joins point 2 to itself"},
  };
  EXPECT_TRUE(validate(cube()));
  EXPECT_TRUE(validate(Polyhedron{}));
  for (const auto& [damage, says] : cases) {
    Polyhedron p = cube();
    damage(p);
    const auto result = validate(p);
    ASSERT_FALSE(result) << says;
    EXPECT_NE(result.error().message().find(says), std::string::npos) << result.error().message();
  }
}

TEST(Polyhedron, TrianglesComeBackAsTheyWere) {
  const TriMesh mesh = testing::sphere(5, 3);
  const Polyhedron polyhedron = to_polyhedron(mesh);
  EXPECT_TRUE(validate(polyhedron));
  EXPECT_EQ(triangulated(polyhedron).triangles, mesh.triangles);
  EXPECT_EQ(edges(polyhedron).size(), mesh.triangles.size() * 3 / 2);
}

TEST(Polyhedron, QuadrilateralsAreCutAlongTheShorterDiagonalAndTheFirstOfEqualOnes) {
  Polyhedron p;
  p.points = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}, {3, 1, 0}, {4, 0, 0}};
  p.add_polygon(std::array{0, 1, 2, 3});
  p.add_polygon(std::array{1, 5, 4, 2});  // 1–4 is 2.24, 5–2 is 3.16
  p.add_polygon(std::array{5, 4, 2, 1});  // the same from another corner
  EXPECT_EQ(triangulated(p).triangles,
            (std::vector<Index3>{{0, 1, 2}, {0, 2, 3}, {1, 5, 4}, {1, 4, 2}, {4, 2, 1}, {4, 1, 5}}));
  Polyhedron pentagon;
  for (int i = 0; i < 5; ++i) pentagon.points.push_back({std::cos(1.2566 * i), std::sin(1.2566 * i), 0});
  pentagon.add_polygon(std::array{0, 1, 2, 3, 4});
  EXPECT_EQ(triangulated(pentagon).triangles, (std::vector<Index3>{{0, 1, 2}, {0, 2, 3}, {0, 3, 4}}));
}

TEST(Polyhedron, EdgesAndLinesAreNamedOnceAscending) {
  Polyhedron grid = make_grid(3, 2);
  grid.lines = {{5, 0}, {1, 0}};
  EXPECT_EQ(edges(grid), (std::vector<Edge>{{0, 1}, {0, 3}, {0, 5}, {1, 2}, {1, 4}, {2, 5}, {3, 4}, {4, 5}}));
  EXPECT_EQ(edges(make_grid(10, 10)).size(), 180u);
}

TEST(Polyhedron, VertexNormalsAreTheMeanOfUnitNormals) {
  const std::vector<Vec3> normals = vertex_normals(cube());
  for (std::size_t i = 0; i < 8; ++i) EXPECT_LT(distance(normals[i], normalized(cube().points[i])), 1e-15);
  // A large and a small polygon count alike, whatever the numbers.
  for (const double scale : {1.0, 1e-200, 1e200}) {
    Polyhedron fold;
    fold.points = {{0, 0, 0}, {1, 0, 0}, {1, 90, 0}, {0, 90, 0}, {1, 0, -2}, {0, 0, -2}, {5, 5, 5}};
    for (Vec3& p : fold.points) p *= scale;
    fold.add_polygon(std::array{0, 1, 2, 3});
    fold.add_polygon(std::array{0, 5, 4, 1});
    const std::vector<Vec3> n = vertex_normals(fold);
    EXPECT_LT(distance(n[0], normalized(Vec3{0, -1, 1})), 1e-15);
    EXPECT_LT(distance(n[3], Vec3{0, 0, 1}), 1e-15);
    EXPECT_EQ(n[6], Vec3{});
  }
  // Two polygons that face each other have no direction together; nor has a flat one.
  Polyhedron leaf = make_grid(2, 2);
  leaf.add_polygon(std::array{2, 3, 1, 0});
  for (const Vec3& n : vertex_normals(leaf)) EXPECT_EQ(n, Vec3{});
}

TEST(Subdivision, OfAGridCountsPolygonsAndKeepsAFlatSheetFlat) {
  const Polyhedron fine = subdivided(make_grid(5, 4), 2);
  EXPECT_TRUE(validate(fine));
  EXPECT_EQ(fine.polygon_count(), 4 * 3 * 16);
  EXPECT_EQ(fine.points.size(), 17u * 13u);
  for (const Vec3& p : fine.points) EXPECT_EQ(p.z, 0);
  // Inside, away from the rim, a regular grid stays the regular grid.
  EXPECT_LT(distance(subdivided(make_grid(5, 5), 1).points[12], Vec3{2, 2, 0}), 1e-15);
}

TEST(Subdivision, RimIsACubicBSpline) {
  Polyhedron grid = make_grid(4, 3);
  grid.points[1].z = 1;
  const Polyhedron fine = subdivided(grid, 1);
  EXPECT_DOUBLE_EQ(fine.points[1].z, 0.75);
  EXPECT_DOUBLE_EQ(fine.points[2].z, 0.125);
  EXPECT_DOUBLE_EQ(fine.points[0].z, 0) << "a corner stays";
}

TEST(Subdivision, CornersOfASheetStaySharpAndItsSizeIsKept) {
  Polyhedron grid = make_grid(4, 3);
  for (const std::size_t corner : {0u, 3u, 8u, 11u}) grid.points[corner].z = 1 + static_cast<double>(corner);
  const Polyhedron fine = subdivided(grid, 3);
  for (const std::size_t corner : {0u, 3u, 8u, 11u}) EXPECT_EQ(fine.points[corner], grid.points[corner]);
  Box3 before, after;
  for (const Vec3& p : grid.points) before.extend({p.x, p.y, 0});
  for (const Vec3& p : fine.points) after.extend({p.x, p.y, 0});
  EXPECT_EQ(after.lower, before.lower);
  EXPECT_EQ(after.upper, before.upper);
  // On a closed surface no point is of one polygon alone: nothing stays there.
  EXPECT_GT(distance(subdivided(cube(), 1).points[0], cube().points[0]), 0.5);
}

TEST(Subdivision, CubeOfTheOriginalPaperTendsToARoundBody) {
  // One level by hand: a corner of the cube goes to 5/9 of itself (Catmull and Clark's rule with n = 3).
  const Polyhedron once = subdivided(cube(), 1);
  EXPECT_LT(distance(once.points[0], Vec3{-5.0 / 9, -5.0 / 9, -5.0 / 9}), 1e-15);
  const Polyhedron fine = subdivided(cube(), 4);
  EXPECT_EQ(fine.polygon_count(), 6 * 256);
  double least = 1e9, most = 0;
  for (const Vec3& p : fine.points) least = std::min(least, length(p)), most = std::max(most, length(p));
  EXPECT_LT(most / least, 1.3) << "the cube itself has 1.73";
}

// Largest distance in height between each point and its mirror image in the plane through x = middle.
double asymmetry(const std::vector<Vec3>& points, double middle) {
  double worst = 0;
  for (const Vec3& p : points) {
    double best = 1e9;
    for (const Vec3& q : points) best = std::min(best, distance(q, Vec3{2 * middle - p.x, p.y, p.z}));
    worst = std::max(worst, best);
  }
  return worst;
}

TEST(Subdivision, SymmetricBumpOnAGridStaysSymmetricWhereTrianglesDoNot) {
  Polyhedron grid = make_grid(7, 7);
  grid.points[24].z = 1;
  EXPECT_LT(asymmetry(subdivided(grid, 2).points, 3), 1e-12);
  // The triangles of the same grid: the bump spreads over two of them in one diagonal direction, one in the
  // other.
  EXPECT_GT(asymmetry(subdivided(to_polyhedron(triangulated(grid)), 2).points, 3), 0.02);
}

TEST(Subdivision, CarriesValuesAndLaterPositions) {
  const Polyhedron grid = make_grid(5, 5);
  const Subdivision subdivision(grid, 2);
  std::vector<double> height(grid.points.size());
  std::vector<Vec3> moved = grid.points;
  for (std::size_t i = 0; i < moved.size(); ++i)
    height[i] = moved[i].z = std::sin(1.7 * static_cast<double>(i));
  Polyhedron bent = grid;
  bent.points = moved;
  EXPECT_EQ(subdivision.values(grid.points), subdivision.surface().points);
  EXPECT_EQ(subdivision.values(moved), subdivided(bent, 2).points);
  const std::vector<double> fine = subdivision.values(height);
  for (std::size_t i = 0; i < fine.size(); ++i) EXPECT_DOUBLE_EQ(fine[i], subdivision.values(moved)[i].z);
}

TEST(Subdivision, SplitsLinesAndSurvivesEverySurface) {
  Polyhedron odd = make_grid(3, 3);
  odd.lines = {{0, 8}, {9, 10}};
  odd.points.insert(odd.points.end(), {{5, 5, 5}, {6, 6, 6}, {7, 7, 7}});
  odd.add_polygon(std::array{0, 1, 9});     // three polygons in an edge
  odd.add_polygon(std::array{0, 1, 10});    //
  odd.add_polygon(std::array{4, 9, 10});    // a second fan at a point
  odd.add_polygon(std::array{0, 1, 4, 3});  // the same polygon twice
  ASSERT_TRUE(validate(odd));
  const Polyhedron fine = subdivided(odd, 3);
  EXPECT_TRUE(validate(fine));
  EXPECT_EQ(fine.lines.size(), 16u);
  EXPECT_EQ(fine.points[11], (Vec3{7, 7, 7}));
  EXPECT_TRUE(subdivided(Polyhedron{}, 2'000'000'000).points.empty());
  EXPECT_EQ(subdivided(odd, -3).points, odd.points);
}

}  // namespace
}  // namespace turgor
