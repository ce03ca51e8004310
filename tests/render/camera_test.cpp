#include "turgor/render/camera.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace turgor {
namespace {

TEST(StandardView, HoldsAllThatTouchesTheBox) {
  const Box3 box{{-80, -110, -200}, {75, 90, 60}};
  for (int v = 0; v < 8; ++v) {
    const CameraView camera = standard_view(static_cast<StandardView>(v), box);
    const bool slanted = v == 1 || v == 2;  // three-quarter views fit a rounded body: its furthest points
    for (int corner = 0; corner < 8; ++corner) {
      const Vec3 s{corner & 1 ? 0.5 : -0.5, corner & 2 ? 0.5 : -0.5, corner & 4 ? 0.5 : -0.5};
      const double reach = slanted ? std::pow(3.0, -0.25) : 1;  // x⁴ + y⁴ + z⁴ = 1 on the diagonal
      const Vec3 p = box.centre() + Vec3{s.x * box.size().x, s.y * box.size().y, s.z * box.size().z} * reach;
      const auto at = project(camera, 900, 1000, p);
      ASSERT_TRUE(at);
      EXPECT_GT(at->x, 0);
      EXPECT_LT(at->x, 900);
      EXPECT_GT(at->y, 0);
      EXPECT_LT(at->y, 1000);
      EXPECT_GT(at->depth, 0);
    }
  }
}

TEST(StandardView, OfAnEmptyBoxIsStillACamera) {
  EXPECT_TRUE(camera_frame(standard_view(StandardView::front, Box3{})));
}

TEST(CameraFrame, IsRightHandedAndOrthonormal) {
  CameraView camera;
  camera.eye = {300, -200, 100};
  camera.up = {0.1, 0.2, 0.9};
  const auto frame = camera_frame(camera);
  ASSERT_TRUE(frame);
  EXPECT_NEAR(length(frame->right), 1, 1e-12);
  EXPECT_NEAR(dot(frame->right, frame->up), 0, 1e-12);
  EXPECT_NEAR(distance(cross(frame->right, frame->up), -frame->forward), 0, 1e-12);
  EXPECT_GT(dot(frame->up, camera.up), 0);
}

TEST(InPerspective, KeepsTheHeightAtTheTarget) {
  const CameraView flat = standard_view(StandardView::front, Box3{{-50, -60, -70}, {50, 60, 70}});
  const CameraView lens = in_perspective(flat, 30);
  const Vec3 in_plane = flat.target + Vec3{20, 0, 30};
  const auto a = project(flat, 500, 500, in_plane), b = project(lens, 500, 500, in_plane);
  ASSERT_TRUE(a && b);
  EXPECT_NEAR(a->x, b->x, 1e-9);
  EXPECT_NEAR(a->y, b->y, 1e-9);
  const auto nearer = project(lens, 500, 500, in_plane - Vec3{0, 40, 0});
  ASSERT_TRUE(nearer);
  EXPECT_GT(nearer->x, b->x);
  EXPECT_FALSE(project(lens, 500, 500, lens.eye - Vec3{0, 1, 0}));
}

}  // namespace
}  // namespace turgor
