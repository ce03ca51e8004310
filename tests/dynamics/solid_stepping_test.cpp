#include <gtest/gtest.h>

#include <algorithm>
#include <numeric>

#include "dynamics/solid_blocks.hpp"
#include "math/float_lanes.hpp"
#include "support/largest_distance.hpp"
#include "support/lattice_solid.hpp"
#include "turgor/core/parallel.hpp"
#include "turgor/core/random.hpp"
#include "turgor/dynamics/time_stepper.hpp"
#include "turgor/tissue/network_energy.hpp"

namespace turgor {
namespace {

using support::largest_distance;
using support::Lattice;

enum class Shape : std::uint8_t { lattice, varying, arbitrary };
constexpr std::array kShapes = {Shape::lattice, Shape::varying, Shape::arbitrary};

Vec3 random_vector(const RandomStream& random, std::uint64_t k) {
  return {random.normal(3 * k), random.normal(3 * k + 1), random.normal(3 * k + 2)};
}

/// A box of cubes; `varying`: each tetrahedron of its own stiffness; `arbitrary`: points moved aside, too.
MotionModel box(const Lattice& l, Shape shape, bool exact = true) {
  const RandomStream random(7);
  MotionModel model;
  model.exact_solids = exact;
  SpringNetwork& net = model.network;
  net = support::lattice_network(l);
  if (shape == Shape::lattice) return model;
  Solid& solid = net.solids[0];
  if (shape == Shape::arbitrary) {
    solid.lattice_mm = 0;
    for (std::size_t i = 0; i < net.rest.size(); ++i)
      net.rest[i] += random_vector(random, i) * (0.07 * l.edge_mm);
  }
  std::vector<SolidStiffness> stiffness(solid.tetrahedra.size(), stiffness_of(l.material));
  for (std::size_t i = 0; i < stiffness.size(); ++i) stiffness[i].length *= 0.5 + random.uniform(1000 + i);
  EXPECT_TRUE(static_cast<bool>(set_stiffness(solid, net.rest, stiffness)));
  return model;
}

TimeStepper prepared(MotionModel model) {
  auto stepper = TimeStepper::prepare(std::move(model));
  EXPECT_TRUE(static_cast<bool>(stepper)) << (stepper ? "" : stepper.error().message());
  return *std::move(stepper);
}

MotionState shaken(const TimeStepper& stepper, double amplitude_mm, double speed_mm_ms = 0) {
  const RandomStream random(3);
  MotionState state = stepper.rest();
  for (std::size_t i = 0; i < state.position.size(); ++i) {
    state.position[i] += random_vector(random, i) * amplitude_mm;
    state.velocity[i] = random_vector(random, 100'000 + i) * speed_mm_ms;
  }
  return state;
}

std::vector<Vec3> forces_at(const TimeStepper& stepper, const MotionState& state) {
  std::vector<Vec3> f(state.position.size());
  stepper.forces(state, f);
  return f;
}

double largest(const std::vector<Vec3>& f) {
  double most = 0;
  for (const Vec3& v : f) most = std::max(most, length(v));
  return most;
}

/// By the energy's own route, element by element in double precision.
std::vector<Vec3> reference(const MotionModel& model, const MotionState& state) {
  const auto energy = NetworkEnergy::prepare(model.network);
  NetworkEnergy::Workspace w;
  std::vector<Vec3> f(state.position.size());
  energy->forces(state.position, f, w);
  return f;
}

void turn(MotionState& state, const RigidTransform& by) {
  for (Vec3& x : state.position) x = by.point(x);
}

TEST(SolidStepping, ForcesAreTheNegativeGradientOfTheEnergy) {
  for (const Shape shape : kShapes) {
    MotionModel model = box({3, 2, 2, 2.0}, shape);
    model.gravity_mm_ms2 = {0, 0.001, -0.0098};
    const TimeStepper stepper = prepared(model);
    for (const double amplitude : {0.02, 0.3, 1.5}) {  // the last inverts some
      MotionState state = shaken(stepper, amplitude);
      const auto f = forces_at(stepper, state);
      const double h = 1e-5;
      for (std::size_t p = 0; p < f.size(); p += 5) {
        for (int axis = 0; axis < 3; ++axis) {
          auto ahead = state.position, behind = state.position;
          ahead[p][axis] += h, behind[p][axis] -= h;
          const double slope = (stepper.potential(behind) - stepper.potential(ahead)) / (2 * h);
          EXPECT_NEAR(f[p][axis], slope, 1e-6 * (largest(f) + 1e-3)) << p;
        }
      }
    }
  }
}

TEST(SolidStepping, ForcesAreThoseOfTheNetworksElements) {
  for (const Shape shape : kShapes) {
    const MotionModel model = box({12, 9, 11, 2.0}, shape);
    const SolidBlocks blocks(model);
    EXPECT_EQ(blocks.lattices(), shape == Shape::arbitrary ? 0 : 1);
    const TimeStepper stepper = prepared(model);
    for (const double amplitude : {1e-4, 0.1, 2.0}) {
      const MotionState state = shaken(stepper, amplitude);
      const auto f = reference(model, state);
      EXPECT_LT(largest_distance(forces_at(stepper, state), f), 2e-10 * largest(f));
    }
  }
}

TEST(SolidStepping, ALatticeNotToldGivesTheSameForces) {
  for (const bool exact : {true, false}) {
    MotionModel model = box({9, 8, 7, 2.0}, Shape::varying, exact);
    const TimeStepper told = prepared(model);
    model.network.solids[0].lattice_mm = 0;
    EXPECT_EQ(SolidBlocks(model).lattices(), 0);
    const TimeStepper untold = prepared(model);
    const MotionState state = shaken(told, 0.2);
    const auto f = forces_at(told, state);
    EXPECT_LT(largest_distance(f, forces_at(untold, state)), (exact ? 1e-12 : 2e-6) * largest(f));
  }
}

TEST(SolidStepping, WhatIsNotALatticeIsNotTakenForOne) {
  MotionModel model = box({3, 3, 3, 2.0}, Shape::lattice);
  model.network.rest[7].x += 1e-6;
  EXPECT_EQ(SolidBlocks(model).lattices(), 0);
  model = box({3, 3, 3, 2.0}, Shape::lattice);
  std::swap(model.network.solids[0].tetrahedra[2], model.network.solids[0].tetrahedra[44]);
  EXPECT_EQ(SolidBlocks(model).lattices(), 0);
}

// Errors are of the forces of single elements, which in balance cancel: they are set against the largest of
// the forces that these would have by themselves, the strain times the stiffness.
TEST(SolidStepping, SinglePrecisionIsNearToDouble) {
  for (const Shape shape : kShapes) {
    const Lattice l{10, 9, 8, 2.0};
    const TimeStepper exact = prepared(box(l, shape)), single = prepared(box(l, shape, false));
    const auto error = [&](const MotionState& state) {
      const auto f = forces_at(exact, state), g = forces_at(single, state);
      for (const Vec3& v : g) EXPECT_TRUE(is_finite(v));
      return largest_distance(f, g) / largest(f);
    };
    for (const double strain : {1e-4, 1e-3, 1e-2, 0.1, 0.5, 1.0}) {
      MotionState state = shaken(exact, strain * l.edge_mm);
      EXPECT_LT(error(state), 2e-6) << strain;
      for (Vec3& x : state.position) x += Vec3{300, -200, 100};
      EXPECT_LT(error(state), 2e-6) << strain << " far off";
      turn(state, RigidTransform::rotate_about({5, 5, 5}, normalized(Vec3{1, 2, 3}), 2.5));
      EXPECT_LT(error(state), 2e-6) << strain << " turned";
    }
  }
}

TEST(SolidStepping, LanesDoAsTheirScalarTwin) {
  for (const Shape shape : kShapes) {
    const MotionModel single = box({9, 7, 8, 2.0}, shape, false), exact = box({9, 7, 8, 2.0}, shape, true);
    const SolidBlocks of_floats(single), of_doubles(exact);
    const MotionState state = shaken(prepared(single), 0.3);
    TimeStepper::Workspace lanes, twin;
    EXPECT_EQ((of_floats.sum_as<Twin<float, 8>>(state.position, twin.solid_force)),
              of_floats.sum(state.position, lanes));
    EXPECT_EQ((of_doubles.sum_as<Twin<double, 4>>(state.position, twin.exact_solid_force)),
              of_doubles.sum(state.position, lanes));
    for (const SolidBlocks* blocks : {&of_floats, &of_doubles}) {
      const auto by_lanes = blocks->reader(lanes), by_twin = blocks->reader(twin);
      for (int p = 0; p < static_cast<int>(state.position.size()); ++p) EXPECT_EQ(by_lanes(p), by_twin(p));
    }
  }
}

TEST(SolidStepping, TheSameBitsOnAnyNumberOfThreads) {
  const TimeStepper stepper = prepared(box({14, 13, 12, 2.0}, Shape::lattice, false));
  std::vector<MotionState> ends;
  for (const int threads : {1, 2, 1}) {
    set_thread_count(threads);
    MotionState state = shaken(stepper, 0.1);
    Context context;
    for (int i = 0; i < 5; ++i)
      ASSERT_TRUE(static_cast<bool>(stepper.step(state, 0.05, Integrator::verlet, context)));
    ends.push_back(state);
  }
  set_thread_count(0);
  for (const MotionState& end : ends) {
    EXPECT_TRUE(end.position == ends[0].position);
    EXPECT_TRUE(end.velocity == ends[0].velocity);
  }
}

TEST(SolidStepping, ElementsWithoutSizeHaveNoForceAndNothingIsNotANumber) {
  for (const Shape shape : kShapes) {
    for (const bool exact : {true, false}) {
      const TimeStepper stepper = prepared(box({3, 3, 3, 2.0}, shape, exact));
      for (const double height : {0.0, -1.0}) {
        MotionState state = stepper.rest();
        for (Vec3& x : state.position) x.z *= height;
        for (const Vec3& f : forces_at(stepper, state)) EXPECT_TRUE(is_finite(f));
        EXPECT_GT(stepper.stable_step_ms(state, Integrator::verlet), 0);
      }
      MotionState state = stepper.rest();
      for (Vec3& x : state.position) x = {1, 2, 3};
      const double stiffest = largest(forces_at(stepper, shaken(stepper, 1)));
      EXPECT_LT(largest(forces_at(stepper, state)), (exact ? 1e-9 : 0.1) * stiffest);
    }
  }
}

TEST(SolidStepping, ASpinningBodyKeepsItsMomenta) {
  for (const bool exact : {true, false}) {
    const TimeStepper stepper = prepared(box({5, 4, 6, 2.0}, Shape::lattice, exact));
    const auto& mass = stepper.model().network.mass_g;
    MotionState state = shaken(stepper, 0.05);
    for (std::size_t i = 0; i < state.position.size(); ++i)
      state.velocity[i] = cross(Vec3{0.01, 0.02, -0.03}, state.position[i]) + Vec3{0.1, 0, 0};
    const auto momenta = [&] {
      Vec3 linear, angular;
      for (std::size_t i = 0; i < mass.size(); ++i) {
        linear += state.velocity[i] * mass[i];
        angular += cross(state.position[i], state.velocity[i]) * mass[i];
      }
      return std::pair{linear, angular};
    };
    const auto before = momenta();
    Context context;
    const double dt = 0.5 * stepper.stable_step_ms(state, Integrator::verlet);
    for (int i = 0; i < 1000; ++i)
      ASSERT_TRUE(static_cast<bool>(stepper.step(state, dt, Integrator::verlet, context)));
    const auto after = momenta();
    const double bound = exact ? 1e-12 : 2e-6;
    EXPECT_LT(distance(before.first, after.first), bound * length(before.first));
    EXPECT_LT(distance(before.second, after.second), bound * length(before.second));
  }
}

TEST(SolidStepping, TheBoundOfTheFrequencyHoldsAndIsNear) {
  for (const Shape shape : kShapes) {
    const MotionModel model = box({4, 4, 4, 2.0}, shape);
    const TimeStepper stepper = prepared(model);
    const auto& mass = model.network.mass_g;
    // The highest frequency by power iteration on differences of forces.
    MotionState state = stepper.rest();
    const RandomStream random(5);
    std::vector<Vec3> u;
    for (std::size_t i = 0; i < mass.size(); ++i) u.push_back(random_vector(random, i));
    double square = 0;
    for (int iteration = 0; iteration < 300; ++iteration) {
      double norm = 0;
      for (const Vec3& v : u) norm += squared_length(v);
      for (Vec3& v : u) v /= std::sqrt(norm);
      const double h = 1e-6;
      MotionState ahead = state, behind = state;
      for (std::size_t i = 0; i < u.size(); ++i)
        ahead.position[i] += u[i] * h, behind.position[i] -= u[i] * h;
      const auto f = forces_at(stepper, ahead), g = forces_at(stepper, behind);
      square = 0;
      std::vector<Vec3> next(u.size());
      for (std::size_t i = 0; i < u.size(); ++i) {
        next[i] = (g[i] - f[i]) / (2 * h * mass[i]);
        square += dot(next[i], u[i]);
      }
      u = next;
    }
    const double limit = 2 / std::sqrt(square), taken = stepper.stable_step_ms(state, Integrator::verlet);
    EXPECT_LT(taken, 0.71 * limit);
    EXPECT_GT(taken, 0.35 * limit);
  }
}

TEST(SolidStepping, AFixedEndHoldsWithItsWholeForce) {
  MotionModel model = box({1, 1, 1, 2.0}, Shape::lattice);
  model.mobile.assign(8, 1);
  for (std::size_t p = 0; p < 4; ++p) model.mobile[p] = 0;
  const TimeStepper held = prepared(model);
  const MotionState state = shaken(held, 0.2);
  const auto f = forces_at(held, state), free = reference(model, state);
  for (std::size_t p = 0; p < 4; ++p) EXPECT_EQ(f[p], Vec3{});
  for (std::size_t p = 4; p < 8; ++p) EXPECT_LT(distance(f[p], free[p]), 1e-12);
}

/// Turned inside out, or torn to three times its size, a damped block comes back to its shape.
TEST(SolidStepping, ACubeTurnedInsideOutRecovers) {
  for (const Shape shape : kShapes) {
    MotionModel model = box({2, 2, 2, 2.0}, shape, false);
    model.damping_g_ms = 2e-4;
    const TimeStepper stepper = prepared(model);
    MotionState state = stepper.rest();
    for (Vec3& x : state.position) x.x *= 3;
    state.position[13] += Vec3{9, 0.4, 0.2};  // the middle point, far outside
    const double before = stepper.potential(state.position);
    Context context;
    for (int i = 0; i < 400; ++i) {
      const auto done = stepper.step(state, 1, Integrator::verlet, context);
      ASSERT_TRUE(static_cast<bool>(done)) << done.error().message();
    }
    EXPECT_LT(stepper.potential(state.position), 1e-6 * before);
    for (const auto& t : model.network.solids[0].tetrahedra)
      EXPECT_GT(signed_volume(state.position[t[0]], state.position[t[1]], state.position[t[2]],
                              state.position[t[3]]),
                0);
  }
}

TEST(SolidStepping, EnergyStaysWithinBoundsInLargeSwings) {
  for (const bool exact : {true, false}) {
    MotionModel model = box({3, 3, 6, 2.0}, Shape::lattice, exact);
    model.mobile.assign(model.network.rest.size(), 1);
    for (std::size_t p = 0; p < 16; ++p) model.mobile[p] = 0;
    const TimeStepper stepper = prepared(model);
    MotionState state = stepper.rest();
    for (std::size_t i = 0; i < state.position.size(); ++i)  // bent by half its length
      state.position[i].x += 0.04 * state.position[i].z * state.position[i].z;
    const double before = stepper.potential(state.position);
    double most = 0, least = before;
    Context context;
    const double dt = 0.5 * stepper.stable_step_ms(state, Integrator::verlet);
    for (int i = 0; i < 3000; ++i) {
      const auto done = stepper.step(state, dt, Integrator::verlet, context);
      ASSERT_TRUE(static_cast<bool>(done)) << done.error().message();
      const auto f = forces_at(stepper, state);
      auto v = state.velocity;  // from half a step ago to now
      for (std::size_t p = 0; p < v.size(); ++p)
        v[p] += f[p] * (0.5 * dt / stepper.model().network.mass_g[p]);
      const double energy = stepper.potential(state.position) + stepper.kinetic(v);
      most = std::max(most, energy), least = std::min(least, energy);
    }
    EXPECT_LT(most, 1.01 * before);
    EXPECT_GT(least, 0.99 * before);
  }
}

/// A block of tissue on a floor, with springs, an area and a volume across it, in gravity.
TEST(SolidStepping, SpringsSolidsAndBarriersMoveTogether) {
  MotionModel model = box({4, 4, 4, 2.0}, Shape::lattice, false);
  SpringNetwork& net = model.network;
  const double weight = std::accumulate(net.mass_g.begin(), net.mass_g.end(), 0.0) * 0.0098;
  net.springs.push_back(
      {0, 124, distance(net.rest[0], net.rest[124]), 0.01, SpringLaw::hookean, SpringKind::fibre});
  net.areas.push_back({{0, 4, 120}, 32, 0.001});
  net.volumes.push_back(
      {{0, 4, 20, 124}, signed_volume(net.rest[0], net.rest[4], net.rest[20], net.rest[124]), 0.001, 0});
  model.gravity_mm_ms2 = {0, 0, -0.0098};
  model.damping_g_ms = 2e-4;
  Barrier floor;
  floor.shape = Barrier::Shape::plane;
  floor.plane = Plane{{0, 0, 1}, -0.5};
  floor.stiffness_n = 0.01;
  model.barriers.push_back(floor);
  const TimeStepper stepper = prepared(model);
  MotionState state = stepper.rest();
  const double start = stepper.potential(state.position);
  Context context;
  double most = start;
  for (int i = 0; i < 40; ++i) {
    const auto done = stepper.step(state, 20, Integrator::verlet, context);
    ASSERT_TRUE(static_cast<bool>(done)) << done.error().message();
    most = std::max(most, stepper.potential(state.position) + stepper.kinetic(state.velocity));
  }
  EXPECT_LT(most, start + 1e-3 * std::abs(start) + 1e-9);
  EXPECT_LT(largest(forces_at(stepper, state)), 1e-3 * weight);
  double lowest = 1e9;
  for (const Vec3& x : state.position) lowest = std::min(lowest, x.z);
  EXPECT_LT(lowest, -0.5);
  EXPECT_GT(lowest, -1.5);
}

TEST(SolidStepping, AnEdgeOfNoTetrahedronIsAnError) {
  MotionModel model = box({2, 2, 2, 2.0}, Shape::lattice);
  model.network.solids[0].edges.push_back({0, 26});
  model.network.solids[0].edge_nmm.push_back(1);
  const auto stepper = TimeStepper::prepare(model);
  ASSERT_FALSE(static_cast<bool>(stepper));
  EXPECT_NE(stepper.error().message().find("solid 0 has an edge or triangle"), std::string::npos);
}

}  // namespace
}  // namespace turgor
