#include "turgor/world/object.hpp"

#include <gtest/gtest.h>

#include <limits>
#include <map>
#include <numbers>
#include <set>

#include "turgor/core/random.hpp"
#include "turgor/world/object_file.hpp"

namespace turgor {
namespace {

constexpr double kInf = std::numeric_limits<double>::infinity();

Object primitive(const std::string& name) {
  auto object = make_primitive(name);
  EXPECT_TRUE(static_cast<bool>(object)) << name << ": " << (object ? "" : object.error().message());
  return object ? *std::move(object) : Object{};
}
const Polyhedron& polyhedron(const Object& object) {
  return std::get<Polyhedron>(object.description);
}
void expect_near(const Vec3& a, const Vec3& b, double tolerance = 1e-12) {
  EXPECT_LE(distance(a, b), tolerance)
      << a.x << ' ' << a.y << ' ' << a.z << " is not " << b.x << ' ' << b.y << ' ' << b.z;
}

ObjectTransform wild_transform(std::uint64_t seed) {
  const RandomStream random(seed);
  ObjectTransform t;
  for (std::uint64_t k = 0; k < 9; ++k) t.linear.c[k / 3][static_cast<int>(k % 3)] = random.normal(k);
  for (std::uint64_t k = 0; k < 3; ++k) {
    t.translation[static_cast<int>(k)] = random.normal(10 + k);
    t.origin[static_cast<int>(k)] = random.normal(20 + k);
  }
  return t;
}

/// Volume of a closed polyhedron, positive where its polygons face outwards.
double volume(const Polyhedron& p) {
  double sum = 0;
  for (int i = 0; i < p.polygon_count(); ++i) {
    const auto corners = p.polygon(i);
    for (std::size_t k = 2; k < corners.size(); ++k)
      sum += dot(p.points[corners[0]], cross(p.points[corners[k - 1]], p.points[corners[k]])) / 6;
  }
  return sum;
}

/// The loops of directed edges that have no opposite: the rim of the surface, holes included.
std::vector<std::vector<int>> rims(const Polyhedron& p) {
  std::set<std::pair<int, int>> directed;
  for (int i = 0; i < p.polygon_count(); ++i) {
    const auto corners = p.polygon(i);
    for (std::size_t k = 0; k < corners.size(); ++k)
      EXPECT_TRUE(directed.emplace(corners[k], corners[(k + 1) % corners.size()]).second);
  }
  std::map<int, int> next;
  for (const auto& [a, b] : directed) {
    if (!directed.contains({b, a})) EXPECT_TRUE(next.emplace(a, b).second) << "two rims meet at " << a;
  }
  std::vector<std::vector<int>> loops;
  while (!next.empty()) {
    std::vector<int>& loop = loops.emplace_back();
    for (int at = next.begin()->first; next.contains(at);) {
      loop.push_back(at);
      const int to = next[at];
      next.erase(at);
      at = to;
    }
  }
  return loops;
}

TEST(Object, TransformTurnsAboutItsOwnOriginWhichTheTranslationCarries) {
  const ObjectTransform t{rotation_xyz({0, 0, 90}), {10, 0, 0}, {1, 2, 3}};
  expect_near(t.point({1, 2, 3}), {11, 2, 3});
  expect_near(t.point({2, 2, 3}), {11, 3, 3});
  expect_near(t.direction({1, 0, 0}), {0, 1, 0});
}

TEST(Object, RotationsFollowOneAnotherAboutXThenYThenZ) {
  const Vec3 p{0.3, -1.2, 2.5};
  const Vec3 step = rotation({0, 0, 1}, 0.9) * (rotation({0, 1, 0}, -0.4) * (rotation({1, 0, 0}, 1.3) * p));
  expect_near(rotation_xyz({degrees(1.3), degrees(-0.4), degrees(0.9)}) * p, step);
  // The sheet of the muscle test: about y by 10 degrees, its right side sinks.
  EXPECT_LT((rotation_xyz({0, 10, 0}) * Vec3{1, 0, 0}).z, 0);
}

TEST(Object, BoxSphereAndOrientationAreThoseOfTheWorld) {
  Object cube = primitive("cube");
  cube.transform = {Mat3{{Vec3{2, 0, 0}, {0, 0, 3}, {0, -4, 0}}}, {1, 1, 1}, {0, 0, 0}};
  const Box3 box = world_box(cube);
  expect_near(box.lower, {0, -1, -0.5});
  expect_near(box.upper, {2, 3, 2.5});
  const BoundingSphere sphere = world_sphere(cube);
  expect_near(sphere.centre, {1, 1, 1});
  EXPECT_NEAR(sphere.radius, length(Vec3{1, 2, 1.5}), 1e-12);
  const Orientation turned = orientation(cube);
  expect_near(turned.normal, {0, -1, 0});
  expect_near(turned.up, {0, 0, 1});

  Object flat = primitive("grid.2.2");
  flat.transform.linear.c[2] = {};
  EXPECT_EQ(orientation(flat).normal, (Vec3{}));
  flat.transform.linear.c[2] = {0, 0, 1e300};
  EXPECT_EQ(orientation(flat).normal, (Vec3{0, 0, 1}));
  flat.transform.linear.c[2] = {0, 5e-324, 0};
  EXPECT_EQ(orientation(flat).normal, (Vec3{0, 1, 0}));
}

TEST(Object, CamerasAndLightsAreTheirPoint) {
  Object camera;
  camera.description = CameraLens{};
  camera.transform.translation = {1, 2, 3};
  EXPECT_EQ(world_box(camera).lower, (Vec3{1, 2, 3}));
  EXPECT_EQ(world_box(camera).upper, (Vec3{1, 2, 3}));
  EXPECT_EQ(world_sphere(camera).radius, 0);
  EXPECT_EQ(world_polyhedron(camera).polygon_count(), 0);
  EXPECT_EQ(name_of(camera.kind()), "camera");
  Object light;
  light.description = Light{};
  EXPECT_EQ(name_of(light.kind()), "light");
  EXPECT_TRUE(static_cast<bool>(harden(camera)));
  EXPECT_EQ(camera.transform.translation, (Vec3{1, 2, 3}));
  Object nothing;
  nothing.transform.translation = {4, 5, 6};
  EXPECT_TRUE(world_box(nothing).empty());
  EXPECT_EQ(world_sphere(nothing).centre, (Vec3{4, 5, 6}));
}

TEST(Object, MirroredPolygonsStillFaceOutwards) {
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    Object cube = primitive("cube");
    cube.transform = wild_transform(seed);
    EXPECT_NEAR(volume(world_polyhedron(cube)), std::abs(cube.transform.linear.determinant()), 1e-9);
  }
}

TEST(Object, HardeningKeepsTheWorldAndTheLocalOrigin) {
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    Object ball = primitive("sphere");
    ball.transform = wild_transform(seed);
    const Polyhedron before = world_polyhedron(ball);
    const Vec3 origin = ball.transform.point(ball.transform.origin);
    ASSERT_TRUE(static_cast<bool>(harden(ball)));
    EXPECT_EQ(ball.transform.linear.c, Mat3{}.c);
    EXPECT_EQ(ball.transform.translation, (Vec3{}));
    expect_near(ball.transform.origin, origin);
    EXPECT_EQ(polyhedron(ball).points, before.points);
    EXPECT_EQ(polyhedron(ball).corners, before.corners);
    const Polyhedron after = world_polyhedron(ball);
    for (std::size_t i = 0; i < before.points.size(); ++i) expect_near(after.points[i], before.points[i]);
  }
  Object huge = primitive("cube");
  for (Vec3& c : huge.transform.linear.c) c *= 1e308;
  huge.transform.linear = huge.transform.linear * Mat3{{Vec3{100, 0, 0}, {0, 1, 0}, {0, 0, 1}}};
  const Object as_it_was = huge;
  EXPECT_FALSE(static_cast<bool>(harden(huge)));
  EXPECT_TRUE(same_description(huge.description, as_it_was.description));
}

