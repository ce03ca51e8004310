#include <gtest/gtest.h>

#include "imaging/imaging_support.hpp"
#include "turgor/core/parallel.hpp"
#include "turgor/imaging/isosurface.hpp"

namespace turgor {
namespace {

using test::grid_of;
using test::sampled;

/// Part of a step at distance d (positive inside) that an edge blurred by a Gaussian of `sigma` shows.
double blurred_step(double d, double sigma) {
  return 0.5 * std::erfc(-d / (sigma * std::sqrt(2.0)));
}

constexpr double kBone = 1500, kSoft = 40, kVoxel = 0.9, kBlur = 0.75 * kVoxel;

CtVolume with_noise(CtVolume volume, double deviation) {
  const RandomStream random(77);
  for (std::size_t v = 0; v < volume.voxels.size(); ++v) {
    volume.voxels[v] =
        static_cast<std::int16_t>(std::lround(volume.voxels[v] + deviation * random.normal(v)));
  }
  return volume;
}

/// A shell of bone in soft tissue (a ball where it is as thick as its radius), and a small ball in its
/// middle, whose surface shows how blurred the scan is.
CtVolume bone_ball(double radius, double thickness, double noise) {
  const Grid grid = grid_of({60, 60, 40}, {kVoxel, kVoxel, 1.3}, {-26.4, -26.7, -25.2});
  return with_noise(sampled(grid,
                            [&](const Vec3& p) {
                              const double outer = blurred_step(radius - length(p), kBlur);
                              const double inner = blurred_step(radius - thickness - length(p), kBlur);
                              const double core =
                                  thickness < radius ? blurred_step(7 - length(p), kBlur) : inner;
                              return kSoft + (kBone - kSoft) * (outer - inner + core);
                            }),
                    noise);
}

/// Mean distance to the sphere of points on its side of `middle`, and the worst.
struct Fit {
  double bias = 0, mean = 0, worst = 0;
};
Fit fit_to_sphere(const TriMesh& mesh, double radius, double at_least, double at_most) {
  Fit fit;
  int n = 0;
  for (const Vec3& p : mesh.points) {
    const double r = length(p);
    if (r < at_least || r > at_most) continue;
    fit.bias += r - radius;
    fit.mean += std::abs(r - radius);
    fit.worst = std::max(fit.worst, std::abs(r - radius));
    ++n;
  }
  fit.bias /= n;
  fit.mean /= n;
  return fit;
}

TEST(LocalLevel, BringsABallMeshedAtALowLevelToItsTrueSurface) {
  const CtVolume volume = bone_ball(15, 15, 12);
  TriMesh mesh = isosurface(volume, 250);
  const Fit before = fit_to_sphere(mesh, 15, 10, 20);
  const int moved = refine_to_local_level(mesh, volume, 3, 1.5);
  const Fit after = fit_to_sphere(mesh, 15, 10, 20);
  EXPECT_GT(before.bias, 0.6 * kVoxel);
  EXPECT_EQ(moved, static_cast<int>(mesh.points.size()));
  EXPECT_LT(after.mean, 0.06 * kVoxel);
  EXPECT_LT(after.worst, 0.25 * kVoxel);
}

class ThinShell : public testing::TestWithParam<double> {};

TEST_P(ThinShell, IsFoundInItsTruePlaceOnBothSides) {
  const double thickness = GetParam() * kVoxel, radius = 15;
  const CtVolume volume = bone_ball(radius, thickness, 12);
  TriMesh mesh = isosurface(volume, 250);
  const double middle = radius - thickness / 2;
  const Fit outer_before = fit_to_sphere(mesh, radius, middle, 25);
  const Fit inner_before = fit_to_sphere(mesh, radius - thickness, 9.5, middle);
  refine_to_local_level(mesh, volume, 3, 1.5);
  const Fit outer = fit_to_sphere(mesh, radius, middle, 25);
  const Fit inner = fit_to_sphere(mesh, radius - thickness, 9.5, middle);
  EXPECT_LT(outer.mean, 0.25 * outer_before.mean);
  EXPECT_LT(inner.mean, 0.25 * inner_before.mean);
  EXPECT_LT(outer.mean, 0.15 * kVoxel);
  EXPECT_LT(inner.mean, 0.15 * kVoxel);
}

INSTANTIATE_TEST_SUITE_P(LocalLevel, ThinShell, testing::Values(1.0, 1.5, 2.0, 3.0));

TEST(LocalLevel, OfSkinOverBoneKeepsTheTwoApart) {
  // Bone, 3 mm of soft tissue, air: each surface finds its own step.
  const Grid grid = grid_of({40, 20, 20}, {kVoxel, kVoxel, kVoxel});
  const double bone_at = 14.2, skin_at = 17.2;
  const CtVolume volume = with_noise(sampled(grid,
                                             [&](const Vec3& p) {
                                               return -1000 + 1040 * blurred_step(skin_at - p.x, kBlur) +
                                                      (kBone - kSoft) * blurred_step(bone_at - p.x, kBlur);
                                             }),
                                     12);
  const auto mean_x = [](const TriMesh& mesh) {
    double sum = 0;
    for (const Vec3& p : mesh.points) sum += p.x;
    return sum / static_cast<double>(mesh.points.size());
  };
  TriMesh bone = isosurface(volume, 250), skin = isosurface(volume, -200);
  refine_to_local_level(bone, volume, 3, 1.5);
  refine_to_local_level(skin, volume, 3, 1.5);
  EXPECT_NEAR(mean_x(bone), bone_at, 0.15 * kVoxel);
  EXPECT_NEAR(mean_x(skin), skin_at, 0.15 * kVoxel);
}

TEST(LocalLevel, LeavesPointsWithoutAClearStepAndNeverMovesFurtherThanAllowed) {
  const CtVolume flat = with_noise(CtVolume(grid_of({20, 20, 20}), 100), 12);
  TriMesh mesh = isosurface(flat, 100);
  const TriMesh untouched = mesh;
  EXPECT_EQ(refine_to_local_level(mesh, flat, 3, 1), 0);
  EXPECT_EQ(mesh.points, untouched.points);

  const CtVolume ball = bone_ball(15, 15, 12);
  TriMesh low = isosurface(ball, 250);
  const TriMesh start = low;
  EXPECT_GT(refine_to_local_level(low, ball, 3, 0.2), 0);
  for (std::size_t p = 0; p < low.points.size(); ++p) {
    ASSERT_LE(distance(low.points[p], start.points[p]), 0.2 + 1e-9);
  }
}

TEST(LocalLevel, IsTheSameOnOneAndTwoThreadsAndRefusesNonsense) {
  const CtVolume volume = bone_ball(15, 15, 12);
  const TriMesh start = isosurface(volume, 250);
  TriMesh one = start, two = start, none = start;
  set_thread_count(1);
  refine_to_local_level(one, volume, 3, 1.5);
  set_thread_count(2);
  refine_to_local_level(two, volume, 3, 1.5);
  set_thread_count(0);
  EXPECT_EQ(one.points, two.points);
  EXPECT_EQ(refine_to_local_level(none, volume, 0, 1), 0);
  EXPECT_EQ(refine_to_local_level(none, volume, std::nan(""), 1), 0);
  EXPECT_EQ(refine_to_local_level(none, volume, 3, HUGE_VAL), 0);
  EXPECT_EQ(refine_to_local_level(none, CtVolume{}, 3, 1), 0);
  EXPECT_EQ(none.points, start.points);
}

}  // namespace
}  // namespace turgor
