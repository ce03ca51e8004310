#include "turgor/world/object_constraints.hpp"

#include <gtest/gtest.h>

#include <limits>

#include "turgor/core/random.hpp"
#include "turgor/world/object_file.hpp"

namespace turgor {
namespace {

constexpr double kInf = std::numeric_limits<double>::infinity();

int add(Scene& scene, const std::string& name, const std::string& primitive, const Vec3& place = {}) {
  Object object = *make_primitive(primitive);
  object.name = name;
  object.transform.translation = place;
  const auto id = scene.add_object(std::move(object));
  EXPECT_TRUE(static_cast<bool>(id));
  return *id;
}
int add_points(Scene& scene, const std::string& name, std::vector<Vec3> points) {
  Object object;
  object.name = name;
  Polyhedron polyhedron;
  polyhedron.points = std::move(points);
  object.description = std::move(polyhedron);
  const auto id = scene.add_object(std::move(object));
  EXPECT_TRUE(static_cast<bool>(id));
  return *id;
}
void place(Scene& scene, int id, const Vec3& translation) {
  ObjectTransform t = scene.find(id)->transform;
  t.translation = translation;
  scene.set_transform(id, t);
}
Vec3 centre(const Scene& scene, int id) {
  return world_box(*scene.find(id)).centre();
}
template <class T>
T ok(Result<T> result) {
  EXPECT_TRUE(static_cast<bool>(result)) << (result ? "" : result.error().message());
  return result ? *std::move(result) : T{};
}
void expect_near(const Vec3& a, const Vec3& b, double tolerance = 1e-12) {
  EXPECT_LE(distance(a, b), tolerance)
      << a.x << ' ' << a.y << ' ' << a.z << " is not " << b.x << ' ' << b.y << ' ' << b.z;
}
/// One frame in which `commands` are given.
template <class Commands>
void frame(Scene& scene, Commands&& commands) {
  scene.begin_frame();
  commands();
  scene.serve_constraints();
  scene.end_frame();
}
void frame(Scene& scene) {
  frame(scene, [] {});
}

// --- look_at ---

TEST(LookAt, TheTargetIsStraightAheadAndUpIsUp) {
  for (std::uint64_t seed = 0; seed < 50; ++seed) {
    const RandomStream random(seed);
    const auto vec = [&](std::uint64_t k) {
      return Vec3{random.normal(k), random.normal(k + 1), random.normal(k + 2)};
    };
    const Vec3 eye = vec(0), target = vec(3), up = vec(6);
    const ObjectTransform t = ok(look_at(eye, target, up));
    EXPECT_EQ(t.point({}), eye);
    expect_near(t.direction({0, 0, -1}), normalized(target - eye));
    EXPECT_NEAR(t.linear.determinant(), 1, 1e-12);
    expect_near((t.linear * t.linear.transposed()).c[1], {0, 1, 0});
    EXPECT_NEAR(dot(t.direction({1, 0, 0}), normalized(up)), 0, 1e-12);
    EXPECT_GT(dot(t.direction({0, 1, 0}), up), 0);
  }
}

TEST(LookAt, WildPointsGiveAFrameOrAnError) {
  for (const Vec3& eye :
       {Vec3{1e308, -1e308, 1e308}, Vec3{0, 0, 5}, Vec3{5e-324, 0, 0}, Vec3{1e-200, 1e-200, 0}}) {
    for (const Vec3& target : {Vec3{-1e308, 1e308, -1e308}, Vec3{0, 0, 0}}) {
      for (const Vec3& up : {Vec3{0, 0, 1}, Vec3{}, Vec3{1e308, 1e308, 1e308}, Vec3{1e-320, 0, 0}}) {
        const auto t = look_at(eye, target, up);
        if (eye.x == 5e-324 && target == Vec3{}) continue;  // half of it is nothing
        ASSERT_TRUE(static_cast<bool>(t)) << eye.x << ' ' << target.x << ' ' << up.x;
        EXPECT_NEAR(t->linear.determinant(), 1, 1e-9);
      }
    }
  }
  EXPECT_FALSE(static_cast<bool>(look_at({1, 2, 3}, {1, 2, 3}, {0, 0, 1})));
  EXPECT_FALSE(static_cast<bool>(look_at({NAN, 2, 3}, {1, 2, 3}, {0, 0, 1})));
  EXPECT_FALSE(static_cast<bool>(look_at({1, 2, 3}, {kInf, 2, 3}, {0, 0, 1})));
  EXPECT_FALSE(static_cast<bool>(look_at({1, 2, 3}, {0, 0, 0}, {0, NAN, 1})));
}

// --- links ---

TEST(LinkConstraint, ReachesFromCentreToCentre) {
  Scene scene;
  const int a = add(scene, "a", "cube", {1, 0, 0}), b = add(scene, "b", "sphere", {0, 2, 1});
  const int link = add(scene, "rubber", "line");
  EXPECT_EQ(ok(add_link(scene, "rubber", "a", "b", false)), "link.1");
  const auto ends = [&] { return world_polyhedron(*scene.find(link)).points; };
  expect_near(ends()[0], {1, 0, 0});
  expect_near(ends()[1], {0, 2, 1});
  const RandomStream random(3);
  for (std::uint64_t k = 0; k < 20; ++k) {
    frame(scene, [&] {
      place(scene, a, Vec3{random.normal(3 * k), random.normal(3 * k + 1), random.normal(3 * k + 2)});
    });
    expect_near(ends()[0], centre(scene, a));
    expect_near(ends()[1], centre(scene, b));
  }
  // Straight up, where no side is next.
  frame(scene, [&] { place(scene, a, {0, 2, -4}); });
  expect_near(ends()[0], {0, 2, -4});
  expect_near(ends()[1], {0, 2, 1});
  EXPECT_TRUE(scene.constraints.report().failures.empty());
}

TEST(LinkConstraint, KeepsItsWidthOrItsVolume) {
  for (const bool keep_volume : {false, true}) {
    Scene scene;
    add(scene, "a", "cube", {0, 0, 0});
    const int b = add(scene, "b", "cube", {2, 0, 0});
    Object rod = *make_primitive("cube");
    rod.name = "rod";
    rod.transform.linear = Mat3{{Vec3{2, 0, 0}, {0, 0.1, 0}, {0, 0, 0.3}}};
    rod.transform.origin = {0.2, -0.3, 0.1};
    const int id = *scene.add_object(rod);
    ok(add_link(scene, "rod", "a", "b", keep_volume));
    EXPECT_NEAR(scene.find(id)->transform.linear.determinant(), 0.06, 1e-12);
    frame(scene, [&] { place(scene, b, {0, 8, 0}); });
    const auto& columns = scene.find(id)->transform.linear.c;
    EXPECT_NEAR(length(columns[0]), 8, 1e-12);
    EXPECT_NEAR(length(columns[1]), keep_volume ? 0.05 : 0.1, 1e-12);
    EXPECT_NEAR(length(columns[2]), keep_volume ? 0.15 : 0.3, 1e-12);
    expect_near(centre(scene, id), {0, 4, 0});
    // No length at all: a flat thing, but a finite one.
    frame(scene, [&] { place(scene, b, {0, 0, 0}); });
    EXPECT_TRUE(scene.constraints.report().failures.empty());
    EXPECT_LE(length(world_box(*scene.find(id)).size()), 1);
    frame(scene, [&] { place(scene, b, {0, 1e308, 0}); });
    EXPECT_TRUE(static_cast<bool>(validate(*scene.find(id))));
  }
}

TEST(LinkConstraint, WhatCannotLinkIsRefused) {
  Scene scene;
  add(scene, "a", "cube");
  add(scene, "b", "cube", {1, 0, 0});
  const int line = add(scene, "line", "line");
  add_points(scene, "point", {{0, 0, 0}});
  EXPECT_FALSE(static_cast<bool>(add_link(scene, "a", "a", "b", false)));
  EXPECT_FALSE(static_cast<bool>(add_link(scene, "line", "a", "a", false)));
  EXPECT_FALSE(static_cast<bool>(add_link(scene, "point", "a", "b", false)));
  EXPECT_FALSE(static_cast<bool>(add_link(scene, "none", "a", "b", false)));
  EXPECT_TRUE(scene.constraints.constraints().empty());
  ok(add_link(scene, "line", "a", "b", false));
  EXPECT_GT(line, 0);
  scene.remove_object("line");
  EXPECT_TRUE(scene.constraints.constraints().empty()) << "a link goes with the object that it stretches";
}

// --- hierarchies ---

TEST(ParentConstraint, AHierarchyOfAnyDepthMovesInOneFrame) {
  Scene scene;
  constexpr int depth = 30;
  std::vector<int> ids;
  // Made from the tip to the root, so that no order of creation helps.
  for (int i = 0; i < depth; ++i)
    ids.push_back(add(scene, "part" + std::to_string(i), "cube", {1.0 * i, 0, 0}));
  for (int i = depth - 1; i > 0; --i)
    ok(add_parent(scene, "part" + std::to_string(i), "part" + std::to_string(i - 1)));
  ObjectTransform turned = scene.find(ids[0])->transform;
  turned.linear = rotation_xyz({0, 0, 90});
  turned.translation = {0, 0, 5};
  frame(scene, [&] { scene.set_transform(ids[0], turned); });
  for (int i = 0; i < depth; ++i) expect_near(centre(scene, ids[i]), {0, 1.0 * i, 5}, 1e-12);
  EXPECT_EQ(scene.constraints.report().served, depth - 1);
  EXPECT_TRUE(scene.constraints.report().loops.empty());
  // A joint in the middle bends: what hangs on it follows, what it hangs on stays.
  ObjectTransform bent = scene.find(ids[10])->transform;
  bent.linear = rotation_xyz({0, 0, 180});
  frame(scene, [&] { scene.set_transform(ids[10], bent); });
  expect_near(centre(scene, ids[9]), {0, 9, 5});
  expect_near(centre(scene, ids[12]), {-2, 10, 5});
  // And the bend is kept when the root moves.
  turned.translation = {0, 0, 0};
  frame(scene, [&] { scene.set_transform(ids[0], turned); });
  expect_near(centre(scene, ids[12]), {-2, 10, 0}, 1e-11);
}

TEST(ParentConstraint, KeepsThePlaceInTheParentsFrameAndNeverDrifts) {
  Scene scene;
  const int parent = add(scene, "parent", "cube"), child = add(scene, "child", "cube", {1, 2, 3});
  ObjectTransform own{
      rotation_xyz({10, 20, 30}) * Mat3{{Vec3{1, 0, 0}, {0, 2, 0}, {0, 0, 0.5}}}, {1, 2, 3}, {0.1, 0.2, 0.3}};
  scene.set_transform(child, own);
  ok(add_parent(scene, "child", "parent"));
  EXPECT_EQ(scene.find(child)->transform, own) << "nothing has moved yet";
  const Vec3 p{0.3, 0.4, 0.5}, at_first = own.point(p);
  for (int i = 1; i <= 2000; ++i) {
    ObjectTransform t;
    t.linear = rotation_xyz({0.37 * i, 0.11 * i, 1.7 * i});
    t.translation = {0.01 * i, -0.02 * i, 0};
    t.origin = {1, 1, 1};
    frame(scene, [&] { scene.set_transform(parent, t); });
    expect_near(scene.find(child)->transform.point(p), t.point(at_first), 1e-11);
    EXPECT_EQ(scene.find(child)->transform.origin, own.origin);
  }
}

TEST(ParentConstraint, HardeningMovesNobody) {
  Scene scene;
  const int parent = add(scene, "parent", "cube"), child = add(scene, "child", "cube", {1, 0, 0});
  ok(add_parent(scene, "child", "parent"));
  ObjectTransform t;
  t.linear = rotation_xyz({0, 0, 90});
  frame(scene, [&] { scene.set_transform(parent, t); });
  expect_near(centre(scene, child), {0, 1, 0});
  frame(scene, [&] { ok(scene.harden(parent) ? Result<bool>(true) : Result<bool>(false)); });
  expect_near(centre(scene, child), {0, 1, 0});
  frame(scene, [&] { EXPECT_TRUE(static_cast<bool>(scene.harden(child))); });
  t.linear = rotation_xyz({0, 0, 45});
  frame(scene, [&] { scene.set_transform(parent, t); });
  expect_near(centre(scene, child), {-std::sqrt(0.5), std::sqrt(0.5), 0});
}

TEST(ParentConstraint, ALoopEndsAndIsReported) {
  Scene scene;
  const int a = add(scene, "a", "cube"), b = add(scene, "b", "cube", {1, 0, 0});
  add(scene, "c", "cube", {2, 0, 0});
  ok(add_parent(scene, "b", "a"));
  ok(add_parent(scene, "c", "b"));
  ok(add_parent(scene, "a", "c"));
  frame(scene, [&] { place(scene, a, {0, 1, 0}); });
  EXPECT_EQ(scene.constraints.report().served, 3);
  EXPECT_EQ(scene.constraints.report().loops,
            (std::vector<std::string>{"parent.1 → parent.2 → parent.3 → parent.1"}));
  expect_near(centre(scene, b), {1, 1, 0});
  for (int i = 0; i < 5; ++i) {
    frame(scene);
    EXPECT_EQ(scene.constraints.report().served, 0);
  }
}

TEST(ParentConstraint, FlatParentsAndOneselfAreRefused) {
  Scene scene;
  const int parent = add(scene, "parent", "cube"), child = add(scene, "child", "cube", {1, 2, 3});
  EXPECT_FALSE(static_cast<bool>(add_parent(scene, "child", "child")));
  EXPECT_FALSE(static_cast<bool>(add_parent(scene, "child", "nobody")));
  ObjectTransform flat;
  flat.linear.c[2] = {};
  scene.set_transform(parent, flat);
  EXPECT_FALSE(static_cast<bool>(add_parent(scene, "child", "parent")));
  // One that is flattened later takes its child along, and gives it back.
  scene.set_transform(parent, {});
  ok(add_parent(scene, "child", "parent"));
  frame(scene, [&] { scene.set_transform(parent, flat); });
  expect_near(centre(scene, child), {1, 2, 0});
  frame(scene, [&] { scene.set_transform(parent, {}); });
  expect_near(centre(scene, child), {1, 2, 3});
  // Beyond all numbers: an error, and everybody stays.
  ObjectTransform huge;
  for (Vec3& c : huge.linear.c) c *= 1.7e308;
  frame(scene, [&] { scene.set_transform(parent, huge); });
  EXPECT_EQ(scene.constraints.report().failures.size(), 1U);
  expect_near(centre(scene, child), {1, 2, 3});
}

// --- stand-ins ---

TEST(StandIn, IsTheWorldsBoxOfWhatItHides) {
  Scene scene;
  scene.worlds.push_back({"other", {}});
  const int ball = add(scene, "ball", "sphere");
  scene.find_world("other")->objects.push_back("ball");
  EXPECT_EQ(ok(add_stand_in(scene, "ball")), "stand_in.1");
  const int box = scene.id_of("box.ball");
  ASSERT_GT(box, 0);
  EXPECT_FALSE(scene.find(ball)->visible);
  EXPECT_TRUE(scene.find(box)->visible);
  EXPECT_EQ(scene.find_world("other")->objects, (std::vector<std::string>{"ball", "box.ball"}));
  EXPECT_EQ(scene.find_world("main")->objects, (std::vector<std::string>{"camera", "ball", "box.ball"}));
  ObjectTransform t;
  t.linear = Mat3{{Vec3{2, 0, 0}, {0, 3, 0}, {0, 0, 4}}};
  t.translation = {1, 1, 1};
  frame(scene, [&] { scene.set_transform(ball, t); });
  const Box3 shown = world_box(*scene.find(box));
  expect_near(shown.lower, {0, -0.5, -1});
  expect_near(shown.upper, {2, 2.5, 3});
  EXPECT_FALSE(static_cast<bool>(add_stand_in(scene, "ball"))) << "the name box.ball is taken";
  add_points(scene, "nothing", {});
  EXPECT_FALSE(static_cast<bool>(add_stand_in(scene, "nothing")));
  EXPECT_TRUE(scene.find("nothing")->visible);
  scene.remove_object("box.ball");
  frame(scene, [&] { place(scene, ball, {5, 5, 5}); });
  EXPECT_TRUE(scene.constraints.report().failures.empty());
}

// --- paths ---

TEST(Path, RunsAtConstantSpeedAlongTheArc) {
  Scene scene;
  const int ball = add(scene, "ball", "sphere", {9, 9, 9});
  // Legs of 1, 3 and 4, and a point that is there twice.
  add_points(scene, "path", {{0, 0, 0}, {1, 0, 0}, {1, 0, 0}, {1, 3, 0}, {1, 3, 4}});
  for (int i = 0; i < 5; ++i) frame(scene);
  EXPECT_EQ(ok(add_object_path(scene, "ball", "path", {16, false})), "mv_obj_path.1");
  expect_near(centre(scene, ball), {0, 0, 0});
  std::vector<Vec3> track{centre(scene, ball)};
  for (int i = 0; i < 20; ++i) {
    frame(scene);
    track.push_back(centre(scene, ball));
  }
  expect_near(track[2], {1, 0, 0});
  expect_near(track[5], {1, 1.5, 0});
  expect_near(track[8], {1, 3, 0});
  expect_near(track[12], {1, 3, 2});
  for (std::size_t i = 16; i <= 20; ++i) expect_near(track[i], {1, 3, 4});
  for (std::size_t i = 1; i <= 16; ++i) EXPECT_NEAR(distance(track[i], track[i - 1]), 0.5, 1e-12);
}

TEST(Path, LoopsStartAgainAndFollowAPathThatMoves) {
  Scene scene;
  const int ball = add(scene, "ball", "sphere");
  const int path = add_points(scene, "path", {{0, 0, 0}, {4, 0, 0}});
  ok(add_object_path(scene, "ball", "path", {4, true}));
  for (int i = 1; i <= 10; ++i) {
    frame(scene);
    expect_near(centre(scene, ball), {1.0 * (i % 4), 0, 0});
  }
  place(scene, path, {0, 7, 0});
  frame(scene);
  expect_near(centre(scene, ball), {3, 7, 0});
}

TEST(Path, DegenerateOnesStayOrAreRefused) {
  Scene scene;
  const int ball = add(scene, "ball", "sphere");
  add_points(scene, "none", {});
  add_points(scene, "single", {{1, 2, 3}});
  add_points(scene, "same", {{3, 2, 1}, {3, 2, 1}, {3, 2, 1}});
  add_points(scene, "far", {{-1e308, 0, 0}, {1e308, 0, 0}});
  EXPECT_FALSE(static_cast<bool>(add_object_path(scene, "ball", "none", {})));
  EXPECT_FALSE(static_cast<bool>(add_object_path(scene, "ball", "far", {})));
  EXPECT_FALSE(static_cast<bool>(add_object_path(scene, "ball", "camera2", {})));
  EXPECT_FALSE(static_cast<bool>(add_object_path(scene, "ball", "ball", {})));
  EXPECT_FALSE(static_cast<bool>(add_object_path(scene, "ball", "camera", {}))) << "a camera has no polyline";
  EXPECT_FALSE(static_cast<bool>(add_object_path(scene, "ball", "single", {0, false})));
  EXPECT_FALSE(static_cast<bool>(add_object_path(scene, "ball", "single", {-3, true})));
  const auto single = ok(add_object_path(scene, "ball", "single", {10, true}));
  for (int i = 0; i < 3; ++i) frame(scene);
  expect_near(centre(scene, ball), {1, 2, 3});
  scene.constraints.remove(single);
  ok(add_object_path(scene, "ball", "same", {10, false}));
  for (int i = 0; i < 30; ++i) frame(scene);
  expect_near(centre(scene, ball), {3, 2, 1});
  EXPECT_TRUE(scene.constraints.report().failures.empty());
}

TEST(Path, TheCamerasEyeRunsOnIt) {
  Scene scene;
  const int camera = scene.id_of("camera");
  ObjectTransform turned = scene.find(camera)->transform;
  turned.origin = {0.5, 0.25, -1};
  scene.set_transform(camera, turned);
  add_points(scene, "path", {{0, 0, 5}, {10, 0, 5}});
  EXPECT_EQ(ok(add_camera_path(scene, "main", "path", {10, false})), "mv_vp_path.1");
  for (int i = 1; i <= 12; ++i) {
    frame(scene);
    expect_near(scene.find(camera)->transform.point({}), {std::min(1.0 * i, 10.0), 0, 5});
  }
  EXPECT_EQ(scene.find(camera)->transform.linear.c, turned.linear.c);
  EXPECT_FALSE(static_cast<bool>(add_camera_path(scene, "side", "path", {})));
  scene.find_viewport("main")->camera = "path";
  frame(scene);
  EXPECT_EQ(scene.constraints.report().failures.size(), 1U) << "not a camera any more";
}

// --- tracking ---

struct Watched {
  Scene scene;
  int camera = scene.id_of("camera");
  int a = add(scene, "a", "sphere", {5, 0, 0}), b = add(scene, "b", "cube", {0, 5, 1});