TEST(Object, DepthMapsAreGridsOfQuadrilaterals) {
  Object map;
  map.description = DepthMap{3, 2, {0, 1, 2, 3, 4, 5}};
  map.transform.linear = Mat3{{Vec3{0.5, 0, 0}, {0, 0.5, 0}, {0, 0, 0.1}}};
  const Polyhedron grid = world_polyhedron(map);
  EXPECT_EQ(grid.polygon_count(), 2);
  expect_near(grid.points[5], {1, 0.5, 0.5});
  for (const Vec3& n : vertex_normals(grid)) EXPECT_GT(n.z, 0);
  ASSERT_TRUE(static_cast<bool>(harden(map)));
  EXPECT_EQ(map.kind(), ObjectKind::polyhedron);
  EXPECT_EQ(polyhedron(map).points, grid.points);
}

TEST(Object, ValuesOutOfRangeAreRefused) {
  const auto refused = [](auto change) {
    Object object = primitive("cube");
    change(object);
    return !validate(object);
  };
  EXPECT_FALSE(refused([](Object&) {}));
  EXPECT_TRUE(refused([](Object& o) { o.transform.translation.y = NAN; }));
  EXPECT_TRUE(refused([](Object& o) { o.transform.linear.c[1].z = kInf; }));
  EXPECT_TRUE(refused([](Object& o) { o.optics.opacity = 1.1; }));
  EXPECT_TRUE(refused([](Object& o) { o.optics.opacity = NAN; }));
  EXPECT_TRUE(refused([](Object& o) { o.optics.specular = -1; }));
  EXPECT_TRUE(refused([](Object& o) { o.optics.diffuse.x = NAN; }));
  EXPECT_TRUE(refused([](Object& o) { o.optics.wire = Vec3f{0, -1, 0}; }));
  EXPECT_TRUE(refused([](Object& o) { o.description = CameraLens{-1}; }));
  EXPECT_TRUE(refused([](Object& o) { o.description = CameraLens{30, 0}; }));
  EXPECT_TRUE(refused([](Object& o) { o.description = CameraLens{30, 1, NAN}; }));
  EXPECT_TRUE(refused([](Object& o) { o.description = Light{{1, 1, 1}, NAN}; }));
  EXPECT_TRUE(refused([](Object& o) { o.description = DepthMap{2, 2, {0, 0, 0}}; }));
  EXPECT_TRUE(refused([](Object& o) { o.description = DepthMap{2, 2, {0, 0, 0, NAN}}; }));
  EXPECT_TRUE(refused([](Object& o) { o.description = DepthMap{-2, -2, {0, 0, 0, 0}}; }));
  EXPECT_TRUE(refused([](Object& o) { std::get<Polyhedron>(o.description).corners[3] = 8; }));
}

