// Equilibrium under gravity, forces, barriers and grabs, and of solids.
#include <gtest/gtest.h>

#include <limits>

#include "dynamics/equilibria.hpp"
#include "support/lattice_solid.hpp"
#include "turgor/core/parallel.hpp"

namespace turgor {
namespace {

EquilibriumResult loaded(const SpringNetwork& net, const PrescribedMotion& motion, const Loads& loads,
                         const EquilibriumOptions& options = {}, const std::vector<Vec3>* start = nullptr) {
  Context context;
  const auto result = solve_equilibrium(net, motion, loads, options, context, start);
  EXPECT_TRUE(static_cast<bool>(result)) << (result ? "" : result.error().message());
  return result ? *result : EquilibriumResult{};
}

constexpr double kGravity = 0.00980665;
const support::Lattice kBar{2, 2, 8, 5.0, {0.05, 0.45, 1e-3, 0.2}};

PrescribedMotion lowest_layer(const SpringNetwork& net, double up_to = 1e-9) {
  PrescribedMotion motion;
  for (std::size_t p = 0; p < net.rest.size(); ++p) {
    if (net.rest[p].z <= up_to) motion.fixed.push_back(static_cast<int>(p));
  }
  return motion;
}

Barrier floor_at(double z, double stiffness_n) {
  Barrier floor;
  floor.shape = Barrier::Shape::plane;
  floor.plane = {{0, 0, 1}, z};
  floor.stiffness_n = stiffness_n;
  return floor;
}

TEST(EquilibriumUnderLoads, AHangingChainOfSpringsHasItsClosedForm) {
  const int n = 20;
  std::vector<Vec3> points;
  for (int i = 0; i <= n; ++i) points.push_back({0, 0, -2.0 * i});
  SpringNetwork net = points_without_springs(points);
  for (int i = 0; i < n; ++i) join(net, i, i + 1, 3.0, SpringLaw::hookean);
  net.rest.push_back({7, 0, 0});  // without any element: it stays
  net.mass_g.push_back(5);
  Loads loads;
  loads.gravity_mm_ms2 = {0, 0, -kGravity};
  loads.force_n.resize(net.rest.size());
  loads.force_n[n] = {0, 0, -0.1};
  const EquilibriumResult r = loaded(net, {{}, {}, {0}}, loads, sharp());
  ASSERT_TRUE(r.converged);
  double z = 0;
  for (int i = 0; i < n; ++i) {
    const double carried = (n - i) * kGravity + 0.1;  // masses of 1 g below
    z -= 2 * (1 + carried / 3);
    EXPECT_NEAR(r.positions[static_cast<std::size_t>(i) + 1].z, z, 1e-8);
  }
  EXPECT_NEAR(r.reaction_n, n * kGravity + 0.1, 1e-9);
  EXPECT_EQ(r.positions.back(), (Vec3{7, 0, 0}));
}

TEST(EquilibriumUnderLoads, ASolidUnderItsWeightBalancesItAtItsBase) {
  const SpringNetwork net = support::lattice_network(kBar);
  const PrescribedMotion motion = lowest_layer(net);
  Loads loads;
  loads.gravity_mm_ms2 = {0, 0, -kGravity};
  const EquilibriumResult r = loaded(net, motion, loads, sharp());
  ASSERT_TRUE(r.converged);
  const NetworkEnergy energy = *NetworkEnergy::prepare(net);
  NetworkEnergy::Workspace workspace;
  std::vector<Vec3> f(net.rest.size());
  energy.forces(r.positions, f, workspace);
  double held = 0, free_mass = 0;
  for (std::size_t p = 0; p < f.size(); ++p) {
    const bool base = net.rest[p].z == 0;
    (base ? held : free_mass) += base ? f[p].z : net.mass_g[p];
    if (!base) EXPECT_LT(distance(f[p], {0, 0, net.mass_g[p] * kGravity}), 1e-8);
  }
  EXPECT_NEAR(held, -free_mass * kGravity, 1e-8);
  EXPECT_EQ(r.inverted_volumes, 0);
}

TEST(EquilibriumUnderLoads, ABentSolidAgreesWithADenseNewtonMethod) {
  const SpringNetwork net = support::lattice_network({1, 2, 6, 5.0, kBar.material});
  PrescribedMotion motion = lowest_layer(net);
  for (std::size_t p = 0; p < net.rest.size(); ++p) {
    if (net.rest[p].z < 30) continue;
    motion.moved.push_back(static_cast<int>(p));
    motion.positions.push_back(net.rest[p] + Vec3{6, 2, -3});
  }
  const EquilibriumResult r = solved(net, motion, sharp());
  ASSERT_TRUE(r.converged);
  EXPECT_LT(largest_distance(r.positions, dense_newton(net, motion)), 1e-7);
}

TEST(EquilibriumUnderLoads, WhatRestsOnAPlanePressesWithItsWeight) {
  const SpringNetwork net = support::lattice_network({3, 3, 2, 5, {0.05, 0.45, 1e-3, 0.2}});
  Loads loads;
  loads.gravity_mm_ms2 = {0, 0, -kGravity};
  for (const double gap : {0.5, -0.3}) {  // from above, and from within
    loads.barriers = {floor_at(-gap, 0.05)};
    const EquilibriumResult r = loaded(net, {}, loads, sharp());
    EXPECT_TRUE(r.converged) << gap << " residual " << r.relative_residual;
    double pressed = 0, weight = 0;
    for (std::size_t p = 0; p < net.rest.size(); ++p) {
      pressed += respond(loads.barriers[0], r.positions[p]).force.z;
      weight += net.mass_g[p] * kGravity;
    }
    EXPECT_NEAR(pressed / weight, 1, 1e-6);
  }
}

TEST(EquilibriumUnderLoads, BalancedLoadsNeedNoFixedPoint) {
  const SpringNetwork net = support::lattice_network(kBar);
  Loads loads;
  loads.force_n.resize(net.rest.size());
  int ends = 0;
  for (std::size_t p = 0; p < net.rest.size(); ++p) {
    if (net.rest[p].z == 0) loads.force_n[p] = {0, 0, -0.05}, ++ends;
    if (net.rest[p].z == 40) loads.force_n[p] = {0, 0, 0.05};
  }
  const EquilibriumResult r = loaded(net, {}, loads);
  EXPECT_TRUE(r.converged) << r.relative_residual;
  const double stretched = r.positions.back().z - r.positions.front().z;
  EXPECT_GT(stretched, 40.5);
  for (const Vec3& p : r.positions) EXPECT_TRUE(is_finite(p));
}

TEST(EquilibriumUnderLoads, WhatNothingHoldsDoesNotConverge) {
  const SpringNetwork net = support::lattice_network({1, 1, 1, 5, {}});
  Loads loads;
  loads.gravity_mm_ms2 = {0, 0, -kGravity};
  const EquilibriumResult r = loaded(net, {}, loads);
  EXPECT_FALSE(r.converged);
  EXPECT_GT(r.relative_residual, 0.1);
  for (const Vec3& p : r.positions) EXPECT_TRUE(is_finite(p));
}

TEST(EquilibriumUnderLoads, AGrabPullsWithItsForceAndGivesWayAtItsLimit) {
  const SpringNetwork net = support::lattice_network(kBar);
  Loads loads;
  loads.grabs.resize(1);
  Grab& grab = loads.grabs[0];
  for (std::size_t p = 0; p < net.rest.size(); ++p) {
    if (net.rest[p].z == 40) grab.points.push_back(static_cast<int>(p));
  }
  grab.weights.assign(grab.points.size(), 1.0 / static_cast<double>(grab.points.size()));
  grab.target = {15, 5, 45};
  grab.stiffness_n_mm = 20;
  for (const double limit : {1e9, 0.1}) {
    grab.limit_n = limit;
    const EquilibriumResult r = loaded(net, lowest_layer(net), loads, sharp());
    ASSERT_TRUE(r.converged);
    EXPECT_LT(r.newton_steps, 40);
    const GrabResponse g = respond(grab, r.positions);
    if (limit < 1) EXPECT_NEAR(length(g.force), limit, 1e-9);
    if (limit > 1) EXPECT_GT(length(g.force), 0.2);
    // What the hand feels is what the base holds.
    const NetworkEnergy energy = *NetworkEnergy::prepare(net);
    NetworkEnergy::Workspace workspace;
    std::vector<Vec3> f(net.rest.size());
    energy.forces(r.positions, f, workspace);
    Vec3 base;
    for (const int p : lowest_layer(net).fixed) base += f[static_cast<std::size_t>(p)];
    EXPECT_LT(distance(base, g.force), 1e-8);
  }
}

TEST(EquilibriumUnderLoads, TwoGrabsAloneHoldABody) {
  const SpringNetwork net = support::lattice_network(kBar);
  Loads loads;
  loads.grabs = {{{0}, {1.0}, {0, 0, -10}, 0.5, 1e9}, {{80}, {1.0}, {10, 10, 50}, 0.5, 1e9}};
  const EquilibriumResult r = loaded(net, {}, loads);
  EXPECT_TRUE(r.converged) << r.relative_residual;
  EXPECT_LT(length(respond(loads.grabs[0], r.positions).force + respond(loads.grabs[1], r.positions).force),
            1e-3);
}

TEST(EquilibriumUnderLoads, ATetrahedronTurnedInsideOutRecovers) {
  SpringNetwork net = points_without_springs({{0, 0, 0}, {4, 0, 0}, {1, 4, 0}, {1.5, 1.2, 3.5}});
  net.solids.push_back(*make_solid({{0, 1, 2, 3}}, 4));
  const std::array stiffness = {stiffness_of({0.1, 0.45, 1e-3, 0.2})};
  ASSERT_TRUE(static_cast<bool>(set_stiffness(net.solids[0], net.rest, stiffness)));
  for (const double height : {-3.5, -1.0, -0.1}) {
    std::vector<Vec3> start = net.rest;
    start[3].z = height;
    const EquilibriumResult r = solved(net, {{}, {}, {0, 1, 2}}, {}, &start);
    EXPECT_TRUE(r.converged);
    EXPECT_EQ(r.inverted_volumes, 0) << height;
    EXPECT_LT(largest_distance(r.positions, net.rest), 1e-2) << height;
  }
}

TEST(EquilibriumUnderLoads, ASolidWithPointsPushedThroughItRecovers) {
  const support::Lattice lattice{3, 3, 3, 5, {0.05, 0.45, 1e-3, 0.2}};
  const SpringNetwork net = support::lattice_network(lattice);
  std::vector<Vec3> start = net.rest;
  start[lattice.point(1, 1, 1)] += Vec3{9, 7, 1};
  start[lattice.point(2, 2, 2)] -= Vec3{2, 9, 8};
  start[lattice.point(1, 2, 3)] -= Vec3{0, 1, 11};
  const EquilibriumResult r = solved(net, lowest_layer(net), {}, &start);
  EXPECT_TRUE(r.converged);
  EXPECT_EQ(r.inverted_volumes, 0);
  EXPECT_LT(largest_distance(r.positions, net.rest), 1e-2);
}

TEST(EquilibriumUnderLoads, HasTheSameBitsOnOneAndTwoThreads) {
  const SpringNetwork net = support::lattice_network({8, 8, 14, 5, kBar.material});
  Loads loads;
  loads.gravity_mm_ms2 = {0.3 * kGravity, 0, -kGravity};
  loads.barriers = {floor_at(30, 0.1)};
  loads.grabs = {{{1000, 1010}, {0.25, 0.75}, {0, 0, 60}, 0.5, 0.2}};
  set_thread_count(1);
  const EquilibriumResult one = loaded(net, lowest_layer(net), loads);
  set_thread_count(2);
  const EquilibriumResult two = loaded(net, lowest_layer(net), loads);
  set_thread_count(0);
  EXPECT_TRUE(one.converged);
  EXPECT_EQ(one.positions, two.positions);
}

TEST(EquilibriumUnderLoads, BadLoadsAreNamed) {
  const SpringNetwork net = support::lattice_network({1, 1, 1, 5, {}});
  constexpr double inf = std::numeric_limits<double>::infinity();
  const auto fault_of = [&](const Loads& loads) {
    Context context;
    const auto r = solve_equilibrium(net, {}, loads, {}, context);
    return r ? std::string("no error") : r.error().message();
  };
  Loads loads;
  loads.force_n.resize(3);
  EXPECT_NE(fault_of(loads).find("3 forces are given for 8"), std::string::npos);
  loads.force_n.assign(8, {});
  loads.force_n[5].y = inf;
  EXPECT_NE(fault_of(loads).find("force on point 5"), std::string::npos);
  loads = {};
  loads.gravity_mm_ms2.z = inf;
  EXPECT_NE(fault_of(loads).find("gravity"), std::string::npos);
  loads = {};
  loads.barriers = {floor_at(0, 1)};
  loads.barriers[0].points = {99};
  EXPECT_NE(fault_of(loads).find("point 99"), std::string::npos);
  loads = {};
  loads.grabs = {{{9}, {1.0}, {}, 1, 1}};
  EXPECT_NE(fault_of(loads).find("point 9"), std::string::npos);
  loads = {};
  loads.force_n.assign(8, {0, 0, 1e300});
  Context context;
  const auto wild = solve_equilibrium(net, {}, loads, {}, context);
  if (wild) {
    EXPECT_FALSE(wild->converged);
    for (const Vec3& p : wild->positions) EXPECT_TRUE(is_within_reach(p));
  }
}

}  // namespace
}  // namespace turgor
