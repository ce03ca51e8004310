#include "turgor/geometry/mesh_edit.hpp"

#include <gtest/gtest.h>

#include <set>

#include "shapes.hpp"
#include "turgor/core/parallel.hpp"
#include "turgor/geometry/surface_query.hpp"

namespace turgor {
namespace {

using testing::sphere;

double roughness(const TriMesh& mesh, double radius) {
  double sum = 0;
  for (const Vec3& p : mesh.points) sum += (length(p) - radius) * (length(p) - radius);
  return std::sqrt(sum / static_cast<double>(mesh.points.size()));
}

TEST(Smooth, KeepsTheVolumeOfASphereAndTakesAwayNoise) {
  const TriMesh clean = sphere(50, 5), rough = testing::noisy(clean, 0.3, 11);
  EXPECT_NEAR(enclosed_volume(smooth(clean, 20, 0.1)) / enclosed_volume(clean), 1, 4e-3);
  const TriMesh smoothed = smooth(rough, 20, 0.1);
  EXPECT_NEAR(enclosed_volume(smoothed) / enclosed_volume(clean), 1, 4e-3);
  EXPECT_LT(roughness(smoothed, 50), 0.4 * roughness(rough, 50));
  EXPECT_EQ(smoothed.triangles, rough.triangles);
}

TEST(Smooth, MultipliesAWaveByTheTransferFunctionOfTaubin) {
  // Along a strip whose points have two neighbours each, a wave of the umbrella operator has a known factor.
  const int n = 64, waves = 6;
  TriMesh ring = testing::torus(100, 1, n, 3);
  const double k_wave = 1 - std::cos(2 * std::numbers::pi * waves / n);
  // Every neighbour list of this torus: two along, two across, two diagonal. A wave along i that is the same
  // across has the factor (2 + 4 cos)/6 per umbrella step, so k = 2/3 (1 - cos).
  const double k = 2.0 / 3 * k_wave;
  for (std::size_t p = 0; p < ring.points.size(); ++p) {
    ring.points[p] = {0, 0, std::cos(2 * std::numbers::pi * waves * static_cast<double>(p / 3) / n)};
  }
  const double lambda = 0.5, mu = 1 / (0.1 - 2.0);
  const TriMesh once = smooth(ring, 1, 0.1);
  const double factor = (1 - lambda * k) * (1 - mu * k);
  for (std::size_t p = 0; p < ring.points.size(); ++p) {
    EXPECT_NEAR(once.points[p].z, factor * ring.points[p].z, 1e-12);
  }
}

TEST(Smooth, LeavesTheBoundaryWhereItIs) {
  const TriMesh rough = testing::noisy(testing::sheet(20, 100), 1.0, 3);
  const TriMesh smoothed = smooth(rough, 10, 0.1);
  const auto boundary = boundary_points(rough);
  int moved = 0;
  for (std::size_t i = 0; i < boundary.size(); ++i) {
    if (boundary[i]) {
      EXPECT_EQ(smoothed.points[i], rough.points[i]);
    } else if (smoothed.points[i] != rough.points[i]) {
      ++moved;
    }
  }
  EXPECT_EQ(moved, 19 * 19);
}

TEST(Smooth, GivesTheSameBitsOnAnyNumberOfThreadsAndStaysFiniteAtTheEndsOfItsRange) {
  const TriMesh rough = testing::noisy(sphere(50, 5), 0.3, 11);
  set_thread_count(1);
  const TriMesh one = smooth(rough, 5, 0.2);
  set_thread_count(0);
  EXPECT_EQ(smooth(rough, 5, 0.2).points, one.points);
  for (const double pass_band : {-1.0, 0.0, 0.5, 1.0, 1.5, 2.0, 5.0}) {
    const TriMesh smoothed = smooth(rough, 50, pass_band);
    EXPECT_TRUE(validate(smoothed));
    EXPECT_NEAR(enclosed_volume(smoothed) / enclosed_volume(rough), 1, 0.05) << pass_band;
  }
}

TEST(SmoothField, SolvesForTheStraightLineBetweenFixedEnds) {
  const TriMesh mesh = testing::sheet(10, 10);
  std::vector<double> values(mesh.points.size(), 0);
  std::vector<bool> fixed(mesh.points.size(), false);
  for (std::size_t i = 0; i < values.size(); ++i) {
    const Vec3& p = mesh.points[i];
    fixed[i] = p.x == 0 || p.x == 10 || p.y == 0 || p.y == 10;
    if (fixed[i]) values[i] = p.x + 2 * p.y;
  }
  const auto smoothed = smooth_field(mesh, values, fixed, 2000, 1.0);
  for (std::size_t i = 0; i < values.size(); ++i) {
    EXPECT_NEAR(smoothed[i], mesh.points[i].x + 2 * mesh.points[i].y, 1e-6);
  }
}

/// What every reduction must keep.
void expect_sound(const TriMesh& reduced, bool closed) {
  EXPECT_TRUE(validate(reduced));
  const Topology found = topology(reduced);
  EXPECT_EQ(found.non_manifold_edges, 0);
  if (closed) {
    EXPECT_EQ(found.boundary_edges, 0);
  }
  std::set<Index3> triangles;
  std::vector<bool> used(reduced.points.size(), false);
  for (Index3 t : reduced.triangles) {
    for (const int p : t) used[static_cast<std::size_t>(p)] = true;
    std::sort(t.begin(), t.end());
    EXPECT_TRUE(triangles.insert(t).second) << "double triangle";
  }
  EXPECT_EQ(std::count(used.begin(), used.end(), false), 0);
}

TEST(Decimate, ReachesTheNumberAskedForAndStaysOnTheSphere) {
  const TriMesh mesh = testing::noisy(sphere(90, 7), 0.02, 5);
  ASSERT_EQ(mesh.triangles.size(), 131072U);
  for (const int target : {60000, 13107, 2000, 300}) {
    double error = -1;
    const TriMesh reduced = decimate(mesh, target, &error);
    EXPECT_LE(reduced.triangles.size(), static_cast<std::size_t>(target));
    EXPECT_GE(reduced.triangles.size(), static_cast<std::size_t>(0.995 * target) - 2);
    expect_sound(reduced, true);
    EXPECT_EQ(topology(reduced).components, 1);
    EXPECT_GT(error, 0);
    EXPECT_LT(error, 5);
    const double share = enclosed_volume(reduced) / enclosed_volume(mesh);
    EXPECT_NEAR(share, 1, 15.0 / target) << target;
  }
}

TEST(Decimate, KeepsABoundaryOnItsCourse) {
  const TriMesh mesh = testing::sheet(60, 120);
  const TriMesh reduced = decimate(mesh, 400);
  expect_sound(reduced, false);
  EXPECT_LE(reduced.triangles.size(), 400U);
  EXPECT_NEAR(surface_area(reduced), 120.0 * 120.0, 1e-6);
}

TEST(Decimate, ThinWallsComeOutManifold) {
  // Two skins a hair apart, rough enough that collapses run into each other.
  const TriMesh shell = append(sphere(50, 6), testing::reversed(sphere(49.9, 6)));
  const TriMesh mesh = testing::noisy(append(shell, testing::torus(30, 0.3, 400, 6)), 0.15, 2);
  for (const int target : {20000, 3000, 500, 60}) {
    const TriMesh reduced = decimate(mesh, target);
    expect_sound(reduced, true);
    EXPECT_LE(reduced.triangles.size(), static_cast<std::size_t>(target));
  }
}

TEST(Decimate, LeavesASmallMeshAsItIsAndDropsUnusedPoints) {
  TriMesh mesh = sphere(1, 2);
  mesh.points.insert(mesh.points.begin(), Vec3{7, 7, 7});
  for (Index3& t : mesh.triangles) {
    for (int& p : t) ++p;
  }
  const TriMesh same = decimate(mesh, 1000000);
  EXPECT_EQ(same.triangles, sphere(1, 2).triangles);
  EXPECT_EQ(same.points, sphere(1, 2).points);
  EXPECT_TRUE(decimate(TriMesh{}, 10).empty());
}

TEST(Decimate, RepeatsToTheBit) {
  const TriMesh mesh = testing::noisy(sphere(90, 6), 0.05, 5);
  const TriMesh first = decimate(mesh, 3000);
  set_thread_count(1);
  const TriMesh second = decimate(mesh, 3000);
  set_thread_count(0);
  EXPECT_EQ(first.points, second.points);
  EXPECT_EQ(first.triangles, second.triangles);
}

}  // namespace
}  // namespace turgor
