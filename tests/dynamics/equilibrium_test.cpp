#include "turgor/dynamics/equilibrium.hpp"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <limits>

#include "support/lattice_solid.hpp"
#include "support/layered_slab.hpp"
#include "turgor/core/parallel.hpp"
#include "turgor/core/random.hpp"
#include "turgor/dynamics/chain.hpp"
#include "turgor/tissue/network_energy.hpp"

namespace turgor {
namespace {

constexpr std::array kLaws = {SpringLaw::linear, SpringLaw::exponential, SpringLaw::logarithmic,
                              SpringLaw::square};

SpringNetwork points_without_springs(std::vector<Vec3> points) {
  SpringNetwork net;
  net.rest = std::move(points);
  net.mass_g.assign(net.rest.size(), 1);
  return net;
}

void join(SpringNetwork& net, int a, int b, double k, SpringLaw law = SpringLaw::linear) {
  net.springs.push_back({a, b, distance(net.rest[a], net.rest[b]), k, law, SpringKind::membrane});
}

EquilibriumResult solved(const SpringNetwork& net, const PrescribedMotion& motion,
                         EquilibriumOptions options = {}, const std::vector<Vec3>* start = nullptr) {
  Context context;
  const auto result = solve_equilibrium(net, motion, options, context, start);
  EXPECT_TRUE(static_cast<bool>(result)) << (result ? "" : result.error().message());
  return result ? *result : EquilibriumResult{};
}

EquilibriumOptions sharp() {
  EquilibriumOptions options;
  options.relative_residual = 1e-11;
  return options;
}

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

double largest_distance(const std::vector<Vec3>& a, const std::vector<Vec3>& b) {
  double largest = 0;
  for (std::size_t i = 0; i < a.size(); ++i) largest = std::max(largest, distance(a[i], b[i]));
  return largest;
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

// Newton's method on the dense Hessian by Eigen's LDLT, from the same start, with nothing of the solver in it
// but the elements' own blocks.
std::vector<Vec3> dense_newton(const SpringNetwork& net, const PrescribedMotion& motion) {
  const NetworkEnergy energy = *NetworkEnergy::prepare(net);
  std::vector<int> column(net.rest.size(), 0);
  std::vector<Vec3> x = net.rest;
  for (std::size_t i = 0; i < motion.moved.size(); ++i) {
    column[motion.moved[i]] = -1;
    x[motion.moved[i]] = motion.positions[i];
  }
  for (const int f : motion.fixed) column[f] = -1;
  int unknowns = 0;
  for (int& c : column) c = c < 0 ? -1 : 3 * unknowns++;
  NetworkEnergy::Workspace workspace;
  std::vector<Vec3> f(x.size());
  for (int step = 0; step < 300; ++step) {
    const double before = energy.forces(x, f, workspace);
    Eigen::VectorXd force(3 * unknowns);
    Eigen::MatrixXd hessian = Eigen::MatrixXd::Zero(3 * unknowns, 3 * unknowns);
    for (std::size_t i = 0; i < x.size(); ++i) {
      for (int k = 0; k < 3 && column[i] >= 0; ++k) force[column[i] + k] = f[i][k];
    }
    if (force.norm() < 1e-12) break;
    ElementStiffness k;
    energy.linearise(x, 0.0, k);
    const auto add = [&](int a, int b, const Mat3& block, double sign) {
      if (column[a] < 0 || column[b] < 0) return;
      for (int r = 0; r < 3; ++r) {
        for (int c = 0; c < 3; ++c)
          hessian(column[a] + r, column[b] + c) += sign * block.c[static_cast<std::size_t>(c)][r];
      }
    };
    for (std::size_t s = 0; s < k.springs.size(); ++s) {
      const auto& [a, b] = energy.spring_ends()[s];
      Mat3 block;
      for (int c = 0; c < 3; ++c) {
        for (int r = 0; r < 3; ++r) {
          const Vec3& n = k.springs[s].direction;
          block.c[static_cast<std::size_t>(c)][r] =
              (k.springs[s].axial - k.springs[s].transverse) * n[r] * n[c] +
              (r == c ? k.springs[s].transverse : 0);
        }
      }
      add(a, a, block, 1), add(b, b, block, 1), add(a, b, block, -1), add(b, a, block, -1);
    }
    for (std::size_t v = 0; v < k.volumes.size(); ++v) {
      for (int a = 0; a < 4; ++a) {
        for (int b = 0; b < 4; ++b) {
          add(energy.volume_corners()[v].p[a], energy.volume_corners()[v].p[b],
              volume_block(k.volumes[v], a, b, 0.0), 1);
        }
      }
    }
    for (std::size_t t = 0; t < k.areas.size(); ++t) {
      for (int a = 0; a < 3; ++a) {
        for (int b = 0; b < 3; ++b) {
          add(energy.area_corners()[t].p[a], energy.area_corners()[t].p[b], area_block(k.areas[t], a, b, 0.0),
              1);
        }
      }
    }
    Eigen::VectorXd d;
    for (double shift = 0;; shift = std::max(10 * shift, 1e-3)) {  // until the factor is positive definite
      const Eigen::LDLT<Eigen::MatrixXd> factor(
          hessian + shift * Eigen::MatrixXd::Identity(3 * unknowns, 3 * unknowns));
      d = factor.solve(force);
      if (factor.isPositive() && d.dot(force) > 0) break;
    }
    std::vector<Vec3> y;
    double t = 1;
    for (; t > 1e-8; t *= 0.5) {
      y = x;
      for (std::size_t i = 0; i < y.size(); ++i) {
        for (int c = 0; c < 3 && column[i] >= 0; ++c) y[i][c] += t * d[column[i] + c];
      }
      if (energy.value(y) <= before * (1 + 1e-14)) break;
    }
    x = y;
  }
  return x;
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
