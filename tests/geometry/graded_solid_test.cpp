// Graded solids against the uniform ones of the same voxels.
#include "turgor/geometry/graded_solid.hpp"

#include <gtest/gtest.h>

#include <map>

#include "geometry/shapes.hpp"
#include "geometry/solid_checks.hpp"
#include "turgor/core/index.hpp"
#include "turgor/core/random.hpp"
#include "turgor/geometry/solid_quality.hpp"
#include "turgor/geometry/tetra_embedding.hpp"

namespace turgor {
namespace {

using testing::box;
using testing::sphere;
using testing::torus;

VoxelGrid voxels_of(const TriMesh& surface, int resolution, bool border = false) {
  VoxelOptions o;
  o.resolution = resolution, o.border = border;
  auto grid = voxelise(surface, o);
  EXPECT_TRUE(grid) << (grid ? "" : grid.error().message());
  return grid ? *std::move(grid) : VoxelGrid({1, 1, 1});
}
SolidMesh graded(const VoxelGrid& voxels, int levels, const std::vector<Box3>& fine = {}) {
  auto solid = graded_solid(voxels, levels, fine);
  EXPECT_TRUE(solid) << (solid ? "" : solid.error().message());
  return solid ? *std::move(solid) : SolidMesh{};
}
double volume_of(const VoxelGrid& g) {
  return static_cast<double>(g.count()) * g.spacing * g.spacing * g.spacing;
}

/// The corners of the surface's triangles, each from its least, in order.
std::vector<std::array<double, 9>> faces_of(const SolidMesh& solid) {
  std::vector<std::array<double, 9>> faces;
  for (Index3 t : solid.surface_triangles) {
    std::rotate(t.begin(), std::min_element(t.begin(), t.end()), t.end());
    std::array<double, 9> f{};
    for (int n = 0; n < 9; ++n) f[at(n)] = solid.points[at(t[at(n / 3)])][n % 3];
    faces.push_back(f);
  }
  std::sort(faces.begin(), faces.end());
  return faces;
}

void expect_sound(const VoxelGrid& voxels, const SolidMesh& solid) {
  test::expect_conforming(solid);
  const SolidQuality q = solid_quality(solid.points, solid.tetrahedra);
  EXPECT_GT(q.least_volume, 0);
  EXPECT_NEAR(q.volume, volume_of(voxels), 1e-9 * q.volume);
  EXPECT_GE(q.least_dihedral_deg, 45 - 1e-6);
  EXPECT_LE(q.greatest_dihedral_deg, 120 + 1e-6);
  EXPECT_GE(q.least_radius_ratio, 0.64);
  EXPECT_EQ(solid.spacing, 0);
  const auto uniform = solid_of(voxels);
  ASSERT_TRUE(uniform);
  EXPECT_TRUE(faces_of(solid) == faces_of(*uniform));
}

TEST(GradedSolid, SharesWholeFacesAndKeepsVolumeAndSurface) {
  for (const int levels : {0, 1, 2, 3, 4}) {
    const VoxelGrid ball = voxels_of(sphere(10, 4), 40);
    expect_sound(ball, graded(ball, levels));
    const VoxelGrid ring = voxels_of(torus(10, 4, 60, 30), 50, true);
    expect_sound(ring, graded(ring, levels));
  }
}

TEST(GradedSolid, HoldsForVoxelsOfAnyShape) {
  const RandomStream random(11);
  std::uint64_t n = 0;
  for (const double part : {0.9, 0.99, 0.999}) {
    VoxelGrid g({41, 38, 35});
    for (int k = 1; k < 34; ++k)
      for (int j = 1; j < 37; ++j)
        for (int i = 1; i < 40; ++i)
          if (random.uniform(n++) < part) g.set(i, j, k);
    expect_sound(g, graded(g, 3));
  }
}

TEST(GradedSolid, TakesFarFewerElementsForThickBodies) {
  const VoxelGrid ball = voxels_of(sphere(10, 4), 80);
  const std::size_t uniform = 5 * ball.count();
  const std::size_t one = graded(ball, 1).tetrahedra.size(), three = graded(ball, 3).tetrahedra.size();
  EXPECT_LT(one, uniform / 2);
  EXPECT_LT(three, one);
  EXPECT_LT(three, uniform * 2 / 5);
}

TEST(GradedSolid, ThinPartsStayFine) {
  // A plate of three voxels: no cell of it has a whole ring around.
  const VoxelGrid plate = voxels_of(box({0, 0, 0}, {40, 40, 3}), 40);
  const SolidMesh solid = graded(plate, 3);
  EXPECT_EQ(solid.tetrahedra.size(), 5 * plate.count());
}

TEST(GradedSolid, LevelZeroIsTheUniformSolid) {
  const VoxelGrid ball = voxels_of(sphere(10, 3), 17);
  const SolidMesh solid = graded(ball, 0);
  const auto uniform = solid_of(ball);
  ASSERT_TRUE(uniform);
  EXPECT_TRUE(solid.points == uniform->points);
  EXPECT_EQ(solid.tetrahedra.size(), uniform->tetrahedra.size());
  EXPECT_TRUE(solid.on_surface == uniform->on_surface);
}

TEST(GradedSolid, BoxesOfFineCellsAreKept) {
  const VoxelGrid cube = voxels_of(box({0, 0, 0}, {32, 32, 32}), 32);
  Box3 fine;
  fine.extend({14, 14, 14}), fine.extend({18, 18, 18});
  const SolidMesh with = graded(cube, 3, {fine});
  expect_sound(cube, with);
  EXPECT_GT(with.tetrahedra.size(), graded(cube, 3).tetrahedra.size());
  // Within the box every edge is that of a voxel or the diagonal of one side.
  int within = 0;
  for (const auto& t : with.tetrahedra) {
    Vec3 middle;
    for (const int p : t) middle += with.points[at(p)] / 4;
    if (!fine.contains(middle)) continue;
    ++within;
    for (const int p : t)
      for (const int q : t) EXPECT_LT(distance(with.points[at(p)], with.points[at(q)]), 1.42 * cube.spacing);
  }
  EXPECT_GE(within, 4 * 4 * 4 * 4);
}

double longest_edge(const SolidMesh& solid, const Index3& t) {
  double longest = 0;
  for (std::size_t n = 0; n < 3; ++n)
    longest = std::max(longest, distance(solid.points[at(t[n])], solid.points[at(t[(n + 1) % 3])]));
  return longest;
}

TEST(GradedSolid, SmoothPartsOfTheSurfaceMayBeCoarseToo) {
  // A small ball stands out of a large one.
  TriMesh surface = sphere(50, 5);
  surface = append(surface, sphere(6, 4, {0, 0, 52}));
  GradedOptions options;
  options.voxels.resolution = 100, options.levels = 3;
  const auto fine = graded_solid(surface, options);
  options.smooth_deg = 35;
  const auto smooth = graded_solid(surface, options);
  ASSERT_TRUE(fine && smooth);
  test::expect_conforming(*smooth);
  EXPECT_LT(smooth->tetrahedra.size(), fine->tetrahedra.size() / 2);
  const SolidQuality q = solid_quality(smooth->points, smooth->tetrahedra);
  EXPECT_GT(q.least_volume, 0);
  EXPECT_GE(q.least_dihedral_deg, 45 - 1e-6);
  EXPECT_GE(q.least_radius_ratio, 0.64);
  const double exact = enclosed_volume(sphere(50, 5));
  EXPECT_GT(q.volume, solid_quality(fine->points, fine->tetrahedra).volume);
  EXPECT_LT(q.volume, 1.35 * exact);
  const double spacing = 112.0 / 100;
  int coarse = 0, near = 0;
  for (const Index3& t : smooth->surface_triangles) {
    const Vec3& p = smooth->points[at(t[0])];
    coarse += longest_edge(*smooth, t) > 2.5 * spacing ? 1 : 0;
    if (distance(p, {0, 0, 52}) > 9 || p.z < 53) continue;
    ++near;
    EXPECT_LT(longest_edge(*smooth, t), 1.5 * spacing);
  }
  EXPECT_GT(coarse, 500);
  EXPECT_GT(near, 20);
  // It still holds the whole surface.
  const auto embedding = TetraEmbedding::bind(smooth->points, smooth->tetrahedra, surface.points);
  ASSERT_TRUE(embedding);
  for (const TetraEmbedding::Place& place : embedding->places()) ASSERT_LT(place.outside_mm, 1e-6);
}

TEST(GradedSolid, FlatSidesAreCoarseAndEdgesFine) {
  const TriMesh cube =
      transformed(box({0, 0, 0}, {30, 30, 30}), RigidTransform::rotate_about({}, {0, 0, 1}, 0.3));
  for (const int levels : {1, 2, 3, 4}) {
    GradedOptions options;
    options.voxels.resolution = 60, options.levels = levels, options.smooth_deg = 10;
    const auto solid = graded_solid(cube, options);
    ASSERT_TRUE(solid);
    test::expect_conforming(*solid);
    EXPECT_GE(solid_quality(solid->points, solid->tetrahedra).least_dihedral_deg, 45 - 1e-6);
  }
  GradedOptions options;
  for (const double angle : {-1.0, 91.0, std::nan("")}) {
    options.smooth_deg = angle;
    EXPECT_FALSE(graded_solid(cube, options));
  }
}

TEST(GradedSolid, RefusesWhatCannotBeGraded) {
  const TriMesh ball = sphere(10, 3);
  GradedOptions options;
  options.levels = 5;
  EXPECT_FALSE(graded_solid(ball, options));
  options.levels = 2;
  options.fine = {Box3{}};
  EXPECT_FALSE(graded_solid(ball, options));
  options.fine.clear();
  EXPECT_TRUE(graded_solid(ball, options));
  EXPECT_FALSE(graded_solid(TriMesh{}, options));
}

TEST(SolidQuality, KnowsTheRegularTetrahedronAndTheSliver) {
  const std::vector<Vec3> regular{{1, 1, 1}, {1, -1, -1}, {-1, 1, -1}, {-1, -1, 1}};
  const SolidQuality q = solid_quality(regular, std::vector<std::array<int, 4>>{{0, 1, 3, 2}, {0, 1, 2, 3}});
  EXPECT_NEAR(q.least_volume, -8.0 / 3, 1e-12);
  EXPECT_NEAR(q.least_dihedral_deg, degrees(std::acos(1.0 / 3)), 1e-9);
  EXPECT_NEAR(q.greatest_dihedral_deg, q.least_dihedral_deg, 1e-9);
  EXPECT_NEAR(q.mean_radius_ratio, 1, 1e-12);
  const std::vector<Vec3> flat{{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 1e-6}};
  const SolidQuality sliver = solid_quality(flat, std::vector<std::array<int, 4>>{{0, 1, 2, 3}});
  EXPECT_LT(sliver.least_dihedral_deg, 1e-3);
  EXPECT_LT(sliver.least_radius_ratio, 1e-3);
  EXPECT_EQ(solid_quality({}, {}).volume, 0);
}

}  // namespace
}  // namespace turgor
