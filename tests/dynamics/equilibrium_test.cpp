#include "turgor/dynamics/equilibrium.hpp"

#include <gtest/gtest.h>

#include <limits>

#include "dynamics/equilibria.hpp"
#include "support/layered_slab.hpp"
#include "turgor/core/parallel.hpp"
#include "turgor/core/random.hpp"
#include "turgor/dynamics/chain.hpp"
#include "turgor/tissue/network_energy.hpp"

namespace turgor {
namespace {

constexpr std::array kLaws = {SpringLaw::linear, SpringLaw::exponential, SpringLaw::logarithmic,
                              SpringLaw::square};

// A third of the bone points moves, the rest stays.
PrescribedMotion third_of_the_bone(const support::Slab& slab, const Vec3& shift) {
  PrescribedMotion motion;
  for (int c = 0; c < slab.columns; ++c) {
    if (3 * c < slab.columns) {
      motion.moved.push_back(c);
      motion.positions.push_back(slab.network.rest[c] + shift);
    } else {
      motion.fixed.push_back(c);
    }
  }
  return motion;
}

TEST(Equilibrium, TwoSpringsInSeriesShareTheForce) {
  for (const SpringLaw law : kLaws) {
    SpringNetwork net = points_without_springs({{0, 0, 0}, {2, 0, 0}, {5, 0, 0}});
    join(net, 0, 1, 1.0, law);
    join(net, 1, 2, 2.5, law);
    const EquilibriumResult r = solved(net, {{2}, {{8, 0, 0}}, {0}}, sharp());
    ASSERT_TRUE(r.converged);
    const double first = respond(net.springs[0], distance(r.positions[0], r.positions[1])).tension;
    const double second = respond(net.springs[1], distance(r.positions[1], r.positions[2])).tension;
    EXPECT_NEAR(first, second, 1e-9);
    if (law == SpringLaw::linear) {  // k1 (x/2 − 1) = k2 ((8 − x)/3 − 1)
      EXPECT_NEAR(r.positions[1].x, (1 + 2.5 * (8.0 / 3 - 1)) / (0.5 + 2.5 / 3), 1e-9);
    }
    EXPECT_NEAR(r.reaction_n, std::sqrt(2.0) * first, 1e-8) << "both ends carry it";
  }
}

TEST(Equilibrium, AContactPushesAsFarAsTheSpringBehindItLets) {
  SpringNetwork net = points_without_springs({{0, 0, 0}, {0, 0, 2}});
  join(net, 0, 1, 1.5);
  const double plane = 1.2, stiffness = 40;
  net.contacts = {{1, {0, 0, -1}, -plane, stiffness}};  // the free half-space lies below z = 1.2
  const EquilibriumResult r = solved(net, {{}, {}, {0}}, sharp());
  ASSERT_TRUE(r.converged);
  // k (2/z − 1) = K (z − plane)
  const double b = (1.5 - stiffness * plane) / stiffness, c = -2 * 1.5 / stiffness;
  EXPECT_NEAR(r.positions[1].z, 0.5 * (-b + std::sqrt(b * b - 4 * c)), 1e-9);

  net.contacts[0].offset_mm = -3;  // out of reach
  EXPECT_EQ(solved(net, {{}, {}, {0}}, sharp()).positions[1].z, 2.0);
}

TEST(Equilibrium, APointHungFromTwoSettlesWhereTheVerticalForcesMeet) {
  // Two inclined springs carry the point, a third pulls it straight down.
  SpringNetwork net = points_without_springs({{-3, 0, 0}, {3, 0, 0}, {0, 0, -1}, {0, 0, -3}});
  join(net, 0, 2, 1.0);
  join(net, 1, 2, 1.0);
  join(net, 2, 3, 0.4);
  const EquilibriumResult r = solved(net, {{3}, {{0, 0, -7}}, {0, 1}}, sharp());
  ASSERT_TRUE(r.converged);
  const auto downward = [&](double z) {  // the force on the point at height z, by hand
    const double inclined = std::sqrt(9 + z * z);
    return 0.4 * ((z + 7) / 2 - 1) - 2 * (inclined / std::sqrt(10.0) - 1) * (-z / inclined);
  };
  double low = -7, high = -1;  // downward(low) < 0 < downward(high)
  for (int i = 0; i < 100; ++i) (downward(0.5 * (low + high)) > 0 ? high : low) = 0.5 * (low + high);
  EXPECT_NEAR(r.positions[2].z, low, 1e-9);
  EXPECT_NEAR(r.positions[2].x, 0, 1e-9);
  EXPECT_NEAR(r.positions[2].y, 0, 1e-9);
}

TEST(Equilibrium, AUniaxiallyStretchedLatticeStretchesEvenly) {
  const int n = 5, length_cells = 8;
  std::vector<Vec3> points;
  const auto number = [&](int x, int y, int z) { return (x * n + y) * n + z; };
  for (int x = 0; x <= length_cells; ++x) {
    for (int y = 0; y < n; ++y) {
      for (int z = 0; z < n; ++z) points.push_back({2.0 * x, 2.0 * y, 2.0 * z});
    }
  }
  SpringNetwork net = points_without_springs(points);
  PrescribedMotion motion;
  for (int x = 0; x <= length_cells; ++x) {
    for (int y = 0; y < n; ++y) {
      for (int z = 0; z < n; ++z) {
        if (x < length_cells) join(net, number(x, y, z), number(x + 1, y, z), 1.5);
        if (y + 1 < n) join(net, number(x, y, z), number(x, y + 1, z), 1.0);
        if (z + 1 < n) join(net, number(x, y, z), number(x, y, z + 1), 1.0);
        if (x == 0) motion.fixed.push_back(number(x, y, z));
        if (x == length_cells) {
          motion.moved.push_back(number(x, y, z));
          motion.positions.push_back(points[number(x, y, z)] + Vec3{4, 0, 0});
        }
      }
    }
  }
  const EquilibriumResult r = solved(net, motion, sharp());
  ASSERT_TRUE(r.converged);
  for (std::size_t i = 0; i < points.size(); ++i) {
    EXPECT_LT(distance(r.positions[i], {points[i].x * 1.25, points[i].y, points[i].z}), 1e-8);
  }
  EXPECT_NEAR(r.energy_nmm, n * n * length_cells * 1.5 * 2.0 * 0.5 * 0.25 * 0.25, 1e-9)
      << "½ k L0 s² a spring";
  EXPECT_NEAR(r.reaction_n, std::sqrt(2.0 * n * n) * 1.5 * 0.25, 1e-9);
}

TEST(Equilibrium, AgreesWithADenseNewtonMethod) {
  for (const bool volumes : {false, true}) {
    for (const SpringLaw law : {SpringLaw::linear, SpringLaw::exponential, SpringLaw::logarithmic}) {
      support::SlabOptions options;
      options.nx = 5;
      options.ny = 9;
      options.volumes = volumes;
      options.law = law;
      const support::Slab slab = support::make_slab(options);
      const PrescribedMotion motion = third_of_the_bone(slab, {1, -3, 0.5});
      const EquilibriumResult r = solved(slab.network, motion, sharp());
      ASSERT_TRUE(r.converged);
      EXPECT_LT(largest_distance(r.positions, dense_newton(slab.network, motion)), 1e-8);
    }
  }
}

// Damped motion, step by step, until it comes to rest: nothing in common with Newton's method but the forces.
std::vector<Vec3> dynamics_to_rest(const SpringNetwork& net, const PrescribedMotion& motion) {
  const NetworkEnergy energy = *NetworkEnergy::prepare(net);
  std::vector<Vec3> x = net.rest, v(x.size()), f(x.size());
  std::vector<char> held(x.size(), 0);
  for (std::size_t i = 0; i < motion.moved.size(); ++i) held[motion.moved[i]] = 1;
  for (const int p : motion.fixed) held[p] = 1;
  NetworkEnergy::Workspace workspace;
  const double dt = 0.05, mass = 0.02, damping = 0.02;  // far below the stable step
  for (int step = 0; step < 40'000; ++step) {
    const double ramp = std::min(1.0, step / 2000.0);
    for (std::size_t i = 0; i < motion.moved.size(); ++i) {
      x[motion.moved[i]] = lerp(net.rest[motion.moved[i]], motion.positions[i], ramp);
    }
    energy.forces(x, f, workspace);
    double fastest = 0;
    for (std::size_t i = 0; i < x.size(); ++i) {
      if (held[i]) continue;
      v[i] += (f[i] - v[i] * damping) * (dt / mass);
      x[i] += v[i] * dt;
      fastest = std::max(fastest, length(v[i]));
    }
    if (ramp == 1.0 && fastest < 1e-9) break;
  }
  return x;
}

TEST(Equilibrium, IsWhereDampedMotionComesToRest) {
  support::SlabOptions options;
  options.nx = 5;
  options.ny = 9;
  options.volumes = true;
  options.volume_modulus_mpa = 0.05;
  const support::Slab slab = support::make_slab(options);
  const PrescribedMotion motion = third_of_the_bone(slab, {1, -3, 0.5});
  const EquilibriumResult r = solved(slab.network, motion, sharp());
  ASSERT_TRUE(r.converged);
  EXPECT_LT(largest_distance(r.positions, dynamics_to_rest(slab.network, motion)), 1e-5);
}

TEST(Equilibrium, TheResidualStatedIsTheResidual) {
  const support::Slab slab = support::make_slab({});
  const PrescribedMotion motion = third_of_the_bone(slab, {0, -6, 0});
  EquilibriumOptions options;
  options.relative_residual = 1e-6;
  const EquilibriumResult r = solved(slab.network, motion, options);
  ASSERT_TRUE(r.converged);
  const NetworkEnergy energy = *NetworkEnergy::prepare(slab.network);
  NetworkEnergy::Workspace workspace;
  std::vector<Vec3> f(r.positions.size());
  EXPECT_EQ(energy.forces(r.positions, f, workspace), r.energy_nmm);
  double largest = 0, free = 0, held = 0;
  for (std::size_t i = 0; i < f.size(); ++i) {
    const bool bone = static_cast<int>(i) < slab.columns;
    (bone ? held : free) += squared_length(f[i]);
    if (!bone) largest = std::max(largest, length(f[i]));
  }
  EXPECT_NEAR(r.residual_n, largest, 1e-12);
  EXPECT_NEAR(r.relative_residual, std::sqrt(free / held), 1e-12);
  EXPECT_LE(r.relative_residual, 1e-6);
}

TEST(Equilibrium, WhenAllBoneTurnsTheTissueTurnsAlong) {
  support::SlabOptions options;
  options.volumes = true;
  const support::Slab slab = support::make_slab(options);
  const RigidTransform turn = RigidTransform::rotate_about({0, 40, -10}, {1, 0, 0}, radians(20));
  PrescribedMotion motion;
  std::vector<Vec3> turned;
  for (const Vec3& p : slab.network.rest) turned.push_back(turn.point(p));
  for (int c = 0; c < slab.columns; ++c) {
    motion.moved.push_back(c);
    motion.positions.push_back(turned[c]);
  }
  const EquilibriumResult r = solved(slab.network, motion);
  ASSERT_TRUE(r.converged);
  EXPECT_LT(largest_distance(r.positions, turned), 1e-6);
  EXPECT_LT(r.energy_nmm, 1e-12);
}

TEST(Equilibrium, AtRestNothingMovesAndNothingIsComputed) {
  const support::Slab slab = support::make_slab({});
  const EquilibriumResult r = solved(slab.network, third_of_the_bone(slab, {}));
  EXPECT_TRUE(r.converged);
  EXPECT_EQ(r.newton_steps, 0);
  EXPECT_LT(largest_distance(r.positions, slab.network.rest), 1e-12);
}

TEST(Equilibrium, DoesNotDependOnLoadStepsOrStart) {
  const support::Slab slab = support::make_slab({});
  const PrescribedMotion motion = third_of_the_bone(slab, {2, -5, 1});
  const EquilibriumResult once = solved(slab.network, motion, sharp());
  EquilibriumOptions in_parts = sharp();
  in_parts.load_steps = 4;
  const EquilibriumResult parts = solved(slab.network, motion, in_parts);
  const std::vector<Vec3> chain = *ChainSolver(slab.network).solve(motion, {});
  const EquilibriumResult from_chain = solved(slab.network, motion, sharp(), &chain);
  ASSERT_TRUE(once.converged && parts.converged && from_chain.converged);
  EXPECT_LT(largest_distance(once.positions, parts.positions), 1e-8);
  EXPECT_LT(largest_distance(once.positions, from_chain.positions), 1e-8);
}

TEST(Equilibrium, HasTheSameBitsOnOneAndTwoThreads) {
  support::SlabOptions options;
  options.nx = 24;
  options.ny = 36;
  options.volumes = true;
  const support::Slab slab = support::make_slab(options);
  const PrescribedMotion motion = third_of_the_bone(slab, {0, -6, 0});
  set_thread_count(1);
  const EquilibriumResult one = solved(slab.network, motion);
  set_thread_count(2);
  const EquilibriumResult two = solved(slab.network, motion), again = solved(slab.network, motion);
  set_thread_count(0);
  ASSERT_TRUE(one.converged);
  EXPECT_TRUE(one.positions == two.positions);
  EXPECT_TRUE(one.positions == again.positions);
  EXPECT_EQ(one.energy_nmm, two.energy_nmm);
  EXPECT_EQ(one.linear_iterations, two.linear_iterations);
}

TEST(Equilibrium, SolvesTheFaceOfDuysakAndZhangInEveryDirection) {
  const support::Slab slab = support::make_slab(support::duysak_zhang_size_braced());
  for (const Vec3& shift : {Vec3{0, -6, 0}, Vec3{0, 0, -6}, Vec3{6, 0, 0}, Vec3{0, 0, 6}}) {
    EquilibriumOptions options;
    options.relative_residual = 1e-6;
    const EquilibriumResult r = solved(slab.network, third_of_the_bone(slab, shift), options);
    EXPECT_TRUE(r.converged) << r.relative_residual;
  }
}

TEST(Equilibrium, StifferVolumesChangeLessAndDoNotInvert) {
  double previous = std::numeric_limits<double>::infinity();
  for (const double modulus : {0.0, 0.1, 1.0, 10.0}) {
    support::SlabOptions options;
    options.volumes = true;
    options.volume_modulus_mpa = modulus;
    const support::Slab slab = support::make_slab(options);
    const EquilibriumResult r = solved(slab.network, third_of_the_bone(slab, {0, 0, 3}));
    ASSERT_TRUE(r.converged);
    EXPECT_EQ(r.inverted_volumes, 0);
    double change = 0;
    for (const VolumeElement& v : slab.network.volumes) {
      const double now =
          signed_volume(r.positions[v.p[0]], r.positions[v.p[1]], r.positions[v.p[2]], r.positions[v.p[3]]);
      change += std::abs(now - v.rest_volume_mm3);
    }
    EXPECT_LT(change, 0.8 * previous) << modulus;
    previous = change;
  }
}

TEST(Equilibrium, PointsWithoutSpringsStayAndLoosePiecesDoNotDisturb) {
  support::Slab slab = support::make_slab({});
  const PrescribedMotion motion = third_of_the_bone(slab, {0, -4, 0});
  const std::vector<Vec3> alone = solved(slab.network, motion).positions;
  const int first = static_cast<int>(slab.network.rest.size());
  for (int i = 0; i < 3; ++i) {
    slab.network.rest.push_back({200.0 + i, 0, 0});
    slab.network.mass_g.push_back(1);
  }
  join(slab.network, first + 1, first + 2, 1.0);  // a spring that nothing holds
  const EquilibriumResult r = solved(slab.network, motion);
  ASSERT_TRUE(r.converged);
  EXPECT_LT(largest_distance({r.positions.begin(), r.positions.begin() + first}, alone), 1e-4);
  for (int i = first; i < first + 3; ++i) EXPECT_LT(distance(r.positions[i], slab.network.rest[i]), 1e-9);
}

TEST(Equilibrium, StopsWithinItsStepsAndSaysThatItHasNotConverged) {
  const support::Slab slab = support::make_slab(support::duysak_zhang_size_braced());
  Context context;
  EquilibriumOptions options;
  options.max_newton_steps = 2;
  const auto r = solve_equilibrium(slab.network, third_of_the_bone(slab, {6, 0, 0}), options, context);
  ASSERT_TRUE(static_cast<bool>(r));
  EXPECT_FALSE(r->converged);
  EXPECT_EQ(r->newton_steps, 2);
  EXPECT_GT(r->relative_residual, 1e-6);
  for (const Vec3& p : r->positions) ASSERT_TRUE(is_finite(p));
  ASSERT_EQ(context.notices().size(), 1U);
  EXPECT_NE(context.notices()[0].text.find("no equilibrium after 2"), std::string::npos);
}

TEST(Equilibrium, StopsOnRequest) {
  const support::Slab slab = support::make_slab(support::duysak_zhang_size());
  int asked = 0;
  Context context({}, {}, [&] { return ++asked > 5; });
  const auto r = solve_equilibrium(slab.network, third_of_the_bone(slab, {6, 0, 0}), {}, context);
  ASSERT_FALSE(static_cast<bool>(r));
  EXPECT_EQ(r.error().kind, ErrorKind::cancelled);
}

TEST(Equilibrium, WildStartsEndInAnAnswerOrAFlagButNeverInNan) {
  support::SlabOptions options;
  options.nx = 5;
  options.ny = 6;
  options.volumes = true;
  EquilibriumOptions few;
  few.max_newton_steps = 60;
  for (const SpringLaw law : kLaws) {
    options.law = law;
    const support::Slab slab = support::make_slab(options);
    const PrescribedMotion motion = third_of_the_bone(slab, {0, -3, 0});
    const RandomStream random(17);
    for (const double scale : {0.0, 1.0, 30.0, 1e4, 1e9}) {  // 0: all points in one place
      std::vector<Vec3> start(slab.network.rest.size());
      for (std::size_t i = 0; i < start.size(); ++i) {
        start[i] = Vec3{random.uniform(3 * i) - 0.5, random.uniform(3 * i + 1) - 0.5,
                        random.uniform(3 * i + 2) - 0.5} *
                   scale;
      }
      Context context;
      const auto r = solve_equilibrium(slab.network, motion, few, context, &start);
      if (!r) {
        EXPECT_NE(r.error().message().find("beyond what can be computed"), std::string::npos);
        continue;
      }
      for (const Vec3& p : r->positions) ASSERT_TRUE(is_finite(p)) << scale;
      ASSERT_TRUE(std::isfinite(r->energy_nmm) && std::isfinite(r->relative_residual)) << scale;
      EXPECT_TRUE(!r->converged || r->relative_residual <= few.relative_residual);
    }
  }
}

TEST(Equilibrium, BadOptionsStartsAndMotionsAreNamed) {
  const support::Slab slab = support::make_slab({});
  const PrescribedMotion motion = third_of_the_bone(slab, {0, -3, 0});
  const auto fault = [&](const SpringNetwork& net, const PrescribedMotion& m, const EquilibriumOptions& o,
                         const std::vector<Vec3>* start) {
    Context context;
    const auto r = solve_equilibrium(net, m, o, context, start);
    return r ? std::string("nothing") : r.error().message();
  };
  EquilibriumOptions options;
  options.relative_residual = 0;
  EXPECT_NE(fault(slab.network, motion, options, nullptr).find("relative residual"), std::string::npos);
  options = {};
  options.load_steps = 0;
  EXPECT_NE(fault(slab.network, motion, options, nullptr).find("load step"), std::string::npos);
  options = {};
  options.max_newton_steps = 0;
  EXPECT_NE(fault(slab.network, motion, options, nullptr).find("Newton"), std::string::npos);
  std::vector<Vec3> start(3);
  EXPECT_NE(fault(slab.network, motion, {}, &start).find("3 positions for"), std::string::npos);
  start = slab.network.rest;
  start[7].x = std::numeric_limits<double>::infinity();
  EXPECT_NE(fault(slab.network, motion, {}, &start).find("start position of point 7"), std::string::npos);
  PrescribedMotion bad = motion;
  bad.positions[0].x = std::numeric_limits<double>::quiet_NaN();
  EXPECT_NE(fault(slab.network, bad, {}, nullptr).find("moved point 0"), std::string::npos);
  SpringNetwork broken = slab.network;
  broken.springs[2].b = broken.springs[2].a;
  EXPECT_NE(fault(broken, motion, {}, nullptr).find("spring 2"), std::string::npos);
  SpringNetwork extreme = slab.network;
  for (Spring& s : extreme.springs) s.stiffness_n = 1e307;
  EXPECT_NE(fault(extreme, motion, {}, nullptr).find("beyond what can be computed"), std::string::npos);
}

}  // namespace
}  // namespace turgor
