#include "turgor/world/scene.hpp"

#include <gtest/gtest.h>

#include <limits>

#include "turgor/world/object_file.hpp"

namespace turgor {
namespace {

Object named(const std::string& name, const std::string& primitive = "cube") {
  Object object = *make_primitive(primitive);
  object.name = name;
  return object;
}

/// Counts the frames in which the object has changed.
int& count_changes(Scene& scene, int id, int& count) {
  scene.constraints.add({.kind = "count",
                         .triggers = {{Node::Kind::object, id}},
                         .satisfy = [&count](Scene&) -> Result<void> {
                           ++count;
                           return {};
                         },
                         .arguments = {}});
  return count;
}

TEST(Scene, BeginsWithOneWorldOneViewportAndOneCamera) {
  Scene scene;
  ASSERT_EQ(scene.worlds.size(), 1U);
  EXPECT_EQ(scene.current_world, "main");
  ASSERT_EQ(scene.screen.viewports.size(), 1U);
  const Viewport& viewport = scene.screen.viewports[0];
  EXPECT_EQ(viewport.world, "main");
  const Object* camera = scene.find(viewport.camera);
  ASSERT_NE(camera, nullptr);
  EXPECT_EQ(camera->kind(), ObjectKind::camera);
  EXPECT_TRUE(static_cast<bool>(validate(*camera)));
  // It looks at the origin.
  const Vec3 forward = camera->transform.direction({0, 0, -1}), to_origin = -camera->transform.translation;
  EXPECT_NEAR(dot(forward, normalized(to_origin)), 1, 1e-12);
}

TEST(Scene, ObjectsAreKnownByNameAndByANumberThatNeverComesBack) {
  Scene scene;
  const auto ball = scene.add_object(named("ball", "sphere"));
  ASSERT_TRUE(static_cast<bool>(ball));
  EXPECT_EQ(scene.id_of("ball"), *ball);
  EXPECT_EQ(scene.find(*ball), scene.find("ball"));
  EXPECT_EQ(scene.find_world("main")->objects, (std::vector<std::string>{"camera", "ball"}));
  EXPECT_FALSE(static_cast<bool>(scene.add_object(named("ball"))));
  EXPECT_TRUE(scene.remove_object("ball"));
  EXPECT_FALSE(scene.remove_object("ball"));
  EXPECT_EQ(scene.id_of("ball"), -1);
  EXPECT_EQ(scene.find(*ball), nullptr);
  EXPECT_EQ(scene.find_world("main")->objects, (std::vector<std::string>{"camera"}));
  EXPECT_NE(*scene.add_object(named("ball")), *ball);
  EXPECT_TRUE(scene.remove_object(scene.find("ball")->name));
}

TEST(Scene, WrongNamesAndObjectsAreRefused) {
  Scene scene;
  for (const char* name : {"", " ", "a b", "a\tb", "a;b", "a\"b", "-a", "#a", "a\nb", "a\x01"}) {
    EXPECT_FALSE(static_cast<bool>(scene.add_object(named(name)))) << name;
  }
  EXPECT_TRUE(static_cast<bool>(scene.add_object(named("skin.face.sourcegrid"))));
  Object broken = named("broken");
  std::get<Polyhedron>(broken.description).corners[0] = 99;
  EXPECT_FALSE(static_cast<bool>(scene.add_object(broken)));
  scene.current_world = "nowhere";
  EXPECT_FALSE(static_cast<bool>(scene.add_object(named("late"))));
  EXPECT_EQ(scene.find("late"), nullptr);
  const auto missing = scene.require("camrea");
  ASSERT_FALSE(static_cast<bool>(missing));
  EXPECT_NE(missing.error().message().find("camera"), std::string::npos);
}

TEST(Scene, OnlyNewValuesNotify) {
  Scene scene;
  const int id = *scene.add_object(named("a"));
  int changes = 0;
  count_changes(scene, id, changes);
  const auto frame = [&](auto change) {
    const int before = changes;
    scene.begin_frame();
    change();
    scene.serve_constraints();
    scene.end_frame();
    return changes - before;
  };
  ObjectTransform moved;
  moved.translation = {1, 2, 3};
  EXPECT_EQ(frame([&] { scene.set_transform(id, moved); }), 1);
  EXPECT_EQ(frame([&] { scene.set_transform(id, moved); }), 0);
  ObjectTransform wild = moved;
  wild.linear.c[1].y = NAN;
  EXPECT_EQ(frame([&] { scene.set_transform(id, wild); }), 0);
  EXPECT_EQ(scene.find(id)->transform, moved);
  EXPECT_EQ(frame([&] { scene.set_description(id, make_primitive("sphere")->description); }), 1);
  EXPECT_EQ(frame([&] { scene.set_description(id, make_primitive("sphere")->description); }), 0);
  Polyhedron infinite;
  infinite.points = {{0, std::numeric_limits<double>::infinity(), 0}};
  EXPECT_EQ(frame([&] { scene.set_description(id, infinite); }), 0);
  EXPECT_EQ(scene.find(id)->description.index(), 0U);
  EXPECT_EQ(std::get<Polyhedron>(scene.find(id)->description).points.size(), 614U);
  EXPECT_EQ(frame([&] { EXPECT_TRUE(static_cast<bool>(scene.harden(id))); }), 1);
  EXPECT_EQ(frame([&] { EXPECT_TRUE(static_cast<bool>(scene.harden(id))); }), 0);
  EXPECT_EQ(frame([&] {
              scene.set_visible(id, false);
              scene.set_triangulated(id, true);
              scene.set_optics(id, {.shading = Shading::faceted});
            }),
            0);
  EXPECT_FALSE(scene.find(id)->visible);
  EXPECT_TRUE(scene.find(id)->triangulated);
  EXPECT_EQ(scene.find(id)->optics.shading, Shading::faceted);
  scene.set_optics(id, {.opacity = NAN});
  EXPECT_EQ(scene.find(id)->optics.opacity, 1);
  // Numbers that nobody has.
  scene.set_transform(99, moved);
  scene.set_visible(-1, true);
  EXPECT_FALSE(static_cast<bool>(scene.harden(99)));
}

TEST(Scene, PoseGoesOnThroughHardening) {
  Scene scene;
  const int id = *scene.add_object(named("a"));
  const ObjectTransform first{rotation_xyz({10, 20, 30}), {1, 2, 3}, {0.5, 0, 0}};
  scene.set_transform(id, first);
  const Vec3 corner{0.5, 0.5, 0.5};
  ASSERT_TRUE(static_cast<bool>(scene.harden(id)));
  EXPECT_LT(distance(scene.pose(id).point(corner), first.point(corner)), 1e-12);
  const ObjectTransform second{rotation_xyz({0, 0, 90}), {0, 1, 0}, {}};
  scene.set_transform(id, second);
  EXPECT_LT(distance(scene.pose(id).point(corner), second.point(first.point(corner))), 1e-12);
  ASSERT_TRUE(static_cast<bool>(scene.harden(id)));
  EXPECT_LT(distance(scene.pose(id).point(corner), second.point(first.point(corner))), 1e-12);
}

TEST(Scene, AFrameHasItsStartItsCommandsAndItsEnd) {
  Scene scene;
  std::vector<std::string> log;
  const int id = *scene.add_object(named("a"));
  const auto write = [&log](const std::string& word) {
    return [&log, word](Scene&) -> Result<void> {
      log.push_back(word);
      return {};
    };
  };
  scene.constraints.add(
      {.kind = "k", .triggers = {{Node::Kind::frame_end}}, .satisfy = write("end"), .arguments = {}});
  scene.constraints.add(
      {.kind = "k", .triggers = {{Node::Kind::object, id}}, .satisfy = write("moved"), .arguments = {}});
  scene.constraints.add(
      {.kind = "k", .triggers = {{Node::Kind::frame_start}}, .satisfy = write("start"), .arguments = {}});
  for (int frame = 1; frame <= 2; ++frame) {
    scene.begin_frame();
    EXPECT_EQ(scene.frame, frame);
    ObjectTransform moved;
    moved.translation.x = frame;
    scene.set_transform(id, moved);
    scene.serve_constraints();
    scene.end_frame();
  }
  EXPECT_EQ(log, (std::vector<std::string>{"start", "moved", "end", "start", "moved", "end"}));
}

TEST(Scene, RemovingAnObjectTakesItsConstraintsAlong) {
  Scene scene;
  const int a = *scene.add_object(named("a")), b = *scene.add_object(named("b"));
  int changes = 0;
  count_changes(scene, a, changes);
  count_changes(scene, b, changes);
  // One constraint removes the other one's object while it waits.
  scene.constraints.add({.kind = "remove",
                         .triggers = {{Node::Kind::frame_start}},
                         .satisfy = [](Scene& s) -> Result<void> {
                           s.remove_object("a");
                           return {};
                         },
                         .arguments = {}});
  ObjectTransform moved;
  moved.translation.x = 1;
  scene.constraints.begin_frame();
  scene.constraints.notify({Node::Kind::frame_start});
  scene.set_transform(a, moved);
  scene.set_transform(b, moved);
  scene.serve_constraints();
  EXPECT_EQ(changes, 1);
  EXPECT_EQ(scene.constraints.constraints().size(), 2U);
}

}  // namespace
}  // namespace turgor
