#include "turgor/dynamics/chain.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <map>
#include <numbers>

#include "support/layered_slab.hpp"
#include "turgor/core/random.hpp"

namespace turgor {
namespace {

SpringNetwork network_of(std::vector<Vec3> points, std::vector<std::pair<int, int>> springs) {
  SpringNetwork net;
  net.rest = std::move(points);
  net.mass_g.assign(net.rest.size(), 1);
  for (const auto& [a, b] : springs) {
    net.springs.push_back(
        {a, b, distance(net.rest[a], net.rest[b]), 1, SpringLaw::linear, SpringKind::membrane});
  }
  return net;
}

ChainParameters as_printed(double alpha, double beta, double limit) {
  ChainParameters p;
  p.alpha = p.column_alpha = alpha;
  p.beta = beta;
  p.max_stretch = p.max_compression = limit;
  p.fixed_points = FixedPoints::inert;
  return p;
}

// The formula of section 3 as it is printed, for one spring: A moves to a, where does B go?
Vec3 printed_formula(const Vec3& A, const Vec3& a, const Vec3& B, double r0, double alpha,
                     const ChainParameters& p) {
  const Vec3 u = B - A, v = B - a, w = u * alpha + v * (1 - alpha);
  const double d = length(w) - r0;
  const double limit = (d > 0 ? p.max_stretch : p.max_compression) * r0;
  const double deformation = limit * (1 - std::exp(-p.beta * std::abs(d) / r0));
  return a + normalized(w) * (d > 0 ? r0 + deformation : r0 - deformation);
}

// The whole algorithm in the slow obvious way: sets of points, a map of sums, one step after the other.
std::vector<Vec3> slow_chain(const SpringNetwork& net, const PrescribedMotion& motion,
                             const ChainParameters& p) {
  std::vector<Vec3> x = net.rest;
  std::vector<int> step(net.rest.size(), -1);
  for (std::size_t i = 0; i < motion.moved.size(); ++i) {
    step[motion.moved[i]] = 0;
    x[motion.moved[i]] = motion.positions[i];
  }
  const bool hold = p.fixed_points == FixedPoints::hold;
  for (const int f : motion.fixed) step[f] = hold ? 0 : -2;
  for (int now = 0;; ++now) {
    const std::vector<Vec3> before = x;
    struct Sum {
      Vec3 moved;
      int count = 0;
    };
    std::map<int, Sum> asked;
    for (const Spring& s : net.springs) {  // semi-active springs
      if (now == 0 || step[s.a] != now || step[s.b] != now) continue;
      const Vec3 d = x[s.b] - x[s.a];
      const double l = length(d), low = s.rest_length_mm * (1 - p.max_compression),
                   high = s.rest_length_mm * (1 + p.max_stretch);
      if (l >= low && l <= high) continue;
      const Vec3 half = d * (0.5 * (l - std::clamp(l, low, high)) / l);
      asked[s.a].moved += half, asked[s.b].moved -= half;
      ++asked[s.a].count, ++asked[s.b].count;
    }
    for (const auto& [point, sum] : asked) x[point] += sum.moved / sum.count;
    std::map<int, Sum> reached;
    for (const Spring& s : net.springs) {
      for (const auto& [from, to] : {std::pair{s.a, s.b}, std::pair{s.b, s.a}}) {
        if (step[from] != now || step[to] != -1) continue;
        const bool column = s.kind == SpringKind::vertical || s.kind == SpringKind::diagonal;
        const bool still = before[from] == net.rest[from];
        if (hold && still && !column) continue;
        const Vec3 b = still ? net.rest[to]
                             : printed_formula(net.rest[from], x[from], net.rest[to], s.rest_length_mm,
                                               column ? p.column_alpha : p.alpha, p);
        reached[to].moved += b;
        ++reached[to].count;
      }
    }
    if (reached.empty()) return x;
    for (const auto& [point, sum] : reached) {
      step[point] = now + 1;
      x[point] = sum.moved / sum.count;
    }
  }
}

// A third of the bone points move, the last third stays; those between are free.
PrescribedMotion third_of_the_bone(const support::Slab& slab, const Vec3& shift) {
  PrescribedMotion motion;
  for (int c = 0; c < slab.columns; ++c) {
    if (3 * c < slab.columns) {
      motion.moved.push_back(c);
      motion.positions.push_back(slab.network.rest[c] + shift);
    } else if (3 * c >= 2 * slab.columns) {
      motion.fixed.push_back(c);
    }
  }
  return motion;
}

std::vector<Vec3> solved(const SpringNetwork& net, const PrescribedMotion& motion, const ChainParameters& p) {
  const auto result = ChainSolver(net).solve(motion, p);
  EXPECT_TRUE(static_cast<bool>(result)) << (result ? "" : result.error().message());
  return result ? *result : std::vector<Vec3>{};
}

TEST(Chain, OneSpringFollowsThePrintedFormulaStretchedAndCompressed) {
  const Vec3 A{1, 2, 3}, B{4, 2, 3};
  const SpringNetwork net = network_of({A, B}, {{0, 1}});
  for (const double alpha : {0.0, 0.3, 0.9, 1.0}) {
    for (const Vec3& a : {Vec3{-1, 2, 3}, Vec3{2.5, 2.5, 3}, Vec3{1, 7, -4}}) {
      const ChainParameters p = as_printed(alpha, 1.7, 0.25);
      const std::vector<Vec3> x = solved(net, {{0}, {a}, {}}, p);
      EXPECT_EQ(x[0], a);
      EXPECT_LT(distance(x[1], printed_formula(A, a, B, 3.0, alpha, p)), 1e-13);
    }
  }
}

TEST(Chain, AgreesWithTheSlowObviousWayOnLayeredTissue) {
  for (const bool diagonals : {false, true}) {
    support::SlabOptions options;
    options.diagonals = diagonals;
    const support::Slab slab = support::make_slab(options);
    for (const Vec3& shift : {Vec3{0, 0, -6}, Vec3{0, -6, 0}, Vec3{5, 1, -2}}) {
      const PrescribedMotion motion = third_of_the_bone(slab, shift);
      for (ChainParameters p : {as_printed(0.9, 1, 0.2), as_printed(0.3, 4, 0.1), ChainParameters{}}) {
        const std::vector<Vec3> fast = solved(slab.network, motion, p),
                                slow = slow_chain(slab.network, motion, p);
        for (std::size_t i = 0; i < fast.size(); ++i) ASSERT_LT(distance(fast[i], slow[i]), 1e-11) << i;
      }
    }
  }
}

TEST(Chain, RigidSpringsCarryEverythingAlong) {
  const support::Slab slab = support::make_slab({});
  const PrescribedMotion motion{{5}, {slab.network.rest[5] + Vec3{3, -2, 1}}, {}};
  const std::vector<Vec3> x = solved(slab.network, motion, as_printed(1, 1, 0.2));
  // Bone points have no springs among themselves, so they too are reached, through the layers.
  for (std::size_t i = 0; i < x.size(); ++i)
    EXPECT_LT(distance(x[i], slab.network.rest[i] + Vec3{3, -2, 1}), 1e-10);
}

TEST(Chain, DecaysByAlphaAcrossTheMotionWhereLengthsAreFree) {
  // Springs at right angles to a small motion: w = u − (1 − α) D keeps its length at first order.
  std::vector<Vec3> points;
  std::vector<std::pair<int, int>> springs;
  for (int i = 0; i < 10; ++i) {
    points.push_back({3.0 * i, 0, 0});
    if (i > 0) springs.emplace_back(i - 1, i);
  }
  const double alpha = 0.7;
  const std::vector<Vec3> x =
      solved(network_of(points, springs), {{0}, {{0, 0, 1e-6}}, {}}, as_printed(alpha, 5, 0.2));
  for (int i = 0; i < 10; ++i) EXPECT_NEAR(x[i].z / 1e-6, std::pow(alpha, i), 1e-6);
}

TEST(Chain, LongSpringsLoseAtMostTheirLimitToLongitudinalMotion) {
  std::vector<Vec3> points;
  std::vector<std::pair<int, int>> springs;
  for (int i = 0; i < 30; ++i) {
    points.push_back({3.0 * i, 0, 0});
    if (i > 0) springs.emplace_back(i - 1, i);
  }
  const std::vector<Vec3> x =
      solved(network_of(points, springs), {{0}, {{-6, 0, 0}}, {}}, as_printed(0, 5, 0.2));
  for (int i = 1; i < 30; ++i) {
    const double stretch = (x[i].x - x[i - 1].x) / 3.0;
    EXPECT_GE(stretch, 1 - 1e-12);
    EXPECT_LE(stretch, 1.2 + 1e-12);
  }
  EXPECT_NEAR(x[3].x - 9, -6 + 3 * 0.6, 0.01) << "each spring takes up a fifth of its length";
  EXPECT_NEAR(x[29].x - 87, 0, 0.01) << "until nothing is left";
}

TEST(Chain, APointReachedFromTwoTakesTheirMean) {
  const std::vector<Vec3> points = {{0, 0, 0}, {6, 0, 0}, {3, 1, 0}};
  const SpringNetwork net = network_of(points, {{0, 2}, {1, 2}});
  const ChainParameters p = as_printed(0.6, 1, 0.3);
  const Vec3 a0{0, 0, 2}, a1{7, 0, -1};
  const std::vector<Vec3> x = solved(net, {{0, 1}, {a0, a1}, {}}, p);
  const double r0 = std::sqrt(10.0);
  const Vec3 expected = (printed_formula(points[0], a0, points[2], r0, 0.6, p) +
                         printed_formula(points[1], a1, points[2], r0, 0.6, p)) /
                        2;
  EXPECT_LT(distance(x[2], expected), 1e-13);
}

TEST(Chain, SemiActiveSpringsComeBackToTheirLimits) {
  // Two arms pulled apart: the tips' common spring is stretched beyond its limit until it is brought back.
  const SpringNetwork net =
      network_of({{0, 0, 0}, {3, 0, 0}, {0, 3, 0}, {3, 3, 0}}, {{0, 2}, {1, 3}, {2, 3}});
  const PrescribedMotion motion{{0, 1}, {{-3, 0, 0}, {6, 0, 0}}, {}};
  ChainParameters p = as_printed(1, 1, 0.2);
  p.semi_active_passes = 0;
  std::vector<Vec3> x = solved(net, motion, p);
  EXPECT_NEAR(distance(x[2], x[3]), 9, 1e-12);
  p.semi_active_passes = 1;
  x = solved(net, motion, p);
  EXPECT_NEAR(distance(x[2], x[3]), 3.6, 1e-12);
  EXPECT_NEAR((x[2].x + x[3].x) / 2, 1.5, 1e-12) << "half at either end";
}

TEST(Chain, PrescribedPointsAreExactlyWhereTheyBelong) {
  const support::Slab slab = support::make_slab({});
  const PrescribedMotion motion = third_of_the_bone(slab, {0.1, -6.3, 0.7});
  for (const FixedPoints fixed : {FixedPoints::inert, FixedPoints::hold}) {
    ChainParameters p;
    p.fixed_points = fixed;
    const std::vector<Vec3> x = solved(slab.network, motion, p);
    for (std::size_t i = 0; i < motion.moved.size(); ++i) EXPECT_EQ(x[motion.moved[i]], motion.positions[i]);
    for (const int f : motion.fixed) EXPECT_EQ(x[f], slab.network.rest[f]);
  }
}

TEST(Chain, TissueFollowsMovedBoneAndStaysOverHeldBone) {
  support::SlabOptions options;
  options.ny = 45;
  const support::Slab slab = support::make_slab(options);
  const auto moved_by = [&](const std::vector<Vec3>& x, int row) {
    const int skin = slab.point(2, row * slab.nx + slab.nx / 2);
    return distance(x[skin], slab.network.rest[skin]);
  };
  for (const Vec3& shift : {Vec3{0, 0, -6}, Vec3{0, -6, 0}, Vec3{6, 0, 0}}) {
    const std::vector<Vec3> x = solved(slab.network, third_of_the_bone(slab, shift), {});
    EXPECT_GT(moved_by(x, 5), 0.9 * 6);
    EXPECT_LT(moved_by(x, 5), 1.01 * 6);
    EXPECT_EQ(moved_by(x, 40), 0);
    for (int row = 16; row < 29; ++row) EXPECT_LT(moved_by(x, row + 1), moved_by(x, row) + 1e-9) << row;
    EXPECT_LT(moved_by(x, 28), 1.0) << "the wave has died down where it meets held tissue";
  }
}

TEST(Chain, DoesNotDependOnTheOrderOfSpringsOrTheirEnds) {
  const support::Slab slab = support::make_slab({});
  SpringNetwork shuffled = slab.network;
  const RandomStream random(5);
  for (std::size_t i = shuffled.springs.size() - 1; i > 0; --i) {
    std::swap(shuffled.springs[i], shuffled.springs[random.bits(i) % (i + 1)]);
    if (random.bits(i) % 3 == 0) std::swap(shuffled.springs[i].a, shuffled.springs[i].b);
  }
  const PrescribedMotion motion = third_of_the_bone(slab, {4, -3, 2});
  const std::vector<Vec3> x = solved(slab.network, motion, {}), y = solved(shuffled, motion, {});
  for (std::size_t i = 0; i < x.size(); ++i) EXPECT_LT(distance(x[i], y[i]), 1e-11);
}

TEST(Chain, RepeatsBitForBitInAUsedWorkspace) {
  const support::Slab slab = support::make_slab({});
  const ChainSolver solver(slab.network);
  const PrescribedMotion motion = third_of_the_bone(slab, {4, -3, 2});
  const std::vector<Vec3> fresh = solved(slab.network, motion, {});
  ChainWorkspace workspace;
  std::vector<Vec3> positions;
  ASSERT_TRUE(static_cast<bool>(solver.solve({{3}, {{1, 1, 1}}, {}}, {}, workspace, positions)));
  ASSERT_TRUE(static_cast<bool>(solver.solve(motion, {}, workspace, positions)));
  EXPECT_TRUE(positions == fresh);
  EXPECT_GT(workspace.steps, 3);
  EXPECT_EQ(workspace.prescribed, static_cast<int>(motion.moved.size() + motion.fixed.size()));
}

TEST(Chain, LeavesAloneWhatNothingJoinsToAMovedPoint) {
  const SpringNetwork net = network_of({{0, 0, 0}, {1, 0, 0}, {5, 5, 5}, {6, 5, 5}}, {{0, 1}, {2, 3}});
  const std::vector<Vec3> x = solved(net, {{0}, {{0, 0, 3}}, {}}, {});
  EXPECT_EQ(x[2], net.rest[2]);
  EXPECT_EQ(x[3], net.rest[3]);
}

TEST(Chain, KeepsItsDirectionWhereTheVectorVanishes) {
  // α = ½ and D = 2u: w = u − ½ · 2u = 0.
  const SpringNetwork net = network_of({{0, 0, 0}, {2, 0, 0}}, {{0, 1}});
  const std::vector<Vec3> x = solved(net, {{0}, {{4, 0, 0}}, {}}, as_printed(0.5, 1, 0.2));
  EXPECT_NEAR(x[1].x, 4 + 2 * (1 - 0.2 * (1 - std::exp(-1.0))), 1e-12);
  EXPECT_EQ(x[1].y, 0);
}

TEST(Chain, WildMotionsStayFinite) {
  const support::Slab slab = support::make_slab({});
  for (const double scale : {1e-300, 1e-9, 1e3, 9e8}) {
    PrescribedMotion motion = third_of_the_bone(slab, {});
    const RandomStream random(3);
    for (std::size_t i = 0; i < motion.positions.size(); ++i) {
      motion.positions[i] =
          Vec3{random.uniform(3 * i), -random.uniform(3 * i + 1), random.uniform(3 * i + 2)} * scale;
    }
    for (const ChainParameters& p : {ChainParameters{}, as_printed(0, 0, 0), as_printed(0.5, 1e6, 0.99)}) {
      for (const Vec3& v : solved(slab.network, motion, p)) ASSERT_TRUE(is_finite(v)) << scale;
    }
  }
}

TEST(Chain, BadParametersMotionsAndNetworksAreNamed) {
  const support::Slab slab = support::make_slab({});
  const ChainSolver solver(slab.network);
  const PrescribedMotion good = third_of_the_bone(slab, {1, 0, 0});
  constexpr double nan = std::numeric_limits<double>::quiet_NaN();
  const auto fault = [](const auto& result) { return result ? std::string() : result.error().message(); };
  const auto with = [](auto&& change) {
    ChainParameters p;
    change(p);
    return p;
  };
  EXPECT_NE(fault(solver.solve(good, with([](auto& p) { p.alpha = 1.1; }))).find("alpha is 1.1"),
            std::string::npos);
  EXPECT_NE(fault(solver.solve(good, with([&](auto& p) { p.column_alpha = nan; }))).find("alpha"),
            std::string::npos);
  EXPECT_NE(fault(solver.solve(good, with([](auto& p) { p.beta = -1; }))).find("beta"), std::string::npos);
  EXPECT_NE(fault(solver.solve(good, with([](auto& p) { p.max_compression = 1; }))).find("compression"),
            std::string::npos);
  EXPECT_NE(fault(solver.solve(good, with([](auto& p) { p.semi_active_passes = -1; }))).find("passes"),
            std::string::npos);
  PrescribedMotion bad = good;
  bad.positions.pop_back();
  EXPECT_NE(fault(solver.solve(bad, {})).find("positions given"), std::string::npos);
  bad = good;
  std::swap(bad.moved[0], bad.moved[1]);
  EXPECT_NE(fault(solver.solve(bad, {})).find("not ascending"), std::string::npos);
  bad = good;
  bad.moved.back() = 1'000'000;
  EXPECT_NE(fault(solver.solve(bad, {})).find("1000000"), std::string::npos);
  bad = good;
  bad.positions[2].z = nan;
  EXPECT_NE(fault(solver.solve(bad, {})).find("moved point 2"), std::string::npos);
  bad = good;
  bad.fixed.insert(bad.fixed.begin(), bad.moved.back());
  EXPECT_NE(fault(solver.solve(bad, {})).find("both moved and fixed"), std::string::npos);
  SpringNetwork broken = slab.network;
  broken.springs[0].rest_length_mm = -1;
  EXPECT_NE(fault(ChainSolver(broken).solve(good, {})).find("rest length of spring 0"), std::string::npos);
}

}  // namespace
}  // namespace turgor
