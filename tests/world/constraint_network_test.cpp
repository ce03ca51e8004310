#include "turgor/world/constraint_network.hpp"

#include <gtest/gtest.h>

#include <deque>
#include <set>

#include "turgor/core/random.hpp"
#include "turgor/world/scene.hpp"

namespace turgor {
namespace {

Node object(int id) {
  return {Node::Kind::object, id};
}

/// A constraint that writes its name down and tells that `changes` have changed.
Constraint writer(std::vector<std::string>& log, const std::string& name, std::vector<Node> triggers,
                  std::vector<Node> changes) {
  return {.name = name,
          .kind = "writer",
          .triggers = std::move(triggers),
          .satisfy = [&log, name, changes](Scene& scene) -> Result<void> {
            log.push_back(name);
            for (const Node& node : changes) scene.constraints.notify(node);
            return {};
          },
          .arguments = {}};
}

using Names = std::vector<std::string>;

TEST(ConstraintNetwork, ServesBreadthFirstEachOnceAFrame) {
  Scene scene;
  Names log;
  scene.constraints.add(writer(log, "a", {object(1)}, {object(2), object(3)}));
  scene.constraints.add(writer(log, "b", {object(2)}, {object(4)}));
  scene.constraints.add(writer(log, "c", {object(3), object(4)}, {}));
  scene.constraints.add(writer(log, "d", {object(4)}, {}));
  scene.constraints.add(writer(log, "e", {object(9)}, {}));
  scene.begin_frame();
  scene.constraints.notify(object(1));
  scene.serve_constraints();
  EXPECT_EQ(log, (Names{"a", "b", "c", "d"}));
  EXPECT_EQ(scene.constraints.report().served, 4);
  EXPECT_TRUE(scene.constraints.report().loops.empty()) << "c was merely served already";
  scene.constraints.notify(object(1));
  scene.serve_constraints();
  EXPECT_EQ(log.size(), 4U);
  scene.begin_frame();
  EXPECT_EQ(scene.constraints.report().served, 0);
  scene.constraints.notify(object(1));
  scene.serve_constraints();
  EXPECT_EQ(log.size(), 8U);
}

TEST(ConstraintNetwork, LoopsEndAndAreNamedOnce) {
  Scene scene;
  Names log;
  scene.constraints.add(writer(log, "start", {object(1)}, {object(2)}));
  scene.constraints.add(writer(log, "a", {object(2)}, {object(3)}));
  scene.constraints.add(writer(log, "b", {object(3)}, {object(2), object(2), object(4)}));
  scene.constraints.add(writer(log, "self", {object(4)}, {object(4)}));
  scene.begin_frame();
  scene.constraints.notify(object(1));
  scene.serve_constraints();
  EXPECT_EQ(log, (Names{"start", "a", "b", "self"}));
  EXPECT_EQ(scene.constraints.report().loops, (Names{"a → b → a", "self → self"}));
}

TEST(ConstraintNetwork, WhatWasMerelyServedAlreadyIsNoLoop) {
  Scene scene;
  Names log;
  // Two independent starts of one thing; the second changes what the first was triggered by.
  scene.constraints.add(writer(log, "a", {{Node::Kind::frame_start}, object(1)}, {}));
  scene.constraints.add(writer(log, "b", {{Node::Kind::frame_start}}, {object(1)}));
  scene.begin_frame();
  EXPECT_EQ(log, (Names{"a", "b"}));
  EXPECT_TRUE(scene.constraints.report().loops.empty());
}

TEST(ConstraintNetwork, FailuresAreCollectedAndOthersGoOn) {
  Scene scene;
  Names log;
  scene.constraints.add({.kind = "broken",
                         .triggers = {object(1)},
                         .satisfy = [](Scene&) -> Result<void> {
                           return Error{ErrorKind::bad_input, "does not fit"};
                         },
                         .arguments = {}});
  scene.constraints.add({.kind = "empty", .triggers = {object(1)}, .satisfy = {}, .arguments = {}});
  scene.constraints.add(writer(log, "a", {object(1)}, {}));
  scene.begin_frame();
  scene.constraints.notify(object(1));
  scene.serve_constraints();
  EXPECT_EQ(log, Names{"a"});
  ASSERT_EQ(scene.constraints.report().failures.size(), 1U);
  EXPECT_EQ(scene.constraints.report().failures[0].message(), "broken.1: does not fit.");
}

TEST(ConstraintNetwork, NamesAreUniqueAndNeverComeBack) {
  ConstraintNetwork network;
  EXPECT_EQ(network.add({.kind = "link"}), "link.1");
  EXPECT_EQ(network.add({.kind = "link"}), "link.2");
  EXPECT_EQ(network.add({.name = "mine", .kind = "link"}), "mine");
  EXPECT_EQ(network.add({.name = "mine", .kind = "link"}), "mine.1");
  EXPECT_EQ(network.add({.name = "link.3", .kind = "link"}), "link.3");
  EXPECT_EQ(network.add({.kind = "link"}), "link.4");
  EXPECT_TRUE(network.remove("link.2"));
  EXPECT_FALSE(network.remove("link.2"));
  EXPECT_EQ(network.add({.kind = "link"}), "link.5");
  EXPECT_EQ(network.constraints().size(), 6U);
  EXPECT_EQ(network.add({.kind = "x", .triggers = {object(7), object(7)}}), "x.1");
  EXPECT_EQ(network.add({.kind = "x", .changes = {object(7)}}), "x.2");
  EXPECT_EQ(network.remove_dependents(object(7)), 2);
  EXPECT_EQ(network.remove_dependents(object(7)), 0);
  EXPECT_EQ(network.constraints().size(), 6U);
}

TEST(ConstraintNetwork, WhatWaitsBetweenFramesIsServedInTheNext) {
  Scene scene;
  Names log;
  scene.constraints.add(writer(log, "a", {object(1)}, {}));
  scene.constraints.add(writer(log, "b", {{Node::Kind::frame_start}}, {object(1)}));
  scene.begin_frame();
  scene.end_frame();
  log.clear();
  scene.constraints.notify(object(1));
  scene.begin_frame();
  EXPECT_EQ(log, (Names{"b", "a"})) << "a had its turn in the frame before, and b triggers it in this one";
  log.clear();
  scene.begin_frame();
  scene.constraints.remove("b");
  Scene other;
  other.constraints.add(writer(log, "c", {object(1)}, {}));
  other.constraints.notify(object(1));
  log.clear();
  other.begin_frame();
  EXPECT_EQ(log, Names{"c"});
}

TEST(ConstraintNetwork, MayBeChangedWhileItIsServed) {
  Scene scene;
  Names log;
  // Removes itself and the one that waits behind it, adds one that is triggered at once, and calls for more.
  scene.constraints.add({.name = "a",
                         .kind = "k",
                         .triggers = {object(1)},
                         .satisfy = [&log](Scene& s) -> Result<void> {
                           log.push_back("a");
                           EXPECT_TRUE(s.constraints.remove("a"));
                           EXPECT_TRUE(s.constraints.remove("b"));
                           for (int i = 0; i < 100; ++i) {
                             s.constraints.add(
                                 writer(log, "new" + std::to_string(i), {object(1)}, {object(1)}));
                           }
                           s.constraints.notify(object(1));
                           s.serve_constraints();
                           s.begin_frame();
                           log.push_back("end of a");
                           return {};
                         },
                         .arguments = {}});
  scene.constraints.add(writer(log, "b", {object(1)}, {}));
  scene.constraints.add(writer(log, "c", {object(1)}, {}));
  scene.begin_frame();
  scene.constraints.notify(object(1));
  scene.serve_constraints();
  EXPECT_EQ(log, (Names{"a", "end of a", "c"}));
  EXPECT_EQ(scene.constraints.constraints().size(), 101U);
  log.clear();
  scene.begin_frame();
  scene.constraints.notify(object(1));
  scene.serve_constraints();
  EXPECT_EQ(log.size(), 101U);
}

TEST(ConstraintNetwork, ConstraintsThatBreedEndTheFrame) {
  Scene scene;
  int served = 0;
  std::function<Result<void>(Scene&)> breed = [&](Scene& s) -> Result<void> {
    ++served;
    s.constraints.add({.kind = "breed", .triggers = {object(1)}, .satisfy = breed, .arguments = {}});
    s.constraints.notify(object(1));
    return {};
  };
  scene.constraints.add({.kind = "breed", .triggers = {object(1)}, .satisfy = breed, .arguments = {}});
  for (int frame = 0; frame < 6; ++frame) {
    scene.begin_frame();
    scene.constraints.notify(object(1));
    scene.serve_constraints();
  }
  EXPECT_EQ(served, 1 + 2 + 4 + 8 + 16 + 32);
}

TEST(ConstraintNetwork, AConstraintKeepsItsStateFromFrameToFrame) {
  Scene scene;
  std::vector<int> seen;
  scene.constraints.add({.kind = "count",
                         .triggers = {{Node::Kind::frame_end}},
                         .satisfy = [&seen, n = 0](Scene&) mutable -> Result<void> {
                           seen.push_back(++n);
                           return {};
                         },
                         .arguments = {}});
  for (int frame = 0; frame < 3; ++frame) {
    scene.begin_frame();
    scene.serve_constraints();
    scene.end_frame();
  }
  EXPECT_EQ(seen, (std::vector<int>{1, 2, 3}));
}

// Random graphs: the order is that of a plain breadth-first search, and every frame ends.
TEST(ConstraintNetwork, AnyNetworkIsServedAsABreadthFirstSearch) {
  for (std::uint64_t seed = 0; seed < 200; ++seed) {
    const RandomStream random(seed);
    std::uint64_t drawn = 0;
    const auto draw = [&](int below) { return static_cast<int>(random.uniform(drawn++) * below); };
    const int nodes = 1 + draw(12), count = draw(40);
    std::vector<std::vector<Node>> triggers(count), changes(count);
    Scene scene;
    Names log;
    for (int c = 0; c < count; ++c) {
      for (int k = draw(4); k >= 0; --k) triggers[c].push_back(object(draw(nodes)));
      for (int k = draw(4); k > 0; --k) changes[c].push_back(object(draw(nodes)));
      scene.constraints.add(writer(log, std::to_string(c), triggers[c], changes[c]));
    }
    const int start = draw(nodes);
    Names expected;
    std::deque<int> queue;
    std::set<int> seen;
    const auto reach = [&](const Node& node) {
      for (int c = 0; c < count; ++c) {
        const bool cares = std::find(triggers[c].begin(), triggers[c].end(), node) != triggers[c].end();
        if (cares && seen.insert(c).second) queue.push_back(c);
      }
    };
    reach(object(start));
    while (!queue.empty()) {
      const int c = queue.front();
      queue.pop_front();
      expected.push_back(std::to_string(c));
      for (const Node& node : changes[c]) reach(node);
    }
    for (int frame = 0; frame < 2; ++frame) {
      log.clear();
      scene.begin_frame();
      scene.constraints.notify(object(start));
      scene.serve_constraints();
      EXPECT_EQ(log, expected) << "seed " << seed;
      EXPECT_EQ(scene.constraints.report().served, static_cast<int>(expected.size()));
      const Names& loops = scene.constraints.report().loops;
      EXPECT_EQ(std::set<std::string>(loops.begin(), loops.end()).size(), loops.size());
    }
  }
}

TEST(ConstraintNetwork, ALongChainIsServedInOneFrame) {
  Scene scene;
  Names log;
  constexpr int length = 2000;
  for (int i = length - 1; i >= 0; --i) {
    scene.constraints.add(writer(log, std::to_string(i), {object(i)}, {object((i + 1) % length)}));
  }
  scene.begin_frame();
  scene.constraints.notify(object(0));
  scene.serve_constraints();
  EXPECT_EQ(log.size(), static_cast<std::size_t>(length));
  EXPECT_EQ(log.back(), std::to_string(length - 1));
  EXPECT_EQ(scene.constraints.report().loops.size(), 1U);
}

}  // namespace
}  // namespace turgor
