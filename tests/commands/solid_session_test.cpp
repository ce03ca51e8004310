// Solids by commands: made, held, led, pulled, in contact, brought to rest, recorded and replayed.
#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <numbers>
#include <string>

#include "turgor/commands/session.hpp"
#include "turgor/core/parallel.hpp"
#include "turgor/world/solid_objects.hpp"

namespace turgor {
namespace {

/// A script carried out to its end, or to its error.
struct Played {
  Context context;
  std::string said;
  std::unique_ptr<Session> session;
  Result<void> done;

  explicit Played(const std::string& script) {
    SessionOptions options;
    options.say = [this](std::string_view text) { said += std::string(text) + "\n"; };
    session = std::make_unique<Session>(std::move(options), context);
    done = session->enter_text(script, "test");
    if (done) done = session->run();
  }
  [[nodiscard]] std::string error() const { return done ? "" : done.error().message(); }
  [[nodiscard]] const Specimen& tissue() const { return session->scene().specimen; }
};

constexpr const char* kBar =
    "instance_object cube bar\n"
    "edit_xform bar -s 10 10 40\n"
    "voxelize bar -resolution 8 -no_border -young 0.05 -poisson 0.3\n";

bool same_bits(const std::vector<Vec3>& a, const std::vector<Vec3>& b) {
  if (a.size() != b.size()) return false;
  for (std::size_t i = 0; i < a.size(); ++i)
    if (!(a[i] == b[i])) return false;
  return true;
}

TEST(SolidSession, VoxelizeMakesASolidThatLooksLikeItsObject) {
  const Played run(std::string("instance_object cube bar\ncolors bar -diff .1 .2 .3\n") +
                   "edit_xform bar -s 10 10 40 -t 5 0 0\nvoxelize bar -resolution 8 -no_border\n");
  ASSERT_TRUE(run.done) << run.error();
  const auto measures = measure_solids(run.tissue());
  ASSERT_EQ(measures.size(), 1U);
  EXPECT_EQ(measures[0].tetrahedra, 5 * 8 * 2 * 2);
  EXPECT_NEAR(measures[0].volume, 4000, 1);  // the grid is a little wider than the object
  EXPECT_EQ(measures[0].inverted, 0);
  const Scene& scene = run.session->scene();
  EXPECT_FALSE(scene.find("bar")->visible);
  const Object* const skin = scene.find("skin.solid.bar");
  ASSERT_NE(skin, nullptr);
  EXPECT_TRUE(skin->visible);
  EXPECT_EQ(skin->optics.diffuse.y, 0.2f);
  const Box3 box = world_box(*skin);
  EXPECT_NEAR(box.lower.x, 0, 1e-9);
  EXPECT_NEAR(box.upper.z, 20, 1e-9);
  EXPECT_FALSE(scene.find("mesh.solid.bar")->visible);
}

TEST(SolidSession, AHiddenDrawingIsUpToDateOnceItIsShown) {
  const Played run(std::string(kBar) +
                   "fix bar -box -9 -9 19 9 9 21\ngravity -g 0.01\nsimulate 100 -dt 0.5 -verlet\n"
                   "visible mesh.solid.bar -on\n");
  ASSERT_TRUE(run.done) << run.error();
  const Box3 shown = world_box(*run.session->scene().find("mesh.solid.bar"));
  EXPECT_LT(shown.lower.z, -20.001);
  EXPECT_EQ(shown.lower.z, measure_solids(run.tissue()).front().box.lower.z);
}

TEST(SolidSession, AHangingBarStretchesAndItsHolderCarriesItsWeight) {
  Played run(std::string(kBar) +
             "fix bar -box -9 -9 19 9 9 21\ngravity -g 0.00980665\nsettle -residual 1e-8\n");
  ASSERT_TRUE(run.done) << run.error();
  const auto m = measure_solids(run.tissue()).front();
  EXPECT_EQ(m.fixed, 9);
  EXPECT_LT(m.box.lower.z, -20.0);
  // Of linear elasticity ρ g L² / 2E, to a good half of it: the bar is coarse and its end is clamped.
  const double expected = 1.04e-3 * 0.00980665 * 40 * 40 / (2 * 0.05);
  EXPECT_NEAR(-20.0 - m.box.lower.z, expected, 0.4 * expected);
  EXPECT_EQ(m.greatest_speed, 0);
}

TEST(SolidSession, WhatIsAttachedGoesWhereTheObjectGoes) {
  Played run(std::string(kBar) +
             "instance_object cube hook\nfix bar -box -9 -9 -21 9 9 -19\n"
             "tie bar hook -box -9 -9 19 9 9 21\n"
             "mv_obj_by hook -turn 30 -axis 0 0 1 -about 0 0 0 -by 1 2 3 -frames 20\n"
             "damping 0.01\nsimulate 200 -dt 0.1 -skip 10 -verlet\n");
  ASSERT_TRUE(run.done) << run.error();
  const TissueBody& body = run.tissue().bodies().at(1);
  const std::vector<Vec3> x = run.tissue().positions_of(body);
  const double c = std::cos(std::numbers::pi / 6), s = 0.5;
  int checked = 0;
  for (std::size_t i = 0; i < x.size(); ++i) {
    const Vec3 p = body.solid->mesh.points[i];
    if (p.z < 19) continue;
    const Vec3 there{c * p.x - s * p.y + 1, s * p.x + c * p.y + 2, p.z + 3};
    EXPECT_LT(distance(x[i], there), 1e-9) << i;
    ++checked;
  }
  EXPECT_EQ(checked, 9);
}

TEST(SolidSession, FreedSamplesNoLongerFollow) {
  Played run(std::string(kBar) +
             "instance_object cube hook\ntie bar hook -box -9 -9 19 9 9 21\n"
             "fix bar -free -box -9 -9 19 9 9 21\nmv_obj_by hook -by 0 0 50 -frames 5\n"
             "simulate 10 -dt 0.1 -verlet\n");
  ASSERT_TRUE(run.done) << run.error();
  EXPECT_TRUE(run.tissue().attachments().empty());
  EXPECT_LT(measure_solids(run.tissue()).front().greatest_displacement, 1e-6);
}

TEST(SolidSession, AGrabTellsItsForceAndKeepsItsLimit) {
  const std::string pull = std::string(kBar) +
                           "fix bar -box -9 -9 19 9 9 21\n"
                           "grab tip -at 0 0 -20 -radius 8 -to 0 0 -30 -c 0.02\nsettle -residual 1e-8\n";
  Played soft(pull + "list grabs\n");
  ASSERT_TRUE(soft.done) << soft.error();
  const NamedGrab& tip = soft.tissue().grabs().front();
  Vec3 mean;
  for (const int i : tip.samples)
    mean += soft.tissue().position({1, i}) / static_cast<double>(tip.samples.size());
  EXPECT_EQ(tip.samples.size(), 14U);
  EXPECT_NEAR(length(soft.tissue().force_of(tip)), 0.02 * distance(mean, tip.target), 1e-9);
  EXPECT_NE(soft.said.find("tip"), std::string::npos);
  Played limited(pull + "grab tip -c 1 -limit 0.05\nsettle -residual 1e-6\n");
  ASSERT_TRUE(limited.done) << limited.error();
  EXPECT_NEAR(length(limited.tissue().force_of(limited.tissue().grabs().front())), 0.05, 1e-12);
  Played gone(pull + "let_go tip\nsettle -residual 1e-6\n");
  ASSERT_TRUE(gone.done) << gone.error();
  EXPECT_LT(measure_solids(gone.tissue()).front().greatest_displacement, 1e-3);
}

TEST(SolidSession, StiffenChangesARegionOnly) {
  Played run(std::string(kBar) +
             "stiffen bar -by 100 -box -9 -9 -21 9 9 0\nfix bar -box -9 -9 19 9 9 21\n"
             "gravity -g 0.1\nsettle -residual 1e-8\n");
  ASSERT_TRUE(run.done) << run.error();
  const TissueBody& body = run.tissue().bodies().at(1);
  const std::vector<Vec3> x = run.tissue().positions_of(body);
  const auto middle = [&](double z) {
    double sum = 0;
    for (std::size_t i = 0; i < x.size(); ++i)
      if (std::abs(body.solid->mesh.points[i].z - z) < 0.1) sum += x[i].z / 9;
    return sum;
  };
  const double upper = (middle(20) - middle(0)) / 20 - 1, lower = (middle(0) - middle(-20)) / 20 - 1;
  EXPECT_GT(upper, 20 * lower);
  EXPECT_GT(lower, 0);
}

TEST(SolidSession, MusclesPullSolids) {
  Played run(std::string(kBar) +
             "fix bar -box -9 -9 19 9 9 21\nblot anchor 30 0 -20 -fixed\n"
             "add_muscle pull -near 0 0 -20 0 0 19 -flesh bar -c 0.2\n"
             "muscle_set pull -scale 0.7\nsettle -residual 1e-7\n");
  ASSERT_TRUE(run.done) << run.error();
  EXPECT_GT(measure_solids(run.tissue()).front().box.lower.z, -19.9) << "shorter";
}

TEST(SolidSession, ANewMeshTakesOverShapeMotionAndHolds) {
  const std::string pulled =
      std::string(kBar) +
      "instance_object cube hook\nfix bar -box -9 -9 19 9 9 21\ntie bar hook -box -9 -9 -21 9 9 -19\n"
      "mv_obj_by hook -turn 60 -by 0 3 -6 -frames 20\ndamping 0.01\n"
      "simulate 200 -dt 0.1 -skip 10 -verlet\n";
  Played before(pulled);
  ASSERT_TRUE(before.done) << before.error();
  Played after(pulled + "remesh bar -resolution 12 -frames 3\nsimulate 100 -dt 0.1 -skip 10 -verlet\n");
  ASSERT_TRUE(after.done) << after.error();
  const auto old = measure_solids(before.tissue()).front(), now = measure_solids(after.tissue()).front();
  EXPECT_GT(now.tetrahedra, 2 * old.tetrahedra);
  EXPECT_EQ(now.inverted, 0);
  EXPECT_GT(now.fixed, 0);
  const auto skin_volume = [](const Played& run) {
    const Object& skin = *run.session->scene().find("skin.solid.bar");
    return enclosed_volume(triangulated(std::get<Polyhedron>(skin.description)));
  };
  EXPECT_NEAR(skin_volume(after) / skin_volume(before), 1, 0.01);
  EXPECT_EQ(after.tissue().attachments().size(), 1U);
  const Played again(after.session->recording());
  ASSERT_TRUE(again.done) << again.error();
  EXPECT_TRUE(same_bits(again.tissue().state().position, after.tissue().state().position));
}

TEST(SolidSession, RepeatsAndReplaysToTheBitOnAnyNumberOfThreads) {
  const std::string script = std::string(kBar) +
                             "instance_object sphere ball\nedit_xform ball -s 12 12 12 -t 0 0 30\n"
                             "voxelize ball -resolution 6 -young 0.05 -skin barycentric\n"
                             "fix bar -box -9 -9 -21 9 9 -19\ngravity -g 0.02\ncontact -friction 0.4\n"
                             "damping 0.001\nsimulate 120 -dt 0.2 -skip 4 -verlet\n"
                             "simulate 3 -dt 2 -implicit\n";
  set_thread_count(1);
  const Played one(script);
  set_thread_count(0);
  const Played two(script);
  ASSERT_TRUE(one.done) << one.error();
  ASSERT_TRUE(two.done) << two.error();
  EXPECT_TRUE(same_bits(one.tissue().state().position, two.tissue().state().position));
  const Played again(two.session->recording());
  ASSERT_TRUE(again.done) << again.error();
  EXPECT_TRUE(same_bits(again.tissue().state().position, two.tissue().state().position));
}

TEST(SolidSession, ErrorsNameThePlaceAndTheRemedy) {
  const auto message = [](const std::string& script) { return Played(script).error(); };
  EXPECT_NE(message("voxelize nothing\n").find("nothing"), std::string::npos);
  EXPECT_NE(message("instance_object grid.5.5 sheet\nvoxelize sheet\n").find("test:2"), std::string::npos);
  EXPECT_NE(message(std::string(kBar) + "voxelize bar\n").find("bar"), std::string::npos);
  EXPECT_NE(message(std::string(kBar) + "grow bar -by 2\n").find("solid"), std::string::npos);
  EXPECT_NE(message(std::string(kBar) + "grab tip -to 0 0 0\n").find("takes hold"), std::string::npos);
  EXPECT_NE(message("let_go tip\n").find("tip"), std::string::npos);
  EXPECT_NE(message(std::string(kBar) + "fix other\n").find("bar"), std::string::npos);
  EXPECT_NE(message(std::string(kBar) + "mv_obj_by bar -turn 5 -axis 0 0 0\n").find("axis"),
            std::string::npos);
}

}  // namespace
}  // namespace turgor
