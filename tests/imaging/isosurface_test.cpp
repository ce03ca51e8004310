#include "turgor/imaging/isosurface.hpp"

#include <gtest/gtest.h>

#include <numbers>
#include <set>

#include "imaging/imaging_support.hpp"
#include "imaging/marching_table.hpp"
#include "turgor/core/parallel.hpp"

namespace turgor {
namespace {

using test::directed_edges;
using test::grid_of;
using test::is_closed_and_oriented;
using test::sampled;

constexpr double kPi = std::numbers::pi;

/// Area, volume and used points are taken here straight from the triangles.
double area_of(const TriMesh& mesh) {
  double area = 0;
  for (const Index3& t : mesh.triangles) area += 0.5 * length(triangle_normal(mesh, t));
  return area;
}
double volume_of(const TriMesh& mesh) {
  double volume = 0;
  for (const Index3& t : mesh.triangles) {
    volume += dot(mesh.points[static_cast<std::size_t>(t[0])], triangle_normal(mesh, t)) / 6;
  }
  return volume;
}

/// A ball: `slope` units per mm, level 0 on the sphere, positive inside.
CtVolume ball(const Grid& grid, const Vec3& centre, double radius, double slope) {
  return sampled(grid, [&](const Vec3& p) { return slope * (radius - distance(p, centre)); });
}

/// A volume of n³ voxels whose whole grid is random.
CtVolume noise(const Grid& grid, std::uint64_t seed, int lowest, int highest) {
  CtVolume volume(grid);
  const RandomStream random(seed);
  for (std::size_t v = 0; v < volume.voxels.size(); ++v) {
    volume.voxels[v] = static_cast<std::int16_t>(lowest + random.uniform(v) * (highest - lowest + 1));
  }
  return volume;
}

/// Two by two by two voxels (or more along i) with the given corners inside.
CtVolume cells_with(int columns, unsigned corners) {
  CtVolume volume(grid_of({columns, 2, 2}));
  for (std::size_t v = 0; v < volume.voxels.size(); ++v) volume.voxels[v] = corners >> v & 1 ? 100 : -100;
  return volume;
}

TEST(MarchingTable, UsesExactlyTheCrossedEdgesInEveryCase) {
  for (unsigned number = 0; number < 256; ++number) {
    std::set<int> crossed, used;
    for (int e = 0; e < 12; ++e) {
      const int axis = e / 4, first = axis == 0 ? 1 : 0, second = axis == 2 ? 1 : 2;
      const int corner = (e & 1) << first | (e >> 1 & 1) << second;
      if ((number >> corner & 1) != (number >> (corner | 1 << axis) & 1)) crossed.insert(e);
    }
    const detail::MarchingCase& cell = detail::marching_table()[number];
    ASSERT_LE(cell.triangles, 5);
    for (std::size_t t = 0; t < 3u * cell.triangles; ++t) used.insert(cell.edges[t]);
    EXPECT_EQ(crossed, used) << "case " << number;
  }
}

TEST(MarchingTable, ClosesEveryCaseWhenTheCellIsSurroundedByOutside) {
  for (unsigned corners = 1; corners < 256; ++corners) {
    const TriMesh mesh = isosurface(cells_with(2, corners), 0, true);
    EXPECT_TRUE(is_closed_and_oriented(mesh)) << "case " << corners;
    EXPECT_GT(volume_of(mesh), 0) << "case " << corners;
  }
}

TEST(MarchingTable, ClosesEveryPairOfNeighbouringCells) {
  for (unsigned corners = 1; corners < 4096; ++corners) {
    EXPECT_TRUE(is_closed_and_oriented(isosurface(cells_with(3, corners), 0, true))) << "corners " << corners;
  }
}

TEST(MarchingTable, KeepsInsideCornersApartOnAnAmbiguousFace) {
  // Two diagonal voxels of one slice are two bodies; their complement is one.
  LabelVolume mask(grid_of({2, 2, 1}));
  mask.at(0, 0, 0) = mask.at(1, 1, 0) = 1;
  const TriMesh mesh = isosurface(mask, 0.5, true);
  EXPECT_EQ(mesh.points.size(), 12u);
  EXPECT_EQ(mesh.triangles.size(), 16u);  // two octahedra
  EXPECT_NEAR(volume_of(mesh), 2 * 4.0 / 3 * 0.125, 1e-12);
}

TEST(Isosurface, OfNoiseIsAClosedManifoldWithoutDegenerateTriangles) {
  // Few distinct values, so that many voxels lie exactly at the level.
  for (const int spread : {3, 1000}) {
    const TriMesh mesh = isosurface(noise(grid_of({70, 19, 17}), 11, -spread, spread), 0, true);
    EXPECT_TRUE(is_closed_and_oriented(mesh));
    for (const Vec3& p : mesh.points) ASSERT_TRUE(is_finite(p));
    for (const Index3& t : mesh.triangles) ASSERT_GT(length(triangle_normal(mesh, t)), 1e-6);
  }
}

TEST(Isosurface, HasBoundaryEdgesOnlyAtTheEndOfTheVolume) {
  const Grid grid = grid_of({67, 9, 11});
  const TriMesh mesh = isosurface(noise(grid, 5, -100, 99), 0);
  const auto edges = directed_edges(mesh);
  const auto at_end = [&](const Vec3& p) {
    return p.x == 0 || p.y == 0 || p.z == 0 || p.x == 66 || p.y == 8 || p.z == 10;
  };
  ASSERT_EQ(std::adjacent_find(edges.begin(), edges.end()), edges.end());
  int open = 0;
  for (const auto& [from, to] : edges) {
    if (std::binary_search(edges.begin(), edges.end(), std::pair{to, from})) continue;
    ++open;
    ASSERT_TRUE(at_end(mesh.points[static_cast<std::size_t>(from)]) &&
                at_end(mesh.points[static_cast<std::size_t>(to)]));
  }
  EXPECT_GT(open, 0);
}

TEST(Isosurface, SharesEachCrossingAmongAllTrianglesAroundIt) {
  const CtVolume volume = noise(grid_of({66, 7, 5}), 3, -50, 50);
  std::size_t crossings = 0;
  const Index3 n = volume.grid.size;
  for (int k = 0; k < n[2]; ++k) {
    for (int j = 0; j < n[1]; ++j) {
      for (int i = 0; i < n[0]; ++i) {
        const bool here = volume.at(i, j, k) >= 10;
        if (i + 1 < n[0]) crossings += here != (volume.at(i + 1, j, k) >= 10);
        if (j + 1 < n[1]) crossings += here != (volume.at(i, j + 1, k) >= 10);
        if (k + 1 < n[2]) crossings += here != (volume.at(i, j, k + 1) >= 10);
      }
    }
  }
  const TriMesh mesh = isosurface(volume, 10);
  EXPECT_EQ(mesh.points.size(), crossings);
  std::set<int> used;
  for (const Index3& t : mesh.triangles) used.insert(t.begin(), t.end());
  EXPECT_EQ(used.size(), crossings);
}

TEST(Isosurface, OfASphereConvergesAtSecondOrder) {
  const double radius = 10;
  double area_error[2], volume_error[2];
  for (int level = 0; level < 2; ++level) {
    const double h = level == 0 ? 1.0 : 0.5;
    const int n = static_cast<int>(26 / h);
    const Vec3 centre{0.13, -0.21, 0.37};
    const Grid grid = grid_of({n, n, n}, {h, h, h}, Vec3{1, 1, 1} * (-0.5 * h * (n - 1)));
    const TriMesh mesh = isosurface(ball(grid, centre, radius, 1500), 0);
    EXPECT_TRUE(is_closed_and_oriented(mesh));
    area_error[level] = std::abs(area_of(mesh) - 4 * kPi * radius * radius);
    volume_error[level] = std::abs(volume_of(mesh) - 4.0 / 3 * kPi * radius * radius * radius);
  }
  EXPECT_LT(area_error[0], 0.01 * 4 * kPi * 100);
  EXPECT_NEAR(area_error[0] / area_error[1], 4, 0.6);
  EXPECT_NEAR(volume_error[0] / volume_error[1], 4, 0.6);
}

TEST(Isosurface, PutsPointsOfAnObliqueAnisotropicGridInThePatient) {
  const Mat3 turn = rotation(normalized(Vec3{1, 2, -0.5}), 0.7);
  const Grid grid = grid_of({60, 52, 30}, {0.5, 0.6, 1.1}, {-20, 30, 7}, turn);
  const Vec3 centre = grid.to_patient({30.3, 25.1, 14.8});
  const TriMesh mesh = isosurface(ball(grid, centre, 9, 3000), 0);
  EXPECT_TRUE(is_closed_and_oriented(mesh));
  EXPECT_GT(volume_of(mesh), 0.98 * 4.0 / 3 * kPi * 729);  // outwards, hence positive
  for (const Vec3& p : mesh.points) ASSERT_NEAR(distance(p, centre), 9, 0.02);
}

TEST(Isosurface, TurnsNormalsTowardsSmallerValues) {
  const CtVolume ramp = sampled(grid_of({5, 6, 7}), [](const Vec3& p) { return -100 * p.y; });
  const TriMesh mesh = isosurface(ramp, -130);
  ASSERT_FALSE(mesh.empty());
  EXPECT_NEAR(area_of(mesh), 4 * 6, 1e-9);
  for (const Index3& t : mesh.triangles) ASSERT_GT(triangle_normal(mesh, t).y, 0);
  for (const Vec3& p : mesh.points) ASSERT_NEAR(p.y, 1.3, 1e-9);
}

TEST(Isosurface, ClosedAtTheBorderIsFlatHalfAVoxelOutside) {
  const CtVolume solid = sampled(grid_of({4, 5, 6}, {1, 2, 3}), [](const Vec3&) { return 100; });
  EXPECT_TRUE(isosurface(solid, 0).empty());
  const TriMesh mesh = isosurface(solid, 0, true);
  EXPECT_TRUE(is_closed_and_oriented(mesh));
  Box3 box;
  for (const Vec3& p : mesh.points) box.extend(p);
  EXPECT_EQ(box.lower, (Vec3{-0.5, -1, -1.5}));
  EXPECT_EQ(box.upper, (Vec3{3.5, 9, 16.5}));
}

TEST(Isosurface, GivesTheSameBitsOnOneAndTwoThreads) {
  const CtVolume volume = noise(grid_of({130, 90, 40}), 21, -300, 400);
  set_thread_count(1);
  const TriMesh one = isosurface(volume, 17.5);
  set_thread_count(2);
  const TriMesh two = isosurface(volume, 17.5);
  set_thread_count(0);
  ASSERT_FALSE(one.empty());
  EXPECT_EQ(one.points, two.points);
  EXPECT_EQ(one.triangles, two.triangles);
}

TEST(Isosurface, IsEmptyWhereNothingCrossesOrTheInputIsUnusable) {
  const CtVolume volume = noise(grid_of({9, 9, 9}), 1, -10, 10);
  EXPECT_TRUE(isosurface(volume, 40000).empty());
  EXPECT_TRUE(isosurface(volume, 40000, true).empty());
  EXPECT_TRUE(isosurface(volume, -40000).empty());
  EXPECT_TRUE(is_closed_and_oriented(isosurface(volume, -40000, true)));
  EXPECT_TRUE(isosurface(volume, std::nan("")).empty());
  EXPECT_TRUE(isosurface(CtVolume{}, 0).empty());
  EXPECT_TRUE(isosurface(CtVolume(grid_of({1, 1, 1}), 100), 0).empty());
  EXPECT_EQ(isosurface(CtVolume(grid_of({1, 1, 1}), 100), 0, true).triangles.size(), 8u);
}

TEST(IsosurfaceOfAMask, LiesMidwayBetweenVoxelCentres) {
  LabelVolume mask(grid_of({5, 5, 5}));
  mask.at(2, 2, 2) = 7;
  const TriMesh mesh = isosurface(mask);
  EXPECT_EQ(mesh.points.size(), 6u);
  for (const Vec3& p : mesh.points) EXPECT_NEAR(distance(p, {2, 2, 2}), 0.5, 1e-12);
}

/// Two balls that touch in the voxels, labelled by the plane midway between them.
struct TwoBalls {
  Grid grid = grid_of({60, 40, 40});
  CtVolume volume;
  LabelVolume labels;
  TwoBalls() {
    const auto depth = [](const Vec3& p) {
      return std::max(10 - distance(p, {19.2, 20, 20}), 10 - distance(p, {38.8, 20, 20}));
    };
    volume = sampled(grid, [&](const Vec3& p) { return 200 * depth(p); });
    labels = LabelVolume(grid);
    for (std::size_t v = 0; v < labels.voxels.size(); ++v) {
      if (volume.voxels[v] >= 0) labels.voxels[v] = v % 60 < 29 ? 1 : 2;
    }
  }
};

TEST(IsosurfaceWithin, OfOneBodyFollowsTheCtAndLeavesTheOtherOut) {
  const TwoBalls balls;
  for (const std::uint8_t label : {std::uint8_t{1}, std::uint8_t{2}}) {
    const TriMesh mesh = isosurface_within(balls.volume, 0, balls.labels, label, -1000);
    EXPECT_TRUE(is_closed_and_oriented(mesh));
    const Vec3 centre{label == 1 ? 19.2 : 38.8, 20, 20};
    int on_sphere = 0;
    for (const Vec3& p : mesh.points) {
      ASSERT_TRUE(label == 1 ? p.x < 29 : p.x > 28);
      if (std::abs(distance(p, centre) - 10) < 0.02) ++on_sphere;
    }
    EXPECT_GT(on_sphere, 0.95 * static_cast<double>(mesh.points.size()));
  }
}

TEST(IsosurfaceOfLabel, IsTheIsosurfaceWhereMaskAndCtAgree) {
  const CtVolume volume = ball(grid_of({40, 40, 40}), {19.3, 20.1, 19.9}, 12, 100);
  LabelVolume mask(volume.grid);
  for (std::size_t v = 0; v < mask.voxels.size(); ++v) mask.voxels[v] = volume.voxels[v] >= 50 ? 1 : 0;
  const TriMesh of_ct = isosurface(volume, 50), of_label = isosurface_of_label(volume, 50, mask);
  EXPECT_EQ(of_ct.triangles, of_label.triangles);
  double worst = 0;
  for (std::size_t p = 0; p < of_ct.points.size(); ++p) {
    worst = std::max(worst, distance(of_ct.points[p], of_label.points[p]));
  }
  EXPECT_LT(worst, 0.011);  // a voxel within one unit of the level
}

TEST(IsosurfaceOfLabel, CutsTouchingBodiesMidwayAndKeepsFilledHolesFilled) {
  const TwoBalls balls;
  LabelVolume labels = balls.labels;
  CtVolume hollow = balls.volume;
  hollow.at(19, 20, 20) = -1000;  // air inside the body, filled in the mask
  const TriMesh mesh = isosurface_of_label(hollow, 0, labels, 1);
  EXPECT_TRUE(is_closed_and_oriented(mesh));
  for (const Vec3& p : mesh.points) {
    ASSERT_GT(distance(p, {19.2, 20, 20}), 9);
    ASSERT_LT(p.x, 29);
  }
}

}  // namespace
}  // namespace turgor
