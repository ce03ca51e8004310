// Flesh whose resolution follows its deformation.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>
#include <functional>
#include <limits>
#include <map>
#include <numeric>
#include <string>

#include "support/grid_surface.hpp"
#include "turgor/anatomy/flesh.hpp"
#include "turgor/core/index.hpp"
#include "turgor/core/random.hpp"
#include "turgor/tissue/network_energy.hpp"

namespace turgor {
namespace {

using support::make_grid;

Flesh make_flesh(const Polyhedron& source, const FleshOptions& options = {}) {
  auto flesh = flesh_out(source, options);
  EXPECT_TRUE(flesh) << flesh.error().message();
  return *flesh;
}

// A sheet that is not regular, of samples that all differ.
Flesh uneven_flesh() {
  Polyhedron source = make_grid(7, 6);
  const RandomStream random(4);
  for (std::size_t i = 0; i < source.points.size(); ++i) {
    source.points[i] += Vec3{0.1 * random.normal(2 * i), 0.1 * random.normal(2 * i + 1), 0};
    source.points[i].z = 0.05 * source.points[i].x * source.points[i].y;
  }
  FleshOptions options;
  options.thickness = {{0.4}, {0.3}};
  options.volume_modulus_mpa = 0.1;
  Flesh flesh = make_flesh(source, options);
  for (std::size_t i = 0; i < flesh.samples.size(); ++i) {
    flesh.samples[i].mass_g = 1 + 0.01 * static_cast<double>(i);
    flesh.samples[i].growth = 1 + 0.001 * static_cast<double>(i);
    flesh.samples[i].mobile = i % 3 != 0;
  }
  return flesh;
}

double mass_of(const Flesh& flesh) {
  double sum = 0;
  for (const FleshSample& s : flesh.samples) sum += s.mass_g;
  return sum;
}

bool same(const FleshSample& a, const FleshSample& b) {
  return a.rest == b.rest && a.mass_g == b.mass_g && a.mobile == b.mobile && a.growth == b.growth &&
         a.stiffness == b.stiffness && a.spacing == b.spacing;
}

bool same(const Flesh& a, const Flesh& b) {
  return a.surface.points == b.surface.points && a.surface.corners == b.surface.corners &&
         a.surface.ends == b.surface.ends && a.layers == b.layers &&
         std::equal(a.samples.begin(), a.samples.end(), b.samples.begin(), b.samples.end(),
                    [](const FleshSample& x, const FleshSample& y) { return same(x, y); });
}

Vec3 centre(const Flesh& flesh, int polygon) {
  Vec3 sum;
  for (const int p : flesh.surface.polygon(polygon)) sum += flesh.surface.points[at(p)];
  return sum / 3.0;
}

// 1 where `wanted` holds at the middle of a polygon, else 0.
std::vector<double> where(const Flesh& flesh, const std::function<bool(const Vec3&)>& wanted) {
  std::vector<double> measure;
  for (int i = 0; i < flesh.surface.polygon_count(); ++i) measure.push_back(wanted(centre(flesh, i)) ? 1 : 0);
  return measure;
}

FleshMap adapted(AdaptiveFlesh& flesh, const std::vector<double>& measure, int most_levels = 1) {
  RefinementOptions options;
  options.most_levels = most_levels;
  auto map = flesh.adapt(measure, options);
  EXPECT_TRUE(map) << map.error().message();
  return *map;
}

std::map<Edge, int> uses_of_edges(const Polyhedron& surface) {
  std::map<Edge, int> uses;
  for (int i = 0; i < surface.polygon_count(); ++i) {
    const auto p = surface.polygon(i);
    for (std::size_t k = 0; k < p.size(); ++k) {
      const auto [a, b] = std::minmax(p[k], p[(k + 1) % p.size()]);
      ++uses[{a, b}];
    }
  }
  return uses;
}

double rim_length(const Polyhedron& surface) {
  double sum = 0;
  for (const auto& [edge, uses] : uses_of_edges(surface)) {
    EXPECT_LE(uses, 2);
    if (uses == 1) sum += distance(surface.points[at(edge[0])], surface.points[at(edge[1])]);
  }
  return sum;
}

TEST(AdaptiveFlesh, SplitsWhereAskedAndLeavesNoEdgeHanging) {
  const Flesh base = uneven_flesh();
  AdaptiveFlesh adaptive(base);
  const double area = surface_area(triangulated(adaptive.flesh().surface));
  const double rim = rim_length(adaptive.flesh().surface), mass = mass_of(base);
  const RandomStream random(8);
  std::size_t most = 0;
  std::ptrdiff_t merged = 0;
  for (int round = 0; round < 12; ++round) {
    // A place that wanders and tears some polygons at random: splits and merges on all levels.
    const Flesh before = adaptive.flesh();
    std::vector<double> measure;
    for (int i = 0; i < before.surface.polygon_count(); ++i) {
      const double noise = random.uniform(static_cast<std::uint64_t>(1000 * round + i));
      const bool near = length(centre(before, i) - Vec3{0.5 * round, 2, 0}) < 1.5;
      measure.push_back(near || noise > 0.99 ? 1 : 0.2 * noise);
    }
    const FleshMap map = adapted(adaptive, measure, 3);
    const Flesh& after = adaptive.flesh();
    most = std::max(most, after.surface.ends.size());
    ASSERT_TRUE(validate(after));
    // A hanging edge would count as rim on both its sides.
    EXPECT_NEAR(rim_length(after.surface), rim, 1e-9);
    EXPECT_NEAR(surface_area(triangulated(after.surface)), area, 1e-9);
    EXPECT_NEAR(mass_of(after), mass, 1e-10);
    for (int c = 0; c < base.columns(); ++c)
      EXPECT_EQ(after.surface.points[at(c)], base.surface.points[at(c)]);
    ASSERT_EQ(map.new_of_old.size(), before.samples.size());
    merged += std::count(map.new_of_old.begin(), map.new_of_old.end(), -1);
    ASSERT_EQ(map.origin.size(), after.samples.size());
    for (std::size_t i = 0; i < map.origin.size(); ++i) {
      const auto [a, b] = map.origin[i];
      EXPECT_LT(
          distance(after.samples[i].rest, (before.samples[at(a)].rest + before.samples[at(b)].rest) * 0.5),
          1e-14);
      if (a == b) {
        EXPECT_EQ(map.new_of_old[at(a)], static_cast<int>(i));
      }
    }
    for (std::size_t i = 0; i < map.new_of_old.size(); ++i) {
      if (map.new_of_old[i] >= 0) {
        EXPECT_EQ(before.samples[i].rest, after.samples[at(map.new_of_old[i])].rest);
      }
    }
    EXPECT_TRUE(make_network(after)) << make_network(after).error().message();
  }
  EXPECT_GT(most, 10 * base.surface.ends.size());
  EXPECT_GT(merged, 1000) << "it merges as well as it splits";
}

TEST(AdaptiveFlesh, RefinedThenMergedIsTheBaseBitForBit) {
  AdaptiveFlesh adaptive(uneven_flesh());
  const Flesh base = adaptive.flesh();
  for (int round = 0; round < 2; ++round) {
    adapted(adaptive, where(adaptive.flesh(), [](const Vec3& p) { return p.x < 3; }), 2);
  }
  EXPECT_GT(adaptive.flesh().columns(), 3 * base.columns());
  for (int round = 0; round < 2; ++round) {
    adapted(adaptive, std::vector<double>(adaptive.flesh().surface.ends.size(), 0.0), 2);
  }
  EXPECT_TRUE(same(adaptive.flesh(), base));
  // Fewer levels than it has: down at once.
  adapted(adaptive, std::vector<double>(base.surface.ends.size(), 1.0), 1);
  adapted(adaptive, std::vector<double>(adaptive.flesh().surface.ends.size(), 1.0), 0);
  EXPECT_TRUE(same(adaptive.flesh(), base));
}

TEST(AdaptiveFlesh, StaysAsItIsBetweenTheLimits) {
  AdaptiveFlesh adaptive(uneven_flesh());
  adapted(adaptive, where(adaptive.flesh(), [](const Vec3& p) { return p.x < 3; }));
  const Flesh before = adaptive.flesh();
  const FleshMap map = adapted(adaptive, std::vector<double>(before.surface.ends.size(), 0.3));
  EXPECT_TRUE(same(adaptive.flesh(), before));
  std::vector<int> identity(before.samples.size());
  std::iota(identity.begin(), identity.end(), 0);
  EXPECT_EQ(map.new_of_old, identity);
}

TEST(AdaptiveFlesh, DependsOnWhatIsSplitAndNotOnTheOrder) {
  const auto left = [](const Vec3& p) { return p.x < 2; };
  const auto right = [](const Vec3& p) { return p.x > 4; };
  RefinementOptions keep;
  keep.merge_below = -1;  // splits only
  AdaptiveFlesh one(uneven_flesh()), other(uneven_flesh());
  ASSERT_TRUE(one.adapt(where(one.flesh(), left), keep));
  ASSERT_TRUE(one.adapt(where(one.flesh(), right), keep));
  ASSERT_TRUE(other.adapt(where(other.flesh(), right), keep));
  ASSERT_TRUE(other.adapt(where(other.flesh(), left), keep));
  EXPECT_TRUE(same(one.flesh(), other.flesh()));
}

TEST(AdaptiveFlesh, OneTriangleHandsItsMassOnByArea) {
  Polyhedron triangle;
  triangle.points = {{0, 0, 0}, {4, 0, 0}, {0, 4, 0}};
  triangle.add_polygon(std::array{0, 1, 2});
  FleshOptions options;
  options.thickness = {};
  options.mass_g = 4;  // 12 g over the triangle; each of the four parts has 3 g, a third of it at each corner
  AdaptiveFlesh adaptive(make_flesh(triangle, options));
  adapted(adaptive, {1});
  const Flesh& flesh = adaptive.flesh();
  ASSERT_EQ(flesh.columns(), 6);
  for (int c = 0; c < 6; ++c) EXPECT_DOUBLE_EQ(flesh.samples[at(c)].mass_g, c < 3 ? 1 : 3);
  for (const FleshSample& s : flesh.samples) EXPECT_DOUBLE_EQ(s.spacing, 0.5);
}

TEST(AdaptiveFlesh, InterpolatesWhatWasSetOnSamples) {
  Flesh base = make_flesh(make_grid(3, 3));
  for (FleshSample& s : base.samples) {
    s.growth = 1 + 0.1 * s.rest.x;
    s.stiffness = 2 + s.rest.y;
    s.mobile = s.rest.x > 0;  // the left rim is held
  }
  AdaptiveFlesh adaptive(base);
  for (int round = 0; round < 2; ++round) {
    adapted(adaptive, std::vector<double>(adaptive.flesh().surface.ends.size(), 1.0), 2);
  }
  EXPECT_EQ(adaptive.flesh().columns(), 81);
  for (const FleshSample& s : adaptive.flesh().samples) {
    EXPECT_NEAR(s.growth, 1 + 0.1 * s.rest.x, 1e-14);
    EXPECT_NEAR(s.stiffness, 2 + s.rest.y, 1e-14);
    EXPECT_EQ(s.mobile, s.rest.x > 0);
    EXPECT_DOUBLE_EQ(s.spacing, 0.25);
  }
}

TEST(AdaptiveFlesh, TakesEditsOfItsBaseAndKeepsItsSplits) {
  AdaptiveFlesh adaptive(uneven_flesh());
  adapted(adaptive, where(adaptive.flesh(), [](const Vec3& p) { return p.x < 3; }));
  const Flesh before = adaptive.flesh();
  Flesh base = adaptive.base();
  for (FleshSample& s : base.samples) s.growth = 1.5;
  ASSERT_TRUE(adaptive.set_base(base));
  EXPECT_EQ(adaptive.flesh().surface.corners, before.surface.corners);
  for (const FleshSample& s : adaptive.flesh().samples) EXPECT_EQ(s.growth, 1.5);
  adapted(adaptive, std::vector<double>(before.surface.ends.size(), 0.0));
  EXPECT_TRUE(same(adaptive.flesh(), base));
  EXPECT_FALSE(adaptive.set_base(make_flesh(make_grid(3, 3))));
  base.samples[0].growth = -1;
  EXPECT_FALSE(adaptive.set_base(base));
}

// A strip between two clamps, at rest in them: its force along x. Heavy-ball descent.
double clamped_force(const Flesh& flesh, double stretch, double strip_length) {
  const SpringNetwork network = make_network(flesh)->network;
  const auto energy = NetworkEnergy::prepare(network);
  std::vector<Vec3> x = network.rest, v(x.size()), f(x.size());
  for (Vec3& p : x) p.x *= 1 + stretch;
  NetworkEnergy::Workspace workspace;
  std::vector<double> stiffness(x.size(), 0);
  for (const Spring& s : network.springs) {
    for (const int end : {s.a, s.b}) stiffness[at(end)] += 2 * s.stiffness_n / s.rest_length_mm;
  }
  const auto is_clamped = [&](std::size_t i) {
    return network.rest[i].x < 1e-9 || network.rest[i].x > strip_length - 1e-9;
  };
  for (int step = 0; step < 1000; ++step) {
    energy->forces(x, f, workspace);
    for (std::size_t i = 0; i < x.size(); ++i) {
      if (is_clamped(i)) continue;
      v[i] = v[i] * 0.97 + f[i] / stiffness[i];
      x[i] += v[i];
    }
  }
  energy->forces(x, f, workspace);
  double pull = 0;
  for (std::size_t i = 0; i < x.size(); ++i) {
    if (!is_clamped(i)) {
      EXPECT_LT(length(f[i]), 1e-5) << "not at rest";
    } else if (network.rest[i].x < 1e-9) {
      pull += f[i].x;
    }
  }
  return pull;
}

TEST(AdaptiveFlesh, StripRefinedInOneHalfCarriesTheSameForce) {
  FleshOptions options;
  // Layers as thick as the grid is wide lose 12 %, by the steeper diagonals; these 1 and 9 %.
  for (const double thickness : {0.1, 0.5}) {
    options.thickness = {{thickness}, {thickness}};
    AdaptiveFlesh adaptive(make_flesh(make_grid(17, 13), options));
    const double coarse = clamped_force(adaptive.flesh(), 0.1, 16);
    adapted(adaptive, where(adaptive.flesh(), [](const Vec3& p) { return p.x < 8; }));
    const double half = clamped_force(adaptive.flesh(), 0.1, 16);
    EXPECT_NEAR(half, coarse, 0.1 * coarse);
  }
}

TEST(AdaptiveFlesh, SaysWhatIsWrongAndChangesNothing) {
  AdaptiveFlesh adaptive(make_flesh(make_grid(3, 3)));
  const Flesh before = adaptive.flesh();
  RefinementOptions options;
  std::vector<double> measure(8, 1.0);
  EXPECT_FALSE(adaptive.adapt(std::vector<double>(4, 1.0), options));
  measure[3] = std::numeric_limits<double>::quiet_NaN();
  EXPECT_NE(adaptive.adapt(measure, options).error().what.find("polygon 3"), std::string::npos);
  measure[3] = std::numeric_limits<double>::infinity();
  options.most_levels = -1;
  EXPECT_FALSE(adaptive.adapt(measure, options));
  options.most_levels = 1'000'000'000;
  EXPECT_FALSE(adaptive.adapt(measure, options));
  options.most_levels = 1;
  options.merge_below = 2;
  EXPECT_FALSE(adaptive.adapt(measure, options));
  EXPECT_TRUE(same(adaptive.flesh(), before));
  options.merge_below = 0.1;
  EXPECT_TRUE(adaptive.adapt(measure, options));
  Flesh damaged = before;
  damaged.surface.corners[0] = 77;
  EXPECT_NE(AdaptiveFlesh(damaged).adapt({1}, options).error().what.find("names point 77"),
            std::string::npos);
}

}  // namespace
}  // namespace turgor