  [[nodiscard]] Vec3 eye() const { return scene.find(camera)->transform.point({}); }
  [[nodiscard]] Vec3 forward() const { return scene.find(camera)->transform.direction({0, 0, -1}); }
};

TEST(Tracking, LookAtAloneTurnsTheCamera) {
  Watched w;
  const Vec3 eye = w.eye();
  EXPECT_EQ(ok(add_camera_tracking(w.scene, "main", "", "b")), "vp_track_obj.1");
  for (const Vec3& p : {Vec3{0, 5, 1}, {-3, 2, 2}, {0, 0, -9}}) {
    frame(w.scene, [&] { place(w.scene, w.b, p); });
    EXPECT_EQ(w.eye(), eye);
    expect_near(w.forward(), normalized(p - eye));
    EXPECT_NEAR(std::get<CameraLens>(w.scene.find(w.camera)->description).target_distance, distance(p, eye),
                1e-12);
  }
  // Whoever moves the camera: it turns by the end of the frame.
  add_points(w.scene, "path", {{-9, 9, 3}, {9, 9, 3}});
  ok(add_camera_path(w.scene, "main", "path", {5, false}));
  for (int i = 0; i < 8; ++i) {
    frame(w.scene);
    expect_near(w.forward(), normalized(centre(w.scene, w.b) - w.eye()));
    EXPECT_TRUE(w.scene.constraints.report().loops.empty());
  }
  expect_near(w.eye(), {9, 9, 3});
}

TEST(Tracking, EyeAloneLooksAlongItsOrientation) {
  Watched w;
  ok(add_camera_tracking(w.scene, "main", "a", ""));
  expect_near(w.eye(), {5, 0, 0});
  expect_near(w.forward(), {0, 0, 1});
  ObjectTransform t{rotation_xyz({90, 0, 0}), {1, 2, 3}, {}};
  frame(w.scene, [&] { w.scene.set_transform(w.a, t); });
  expect_near(w.eye(), {1, 2, 3});
  expect_near(w.forward(), {0, -1, 0});
  expect_near(w.scene.find(w.camera)->transform.direction({0, 1, 0}), {0, 0, 1});
  // Flat: the camera stays, and says why.
  t.linear.c[2] = {};
  frame(w.scene, [&] { w.scene.set_transform(w.a, t); });
  EXPECT_EQ(w.scene.constraints.report().failures.size(), 1U);
  expect_near(w.forward(), {0, -1, 0});
}

TEST(Tracking, BothGiveThePlaceAndTheDirection) {
  Watched w;
  ok(add_camera_tracking(w.scene, "main", "a", "b"));
  for (int i = 0; i < 5; ++i) {
    frame(w.scene, [&] {
      place(w.scene, w.a, {5, 1.0 * i, 0});
      place(w.scene, w.b, {0, 0, 1.0 * i});
    });
    expect_near(w.eye(), centre(w.scene, w.a));
    expect_near(w.forward(), normalized(centre(w.scene, w.b) - centre(w.scene, w.a)));
  }
  frame(w.scene, [&] { place(w.scene, w.b, centre(w.scene, w.a)); });
  EXPECT_EQ(w.scene.constraints.report().failures.size(), 1U);
  w.scene.remove_object("b");
  EXPECT_TRUE(w.scene.constraints.constraints().empty());
}

TEST(Tracking, WhatCannotBeTrackedIsRefused) {
  Watched w;
  EXPECT_FALSE(static_cast<bool>(add_camera_tracking(w.scene, "main", "", "")));
  EXPECT_FALSE(static_cast<bool>(add_camera_tracking(w.scene, "main", "nobody", "")));
  EXPECT_FALSE(static_cast<bool>(add_camera_tracking(w.scene, "side", "a", "b")));
  EXPECT_FALSE(static_cast<bool>(add_camera_tracking(w.scene, "main", "camera", "b")));
  EXPECT_FALSE(static_cast<bool>(add_camera_tracking(w.scene, "main", "", "camera")));
  EXPECT_FALSE(static_cast<bool>(add_camera_tracking(w.scene, "main", "a", "a")));
  EXPECT_TRUE(w.scene.constraints.constraints().empty());
}

// A link on a child of a moving thing, watched by a camera, in a box: one frame.
TEST(ObjectConstraints, WorkTogetherInOneFrame) {
  Scene scene;
  add(scene, "root", "cube");
  const int hand = add(scene, "hand", "cube", {2, 0, 0});
  add(scene, "wall", "cube", {0, 0, 10});
  const int rope = add(scene, "rope", "line");
  add_points(scene, "path", {{0, 0, 0}, {0, 8, 0}});
  ok(add_stand_in(scene, "rope"));
  ok(add_camera_tracking(scene, "main", "", "hand"));
  ok(add_link(scene, "rope", "hand", "wall", true));
  ok(add_parent(scene, "hand", "root"));
  ok(add_object_path(scene, "root", "path", {8, false}));
  for (int i = 1; i <= 8; ++i) {
    frame(scene);
    expect_near(centre(scene, hand), {2, 1.0 * i, 0});
    expect_near(world_polyhedron(*scene.find(rope)).points[0], {2, 1.0 * i, 0});
    expect_near(world_box(*scene.find("box.rope")).size(), world_box(*scene.find(rope)).size());
    const ObjectTransform& camera = scene.find("camera")->transform;
    expect_near(camera.direction({0, 0, -1}), normalized(Vec3{2, 1.0 * i, 0} - camera.translation));
    EXPECT_TRUE(scene.constraints.report().loops.empty());
    EXPECT_TRUE(scene.constraints.report().failures.empty());
  }
}

// Any constraints between any objects, moved to any numbers: every frame ends, and all stays finite.
TEST(ObjectConstraints, HoldOnWildNumbers) {
  constexpr double wild[] = {0, -0.0, 1, -1e-320, 5e-324, 1e-160, 1e160, -1.7e308, 1.7e308, kInf, NAN, 0.3};
  const char* const shapes[] = {"cube", "line", "grid.2.3", "sphere"};
  for (std::uint64_t seed = 0; seed < 150; ++seed) {
    const RandomStream random(seed);
    std::uint64_t drawn = 0;
    const auto below = [&](int n) { return static_cast<int>(random.uniform(drawn++) * n); };
    const auto number = [&] { return below(3) > 0 ? random.normal(drawn++) : wild[below(std::size(wild))]; };
    const auto vec = [&] { return Vec3{number(), number(), number()}; };
    Scene scene;
    std::vector<std::string> names{"camera"};
    for (int i = 0; i < 6; ++i) {
      names.push_back("o" + std::to_string(i));
      add(scene, names.back(), shapes[below(4)], {random.normal(drawn++), random.normal(drawn++), 0});
    }
    const auto any = [&]() -> const std::string& { return names[below(static_cast<int>(names.size()))]; };
    int added = 0;
    for (int i = 0; i < 12; ++i) {
      const int kind = below(6);
      const auto name = kind == 0   ? add_link(scene, any(), any(), any(), below(2) == 0)
                        : kind == 1 ? add_parent(scene, any(), any())
                        : kind == 2 ? add_stand_in(scene, any())
                        : kind == 3 ? add_object_path(scene, any(), any(), {1 + below(3), below(2) == 0})
                        : kind == 4 ? add_camera_path(scene, "main", any(), {1 + below(3), below(2) == 0})
                                    : add_camera_tracking(scene, "main", below(2) == 0 ? "" : any(), any());
      added += name ? 1 : 0;
    }
    for (int i = 0; i < 8; ++i) {
      frame(scene, [&] {
        scene.set_transform(scene.id_of(any()), {Mat3{{vec(), vec(), vec()}}, vec(), vec()});
      });
      EXPECT_LE(scene.constraints.report().served, added);
      for (const auto& [id, object] : scene.objects()) {
        const auto valid = validate(object);
        EXPECT_TRUE(static_cast<bool>(valid)) << "seed " << seed << ' ' << object.name;
        EXPECT_FALSE(std::isnan(world_sphere(object).radius));
        const Orientation along = orientation(object);
        EXPECT_TRUE(is_finite(along.normal) && is_finite(along.up));
      }
    }
  }
}

}  // namespace
}  // namespace turgor
