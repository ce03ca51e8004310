#include <gtest/gtest.h>

#include <cmath>

#include "turgor/dynamics/time_stepper.hpp"

namespace turgor {
namespace {

/// A mass on a Hookean spring that hangs from a fixed point: x'' = −ω² (x + 10) − 2 γ x' along z.
struct Oscillator {
  double mass = 0.8, stiffness_n = 0.3, length_mm = 10, damping = 0;

  [[nodiscard]] double square() const { return stiffness_n / (length_mm * mass); }
  [[nodiscard]] double decay() const { return 0.5 * damping / mass; }
  [[nodiscard]] TimeStepper stepper() const {
    MotionModel model;
    model.network.rest = {{0, 0, 0}, {0, 0, -length_mm}};
    model.network.mass_g = {mass, mass};
    model.network.springs = {{0, 1, length_mm, stiffness_n, SpringLaw::hookean, SpringKind::fibre}};
    model.mobile = {0, 1};
    model.damping_g_ms = damping;
    auto stepper = TimeStepper::prepare(std::move(model));
    EXPECT_TRUE(static_cast<bool>(stepper));
    return *std::move(stepper);
  }
  /// The distance from rest, from 2 mm and standing still.
  [[nodiscard]] double exact(double t) const {
    const double w = std::sqrt(square() - decay() * decay());
    return 2 * std::exp(-decay() * t) * (std::cos(w * t) + decay() / w * std::sin(w * t));
  }
  [[nodiscard]] double speed(double t) const { return (exact(t + 1e-5) - exact(t - 1e-5)) / 2e-5; }
};

MotionState displaced(const TimeStepper& stepper, double by, double speed) {
  MotionState state = stepper.rest();
  state.position[1].z += by;
  state.velocity[1].z = speed;
  return state;
}

void step(const TimeStepper& stepper, MotionState& state, double dt) {
  Context context;
  const auto done = stepper.step(state, dt, Integrator::verlet, context);
  ASSERT_TRUE(static_cast<bool>(done)) << done.error().message();
  ASSERT_EQ(done->sub_steps, 1);
}

TEST(Verlet, IsOfSecondOrderWithAndWithoutDamping) {
  for (const double damping : {0.0, 0.02}) {
    Oscillator o;
    o.damping = damping;
    const TimeStepper stepper = o.stepper();
    const auto error = [&](int steps) {
      const double t = 70, dt = t / steps;
      MotionState state = displaced(stepper, 2, o.speed(-0.5 * dt));
      for (int i = 0; i < steps; ++i) step(stepper, state, dt);
      return std::abs(state.position[1].z + o.length_mm - o.exact(t));
    };
    EXPECT_NEAR(std::log2(error(100) / error(200)), 2, 0.1);
    EXPECT_LT(error(200), 5e-3);
  }
}

// (x₊ − 2x + x₋)/dt² = −ω² x − c/m (x₊ − x₋)/2dt, step by step.
TEST(Verlet, FollowsItsRecurrence) {
  Oscillator o;
  o.damping = 0.05;
  const TimeStepper stepper = o.stepper();
  const double dt = 3, a = o.decay() * dt;
  MotionState state = displaced(stepper, 2, 0);
  double before = 2, now = 2;
  for (int i = 0; i < 50; ++i) {
    const double next = (2 * now - (1 - a) * before - dt * dt * o.square() * now) / (1 + a);
    before = now, now = next;
    step(stepper, state, dt);
    EXPECT_NEAR(state.position[1].z + o.length_mm, now, 1e-12);
  }
}

TEST(Verlet, KeepsTheEnergyOfAnUndampedOscillatorWithinBounds) {
  const Oscillator o;
  const TimeStepper stepper = o.stepper();
  const double dt = 0.9 * stepper.stable_step_ms(stepper.rest(), Integrator::verlet);
  MotionState state = displaced(stepper, 2, 0);
  // What the leapfrog keeps exactly: with v on both sides of x, ½ m v₋ v₊ + E(x).
  double first = 0;
  for (int i = 0; i < 20'000; ++i) {
    const double x = state.position[1].z + o.length_mm, v = state.velocity[1].z;
    step(stepper, state, dt);
    const double kept = 0.5 * o.mass * v * state.velocity[1].z + 0.5 * o.mass * o.square() * x * x;
    if (i == 0) first = kept;
    ASSERT_NEAR(kept, first, 1e-9 * first) << i;
  }
}

TEST(Verlet, DampingNeverLimitsTheStep) {
  Oscillator o;
  const double free = o.stepper().stable_step_ms(o.stepper().rest(), Integrator::verlet);
  o.damping = 100;
  const TimeStepper stepper = o.stepper();
  EXPECT_DOUBLE_EQ(stepper.stable_step_ms(stepper.rest(), Integrator::verlet), free);
  EXPECT_LT(stepper.stable_step_ms(stepper.rest(), Integrator::euler), 0.1 * free);
  MotionState state = displaced(stepper, 2, 0);
  for (int i = 0; i < 100; ++i) step(stepper, state, 0.99 * free);
  EXPECT_GT(state.position[1].z + o.length_mm, 0);
  EXPECT_LT(state.position[1].z + o.length_mm, 2);
}

TEST(Verlet, TakesSubStepsWhereAskedForMoreThanIsStable) {
  const Oscillator o;
  const TimeStepper stepper = o.stepper();
  MotionState state = displaced(stepper, 2, 0);
  Context context;
  const auto done = stepper.step(state, 700, Integrator::verlet, context);
  ASSERT_TRUE(static_cast<bool>(done));
  EXPECT_GT(done->sub_steps, 10);
  EXPECT_LT(std::abs(state.position[1].z + o.length_mm), 2.6);
}

}  // namespace
}  // namespace turgor
