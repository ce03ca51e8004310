#include "turgor/world/specimen.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numeric>

#include "turgor/world/flesh_objects.hpp"
#include "turgor/world/object_file.hpp"

namespace turgor {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr double kInf = std::numeric_limits<double>::infinity();

/// Three layers over a square sheet of 4 × 4 points, 1 × 1, thickness 0.2; sample = 16 layer + 4 row +
/// column.
Flesh sheet(double volume = 0) {
  FleshOptions options;
  options.thickness = {{0.1}, {0.1}};
  options.volume_modulus_mpa = volume;
  options.inversion_guard_mpa = 10 * volume;
  return *flesh_out(std::get<Polyhedron>(make_primitive("grid.4.4")->description), options);
}

Specimen with_sheet(double volume = 0) {
  Specimen specimen;
  EXPECT_TRUE(static_cast<bool>(specimen.add_flesh("sheet", sheet(volume), 0)));
  return specimen;
}

SampleRef in_sheet(int layer, int column) {
  return {1, 16 * layer + column};
}

void run(Specimen& specimen, int steps, double dt = 0.02) {
  Context context;
  SimulationReport report;
  for (int i = 0; i < steps; ++i) {
    const auto done = specimen.step(i * dt, {dt, Integrator::heun, 0}, report, context);
    ASSERT_TRUE(static_cast<bool>(done)) << done.error().message();
  }
}

bool is_finite(const Specimen& specimen) {
  for (const auto* field : {&specimen.state().position, &specimen.state().velocity}) {
    for (const Vec3& v : *field) {
      if (!is_within_reach(v)) return false;
    }
  }
  return true;
}

double total_mass(const Specimen& specimen) {
  double sum = 0;
  for (const TissueBody& body : specimen.bodies()) {
    for (const FleshSample& s : body.flesh.samples) sum += s.mass_g;
  }
  return sum;
}

Region around(const Vec3& centre, double radius, int layer = -1) {
  Region region;
  region.centre = centre;
  region.radius = radius;
  region.layer = layer;
  return region;
}

// ---- twitch ----

TEST(Twitch, FollowsHalfACosineBetweenItsKeysAndHoldsBeyondThem) {
  const Twitch twitch{2, {0, 10, 30}, {1, 0.3, 0.5}};
  ASSERT_TRUE(static_cast<bool>(validate(twitch)));
  EXPECT_EQ(twitch.scale_at(-5), 1);
  EXPECT_EQ(twitch.scale_at(2), 1);
  EXPECT_NEAR(twitch.scale_at(4.5), 1 - 0.7 * (0.5 - 0.5 * std::cos(0.25 * 3.14159265358979)), 1e-12);
  EXPECT_NEAR(twitch.scale_at(7), 0.65, 1e-12);
  EXPECT_EQ(twitch.scale_at(12), 0.3);
  EXPECT_NEAR(twitch.scale_at(22), 0.4, 1e-12);
  EXPECT_EQ(twitch.scale_at(32), 0.5);
  EXPECT_EQ(twitch.scale_at(1e9), 0.5);
}

TEST(Twitch, RefusesWhatIsNoCourseOfTime) {
  const auto refused = [](const Twitch& t) { return !validate(t); };
  EXPECT_TRUE(refused({0, {}, {}}));
  EXPECT_TRUE(refused({0, {0, 1}, {1}}));
  EXPECT_TRUE(refused({0, {0, 0}, {1, 1}}));
  EXPECT_TRUE(refused({0, {1, 0}, {1, 1}}));
  EXPECT_TRUE(refused({0, {0, 1}, {1, -0.1}}));
  EXPECT_TRUE(refused({0, {0, kNan}, {1, 1}}));
  EXPECT_TRUE(refused({kInf, {0, 1}, {1, 1}}));
  EXPECT_TRUE(refused({0, {0, 1}, {kNan, 1}}));
  EXPECT_TRUE(refused({0, {-1e308, 1e308}, {1, 1}}));
}

// ---- muscles ----

TEST(Specimen, AMuscleIsSetAtOnceUnlessItTwitches) {
  Specimen specimen = with_sheet();
  ASSERT_TRUE(static_cast<bool>(specimen.add_fibre("m", in_sheet(1, 0), in_sheet(1, 3), {})));
  ASSERT_EQ(specimen.muscles().size(), 1U);
  const auto scale = [&] { return specimen.muscles()[0].fibres[0].scale; };
  EXPECT_EQ(*specimen.set_muscle("m", std::nullopt, 0.5), true);
  EXPECT_EQ(*specimen.set_muscle("m", std::nullopt, 0.5), true);  // of the present one
  EXPECT_EQ(scale(), 0.25);
  EXPECT_EQ(*specimen.set_muscle("m", 0.5, std::nullopt), true);
  EXPECT_NEAR(scale(), 0.5, 1e-15);
  ASSERT_TRUE(static_cast<bool>(specimen.set_twitch("m", {0, {0, 1}, {1, 0.2}})));
  EXPECT_EQ(*specimen.set_muscle("m", std::nullopt, 0.9), false);
  EXPECT_NEAR(scale(), 0.5, 1e-15);
  run(specimen, 1);  // from now on the twitch drives it
  EXPECT_EQ(scale(), 1);
  EXPECT_FALSE(static_cast<bool>(specimen.set_muscle("other", 1, std::nullopt)));
  EXPECT_FALSE(static_cast<bool>(specimen.set_twitch("other", {0, {0}, {1}})));
}

TEST(Specimen, AContractedMusclePullsItsEndsTogetherAndNothingElseMovesTheCentre) {
  Specimen specimen = with_sheet();
  ASSERT_TRUE(static_cast<bool>(specimen.add_fibre("m", in_sheet(1, 4), in_sheet(1, 7), {.stiffness = 5})));
  ASSERT_TRUE(static_cast<bool>(specimen.set_damping(1)));
  ASSERT_TRUE(static_cast<bool>(specimen.set_muscle("m", std::nullopt, 0.5)));
  const Fibre fibre = specimen.muscles()[0].fibres[0];
  const double before = specimen.length(fibre);
  EXPECT_GT(specimen.tension(specimen.muscles()[0].fibres[0]), 0);
  run(specimen, 400);
  EXPECT_LT(specimen.length(fibre), 0.9 * before);
  Vec3 centre;
  for (const Vec3& x : specimen.state().position) centre += x / 48;
  EXPECT_LT(distance(centre, {0, 0, 0.1}), 1e-9);  // no force from outside
}

// ---- edits ----

/// A sheet that swings, with fibres, a shock, a loose sample and handles.
struct Swinging {
  Specimen specimen = with_sheet();
  int corner = 0, middle = 0, hook = 0;
  Swinging() {
    const auto loose = specimen.add_sample("hook", {0, 0, 1}, 2, false);
    EXPECT_TRUE(static_cast<bool>(loose));
    EXPECT_TRUE(static_cast<bool>(specimen.add_fibre("m", in_sheet(1, 0), in_sheet(1, 12), {})));
    EXPECT_TRUE(static_cast<bool>(specimen.add_fibre("m", in_sheet(1, 5), in_sheet(1, 6), {})));
    EXPECT_TRUE(static_cast<bool>(specimen.add_shock(*loose, in_sheet(2, 15), {.stiffness = 3})));
    EXPECT_TRUE(static_cast<bool>(specimen.add_shock(*loose, in_sheet(2, 6), {.stiffness = 3})));
    corner = specimen.hold(in_sheet(2, 15));
    middle = specimen.hold(in_sheet(2, 6));
    hook = specimen.hold(*loose);
    EXPECT_TRUE(static_cast<bool>(specimen.set_muscle("m", std::nullopt, 0.6)));
    run(specimen, 5);
  }
};

TEST(Specimen, RemovalTakesFibresWithItAndTheRestKeepsItsSamplesAndItsMotion) {
  Swinging s;
  Specimen& specimen = s.specimen;
  const Vec3 place = specimen.position(in_sheet(2, 15));
  const Vec3 velocity = specimen.state().velocity[static_cast<std::size_t>(specimen.index(in_sheet(2, 15)))];
  const Fibre outer = specimen.muscles()[0].fibres[0];
  const double span = specimen.length(outer);
  ASSERT_GT(length(velocity), 0);
  // Column 6, and with it 2, 3 and 7, which no polygon uses any more.
  const auto removed = specimen.remove("sheet", around({1. / 6, -1. / 6, 0.2}, 0.15, 2));
  ASSERT_TRUE(static_cast<bool>(removed)) << removed.error().message();
  EXPECT_EQ(*removed, 1);
  EXPECT_EQ(specimen.bodies()[1].count, 36);
  EXPECT_EQ(specimen.state().position.size(), 37U);
  // The inner fibre and the shock to column 6 are gone.
  ASSERT_EQ(specimen.muscles()[0].fibres.size(), 1U);
  EXPECT_EQ(specimen.length(specimen.muscles()[0].fibres[0]), span);
  EXPECT_EQ(specimen.muscles()[0].fibres[0].scale, outer.scale);
  ASSERT_EQ(specimen.shocks().size(), 1U);
  EXPECT_EQ(specimen.position(specimen.shocks()[0].b), place);
  // Handles follow, or know that theirs is gone.
  ASSERT_TRUE(specimen.held(s.corner).has_value());
  EXPECT_EQ(specimen.position(*specimen.held(s.corner)), place);
  EXPECT_EQ(specimen.state().velocity[static_cast<std::size_t>(specimen.index(*specimen.held(s.corner)))],
            velocity);
  EXPECT_FALSE(specimen.held(s.middle).has_value());
  EXPECT_EQ(specimen.position(*specimen.held(s.hook)), (Vec3{0, 0, 1}));
  run(specimen, 50);
  EXPECT_TRUE(is_finite(specimen));
}

TEST(Specimen, RemovingNothingOrEverythingChangesNothing) {
  Specimen specimen = with_sheet();
  const int springs = specimen.spring_count();
  EXPECT_EQ(*specimen.remove("sheet", around({9, 9, 9}, 1)), 0);
  EXPECT_FALSE(static_cast<bool>(specimen.remove("sheet", around({}, 100))));
  EXPECT_FALSE(static_cast<bool>(specimen.remove("other", around({}, 1))));
  EXPECT_EQ(specimen.spring_count(), springs);
  run(specimen, 2);
}

double mean_edge(const Specimen& specimen, int layer) {
  double sum = 0;
  for (int c = 0; c < 3; ++c)
    sum += distance(specimen.position(in_sheet(layer, c)), specimen.position(in_sheet(layer, c + 1)));
  return sum / 3;
}

TEST(Specimen, TissueGrowsAndShrinksToItsNewRestLengths) {
  for (const double factor : {1.2, 0.8}) {
    Specimen specimen = with_sheet();
    ASSERT_TRUE(static_cast<bool>(specimen.set_damping(1)));
    EXPECT_EQ(*specimen.scale_growth("sheet", {}, factor), 48);
    run(specimen, 1500);
    EXPECT_NEAR(mean_edge(specimen, 1), factor / 3, 0.01);
  }
}

TEST(Specimen, GrowthOfOneLayerBendsTheSheet) {
  Specimen specimen = with_sheet();
  ASSERT_TRUE(static_cast<bool>(specimen.set_damping(1)));
  Region skin;
  skin.layer = 2;
  EXPECT_EQ(*specimen.scale_growth("sheet", skin, 1.2), 16);
  run(specimen, 1000);
  EXPECT_GT(mean_edge(specimen, 2), 1.05 * mean_edge(specimen, 0));
}

TEST(Specimen, AStifferRegionGivesLessUnderTheSamePull) {
  const auto stretch = [](double factor) {
    Specimen specimen = with_sheet();
    EXPECT_TRUE(static_cast<bool>(specimen.set_damping(1)));
    EXPECT_TRUE(static_cast<bool>(specimen.add_fibre("m", in_sheet(1, 4), in_sheet(1, 7), {.stiffness = 1})));
    EXPECT_TRUE(static_cast<bool>(specimen.set_muscle("m", std::nullopt, 0.5)));
    EXPECT_EQ(*specimen.scale_stiffness("sheet", {}, factor), 48);
    run(specimen, 500);
    return 1 - specimen.length(specimen.muscles()[0].fibres[0]);
  };
  const double soft = stretch(1), stiff = stretch(10);
  EXPECT_GT(soft, 3 * stiff);
  EXPECT_GT(stiff, 0);
}

TEST(Specimen, FixedSamplesStayWhereTheyAreAndMoveAgainWhenFreed) {
  Specimen specimen = with_sheet();
  Region bone;
  bone.layer = 0;
  ASSERT_TRUE(static_cast<bool>(specimen.set_gravity({0, 0, -1})));
  EXPECT_EQ(*specimen.set_mobile("sheet", bone, false), 16);
  const std::vector<Vec3> before = specimen.state().position;
  run(specimen, 20);
  for (std::size_t i = 0; i < 16; ++i) EXPECT_EQ(specimen.state().position[i], before[i]);
  EXPECT_LT(specimen.state().position[40].z, before[40].z);
  EXPECT_EQ(*specimen.set_mobile("sheet", bone, true), 16);
  run(specimen, 20);
  for (std::size_t i = 0; i < 16; ++i) EXPECT_LT(specimen.state().position[i].z, before[i].z);
}

TEST(Specimen, VolumesComeAndGo) {
  Specimen specimen = with_sheet();
  const auto volumes = [&] { return specimen.bodies()[1].parts.network.volumes.size(); };
  EXPECT_EQ(volumes(), 0U);
  EXPECT_EQ(*specimen.set_volume("sheet", 50, 500), 9);
  EXPECT_GT(volumes(), 0U);
  EXPECT_EQ(*specimen.set_volume("sheet", 0, 0), 9);
  EXPECT_EQ(volumes(), 0U);
  EXPECT_FALSE(static_cast<bool>(specimen.set_volume("sheet", -1, 0)));
  EXPECT_FALSE(static_cast<bool>(specimen.set_volume("sheet", kNan, 0)));
  EXPECT_EQ(volumes(), 0U);
}

// ---- refinement ----

TEST(Specimen, RefinesWhereItIsStrainedAndIsTheSameAgainAfterwards) {
  Swinging s;
  Specimen& specimen = s.specimen;
  const double mass = total_mass(specimen), length = specimen.length(specimen.muscles()[0].fibres[1]);
  const Vec3 held = specimen.position(*specimen.held(s.middle));
  ASSERT_EQ(*specimen.refine("sheet", RefinementOptions{1e-6, 1e-9, 2}), 1);
  ASSERT_EQ(*specimen.adapt(), 1);  // the second level
  EXPECT_GT(specimen.bodies()[1].count, 200);
  EXPECT_NEAR(total_mass(specimen), mass, 1e-9);
  EXPECT_EQ(specimen.position(*specimen.held(s.middle)), held);
  EXPECT_EQ(specimen.length(specimen.muscles()[0].fibres[1]), length);
  EXPECT_EQ(specimen.shocks().size(), 2U);
  run(specimen, 5);
  const Vec3 moved = specimen.position(*specimen.held(s.middle));
  // All levels are joined at once.
  EXPECT_EQ(*specimen.refine("sheet", std::nullopt), 1);
  EXPECT_EQ(specimen.bodies()[1].count, 48);
  EXPECT_FALSE(specimen.bodies()[1].refinement.has_value());
  EXPECT_NEAR(total_mass(specimen), mass, 1e-9);
  EXPECT_EQ(specimen.position(*specimen.held(s.middle)), moved);
  EXPECT_EQ(specimen.muscles()[0].fibres.size(), 2U);
  EXPECT_EQ(*specimen.refine("sheet", std::nullopt), 0);
  run(specimen, 20);
  EXPECT_TRUE(is_finite(specimen));
}

TEST(Specimen, EditsOfRefinedTissueAreOfItsBase) {
  Specimen specimen = with_sheet();
  ASSERT_EQ(*specimen.refine("sheet", RefinementOptions{1e-9, 0, 1}), 1) << "in triangles";
  specimen.set_position({1, 0}, specimen.position({1, 0}) + Vec3{-0.3, 0, 0});
  specimen.set_position({1, specimen.bodies()[1].flesh.sample(2, 0)}, {-2, -2, 0.5});
  ASSERT_EQ(*specimen.adapt(), 1);
  const int refined = specimen.bodies()[1].count;
  EXPECT_GT(refined, 48);
  const int base = *specimen.scale_growth("sheet", {}, 1.5);
  EXPECT_EQ(base, 48) << "samples of the base are counted";
  EXPECT_EQ(specimen.bodies()[1].count, refined) << "the resolution stays";
  for (const FleshSample& sample : specimen.bodies()[1].flesh.samples) EXPECT_EQ(sample.growth, 1.5);
  *specimen.adapt();
  EXPECT_LE(specimen.bodies()[1].count, 4 * 48) << "one level, not one more";
  ASSERT_GT(*specimen.remove("sheet", {Box3{{-3, -3, -3}, {-1, 3, 3}}, {}, 0, {}, -1}), 0);
  EXPECT_FALSE(specimen.bodies()[1].refinement.has_value());
}

TEST(Specimen, LimitsOfRefinementAreChecked) {
  Specimen specimen = with_sheet();
  for (const RefinementOptions& bad :
       {RefinementOptions{0.1, 0.2, 1}, RefinementOptions{kNan, 0, 1}, RefinementOptions{kInf, 0, 1},
        RefinementOptions{1, kNan, 1}, RefinementOptions{1, -1, 1}, RefinementOptions{1, 0, -1}}) {
    EXPECT_FALSE(static_cast<bool>(specimen.refine("sheet", bad)));
  }
  EXPECT_FALSE(static_cast<bool>(specimen.refine("other", RefinementOptions{})));
  EXPECT_EQ(*specimen.adapt(), 0);
}

// ---- collisions ----

Scene scene_with_ball() {
  Scene scene;
  Object ball = *make_primitive("sphere");
  ball.name = "ball";
  EXPECT_TRUE(static_cast<bool>(scene.add_object(std::move(ball))));
  scene.specimen = with_sheet();
  Collision collision;
  collision.object = scene.id_of("ball");
  collision.barrier = *barrier_of(scene, collision.object, RegionShape::sphere);
  collision.barrier.stiffness_n = 1000;
  EXPECT_TRUE(static_cast<bool>(scene.specimen.add_collision(collision)));
  return scene;
}

TEST(Specimen, CollisionsFollowTheirObjectAndKeepTheirConstants) {
  Scene scene = scene_with_ball();
  const int ball = scene.id_of("ball");
  ObjectTransform moved = scene.find(ball)->transform;
  moved.translation = {3, 4, 5};
  scene.set_transform(ball, moved);
  ASSERT_TRUE(static_cast<bool>(update_collisions(scene)));
  const Barrier& barrier = scene.specimen.collisions()[0].barrier;
  EXPECT_LT(distance(barrier.centre, {3, 4, 5}), 1e-12);
  EXPECT_EQ(barrier.stiffness_n, 1000);
  EXPECT_EQ(penetrations(scene.specimen)[0].depth, 0);
  EXPECT_TRUE(scene.remove_object("ball"));
  ASSERT_TRUE(static_cast<bool>(update_collisions(scene)));
  EXPECT_TRUE(scene.specimen.collisions().empty());
}

TEST(Specimen, ACollisionActsOnItsLayerAloneAndIsMeasuredThere) {
  Scene scene = scene_with_ball();  // the sheet cuts through the upper half of the ball
  Specimen& specimen = scene.specimen;
  Collision skin_only = specimen.collisions()[0];
  specimen.forget_collisions([](const Collision&) { return true; });
  skin_only.body = 1, skin_only.layer = 2;
  const double all_layers = 0.5 - std::hypot(1. / 6, 1. / 6);
  ASSERT_TRUE(static_cast<bool>(specimen.add_collision(skin_only)));
  EXPECT_LT(penetrations(specimen)[0].depth, all_layers - 0.02);
  ASSERT_TRUE(static_cast<bool>(specimen.scale_stiffness("sheet", {}, 0)));  // no spring pulls
  const std::vector<Vec3> before = specimen.state().position;
  run(specimen, 3, 0.001);
  for (std::size_t i = 0; i < 32; ++i) EXPECT_EQ(specimen.state().position[i], before[i]) << i;
  EXPECT_NE(specimen.state().position[32 + 5], before[32 + 5]);
}

// ---- state ----

TEST(Specimen, AStateOfAnotherTissueOrWithWildNumbersIsRefused) {
  Specimen specimen = with_sheet();
  const MotionState good = specimen.state();
  MotionState state = good;
  state.position.pop_back();
  EXPECT_FALSE(static_cast<bool>(specimen.set_state(state)));
  state = good;
  state.velocity.clear();
  EXPECT_FALSE(static_cast<bool>(specimen.set_state(state)));
  for (const double wild : {kNan, kInf, 1e308}) {
    state = good;
    state.position[3].y = wild;
    EXPECT_FALSE(static_cast<bool>(specimen.set_state(state)));
    state = good;
    state.velocity[3].y = wild;
    EXPECT_FALSE(static_cast<bool>(specimen.set_state(state)));
  }
  EXPECT_EQ(specimen.state().position, good.position);
  EXPECT_TRUE(static_cast<bool>(specimen.set_state(good)));
}

TEST(Specimen, GoesOnFromAStateToTheSameBits) {
  Swinging s;
  const MotionState kept = s.specimen.state();
  run(s.specimen, 30);
  const std::vector<Vec3> then = s.specimen.state().position;
  ASSERT_TRUE(static_cast<bool>(s.specimen.set_state(kept)));
  run(s.specimen, 30);
  EXPECT_EQ(s.specimen.state().position, then);
}

TEST(Specimen, WildNumbersAreRefusedWhereTheyAreGiven) {
  Specimen specimen = with_sheet();
  const SampleRef a = in_sheet(1, 0), b = in_sheet(1, 3);
  for (const double wild : {kNan, kInf, -kInf, -1.0}) {
    EXPECT_FALSE(static_cast<bool>(specimen.add_sample("s", {0, 0, 0}, wild, true)));
    EXPECT_FALSE(static_cast<bool>(specimen.add_shock(a, b, {.stiffness = wild})));
    EXPECT_FALSE(static_cast<bool>(specimen.add_shock(a, b, {.viscosity = wild})));
    EXPECT_FALSE(static_cast<bool>(specimen.add_fibre("m", a, b, {.cutoff = wild})));
    EXPECT_FALSE(static_cast<bool>(specimen.set_damping(wild)));
    EXPECT_FALSE(static_cast<bool>(specimen.scale_growth("sheet", {}, wild)));
    EXPECT_FALSE(static_cast<bool>(specimen.scale_stiffness("sheet", {}, wild)));
    EXPECT_FALSE(static_cast<bool>(specimen.add_flesh("other", sheet(), wild)));
  }
  for (const double wild : {kNan, kInf, 1e300}) {
    EXPECT_FALSE(static_cast<bool>(specimen.add_sample("s", {0, wild, 0}, 1, true)));
    EXPECT_FALSE(static_cast<bool>(specimen.set_gravity({wild, 0, 0})));
  }
  EXPECT_FALSE(static_cast<bool>(specimen.add_shock(a, a, {})));
  EXPECT_FALSE(static_cast<bool>(specimen.add_fibre("m", a, a, {})));
  EXPECT_FALSE(static_cast<bool>(specimen.add_fibre("a;b", a, b, {})));  // its drawing could not be named
  EXPECT_FALSE(static_cast<bool>(specimen.add_flesh("sheet", sheet(), 0)));
  EXPECT_TRUE(specimen.muscles().empty() && specimen.shocks().empty());
  EXPECT_FALSE(specimen.sample("s").has_value());
  EXPECT_EQ(specimen.bodies().size(), 2U);
}

TEST(Specimen, OverflowingFactorsLeaveTheTissueAsItWas) {
  Specimen specimen = with_sheet();
  for (int i = 0; i < 60; ++i) {
    static_cast<void>(specimen.scale_growth("sheet", {}, 1e6));
    static_cast<void>(specimen.scale_stiffness("sheet", {}, 1e6));
  }
  Context context;
  SimulationReport report;
  static_cast<void>(specimen.step(0, {0.01, Integrator::heun, 0}, report, context));
  EXPECT_TRUE(is_finite(specimen));
}

}  // namespace
}  // namespace turgor
