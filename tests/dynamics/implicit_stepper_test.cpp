#include "turgor/dynamics/implicit_stepper.hpp"

#include <gtest/gtest.h>

#include <limits>

#include "support/largest_distance.hpp"
#include "support/lattice_solid.hpp"
#include "support/soft_blocks.hpp"
#include "turgor/core/parallel.hpp"
#include "turgor/tissue/network_energy.hpp"

namespace turgor {
namespace {

using support::largest_distance;
using support::Lattice;

constexpr double kGravity = 0.00980665;  // mm/ms²
const Lattice kBar{2, 2, 6, 5.0, {0.05, 0.4, 1e-3, 0.2}};

ImplicitStepper prepared(const MotionModel& model) {
  Context context;
  auto stepper = ImplicitStepper::prepare(model, context);
  EXPECT_TRUE(static_cast<bool>(stepper)) << (stepper ? "" : stepper.error().message());
  return *std::move(stepper);
}

ImplicitReport stepped(ImplicitStepper& stepper, MotionState& state, double dt, double residual = 1e-5) {
  Context context;
  const auto report = stepper.step(state, dt, context, residual);
  EXPECT_TRUE(static_cast<bool>(report)) << (report ? "" : report.error().message());
  return report ? *report : ImplicitReport{};
}

MotionState at_rest(const SpringNetwork& network) {
  return {network.rest, std::vector<Vec3>(network.rest.size()), 0};
}

MotionModel mass_on_a_spring() {
  MotionModel model;
  model.network.rest = {{0, 0, 0}, {0, 0, -10}};
  model.network.mass_g = {1, 2};
  model.network.springs.push_back({0, 1, 10, 5, SpringLaw::hookean, SpringKind::membrane});
  model.mobile = {0, 1};
  return model;
}

// The lowest layer fixed.
MotionModel standing_bar(const Lattice& lattice) {
  MotionModel model;
  model.network = support::lattice_network(lattice);
  for (const Vec3& p : model.network.rest) model.mobile.push_back(static_cast<char>(p.z > 0));
  model.gravity_mm_ms2 = {0, 0, -kGravity};
  return model;
}

TEST(ImplicitStepper, AMassOnASpringFollowsTheRecurrenceOfImplicitEuler) {
  MotionModel model = mass_on_a_spring();
  model.gravity_mm_ms2 = {0, 0, -kGravity};
  model.damping_g_ms = 0.01;
  ImplicitStepper stepper = prepared(model);
  MotionState state = at_rest(model.network);
  state.position[1].z -= 1;
  const double dt = 0.7, mass = 2, k = 5.0 / 10, c = 0.01;
  double u = -1, v = 0;  // (m + c dt + k dt²) v' = m v + dt (m g − k u)
  for (int i = 0; i < 50; ++i) {
    stepped(stepper, state, dt, 1e-13);
    v = (mass * v + dt * (-mass * kGravity - k * u)) / (mass + c * dt + k * dt * dt);
    u += dt * v;
    ASSERT_NEAR(state.position[1].z, -10 + u, 1e-9);
    ASSERT_NEAR(state.velocity[1].z, v, 1e-9);
  }
  EXPECT_NEAR(state.time_ms, 35, 1e-12);
  EXPECT_EQ(state.position[0], Vec3{}) << "it is held";
}

TEST(ImplicitStepper, FreeFallIsThatOfImplicitEuler) {
  MotionModel model;
  model.network = support::lattice_network({1, 1, 1, 5, {}});
  model.network.rest.push_back({50, 0, 0});  // a point without any element falls along
  model.network.mass_g.push_back(0.3);
  model.gravity_mm_ms2 = {0, 0, -kGravity};
  ImplicitStepper stepper = prepared(model);
  MotionState state = at_rest(model.network);
  const Vec3 start{0.01, 0, 0.02};
  for (Vec3& v : state.velocity) v = start;
  const double dt = 10;
  for (int n = 1; n <= 5; ++n) {
    stepped(stepper, state, dt, 1e-12);
    const Vec3 fallen{start.x * n * dt, 0, start.z * n * dt - kGravity * dt * dt * 0.5 * n * (n + 1)};
    for (std::size_t p = 0; p < state.position.size(); ++p)
      EXPECT_LT(distance(state.position[p], model.network.rest[p] + fallen), 1e-9);
  }
}

TEST(ImplicitStepper, EnergyNeverGrowsWithoutLoads) {
  MotionModel model = standing_bar(kBar);
  model.gravity_mm_ms2 = {};
  const NetworkEnergy energy = *NetworkEnergy::prepare(model.network);
  for (const double dt : {1.0, 20.0}) {
    ImplicitStepper stepper = prepared(model);
    MotionState state = at_rest(model.network);
    for (Vec3& p : state.position) p.x += 0.01 * p.z * p.z;
    const auto total = [&] {
      double sum = energy.value(state.position);
      for (std::size_t p = 0; p < state.velocity.size(); ++p)
        sum += 0.5 * model.network.mass_g[p] * squared_length(state.velocity[p]);
      return sum;
    };
    double before = total();
    const double first = before;
    for (int i = 0; i < 20; ++i) {
      EXPECT_TRUE(stepped(stepper, state, dt).converged);
      const double after = total();
      EXPECT_LE(after, before + 1e-9 * first) << i;
      before = after;
    }
    EXPECT_LT(before, 0.9 * first);
  }
}

TEST(ImplicitStepper, LongStepsTendToTheEquilibriumThatSettleFinds) {
  const MotionModel model = standing_bar(kBar);
  ImplicitStepper stepper = prepared(model);
  MotionState moving = at_rest(model.network), settled = moving;
  Context context;
  EquilibriumOptions options;
  options.relative_residual = 1e-9;
  const auto result = stepper.settle(settled, options, context);
  ASSERT_TRUE(static_cast<bool>(result));
  EXPECT_TRUE(result->converged);
  EXPECT_GT(largest_distance(settled.position, model.network.rest), 0.05);
  for (int i = 0; i < 4; ++i) stepped(stepper, moving, 1e5, 1e-9);
  EXPECT_LT(largest_distance(moving.position, settled.position), 1e-5);
  // The same as without a stepper.
  PrescribedMotion motion;
  for (std::size_t p = 0; p < model.mobile.size(); ++p) {
    if (model.mobile[p] == 0) motion.fixed.push_back(static_cast<int>(p));
  }
  Loads loads;
  loads.gravity_mm_ms2 = model.gravity_mm_ms2;
  const auto direct = solve_equilibrium(model.network, motion, loads, options, context);
  ASSERT_TRUE(static_cast<bool>(direct));
  EXPECT_LT(largest_distance(direct->positions, settled.position), 1e-6);
}

TEST(ImplicitStepper, ADrivenFibreBarriersAndGrabsActFromTheNextStepOn) {
  MotionModel model = mass_on_a_spring();
  ImplicitStepper stepper = prepared(model);
  MotionState state = at_rest(model.network);
  Context context;
  EquilibriumOptions sharp;
  sharp.relative_residual = 1e-11;
  ASSERT_TRUE(static_cast<bool>(stepper.set_rest_length(0, 6)));
  ASSERT_TRUE(static_cast<bool>(stepper.settle(state, sharp, context)));
  EXPECT_NEAR(state.position[1].z, -6, 1e-9);
  // k_grab (target − z) = k (z + 6), k = 5/6 N/mm at the new length.
  ASSERT_TRUE(static_cast<bool>(stepper.set_grabs({{{1}, {1.0}, {0, 0, -9}, 0.4, 1e9}})));
  ASSERT_TRUE(static_cast<bool>(stepper.settle(state, sharp, context)));
  EXPECT_NEAR(state.position[1].z, -(0.4 * 9 + 5) / (0.4 + 5.0 / 6), 1e-9);
  ASSERT_TRUE(static_cast<bool>(stepper.set_grabs({})));
  Barrier floor;
  floor.shape = Barrier::Shape::plane;
  floor.plane = {{0, 0, -1}, 3};  // keeps below z = −3
  floor.stiffness_n = 2;
  ASSERT_TRUE(static_cast<bool>(stepper.set_barriers({floor})));
  ASSERT_TRUE(static_cast<bool>(stepper.set_rest_length(0, 1)));
  ASSERT_TRUE(static_cast<bool>(stepper.settle(state, sharp, context)));
  EXPECT_NEAR(state.position[1].z, -(5.0 * 1 + 2 * 3) / 7, 1e-9) << "5 (L − 1) = 2 (3 − L)";
}

TEST(ImplicitStepper, ErrorsAndCancelLeaveTheStateAsItWas) {
  const MotionModel model = standing_bar(kBar);
  ImplicitStepper stepper = prepared(model);
  MotionState state = at_rest(model.network);
  const MotionState before = state;
  Context context, stopped(nullptr, nullptr, [] { return true; });
  constexpr double inf = std::numeric_limits<double>::infinity();
  for (const double dt : {0.0, -1.0, inf, std::numeric_limits<double>::quiet_NaN()})
    EXPECT_FALSE(static_cast<bool>(stepper.step(state, dt, context)));
  const auto cancelled = stepper.step(state, 1, stopped);
  ASSERT_FALSE(static_cast<bool>(cancelled));
  EXPECT_EQ(cancelled.error().kind, ErrorKind::cancelled);
  EXPECT_FALSE(static_cast<bool>(stepper.settle(state, {}, stopped)));
  MotionState fast = state;
  fast.velocity[40] = {1e300, 0, 0};
  for (const double dt : {1e-200, 1e200}) EXPECT_FALSE(static_cast<bool>(stepper.step(fast, dt, context)));
  MotionState small = state;
  small.velocity.pop_back();
  EXPECT_FALSE(static_cast<bool>(stepper.step(small, 1, context)));
  EXPECT_FALSE(static_cast<bool>(stepper.set_rest_length(0, 1))) << "there are no springs";
  EXPECT_FALSE(static_cast<bool>(stepper.set_grabs({{{-1}, {1.0}, {}, 1, 1}})));
  Barrier unsized;
  unsized.radius_mm = -1;
  EXPECT_FALSE(static_cast<bool>(stepper.set_barriers({unsized})));
  EXPECT_EQ(state.position, before.position);
  EXPECT_EQ(state.velocity, before.velocity);
  EXPECT_EQ(state.time_ms, 0);
}

TEST(ImplicitStepper, WarnsOfWhatDoesNotAct) {
  MotionModel model = mass_on_a_spring();
  model.springs = {{0.1, 20, false}};
  Context context;
  ASSERT_TRUE(static_cast<bool>(ImplicitStepper::prepare(model, context)));
  EXPECT_EQ(context.notices().size(), 2u);
}

TEST(ImplicitStepper, LedPointsGoOnWithTheirVelocity) {
  const MotionModel model = standing_bar(kBar);
  ImplicitStepper stepper = prepared(model);
  MotionState state = at_rest(model.network);
  for (std::size_t p = 0; p < state.velocity.size(); ++p)
    if (model.mobile[p] == 0) state.velocity[p] = {0.1, 0, 0};
  for (int i = 0; i < 5; ++i) stepped(stepper, state, 10);
  for (std::size_t p = 0; p < state.velocity.size(); ++p) {
    if (model.mobile[p] == 0)
      EXPECT_LT(distance(state.position[p], model.network.rest[p] + Vec3{5, 0, 0}), 1e-9);
  }
}

// A block falls on one that is fixed, and lies on it with its weight.
TEST(ImplicitStepper, BodiesInContactComeToRestOnEachOther) {
  MotionModel model;
  support::Block below, above;
  below.mobile = false;
  above.lower = {0.3, 0.2, 5};
  support::add_block(model, below);
  const int first = support::add_block(model, above);
  model.contact->thickness_mm = 0.4;
  model.contact->stiffness_n_mm = 0.01;
  model.gravity_mm_ms2 = {0, 0, -kGravity};
  model.damping_g_ms = 1e-4;
  ImplicitStepper stepper = prepared(model);
  MotionState state = at_rest(model.network);
  for (int i = 0; i < 300; ++i) stepped(stepper, state, 4);
  const double weight = kGravity * support::mass(model, first, static_cast<int>(model.network.rest.size()));
  std::vector<double> inverse_mass(model.network.rest.size(), 1);
  const auto contact = SurfaceContact::prepare(*model.contact, model.network.rest, inverse_mass);
  ASSERT_TRUE(static_cast<bool>(contact));
  const ContactMeasures measures = contact->measure(state.position);
  ASSERT_EQ(measures.pairs.size(), 1u);
  EXPECT_NEAR(measures.pairs[0].normal_n / weight, 1, 0.1);
  double speed = 0;
  for (const Vec3& v : state.velocity) speed = std::max(speed, length(v));
  EXPECT_LT(speed, 1e-3);
}

TEST(ImplicitStepper, HasTheSameBitsOnOneAndTwoThreads) {
  const MotionModel model = standing_bar({6, 6, 12, 5, kBar.material});
  const auto run = [&](int threads) {
    set_thread_count(threads);
    ImplicitStepper stepper = prepared(model);
    MotionState state = at_rest(model.network);
    for (int i = 0; i < 3; ++i) stepped(stepper, state, 10);
    return state.position;
  };
  const auto one = run(1), two = run(2);
  set_thread_count(0);
  EXPECT_EQ(one, two);
}

}  // namespace
}  // namespace turgor
