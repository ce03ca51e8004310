#include "anatomy/implicit.hpp"

#include <gtest/gtest.h>

#include <vector>

#include "anatomy/phantom_shapes.hpp"
#include "turgor/core/random.hpp"

namespace turgor::implicit {
namespace {

struct NamedShape {
  const char* name;
  ShapePtr shape;
};

std::vector<NamedShape> every_kind() {
  const Mat3 turned = rotation(normalized(Vec3{1, 2, 3}), 0.7);
  Field cluster;
  cluster.join(ellipsoid({4, -6, 2}, {9, 5, 7})).join(ellipsoid({8, 3, 0}, {6, 8, 5}), 4, Side::both);
  cluster.cut(rounded_box({0, 0, 6}, {3, 20, 2}, 1), 2);
  return {{"ellipsoid", ellipsoid({1, 2, 3}, {12, 7, 9}, turned)},
          {"flat ellipsoid", ellipsoid({0, 0, 0}, {20, 16, 5})},
          {"rounded box", rounded_box({2, -1, 0}, {8, 5, 6}, 2, turned)},
          {"half space", half_space({normalized(Vec3{1, 1, 0}), 3})},
          {"sweep", sweep({{{-12, 0, 0}, 3}, {{0, 6, 2}, 4}, {{10, 0, 6}, 2}})},
          {"wall", wall({{-14, 4, 0, 5, 3}, {0, -6, 1, 6, 3.5}, {14, 4, -1, 5, 3}}, 0.8)},
          {"plate", plate({0, 0, 0}, turned, {{10, 0}, {4, 9}, {-8, 6}, {-3, 0}, {-8, -6}, {4, -9}}, 3, 1)},
          {"offset", offset(ellipsoid({0, 0, 0}, {9, 6, 7}), 2)},
          {"moved", moved(ellipsoid({0, 0, 0}, {9, 6, 7}), {turned, {1, 2, 3}})},
          {"group", group(cluster)}};
}

class Points {
 public:
  explicit Points(std::uint64_t seed) : random_(seed) {}
  Vec3 within(const Box3& box) {
    Vec3 p;
    for (int a = 0; a < 3; ++a) p[a] = box.lower[a] + box.size()[a] * random_.uniform(next_++);
    return p;
  }

