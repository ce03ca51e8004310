// Relaxing springs, driven fibres, and steps chosen by their error.
#include <gtest/gtest.h>

#include <limits>

#include "support/layered_slab.hpp"
#include "turgor/core/parallel.hpp"
#include "turgor/core/random.hpp"
#include "turgor/dynamics/time_stepper.hpp"

namespace turgor {
namespace {

TimeStepper prepared(MotionModel model) {
  auto stepper = TimeStepper::prepare(std::move(model));
  EXPECT_TRUE(static_cast<bool>(stepper)) << (stepper ? "" : stepper.error().message());
  return *std::move(stepper);
}

/// A spring of 10 mm down from a fixed point to a weight.
MotionModel hanging(double mass_g, double stiffness_n) {
  MotionModel model;
  model.network.rest = {{0, 0, 0}, {0, 0, -10}};
  model.network.mass_g = {1, mass_g};
  model.network.springs = {{0, 1, 10.0, stiffness_n, SpringLaw::linear, SpringKind::membrane}};
  model.mobile = {0, 1};
  return model;
}

TEST(Relaxation, ASpringHeldAtALengthFollowsThePronySeries) {
  // Held by the mass of a mountain.
  MotionModel model = hanging(1e20, 0.8);
  model.springs = {{0, 0, true}};
  model.relaxation = {{{0.3, 5}, {0.2, 70}, {0.1, 900}}};
  const TimeStepper stepper = prepared(model);
  for (const Integrator integrator : {Integrator::euler, Integrator::heun}) {
    MotionState state = stepper.rest();
    state.position[1].z = -12;
    std::vector<Vec3> f(2);
    Context context;
    for (const double dt : {1.0, 3.0, 40.0, 500.0, 2000.0}) {
      ASSERT_TRUE(static_cast<bool>(stepper.step(state, dt, integrator, context)));
      stepper.forces(state, f);
      double left = 1;
      for (const Relaxation& r : model.relaxation) left -= r.share * -std::expm1(-state.time_ms / r.time_ms);
      EXPECT_NEAR(f[1].z, 0.8 * 0.2 * left, 1e-12) << state.time_ms;
    }
  }
}

TEST(Relaxation, HeunIsOfSecondOrderWhereALoadStretchesASpringThatRelaxes) {
  // Stretched throughout, the standard linear solid: m x'' = -k (x - q), q' = (g x - q)/τ, solved finely.
  MotionModel model = hanging(0.8, 0.3);
  model.springs = {{0, 0, true}};
  model.relaxation[1] = {0.4, 12};
  const TimeStepper stepper = prepared(model);
  const double t = 7, k = 0.3 / 10;
  double x = 1, v = 0, q = 0;  // pulled by 1 mm, q in mm
  const int fine = 30'000;
  for (int i = 0; i < fine; ++i) {  // midpoint rule, error (t/fine)²
    const double h = t / fine;
    const double xm = x + 0.5 * h * v, vm = v - 0.5 * h * k / 0.8 * (x - q),
                 qm = q + 0.5 * h * (0.4 * x - q) / 12;
    x += h * vm, v -= h * k / 0.8 * (xm - qm), q += h * (0.4 * xm - qm) / 12;
  }
  const auto error = [&](int steps, Integrator integrator) {
    MotionState state = stepper.rest();
    state.position[1].z = -11;
    Context context;
    for (int i = 0; i < steps; ++i)
      EXPECT_TRUE(static_cast<bool>(stepper.step(state, t / steps, integrator, context)));
    return std::abs(-10 - state.position[1].z - x);
  };
  // As long as the weight has not passed the rest length, where the law changes.
  ASSERT_GT(x, 0);
  EXPECT_NEAR(std::log2(error(200, Integrator::euler) / error(400, Integrator::euler)), 1, 0.15);
  EXPECT_NEAR(std::log2(error(200, Integrator::heun) / error(400, Integrator::heun)), 2, 0.15);
}

TEST(Relaxation, DissipatesAndLeavesTheStateOfOthersEmpty) {
  MotionModel model = hanging(0.8, 0.3);
  EXPECT_TRUE(prepared(model).rest().relaxed.empty());
  model.springs = {{0, 0, true}};
  model.relaxation[0] = {0.5, 10};
  const TimeStepper stepper = prepared(model);
  MotionState state = stepper.rest();
  state.position[1].z = -13;
  Context context;
  double swing = 3;
  for (int period = 0; period < 5; ++period) {
    double farthest = 0;
    for (int i = 0; i < 700; ++i) {
      ASSERT_TRUE(static_cast<bool>(stepper.step(state, 0.1, Integrator::heun, context)));
      farthest = std::max(farthest, std::abs(state.position[1].z + 10));
    }
    if (period > 0) EXPECT_LT(farthest, swing) << period;
    swing = farthest;
  }
  EXPECT_LT(swing, 1);
}

TEST(Relaxation, HasTheSameBitsOnOneAndTwoThreadsAndKeepsMomentum) {
  support::SlabOptions options;
  options.nx = options.ny = 50;
  MotionModel model;
  model.network = support::make_slab(options).network;
  const std::size_t n = model.network.rest.size();
  model.network.mass_g.assign(n, 0.05);
  for (std::size_t i = 0; i < model.network.springs.size(); ++i)
    model.springs.push_back({0.01, 0, i % 2 == 0});
  model.relaxation[0] = {0.4, 3};
  const TimeStepper stepper = prepared(model);
  MotionState start = stepper.rest();
  const RandomStream random(4);
  for (std::size_t i = 0; i < n; ++i)
    start.velocity[i] = Vec3{random.normal(3 * i), random.normal(3 * i + 1), random.normal(3 * i + 2)} * 0.05;
  const auto momentum = [&](const MotionState& s) {
    Vec3 sum;
    for (const Vec3& v : s.velocity) sum += v * 0.05;
    return sum;
  };
  const auto at = [&](int threads, const auto& move) {
    set_thread_count(threads);
    MotionState state = start;
    Context context;
    TimeStepper::Workspace w;
    for (int i = 0; i < 5; ++i) move(state, context, w);
    set_thread_count(0);
    EXPECT_LT(length(momentum(state) - momentum(start)), 1e-11);
    return state;
  };
  const auto same = [&](const auto& move) {
    const MotionState one = at(1, move), two = at(2, move);
    EXPECT_TRUE(one.position == two.position && one.velocity == two.velocity && one.relaxed == two.relaxed);
    EXPECT_FALSE(one.position == start.position);
  };
  for (const Integrator integrator : {Integrator::euler, Integrator::heun}) {
    same([&](MotionState& state, Context& context, TimeStepper::Workspace& w) {
      EXPECT_TRUE(static_cast<bool>(stepper.step(state, 1, integrator, context, w)));
    });
  }
  same([&](MotionState& state, Context& context, TimeStepper::Workspace& w) {
    EXPECT_TRUE(static_cast<bool>(stepper.advance(state, 0.1, {1e-3, 1e-6, 10}, context, w)));
  });
}

TEST(Relaxation, BadOnesAreNamed) {
  const auto refused = [](Relaxation r) {
    MotionModel model = hanging(1, 1);
    model.relaxation[2] = r;
    return !TimeStepper::prepare(model);
  };
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_TRUE(refused({1, 5}));
  EXPECT_TRUE(refused({-0.1, 5}));
  EXPECT_TRUE(refused({nan, 5}));
  EXPECT_TRUE(refused({0.5, 0}));
  EXPECT_TRUE(refused({0.5, nan}));
  EXPECT_FALSE(refused({0.5, 5}));
}

TEST(TimeStepper, AFibreIsDrivenByItsRestLength) {
  MotionModel model = hanging(1, 0.5);
  TimeStepper stepper = prepared(model);
  std::vector<Vec3> f(2);
  ASSERT_TRUE(static_cast<bool>(stepper.set_rest_length(0, 8)));
  EXPECT_EQ(stepper.model().network.springs[0].rest_length_mm, 8);
  stepper.forces(stepper.rest(), f);
  EXPECT_NEAR(f[1].z, 0.5 * (10.0 / 8 - 1), 1e-15);
  EXPECT_NEAR(stepper.potential(model.network.rest), 0.5 * 8 * 0.5 * 0.25 * 0.25, 1e-15);
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(static_cast<bool>(stepper.set_rest_length(1, 8)));
  EXPECT_FALSE(static_cast<bool>(stepper.set_rest_length(-1, 8)));
  EXPECT_FALSE(static_cast<bool>(stepper.set_rest_length(0, 0)));
  EXPECT_FALSE(static_cast<bool>(stepper.set_rest_length(0, nan)));
  EXPECT_EQ(stepper.model().network.springs[0].rest_length_mm, 8);
}

TEST(TimeStepper, WhatAWorkspaceHoldsDoesNotChangeResults) {
  MotionModel model = hanging(0.8, 0.3);
  model.gravity_mm_ms2 = {0, 0, -0.0098};
  const TimeStepper stepper = prepared(model);
  Context context;
  for (const Integrator integrator : {Integrator::euler, Integrator::heun}) {
    TimeStepper::Workspace kept;
    MotionState one = stepper.rest(), two = one;
    for (const double dt : {3.0, 80.0, 0.5, 200.0}) {
      const auto fresh = stepper.step(one, dt, integrator, context);
      const auto used = stepper.step(two, dt, integrator, context, kept);
      ASSERT_TRUE(fresh && used);
      EXPECT_EQ(fresh->sub_steps, used->sub_steps);
      EXPECT_TRUE(one.position == two.position && one.velocity == two.velocity);
    }
  }
}

TEST(TimeStepper, HeunAtItsLongestStepDoesNotGrow) {
  // A chain whose highest modes ring. Energy swings within a period, hence the most of 40 steps is compared.
  MotionModel model;
  for (int i = 0; i < 40; ++i) model.network.rest.push_back({static_cast<double>(i), 0, 0});
  model.network.mass_g.assign(40, 0.01);
  for (int i = 0; i + 1 < 40; ++i)
    model.network.springs.push_back({i, i + 1, 1.0, 2.0, SpringLaw::linear, SpringKind::membrane});
  for (const double damping : {0.0, 0.01, 0.05, 0.2, 1.0, 5.0}) {
    model.damping_g_ms = damping;
    const TimeStepper stepper = prepared(model);
    MotionState state = stepper.rest();
    const double dt = stepper.stable_step_ms(state, Integrator::heun);
    for (std::size_t i = 0; i < 40; ++i) state.velocity[i].x = i % 2 == 0 ? 0.01 : -0.01;
    Context context;
    double before = 0;
    for (int block = 0; block < 50; ++block) {
      double most = 0;
      for (int i = 0; i < 40; ++i) {
        ASSERT_TRUE(static_cast<bool>(stepper.step(state, dt, Integrator::heun, context)));
        most = std::max(most, stepper.kinetic(state.velocity) + stepper.potential(state.position));
      }
      if (block > 0) EXPECT_LT(most, before * (damping > 0 ? 1.0 : 1.1)) << damping << ' ' << block;
      if (block == 0 || damping > 0) before = most;
    }
  }
}

TEST(TimeStepper, WhatEnergyIsLostIsWhatDampingAndViscosityTake) {
  MotionModel model = hanging(0.8, 0.3);
  model.springs = {{0.003, 0}};
  model.damping_g_ms = 0.004;
  model.gravity_mm_ms2 = {0, 0, -0.0098};
  const TimeStepper stepper = prepared(model);
  MotionState state = stepper.rest();
  Context context;
  const auto energy = [&] { return stepper.potential(state.position) + stepper.kinetic(state.velocity); };
  const double before = energy();
  double lost = 0;
  for (int i = 0; i < 4000; ++i) {
    const double v = state.velocity[1].z;
    ASSERT_TRUE(static_cast<bool>(stepper.step(state, 0.02, Integrator::heun, context)));
    const double mean = 0.5 * (v + state.velocity[1].z);
    lost += (0.004 + 0.003) * mean * mean * 0.02;
  }
  EXPECT_GT(lost, 1e-4);
  EXPECT_NEAR(before - energy(), lost, 1e-4 * lost);
}

TEST(Advance, KeepsToTheClosedFormOfAnOscillator) {
  MotionModel model = hanging(0.8, 0.3);
  model.springs = {{0.002, 0}};
  model.gravity_mm_ms2 = {0, 0, -0.0098};
  const TimeStepper stepper = prepared(model);
  const double sag = 0.8 * 0.0098 * 10 / 0.3, decay = 0.5 * 0.002 / 0.8, t = 200;
  const double frequency = std::sqrt(0.3 / (10 * 0.8) - decay * decay);
  const double x =
      std::exp(-decay * t) * sag * (std::cos(frequency * t) + decay / frequency * std::sin(frequency * t));
  int last = 0;
  for (const double tolerance : {1e-3, 1e-4, 1e-5}) {
    MotionState state = stepper.rest();
    Context context;
    const auto report = stepper.advance(state, t, {tolerance, 1e-6, 100}, context);
    ASSERT_TRUE(static_cast<bool>(report)) << report.error().message();
    EXPECT_DOUBLE_EQ(state.time_ms, t);
    // The tolerance is that of one step, and the errors of steps add up.
    EXPECT_NEAR(state.position[1].z, x - 10 - sag, std::min(25, report->accepted) * tolerance) << tolerance;
    EXPECT_GT(report->accepted, last);
    EXPECT_EQ(report->beyond_tolerance, 0);
    last = report->accepted;
  }
}

TEST(Advance, GoesInLongStepsWhereItIsQuietAndShortOnesWhereItIsNot) {
  // A drop onto a stiff floor with much damping: quiet before and long after.
  MotionModel model;
  model.network.rest = {{0, 0, 5}};
  model.network.mass_g = {1};
  model.gravity_mm_ms2 = {0, 0, -0.0098};
  model.damping_g_ms = 0.3;
  Barrier floor;
  floor.shape = Barrier::Shape::plane;
  floor.stiffness_n = 5;
  model.barriers = {floor};
  const TimeStepper stepper = prepared(model);
  MotionState state = stepper.rest();
  Context context;
  const auto report = stepper.advance(state, 2000, {1e-4, 1e-6, 50}, context);
  ASSERT_TRUE(static_cast<bool>(report)) << report.error().message();
  EXPECT_GT(report->longest_ms, 4 * report->shortest_ms);
  EXPECT_NEAR(state.position[0].z, -0.0098 / 5, 1e-6);
  const auto again = stepper.advance(state, 50, {1e-4, 1e-6, 50}, context);
  ASSERT_TRUE(static_cast<bool>(again));
  EXPECT_EQ(again->rejected, 0) << "at rest nothing is in error";
}

TEST(Advance, RejectsAStepThatIsTooLongAndTellsOfOnesThatCannotBeShorter) {
  MotionModel model = hanging(1, 0.001);
  model.gravity_mm_ms2 = {0, 0, -0.01};
  const TimeStepper stepper = prepared(model);
  Context context;
  MotionState state = stepper.rest();
  const auto careful = stepper.advance(state, 100, {1e-3, 1e-6, 100}, context);
  ASSERT_TRUE(static_cast<bool>(careful));
  EXPECT_GT(careful->rejected, 0);
  state = stepper.rest();
  const auto forced = stepper.advance(state, 100, {1e-9, 5, 100}, context);
  ASSERT_TRUE(static_cast<bool>(forced));
  EXPECT_GT(forced->beyond_tolerance, 0);
}

TEST(Advance, WildNumbersEndInAnErrorOrInFiniteStates) {
  MotionModel model = hanging(0.8, 0.3);
  const TimeStepper stepper = prepared(model);
  Context context;
  const double nan = std::numeric_limits<double>::quiet_NaN(), inf = std::numeric_limits<double>::infinity();
  MotionState state = stepper.rest();
  for (const double bad : {nan, inf, 0.0, -1.0}) {
    EXPECT_FALSE(static_cast<bool>(stepper.advance(state, bad, {}, context)));
    EXPECT_FALSE(static_cast<bool>(stepper.advance(state, 1, {bad, 1e-6, 1}, context)));
    EXPECT_FALSE(static_cast<bool>(stepper.advance(state, 1, {1e-3, bad, 1}, context)));
    EXPECT_FALSE(static_cast<bool>(stepper.advance(state, 1, {1e-3, 1e-6, bad}, context)));
  }
  EXPECT_FALSE(static_cast<bool>(stepper.advance(state, 1e300, {}, context))) << "leaves or takes too long";
  EXPECT_TRUE(state.position == stepper.rest().position);
  state.velocity[1].z = nan;
  const MotionState before = state;
  EXPECT_FALSE(static_cast<bool>(stepper.advance(state, 1, {1e-3, 1e-3, 1}, context)));
  EXPECT_FALSE(static_cast<bool>(stepper.step(state, 1, Integrator::heun, context)));
  state.velocity[1].z = 1e200;
  EXPECT_FALSE(static_cast<bool>(stepper.step(state, 1, Integrator::euler, context)));
}

}  // namespace
}  // namespace turgor
