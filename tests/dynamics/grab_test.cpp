#include "turgor/dynamics/grab.hpp"

#include <gtest/gtest.h>

#include <functional>
#include <limits>

#include "turgor/core/random.hpp"
#include "turgor/dynamics/time_stepper.hpp"

namespace turgor {
namespace {

const std::vector<Vec3> kPoints = {{0, 0, 0}, {4, 0, 1}, {0, 3, 0}, {1, 1, 5}};

Grab hand(const Vec3& target) {
  Grab grab;
  grab.points = {2, 0, 3};
  grab.weights = {0.5, 0.2, 0.3};
  grab.target = target;
  grab.stiffness_n_mm = 0.7;
  grab.limit_n = 2;
  return grab;
}

/// Four points with springs between all of them.
MotionModel tetrahedron() {
  MotionModel model;
  model.network.rest = kPoints;
  model.network.mass_g = {1, 2, 1.5, 0.5};
  for (int a = 0; a < 4; ++a)
    for (int b = 0; b < a; ++b) {
      const double rest = distance(kPoints[a], kPoints[b]);
      model.network.springs.push_back({a, b, rest, 1, SpringLaw::hookean, SpringKind::membrane});
    }
  return model;
}

TEST(Grab, ForceIsTheNegativeGradientOfTheEnergyBelowAndAboveTheLimit) {
  const RandomStream random(3);
  int limited = 0;
  for (std::uint64_t i = 0; i < 40; ++i) {
    const Grab grab =
        hand(Vec3{random.uniform(3 * i), random.uniform(3 * i + 1), random.uniform(3 * i + 2)} * 6.0);
    const GrabResponse r = respond(grab, kPoints);
    limited += length(r.force) > 2 - 1e-12 ? 1 : 0;
    for (std::size_t j = 0; j < grab.points.size(); ++j) {
      for (int axis = 0; axis < 3; ++axis) {
        std::vector<Vec3> low = kPoints, high = kPoints;
        low[grab.points[j]][axis] -= 1e-5, high[grab.points[j]][axis] += 1e-5;
        const double slope = (respond(grab, high).energy - respond(grab, low).energy) / 2e-5;
        EXPECT_NEAR(r.force[axis] * grab.weights[j], -slope, 1e-8);
      }
    }
  }
  EXPECT_GT(limited, 5);
  EXPECT_LT(limited, 35);
}

TEST(Grab, GivesWayAtExactlyItsLimit) {
  for (const double far : {1.0, 2.0 / 0.7, 3.0, 1e3, 1e8}) {
    Grab grab = hand({});
    Vec3 mean;
    for (std::size_t j = 0; j < 3; ++j) mean += kPoints[grab.points[j]] * grab.weights[j];
    grab.target = mean + Vec3{0, 0, far};
    EXPECT_NEAR(length(respond(grab, kPoints).force), std::min(0.7 * far, 2.0), 1e-12 * (1 + far)) << far;
  }
  Grab at_target = hand({});
  at_target.points = {0}, at_target.weights = {1}, at_target.target = kPoints[0];
  EXPECT_EQ(respond(at_target, kPoints).force, Vec3{});
  EXPECT_EQ(respond(at_target, kPoints).energy, 0);
}

TEST(Grab, IsInThePotentialAndTheForcesOfTheStepper) {
  MotionModel model = tetrahedron();
  model.mobile = {1, 1, 0, 1};
  model.grabs = {hand({2, 2, 2}), hand({30, 0, 0})};
  const auto stepper = TimeStepper::prepare(model);
  ASSERT_TRUE(static_cast<bool>(stepper));
  MotionState state = stepper->rest();
  for (std::size_t i = 0; i < 4; ++i) state.position[i] += Vec3{0.1, -0.2, 0.3} * static_cast<double>(i * i);
  std::vector<Vec3> forces(4);
  stepper->forces(state, forces);
  EXPECT_EQ(forces[2], Vec3{});
  for (const int p : {0, 1, 3}) {
    for (int axis = 0; axis < 3; ++axis) {
      std::vector<Vec3> low = state.position, high = state.position;
      low[p][axis] -= 1e-5, high[p][axis] += 1e-5;
      EXPECT_NEAR(forces[p][axis], -(stepper->potential(high) - stepper->potential(low)) / 2e-5, 1e-7);
    }
  }
  EXPECT_NEAR(length(stepper->grab_force(state, 1)), 2, 1e-12);
  EXPECT_EQ(stepper->grab_force(state, 2), Vec3{});
}

TEST(Grab, PullsTheWholeByItsForceAlone) {
  MotionModel model = tetrahedron();
  model.grabs = {hand({100, 0, 0})};  // far: at the limit all along
  for (const Integrator integrator : {Integrator::euler, Integrator::heun}) {
    const auto stepper = TimeStepper::prepare(model);
    ASSERT_TRUE(static_cast<bool>(stepper));
    MotionState state = stepper->rest();
    Context context;
    Vec3 impulse;
    for (int i = 0; i < 200; ++i) {
      const Vec3 before = stepper->grab_force(state, 0);
      ASSERT_TRUE(static_cast<bool>(stepper->step(state, 0.01, integrator, context)));
      impulse += (before + stepper->grab_force(state, 0)) * 0.005;
    }
    Vec3 momentum;
    for (std::size_t i = 0; i < 4; ++i) momentum += state.velocity[i] * model.network.mass_g[i];
    EXPECT_LT(distance(momentum, impulse), 1e-4);
    EXPECT_GT(length(momentum), 3.9);
  }
}

TEST(Grab, HoldsAWeightWhereTheSpringBalancesItAndLosesAHeavierOne) {
  MotionModel model;
  model.network.rest = {{0, 0, 0}};
  model.network.mass_g = {100};
  model.gravity_mm_ms2 = {0, 0, -0.01};  // 1 N
  model.damping_g_ms = 20;
  Grab grab;
  grab.points = {0}, grab.weights = {1}, grab.stiffness_n_mm = 0.5, grab.limit_n = 1.5;
  model.grabs = {grab};
  auto stepper = TimeStepper::prepare(model);
  ASSERT_TRUE(static_cast<bool>(stepper));
  MotionState state = stepper->rest();
  Context context;
  TimeStepper::Workspace w;
  for (int i = 0; i < 500; ++i)
    ASSERT_TRUE(static_cast<bool>(stepper->step(state, 1, Integrator::heun, context, w)));
  EXPECT_NEAR(state.position[0].z, -2, 1e-5);
  EXPECT_NEAR(stepper->grab_force(state, 0).z, 1, 1e-5);
  grab.limit_n = 0.9;
  ASSERT_TRUE(static_cast<bool>(stepper->set_grabs({grab})));
  for (int i = 0; i < 500; ++i)
    ASSERT_TRUE(static_cast<bool>(stepper->step(state, 1, Integrator::heun, context, w)));
  EXPECT_LT(state.position[0].z, -3);
  EXPECT_NEAR(stepper->grab_force(state, 0).z, 0.9, 1e-12);
  ASSERT_TRUE(static_cast<bool>(stepper->set_grabs({})));
  std::vector<Vec3> forces(1);
  state.velocity[0] = {};
  stepper->forces(state, forces);
  EXPECT_EQ(forces[0].z, -1);
}

TEST(Grab, StiffOnesShortenTheStableStep) {
  MotionModel model;
  model.network.rest = {{0, 0, 0}};
  model.network.mass_g = {1};
  Grab grab;
  grab.points = {0}, grab.weights = {1}, grab.target = {1, 0, 0}, grab.stiffness_n_mm = 100;
  model.grabs = {grab};
  const auto stepper = TimeStepper::prepare(model);
  ASSERT_TRUE(static_cast<bool>(stepper));
  EXPECT_NEAR(stepper->stable_step_ms(stepper->rest(), Integrator::heun), 0.1, 1e-9);  // 1/ω
}

TEST(Grab, WildOnesAreNamed) {
  const auto message = [](const std::function<void(Grab&)>& damage) {
    Grab grab = hand({1, 2, 3});
    damage(grab);
    const auto valid = validate(grab, 4);
    return valid ? std::string{} : valid.error().message();
  };
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(message([](Grab&) {}), "");
  EXPECT_NE(message([](Grab& g) { g.points.clear(), g.weights.clear(); }), "");
  EXPECT_NE(message([](Grab& g) { g.weights.pop_back(); }), "");
  EXPECT_NE(message([](Grab& g) { g.points[1] = 4; }), "");
  EXPECT_NE(message([](Grab& g) { g.points[1] = -1; }), "");
  EXPECT_NE(message([](Grab& g) { g.weights[0] = 0.6; }), "");
  EXPECT_NE(message([](Grab& g) { g.weights = {1.5, -0.8, 0.3}; }), "");
  EXPECT_NE(message([&](Grab& g) { g.weights[0] = nan; }), "");
  EXPECT_NE(message([](Grab& g) { g.target.x = 1e308; }), "");
  EXPECT_NE(message([&](Grab& g) { g.stiffness_n_mm = nan; }), "");
  EXPECT_NE(message([](Grab& g) { g.stiffness_n_mm = -1; }), "");
  EXPECT_NE(message([](Grab& g) { g.limit_n = 0; }), "");
  EXPECT_NE(message([](Grab& g) { g.limit_n = std::numeric_limits<double>::infinity(); }), "");

  MotionModel model = tetrahedron();
  auto stepper = TimeStepper::prepare(model);
  ASSERT_TRUE(static_cast<bool>(stepper));
  Grab wrong = hand({});
  wrong.points[0] = 9;
  EXPECT_FALSE(static_cast<bool>(stepper->set_grabs({wrong})));
  model.grabs = {wrong};
  EXPECT_FALSE(static_cast<bool>(TimeStepper::prepare(model)));
}

}  // namespace
}  // namespace turgor
