#include "turgor/math/vec.hpp"

#include <gtest/gtest.h>

#include <numbers>

namespace turgor {
namespace {

void expect_near(const Vec3& a, const Vec3& b, double tolerance = 1e-12) {
  EXPECT_LT(distance(a, b), tolerance) << a.x << ' ' << a.y << ' ' << a.z;
}

TEST(Rotation, IsRightHandedAndKeepsTheAxis) {
  expect_near(rotation({0, 0, 1}, std::numbers::pi / 2) * Vec3{1, 0, 0}, {0, 1, 0});
  const Vec3 axis = normalized(Vec3{1, 2, 3});
  expect_near(rotation(axis, 1.2) * axis, axis);
  EXPECT_NEAR(rotation(axis, 1.2).determinant(), 1, 1e-12);
}

TEST(RigidTransform, InverseUndoesAndProductAppliesTheRightFirst) {
  const auto a = RigidTransform::rotate_about({1, 2, 3}, normalized(Vec3{1, 1, 0}), 0.7);
  const auto b = RigidTransform::translate({4, -5, 6});
  const Vec3 p{-2, 7, 0.5};
  expect_near((a * b).point(p), a.point(b.point(p)));
  expect_near((a.inverse() * a).point(p), p);
  expect_near(a.point({1, 2, 3}), {1, 2, 3});
}

TEST(Mat3, InverseTimesMatrixIsIdentity) {
  const Mat3 m{{Vec3{2, 1, 0}, Vec3{-1, 3, 0.5}, Vec3{0.2, 0.1, 4}}};
  const Mat3 product = m.inverse() * m;
  for (int j = 0; j < 3; ++j)
    expect_near(product.c[static_cast<std::size_t>(j)], Mat3{}.c[static_cast<std::size_t>(j)]);
}

}  // namespace
}  // namespace turgor