 private:
  RandomStream random_;
  std::uint64_t next_ = 0;
};

const Box3 around{{-25, -25, -25}, {25, 25, 25}};
const Box3 head{{-110, -135, -185}, {110, 135, 140}};

TEST(Implicit, EllipsoidDistanceIsThatOfTheNearestOfManySurfacePoints) {
  const Vec3 radii{12, 7, 4};
  const ShapePtr shape = ellipsoid({0, 0, 0}, radii);
  std::vector<Vec3> surface;
  for (int i = 0; i <= 400; ++i) {
    for (int j = 0; j < 800; ++j) {
      const double u = 3.14159265358979 * i / 400, v = 6.28318530717959 * j / 800;
      surface.push_back(
          {radii.x * std::sin(u) * std::cos(v), radii.y * std::sin(u) * std::sin(v), radii.z * std::cos(u)});
    }
  }
  Points points(3);
  for (int n = 0; n < 60; ++n) {
    const Vec3 p = points.within({{-15, -10, -8}, {15, 10, 8}});
    double nearest = 1e9;
    for (const Vec3& s : surface) nearest = std::min(nearest, distance(p, s));
    const bool inside = p.x * p.x / 144 + p.y * p.y / 49 + p.z * p.z / 16 < 1;
    EXPECT_NEAR(shape->distance(p), inside ? -nearest : nearest, 0.03);
  }
}

TEST(Implicit, EllipsoidDistanceHoldsOnItsAxesAndAtItsCentre) {
  const ShapePtr shape = ellipsoid({1, 1, 1}, {12, 7, 4});
  EXPECT_NEAR(shape->distance({1, 1, 1}), -4, 1e-6);
  EXPECT_NEAR(shape->distance({21, 1, 1}), 8, 1e-9);
  EXPECT_NEAR(shape->distance({1, 1, 9}), 4, 1e-9);
  EXPECT_NEAR(shape->distance({1, 7, 1}), -1, 1e-6);
}

TEST(Implicit, SweepOfTwoKnotsIsACapsule) {
  const ShapePtr shape = sweep({{{0, 0, 0}, 2}, {{10, 0, 0}, 2}});
  EXPECT_NEAR(shape->distance({4, 5, 0}), 3, 1e-9);
  EXPECT_NEAR(shape->distance({-3, 4, 0}), 3, 1e-9);
  EXPECT_NEAR(shape->distance({10, 0, 1}), -1, 1e-9);
}

TEST(Implicit, NoShapeIsSteeperThanItClaims) {
  Points points(5);
  for (const NamedShape& kind : every_kind()) {
    for (int n = 0; n < 4000; ++n) {
      const Vec3 p = points.within(around);
      const Vec3 q = p + points.within({{-0.5, -0.5, -0.5}, {0.5, 0.5, 0.5}});
      const double change = std::abs(kind.shape->distance(p) - kind.shape->distance(q));
      ASSERT_LE(change, kind.shape->lipschitz() * distance(p, q) + 1e-6) << kind.name;
    }
  }
}

TEST(Implicit, GradientOnTheSurfaceHasLengthOne) {
  Points points(6);
  for (const NamedShape& kind : every_kind()) {
    if (std::string_view(kind.name) == "group") continue;  // joins and cuts bend it
    int found = 0, unit = 0;
    for (int n = 0; n < 200000 && found < 300; ++n) {
      const Vec3 p = points.within(around);
      if (std::abs(kind.shape->distance(p)) > 0.05) continue;
      ++found;
      Vec3 g;
      for (int a = 0; a < 3; ++a) {
        Vec3 step;
        step[a] = 1e-5;
        g[a] = (kind.shape->distance(p + step) - kind.shape->distance(p - step)) / 2e-5;
      }
      unit += std::abs(length(g) - 1) < 0.12;  // a wall's slope counts in its height
    }
    EXPECT_GT(found, 20) << kind.name;
    EXPECT_GE(unit, found * 98 / 100) << kind.name;
  }
}

TEST(Implicit, BoundingBallsHoldTheShapes) {
  Points points(7);
  for (const NamedShape& kind : every_kind()) {
    const Knot ball = kind.shape->bound();
    for (int n = 0; n < 4000; ++n) {
      const Vec3 p = points.within({around.lower * 3, around.upper * 3});
      ASSERT_GE(kind.shape->distance(p), distance(p, ball.point) - ball.radius - 1e-9) << kind.name;
    }
  }
}

TEST(Implicit, SmoothMinimumIsBelowTheMinimumByAtMostASixthOfTheBlend) {
  for (double a = -3; a <= 3; a += 0.1) {
    const double value = smooth_min(a, 0.5, 2);
    EXPECT_LE(value, std::min(a, 0.5));
    EXPECT_GE(value, std::min(a, 0.5) - 2.0 / 6 - 1e-12);
    EXPECT_NEAR(smooth_max(-a, -0.5, 2), -value, 1e-15);
    if (std::abs(a - 0.5) > 2) {
      EXPECT_EQ(value, std::min(a, 0.5));
    }
    const double h = 1e-5;
    const double slope = (smooth_min(a + h, 0.5, 2) - smooth_min(a - h, 0.5, 2)) / (2 * h);
    const double later = (smooth_min(a + 2 * h, 0.5, 2) - smooth_min(a, 0.5, 2)) / (2 * h);
    EXPECT_NEAR(slope, later, 1e-4);  // no jump in the slope
  }
}

TEST(Implicit, CutRemovesAndKeepLeavesOnlyTheCommonPart) {
  Field cut, keep;
  const ShapePtr big = ellipsoid({0, 0, 0}, {10, 10, 10}), small = ellipsoid({8, 0, 0}, {5, 5, 5});
  cut.join(big).cut(small);
  keep.join(big).keep(small);
  EXPECT_LT(cut.value({0, 0, 0}), 0);
  EXPECT_GT(cut.value({8, 0, 0}), 0);
  EXPECT_GT(keep.value({0, 0, 0}), 0);
  EXPECT_LT(keep.value({8, 0, 0}), 0);
}

TEST(Implicit, SidesMirrorAShape) {
  Field field;
  field.join(ellipsoid({20, 0, 0}, {5, 6, 7}), 0, Side::sharp);
  EXPECT_EQ(field.value({20, 1, 2}), field.value({-20, 1, 2}));
  EXPECT_LT(field.value({-20, 0, 0}), 0);
}

// Everything that makes the head quick rests on this: leaving out what cannot matter changes no bit.
TEST(Implicit, FieldsIndexedByCellsGiveTheSameBitsAsWholeOnes) {
  const phantom::Fit fit;
  const std::vector<std::pair<const char*, Field>> fields{{"skin", phantom::skin()},
                                                          {"skull", phantom::skull_bone(fit)},
                                                          {"mandible", phantom::mandible_bone(fit)},
                                                          {"teeth", phantom::upper_teeth(fit)},
                                                          {"air", phantom::air_spaces()},
                                                          {"muscles", phantom::muscles()}};
  for (const auto& [name, field] : fields) {
    const IndexedField indexed(field, head, 8);
    Points points(11);
    for (int n = 0; n < 20000; ++n) {
      const Vec3 p = points.within({head.lower - Vec3{9, 9, 9}, head.upper + Vec3{9, 9, 9}});
      ASSERT_EQ(indexed.value(p), field.value(p)) << name << " at " << p.x << " " << p.y << " " << p.z;
    }
  }
}

TEST(Implicit, ShortenedFieldsGiveTheSameBitsInTheirBall) {
  const Field field = phantom::skull_bone({});
  Points points(12);
  std::size_t steps = 0;
  for (int n = 0; n < 300; ++n) {
    const Vec3 centre = points.within(head);
    const Field part = field.shortened(centre, 3);
    steps += part.size();
    for (int i = 0; i < 20; ++i) {
      const Vec3 p = centre + points.within({{-1.7, -1.7, -1.7}, {1.7, 1.7, 1.7}});
      ASSERT_EQ(part.value(p), field.value(p));
    }
  }
  EXPECT_LT(steps, 300 * field.size() / 4);
}

}  // namespace
}  // namespace turgor::implicit
