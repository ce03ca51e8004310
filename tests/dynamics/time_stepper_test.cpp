#include "turgor/dynamics/time_stepper.hpp"

#include <gtest/gtest.h>

#include <limits>

#include "support/layered_slab.hpp"
#include "turgor/core/parallel.hpp"
#include "turgor/core/random.hpp"
#include "turgor/dynamics/equilibrium.hpp"

namespace turgor {
namespace {

constexpr std::array kIntegrators = {Integrator::euler, Integrator::heun};

TimeStepper prepared(MotionModel model) {
  auto stepper = TimeStepper::prepare(std::move(model));
  EXPECT_TRUE(static_cast<bool>(stepper)) << (stepper ? "" : stepper.error().message());
  return *std::move(stepper);
}

MotionModel points(std::vector<Vec3> rest, double mass_g) {
  MotionModel model;
  model.network.mass_g.assign(rest.size(), mass_g);
  model.network.rest = std::move(rest);
  return model;
}

void join(MotionModel& model, int a, int b, double stiffness_n, SpringLaw law = SpringLaw::linear) {
  const auto& rest = model.network.rest;
  model.network.springs.push_back({a, b, distance(rest[a], rest[b]), stiffness_n, law, SpringKind::membrane});
}

MotionState run(const TimeStepper& stepper, MotionState state, Integrator integrator, double dt, int steps) {
  Context context;
  for (int i = 0; i < steps; ++i) {
    const auto done = stepper.step(state, dt, integrator, context);
    EXPECT_TRUE(static_cast<bool>(done)) << done.error().message();
    EXPECT_EQ(done->sub_steps, 1) << "the test measures steps of its own length";
  }
  return state;
}

// Base-2 logarithm of how the error falls as the step is halved.
double order(const std::function<double(int steps)>& error) {
  return std::log2(error(200) / error(400));
}

// A slab of all laws, viscous, with volumes, in gravity, over a ball and a floor, shaken.
struct Shaken {
  MotionModel model;
  MotionState state;
};

Shaken make_shaken(double amplitude_mm, bool surroundings) {
  support::SlabOptions options;
  options.nx = 6, options.ny = 7;
  options.volumes = true;
  Shaken shaken;
  MotionModel& m = shaken.model;
  m.network = support::make_slab(options).network;
  for (std::size_t i = 0; i < m.network.springs.size(); ++i) {
    m.network.springs[i].law = kSpringLaws[i % kSpringLaws.size()];
    m.springs.push_back({0.02 * static_cast<double>(i % 3), i % 7 == 0 ? 3.5 : 0.0});
  }
  m.network.mass_g.assign(m.network.rest.size(), 0.03);
  if (surroundings) {
    m.gravity_mm_ms2 = {0, 0, -0.0098};
    m.damping_g_ms = 0.001;
    Vec3 middle;
    for (const Vec3& p : m.network.rest) middle += p / static_cast<double>(m.network.rest.size());
    m.barriers.push_back({Barrier::Shape::sphere, middle, 9, {}, 1, 0.5, SpringLaw::linear, false});
    m.barriers.push_back(
        {Barrier::Shape::plane, {}, 1, Plane::through(middle, {0, 0, 1}), 2, 0.4, SpringLaw::square, true});
  }
  const RandomStream random(3);
  shaken.state.position = m.network.rest;
  shaken.state.velocity.resize(m.network.rest.size());
  for (std::size_t i = 0; i < shaken.state.position.size(); ++i) {
    const Vec3 d{random.normal(6 * i), random.normal(6 * i + 1), random.normal(6 * i + 2)};
    shaken.state.position[i] += d * amplitude_mm;
    shaken.state.velocity[i] =
        Vec3{random.normal(6 * i + 3), random.normal(6 * i + 4), random.normal(6 * i + 5)} *
        (0.1 * amplitude_mm);
  }
  return shaken;
}

TEST(TimeStepper, APointFallsFreely) {
  MotionModel model = points({{0, 0, 100}}, 2.5);
  model.gravity_mm_ms2 = {0, 0, -0.0098};
  const TimeStepper stepper = prepared(model);
  const double t = 80, fallen = 0.5 * 0.0098 * t * t;
  EXPECT_NEAR(run(stepper, stepper.rest(), Integrator::heun, 8, 10).position[0].z, 100 - fallen, 1e-12);
  // v is updated first: each step falls by half a step's gain too far.
  EXPECT_NEAR(run(stepper, stepper.rest(), Integrator::euler, 8, 10).position[0].z,
              100 - fallen - 0.5 * 0.0098 * t * 8, 1e-12);
}

TEST(TimeStepper, ADampedPointFallsAsTheClosedFormTells) {
  MotionModel model = points({{0, 0, 0}}, 0.5);
  model.gravity_mm_ms2 = {0, 0, -0.0098};
  model.damping_g_ms = 0.02;
  const TimeStepper stepper = prepared(model);
  const double t = 60, rate = 0.02 / 0.5, terminal = -0.0098 / rate;
  const double z = terminal * (t - (1 - std::exp(-rate * t)) / rate);
  for (const Integrator integrator : kIntegrators) {
    const auto error = [&](int steps) {
      return std::abs(run(stepper, stepper.rest(), integrator, t / steps, steps).position[0].z - z);
    };
    EXPECT_NEAR(order(error), integrator == Integrator::euler ? 1 : 2, 0.1);
    EXPECT_LT(error(400), integrator == Integrator::euler ? 0.05 : 1e-4);
  }
}

TEST(TimeStepper, AViscousSpringOscillatesAsTheClosedFormTells) {
  // Hung up, so that the spring is stretched throughout and its linear law is linear in the length.
  MotionModel model = points({{0, 0, 0}, {0, 0, -10}}, 0.8);
  join(model, 0, 1, 0.3);
  model.mobile = {0, 1};
  model.springs = {{0.002, 0}};
  model.gravity_mm_ms2 = {0, 0, -0.0098};
  const TimeStepper stepper = prepared(model);
  const double sag = 0.8 * 0.0098 * 10 / 0.3, decay = 0.5 * 0.002 / 0.8, t = 70;
  const double frequency = std::sqrt(0.3 / (10 * 0.8) - decay * decay);
  // From rest length and standing still: x is the distance from equilibrium.
  const double x =
      std::exp(-decay * t) * sag * (std::cos(frequency * t) + decay / frequency * std::sin(frequency * t));
  for (const Integrator integrator : kIntegrators) {
    const auto error = [&](int steps) {
      return std::abs(run(stepper, stepper.rest(), integrator, t / steps, steps).position[1].z -
                      (x - 10 - sag));
    };
    EXPECT_NEAR(order(error), integrator == Integrator::euler ? 1 : 2, 0.15);
    EXPECT_LT(error(400), integrator == Integrator::euler ? 0.02 : 1e-3) << "of a swing of " << sag;
  }
}

TEST(TimeStepper, ASpringActsByHalfBetweenMobileEndsAndWholeOnAFixedOne) {
  for (const int fixed : {-1, 0, 1}) {
    MotionModel model = points({{0, 0, 0}, {2, 0, 0}}, 1);
    join(model, 0, 1, 0.7);
    model.springs = {{0.5, 0}};
    model.mobile = {fixed != 0, fixed != 1};
    const TimeStepper stepper = prepared(model);
    MotionState state = stepper.rest();
    state.position[1].x = 5;  // strain 3/2
    state.velocity[1].x = 0.2;
    std::vector<Vec3> f(2);
    stepper.forces(state, f);
    const double whole = 0.7 * 1.5 + 0.5 * 0.2;
    EXPECT_NEAR(f[0].x, fixed == 0 ? 0 : fixed == 1 ? whole : 0.5 * whole, 1e-15);
    EXPECT_NEAR(f[1].x, fixed == 1 ? 0 : fixed == 0 ? -whole : -0.5 * whole, 1e-15);
  }
}

TEST(TimeStepper, ForcesAreTheNegativeGradientOfThePotential) {
  Shaken s = make_shaken(0.6, true);
  s.state.velocity.assign(s.state.velocity.size(), {});
  s.model.mobile.assign(s.state.position.size(), 1);
  for (std::size_t i = 0; i < s.model.mobile.size(); i += 5) s.model.mobile[i] = 0;
  const TimeStepper stepper = prepared(s.model);
  std::vector<Vec3> f(s.state.position.size());
  EXPECT_EQ(stepper.forces(s.state, f), 0);
  const double h = 1e-5;
  for (std::size_t i = 0; i < f.size(); ++i) {
    for (int axis = 0; axis < 3; ++axis) {
      auto high = s.state.position, low = high;
      high[i][axis] += h;
      low[i][axis] -= h;
      const double slope = (stepper.potential(high) - stepper.potential(low)) / (2 * h);
      if (s.model.mobile[i] == 0) {
        EXPECT_EQ(f[i][axis], 0);
      } else {
        EXPECT_NEAR(f[i][axis], -slope, 2e-6 * (1 + std::abs(slope))) << i << ' ' << axis;
      }
    }
  }
}

TEST(TimeStepper, WithoutSurroundingsMomentumStaysAndEnergyFalls) {
  Shaken s = make_shaken(0.3, false);
  for (SpringMotion& motion : s.model.springs) motion.cutoff_mm = 0;
  for (const Integrator integrator : kIntegrators) {
    const TimeStepper stepper = prepared(s.model);
    const auto momentum = [&](const MotionState& state) {
      Vec3 sum;
      for (const Vec3& v : state.velocity) sum += v * 0.03;
      return sum;
    };
    MotionState state = s.state;
    const double dt = 0.2 * stepper.stable_step_ms(state, integrator);
    const Vec3 before = momentum(state);
    double energy = stepper.potential(state.position) + stepper.kinetic(state.velocity);
    const double first = energy;
    for (int block = 0; block < 20; ++block) {
      state = run(stepper, state, integrator, dt, 25);
      const double now = stepper.potential(state.position) + stepper.kinetic(state.velocity);
      EXPECT_LT(now, energy * (1 + 1e-3)) << block;
      energy = now;
    }
    EXPECT_LT(energy, 0.9 * first);
    EXPECT_LT(length(momentum(state) - before), 1e-12);
  }
}

// What energy came to in `steps` Heun steps, of that before, less 1.
struct EnergyRange {
  double least = 0, most = 0;
  [[nodiscard]] double change() const { return std::max(most, -least); }
};

EnergyRange energy_range(const TimeStepper& stepper, MotionState state, double dt, int steps) {
  const auto energy = [&] { return stepper.potential(state.position) + stepper.kinetic(state.velocity); };
  const double before = energy();
  Context context;
  TimeStepper::Workspace workspace;
  EnergyRange range;
  for (int i = 0; i < steps; ++i) {
    EXPECT_TRUE(static_cast<bool>(stepper.step(state, dt, Integrator::heun, context, workspace)));
    if (i % 10 != 0) continue;
    const double change = energy() / before - 1;
    range = {std::min(range.least, change), std::max(range.most, change)};
  }
  return range;
}

TEST(TimeStepper, ALosslessNetworkKeepsItsEnergy) {
  // It swings, as the square of the step, and does not drift.
  Shaken s = make_shaken(0.2, false);
  s.model.springs.clear();
  const TimeStepper stepper = prepared(s.model);
  const double stable = stepper.stable_step_ms(s.state, Integrator::heun);
  const double coarse = energy_range(stepper, s.state, 0.2 * stable, 1000).change();
  EXPECT_LT(coarse, 2e-3);
  EXPECT_LT(energy_range(stepper, s.state, 0.05 * stable, 4000).change(), coarse / 10);
  EXPECT_LT(energy_range(stepper, s.state, 0.2 * stable, 10000).change(), 2 * coarse);
}

TEST(TimeStepper, NothingGrowsInHeunsLongestSteps) {
  for (const double amplitude_mm : {0.05, 0.2, 0.5}) {
    Shaken s = make_shaken(amplitude_mm, false);
    s.model.springs.clear();
    const TimeStepper stepper = prepared(s.model);
    const double stable = stepper.stable_step_ms(s.state, Integrator::heun);
    const EnergyRange range = energy_range(stepper, s.state, stable, 10000);
    EXPECT_LT(range.most, 0.03) << amplitude_mm;
    EXPECT_GT(range.least, -0.2) << amplitude_mm;
  }
}

TEST(TimeStepper, ABallOnAHardFloorBouncesNoHigherWhereAStepMeetsItUnawares) {
  // A period of the floor's spring is 0.2 ms; longer steps that meet it are taken again in parts.
  MotionModel model = points({{0, 0, 0.5}}, 1);
  model.gravity_mm_ms2 = {0, 0, -0.1};
  model.barriers.push_back(
      {Barrier::Shape::plane, {}, 1, Plane{{0, 0, 1}, 0}, 1, 1000, SpringLaw::linear, false});
  const TimeStepper stepper = prepared(model);
  for (const double dt : {0.005, 0.02, 0.05, 0.1}) {
    const EnergyRange range = energy_range(stepper, stepper.rest(), dt, static_cast<int>(400 / dt));
    EXPECT_LT(range.most, 0.02) << dt;
    if (dt < 0.01) EXPECT_GT(range.least, -0.1);
  }
}

TEST(TimeStepper, TissueDroppedOnAHardBallComesToRest) {
  // As in the ball drape script (Pieper 1989, section 6.2). It would tremble for ever if contact gave energy.
  support::SlabOptions options;
  options.nx = options.ny = 9;
  options.spacing_mm = 0.125, options.layer_mm = 0.1, options.radius_mm = 0;
  options.volumes = true;
  MotionModel model;
  model.network = support::make_slab(options).network;
  Vec3 middle;
  for (const Vec3& p : model.network.rest) middle += p / static_cast<double>(model.network.rest.size());
  model.network.mass_g.assign(model.network.rest.size(), 1);
  model.gravity_mm_ms2 = {0, 0, -0.1};
  model.damping_g_ms = 0.2;
  const Vec3 below = middle - Vec3{0, 0, 0.4};
  model.barriers.push_back({Barrier::Shape::sphere, below, 0.25, {}, 1, 1000, SpringLaw::linear, false});
  model.barriers.push_back({Barrier::Shape::plane,
                            {},
                            1,
                            Plane::through(below - Vec3{0, 0, 0.25}, {0, 0, 1}),
                            1,
                            1000,
                            SpringLaw::linear,
                            false});
  const TimeStepper stepper = prepared(model);
  MotionState state = stepper.rest();
  Context context;
  TimeStepper::Workspace workspace;
  for (int i = 0; i < 1200; ++i)
    ASSERT_TRUE(static_cast<bool>(stepper.step(state, 0.05, Integrator::heun, context, workspace)));
  double fastest = 0;
  for (const Vec3& v : state.velocity) fastest = std::max(fastest, length(v));
  EXPECT_LT(fastest, 0.01);
}

TEST(TimeStepper, ComesToRestWhereTheStaticSolverDoes) {
  support::SlabOptions options;
  options.nx = 5, options.ny = 6;
  const support::Slab slab = support::make_slab(options);
  PrescribedMotion motion;
  MotionModel model;
  model.network = slab.network;
  model.mobile.assign(slab.network.rest.size(), 1);
  for (int c = 0; c < slab.columns; ++c) {
    model.mobile[c] = 0;
    if (c % 2 == 0) {
      motion.moved.push_back(c);
      motion.positions.push_back(slab.network.rest[c] + Vec3{0.8, 0, 0.5});
    } else {
      motion.fixed.push_back(c);
    }
  }
  model.network.mass_g.assign(model.network.rest.size(), 0.05);
  model.damping_g_ms = 0.02;
  const TimeStepper stepper = prepared(model);
  MotionState state = stepper.rest();
  for (std::size_t i = 0; i < motion.moved.size(); ++i) state.position[motion.moved[i]] = motion.positions[i];
  state =
      run(stepper, state, Integrator::euler, 0.5 * stepper.stable_step_ms(state, Integrator::euler), 6000);

  // The half-force rule is a network whose springs between mobile points have half the stiffness.
  SpringNetwork halved = slab.network;
  for (Spring& s : halved.springs) s.stiffness_n *= s.a < slab.columns || s.b < slab.columns ? 1.0 : 0.5;
  Context context;
  EquilibriumOptions sharp;
  sharp.relative_residual = 1e-10;
  const auto still = solve_equilibrium(halved, motion, sharp, context);
  ASSERT_TRUE(static_cast<bool>(still)) << still.error().message();
  for (std::size_t i = 0; i < state.position.size(); ++i) {
    EXPECT_LT(distance(state.position[i], still->positions[i]), 1e-6) << i;
  }
}

TEST(TimeStepper, ASpringBeyondItsCutOffLetsGo) {
  MotionModel model = points({{0, 0, 0}, {2, 0, 0}}, 1);
  join(model, 0, 1, 0.7);
  model.springs = {{0.5, 4}};
  const TimeStepper stepper = prepared(model);
  MotionState state = stepper.rest();
  state.velocity[1].x = 1;
  std::vector<Vec3> f(2);
  state.position[1].x = 3.99;
  stepper.forces(state, f);
  EXPECT_LT(f[1].x, -0.5);
  state.position[1].x = 4.01;
  stepper.forces(state, f);
  EXPECT_EQ(f[1].x, 0);
}

TEST(TimeStepper, AStepBeyondWhatIsStableIsDivided) {
  Shaken s = make_shaken(0.3, true);
  const TimeStepper stepper = prepared(s.model);
  Context context;
  for (const Integrator integrator : kIntegrators) {
    const double stable = stepper.stable_step_ms(s.state, integrator);
    MotionState state = s.state;
    const auto report = stepper.step(state, 40 * stable, integrator, context);
    ASSERT_TRUE(static_cast<bool>(report)) << report.error().message();
    EXPECT_GE(report->sub_steps, 30);
    EXPECT_DOUBLE_EQ(report->stable_step_ms, stable);
    EXPECT_DOUBLE_EQ(state.time_ms, 40 * stable);
    const double energy = stepper.potential(state.position) + stepper.kinetic(state.velocity);
    EXPECT_LT(energy, 1.05 * (stepper.potential(s.state.position) + stepper.kinetic(s.state.velocity)));
  }
}

TEST(TimeStepper, TheStableStepIsOne) {
  // A chain's highest frequency is known: 2 √(k/m). Far below it nothing grows, with a margin of some
  // twofold.
  MotionModel model = points({}, 1);
  for (int i = 0; i < 40; ++i) model.network.rest.push_back({static_cast<double>(i), 0, 0});
  model.network.mass_g.assign(40, 0.01);
  for (int i = 0; i + 1 < 40; ++i) join(model, i, i + 1, 2.0);
  const TimeStepper stepper = prepared(model);
  const double limit = 2 / (2 * std::sqrt(0.5 * 2.0 / 0.01));  // half the stiffness: both ends are mobile
  const double stable = stepper.stable_step_ms(stepper.rest(), Integrator::euler);
  EXPECT_LT(stable, limit);
  EXPECT_GT(stable, 0.5 * limit);
}

TEST(TimeStepper, WildNumbersEndInAnErrorOrInFiniteStates) {
  const RandomStream random(17);
  Context context;
  int refused = 0, done = 0;
  for (std::uint64_t trial = 0; trial < 60; ++trial) {
    const auto scale = [&](std::uint64_t k) {
      return std::pow(10.0, 24 * random.uniform(8 * trial + k) - 12);
    };
    Shaken s = make_shaken(std::min(1e3, scale(0)), true);
    for (Spring& spring : s.model.network.springs) spring.stiffness_n *= scale(1);
    for (double& m : s.model.network.mass_g) m *= scale(2);
    s.model.damping_g_ms *= scale(3);
    for (std::size_t i = 0; i < s.model.springs.size(); i += 3) s.model.springs[i].relaxes = true;
    s.model.relaxation[1] = {0.5, scale(6)};
    s.state.relaxed.resize((s.model.springs.size() + 2) / 3);
    s.model.gravity_mm_ms2 = s.model.gravity_mm_ms2 * scale(4);
    const TimeStepper stepper = prepared(s.model);
    MotionState state = s.state;
    const double dt = std::min(scale(5), 100 * stepper.stable_step_ms(state, Integrator::euler));
    const Integrator integrator = trial % 2 == 0 ? Integrator::euler : Integrator::heun;
    const auto report = stepper.step(state, dt, integrator, context);
    if (!report) {
      ++refused;
      EXPECT_TRUE(state.position == s.state.position && state.velocity == s.state.velocity);
      continue;
    }
    ++done;
    for (const Vec3& p : state.position) ASSERT_TRUE(is_finite(p)) << trial;
    for (const Vec3& v : state.velocity) ASSERT_TRUE(is_finite(v)) << trial;
  }
  EXPECT_GT(done, 10);
  EXPECT_GT(refused + done, 59);
}

TEST(TimeStepper, HasTheSameBitsOnOneAndTwoThreads) {
  support::SlabOptions options;
  options.nx = 60, options.ny = 60;
  options.volumes = true;
  MotionModel model;
  model.network = support::make_slab(options).network;
  model.network.mass_g.assign(model.network.rest.size(), 0.05);
  model.gravity_mm_ms2 = {0.001, 0, -0.0098};
  model.barriers.push_back(
      {Barrier::Shape::plane, {}, 1, Plane{{0, 0, 1}, 0}, 1, 0.5, SpringLaw::linear, false});
  const TimeStepper stepper = prepared(model);
  const auto at = [&](int threads) {
    set_thread_count(threads);
    const double dt = stepper.stable_step_ms(stepper.rest(), Integrator::heun);
    Context context;
    MotionState state = stepper.rest();
    for (int i = 0; i < 15; ++i)
      EXPECT_TRUE(static_cast<bool>(stepper.step(state, 1.7 * dt, Integrator::heun, context)));
    set_thread_count(0);
    return state;
  };
  const MotionState one = at(1), two = at(2);
  EXPECT_TRUE(one.position == two.position);
  EXPECT_TRUE(one.velocity == two.velocity);
}

TEST(TimeStepper, CoincidentEndsAreCountedAndExertNoForce) {
  MotionModel model = points({{0, 0, 0}, {2, 0, 0}}, 1);
  join(model, 0, 1, 0.7);
  const TimeStepper stepper = prepared(model);
  MotionState state = stepper.rest();
  state.position[1] = state.position[0];
  Context context;
  const auto report = stepper.step(state, 1, Integrator::heun, context);
  ASSERT_TRUE(static_cast<bool>(report));
  EXPECT_EQ(report->coincident_springs, 1);
  EXPECT_EQ(state.position[1], Vec3{});
}

TEST(TimeStepper, BadModelsAndStepsAreNamed) {
  const auto message = [](const std::function<void(MotionModel&)>& damage) {
    MotionModel model = points({{0, 0, 0}, {2, 0, 0}}, 1);
    join(model, 0, 1, 0.7);
    damage(model);
    const auto stepper = TimeStepper::prepare(std::move(model));
    return stepper ? std::string{} : stepper.error().message();
  };
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_NE(message([](MotionModel& m) { m.network.mass_g[1] = 0; }).find("point 1 has no mass"),
            std::string::npos);
  EXPECT_EQ(message([](MotionModel& m) { m.network.mass_g[1] = 0, m.mobile = {1, 0}; }), "");
  EXPECT_NE(message([](MotionModel& m) { m.springs.resize(3); }).find("3 viscosities"), std::string::npos);
  EXPECT_NE(message([&](MotionModel& m) { m.springs = {{nan, 0}}; }).find("spring 0"), std::string::npos);
  EXPECT_NE(message([](MotionModel& m) { m.mobile = {1}; }).find("of 2"), std::string::npos);
  EXPECT_NE(message([](MotionModel& m) { m.damping_g_ms = -1; }).find("damping"), std::string::npos);
  EXPECT_NE(message([&](MotionModel& m) { m.gravity_mm_ms2.y = nan; }).find("gravity"), std::string::npos);
  EXPECT_NE(message([](MotionModel& m) { m.barriers.resize(1), m.barriers[0].radius_mm = 0; }).find("radius"),
            std::string::npos);

  MotionModel model = points({{0, 0, 0}}, 1);
  const TimeStepper stepper = prepared(model);
  Context context;
  MotionState state = stepper.rest();
  EXPECT_FALSE(static_cast<bool>(stepper.step(state, 0, Integrator::euler, context)));
  EXPECT_FALSE(static_cast<bool>(stepper.step(state, nan, Integrator::euler, context)));
  state.velocity.clear();
  EXPECT_FALSE(static_cast<bool>(stepper.step(state, 1, Integrator::euler, context)));
}

TEST(Barrier, ASphereResistsAsTheStrainOfItsRadiusOverTheDistance) {
  Barrier ball;
  ball.centre = {1, 2, 3};
  ball.radius_mm = 10;
  ball.stiffness_n = 0.6;
  const BarrierResponse inside = respond(ball, {1, 2, 8});  // strain 10/5 − 1
  EXPECT_NEAR(inside.force.z, 0.6, 1e-15);
  EXPECT_EQ(inside.force.x, 0);
  EXPECT_EQ(respond(ball, {1, 2, 14}).force, Vec3{});
  EXPECT_EQ(respond(ball, ball.centre).force, Vec3{});
  ball.clings = true;
  EXPECT_LT(respond(ball, {1, 2, 14}).force.z, 0);
}

TEST(Barrier, APlaneResistsByDepthOverItsScale) {
  Barrier floor;
  floor.shape = Barrier::Shape::plane;
  floor.plane = Plane{{0, 0, 1}, 5};
  floor.scale_mm = 2;
  floor.stiffness_n = 0.6;
  EXPECT_NEAR(respond(floor, {7, 7, 4}).force.z, 0.3, 1e-15);
  EXPECT_EQ(respond(floor, {7, 7, 6}).force, Vec3{});
  floor.clings = true;
  EXPECT_NEAR(respond(floor, {7, 7, 6}).force.z, -0.3, 1e-15);
}

}  // namespace
}  // namespace turgor