TEST(Primitive, GridsAreNumberedByRowAlongY) {
  const Object object = primitive("grid.10.10");
  const Polyhedron& grid = polyhedron(object);
  ASSERT_EQ(grid.points.size(), 100U);
  EXPECT_EQ(grid.polygon_count(), 81);
  expect_near(grid.points[0], {-0.5, -0.5, 0});
  expect_near(grid.points[83], {3 / 9.0 - 0.5, 8 / 9.0 - 0.5, 0});
  for (const Vec3& n : vertex_normals(grid)) expect_near(n, {0, 0, 1});
  EXPECT_EQ(edges(grid).size(), 2U * 9 * 10);
  const Object wide = primitive("grid.3.2");
  expect_near(polyhedron(wide).points[2], {0.5, -0.5, 0});

  const Object wire = primitive("wiregrid.5.5");
  EXPECT_EQ(polyhedron(wire).polygon_count(), 0);
  EXPECT_EQ(polyhedron(wire).lines.size(), 40U);
  EXPECT_EQ(polyhedron(wire).points, polyhedron(primitive("grid.5.5")).points);
}

TEST(Primitive, SphereCubeAndLineHaveTheirMeasures) {
  const Object ball = primitive("sphere");
  const BoundingSphere sphere = world_sphere(ball);
  expect_near(sphere.centre, {});
  EXPECT_NEAR(sphere.radius, 0.5, 1e-12);
  EXPECT_NEAR(volume(polyhedron(ball)), std::numbers::pi / 6, 0.01);
  EXPECT_GE(polyhedron(ball).polygon_count(), 500);
  EXPECT_LE(polyhedron(ball).polygon_count(), 1000);
  EXPECT_TRUE(rims(polyhedron(ball)).empty());
  for (const Vec3& p : polyhedron(ball).points) EXPECT_NEAR(length(p), 0.5, 1e-12);
  EXPECT_NEAR(volume(polyhedron(primitive("cube"))), 1, 1e-12);
  EXPECT_TRUE(rims(polyhedron(primitive("cube"))).empty());
  const Object line = primitive("line");
  EXPECT_EQ(polyhedron(line).lines, (std::vector<Edge>{{0, 1}}));
  EXPECT_EQ(world_box(line).size(), (Vec3{1, 0, 0}));
}

// Pieper 1989, section 6.1.1: 174 points, sutured 70-71, 81-82, 91-92 and 102-103 across the wound.
TEST(Primitive, FusiformIsTheSheetOfTheWoundClosure) {
  const Object object = primitive("fusiform");
  const Polyhedron& sheet = polyhedron(object);
  ASSERT_EQ(sheet.points.size(), 174U);
  EXPECT_EQ(world_box(object).lower, (Vec3{-0.5, -0.5, 0}));
  EXPECT_EQ(world_box(object).upper, (Vec3{0.5, 0.5, 0}));
  const auto loops = rims(sheet);
  ASSERT_EQ(loops.size(), 2U) << "the outer rim and one hole";
  const auto& smaller = loops[0].size() < loops[1].size() ? loops[0] : loops[1];
  const std::set<int> hole(smaller.begin(), smaller.end());
  const int lower_tip = 4 * 13 + 6, upper_tip = 109 + 6;
  EXPECT_EQ(hole, (std::set<int>{70, 71, 81, 82, 91, 92, 102, 103, lower_tip, upper_tip}));
  expect_near(sheet.points[lower_tip], {0, 4 / 13.0 - 0.5, 0});
  expect_near(sheet.points[upper_tip], {0, 9 / 13.0 - 0.5, 0});
  // Each pair faces one another across the axis of the spindle, 2, 4, 4 and 2 columns apart.
  for (const auto& [left, right, columns] :
       {std::tuple{70, 71, 2}, {81, 82, 4}, {91, 92, 4}, {102, 103, 2}}) {
    EXPECT_NEAR(sheet.points[left].x, -sheet.points[right].x, 1e-15);
    EXPECT_NEAR(sheet.points[left].y, sheet.points[right].y, 1e-15);
    EXPECT_NEAR(distance(sheet.points[left], sheet.points[right]), columns / 12.0, 1e-12);
  }
  std::set<int> used(sheet.corners.begin(), sheet.corners.end());
  EXPECT_EQ(used.size(), 174U);
}

TEST(Primitive, WrongNamesAreRefusedWithTheNearestOne) {
  for (const char* name :
       {"grid", "grid.", "grid.5", "grid.5.", "grid.1.5", "grid.5.1", "grid.-5.5", "grid.5.5.5", "grid.5.5x",
        "grid.nan.5", "grid. 5.5", "wiregrid.0.0", "", "Cube", "sphere.1"}) {
    const auto object = make_primitive(name);
    ASSERT_FALSE(static_cast<bool>(object)) << name;
    EXPECT_EQ(object.error().kind, ErrorKind::bad_input) << name;
  }
  for (const char* name : {"grid.2001.2000", "grid.99999999999999999999.2", "wiregrid.2.4000000"}) {
    const auto object = make_primitive(name);
    ASSERT_FALSE(static_cast<bool>(object)) << name;
    EXPECT_NE(object.error().message().find("4 million"), std::string::npos) << object.error().message();
  }
  EXPECT_NE(make_primitive("fusifrom").error().message().find("fusiform"), std::string::npos);
  EXPECT_NE(make_primitive("gird.5.5").error().message().find("grid.N.M"), std::string::npos);
  for (const std::string& name : primitive_names()) EXPECT_FALSE(name.empty());
}

}  // namespace
}  // namespace turgor
