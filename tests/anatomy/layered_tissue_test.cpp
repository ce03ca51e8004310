#include "turgor/anatomy/layered_tissue.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "support/phantom_case.hpp"
#include "turgor/anatomy/tissue_network.hpp"
#include "turgor/core/parallel.hpp"

namespace turgor {
namespace {

const LayeredTissue& phantom_tissue() {
  static const LayeredTissue tissue = [] {
    Context context;
    const auto& c = test::phantom_case();
    auto built = build_tissue(c.head, c.landmarks, {}, context);
    if (!built) {
      ADD_FAILURE() << built.error().message();
      std::abort();
    }
    return *std::move(built);
  }();
  return tissue;
}

TEST(SmallestPrismVolume, IsPositiveForASoundPrismAndNotForACrossedOne) {
  const Vec3 a{0, 0, 0}, b{1, 0, 0}, c{0, 1, 0}, down{0, 0, -1};
  EXPECT_DOUBLE_EQ(smallest_prism_volume(a, b, c, a + down, b + down, c + down), 1.0);
  EXPECT_LT(smallest_prism_volume(a, b, c, b + down, a + down, c + down), 0);
  EXPECT_LT(smallest_prism_volume(a, b, c, a - down, b + down, c + down), 0);
}

TEST(LayeredTissue, HasNoInvertedPrismAndCountsItsParts) {
  const LayeredTissue& t = phantom_tissue();
  EXPECT_EQ(count_inverted(t, t.points), 0);
  EXPECT_EQ(t.points.size(), static_cast<std::size_t>(t.columns() * t.sheets));
  EXPECT_EQ(t.sheets, 4);
  EXPECT_NEAR(t.columns(), TissueOptions{}.columns, 0.02 * TissueOptions{}.columns);
  EXPECT_GT(t.skin_points_above_bone, 0);
  EXPECT_GE(std::count(t.ends.begin(), t.ends.end(), ColumnEnd::none), t.rays_missed);
  EXPECT_LT(t.rays_missed, t.columns() / 2);
  EXPECT_NEAR(std::accumulate(t.layer_fractions.begin(), t.layer_fractions.end(), 0.0), 1.0, 1e-9);
}

TEST(LayeredTissue, ThicknessAgreesWithThePhantomsTruth) {
  const auto& phantom = test::phantom_case();
  const LayeredTissue& t = phantom_tissue();
  const double voxel = phantom.parameters.voxel_mm;
  std::vector<double> errors;
  for (int c = 0; c < t.columns(); ++c) {
    const auto i = static_cast<std::size_t>(c);
    if (t.ends[i] == ColumnEnd::none) continue;
    const Vec3& skin = t.points[i];
    const Vec3& bone = t.points[static_cast<std::size_t>(t.point(t.sheets - 1, c))];
    const Vec3 direction = normalized(bone - skin);
    // The exact ray starts on the exact skin, a little outside or inside of the one found.
    const double start = phantom.phantom.skin(skin);
    const auto exact = phantom.phantom.trace(PhantomSurface::bone, skin, direction, 60);
    if (exact) errors.push_back(std::abs(*exact - start - t.thickness_mm[i]) / voxel);
  }
  ASSERT_GT(errors.size(), 1000U);
  std::sort(errors.begin(), errors.end());
  const double mean = std::accumulate(errors.begin(), errors.end(), 0.0) / static_cast<double>(errors.size());
  const double percentile_99 = errors[errors.size() * 99 / 100];
  RecordProperty("mean_voxels", std::to_string(mean));
  RecordProperty("percentile_99_voxels", std::to_string(percentile_99));
  EXPECT_LT(mean, 0.5);
  EXPECT_LT(percentile_99, 2.0);
}

TEST(LayeredTissue, PartsTheLipsAndLeavesTheVestibuleFree) {
  const LayeredTissue& t = phantom_tissue();
  ASSERT_TRUE(t.slit.has_value());
  const auto upper = std::count(t.lip_side.begin(), t.lip_side.end(), 1);
  const auto lower = std::count(t.lip_side.begin(), t.lip_side.end(), -1);
  EXPECT_GT(upper, 5);
  EXPECT_EQ(upper, lower);
  int free_over_bone = 0;
  for (std::size_t c = 0; c < t.ends.size(); ++c)
    free_over_bone += t.ends[c] != ColumnEnd::none && !t.attached[c];
  EXPECT_GT(free_over_bone, 20);
}

TEST(LayeredTissue, IsTheSameOnOneAndTwoThreads) {
  const auto& c = test::phantom_case();
  Context context;
  set_thread_count(1);
  const auto one = build_tissue(c.head, c.landmarks, {}, context);
  set_thread_count(2);
  const auto two = build_tissue(c.head, c.landmarks, {}, context);
  set_thread_count(0);
  ASSERT_TRUE(one && two);
  EXPECT_TRUE(one->points == two->points);
}

TEST(LayeredTissue, TakesCentresLipLevelAndThicknessFromTheUser) {
  const auto& c = test::phantom_case();
  Context context;
  TissueOptions options;
  options.columns = 1200;
  options.upper_centre = phantom_tissue().upper_centre + Vec3{0, 10, 5};
  options.thickness_mm = {1.5, 3.0, 4.0};
  const auto t = build_tissue(c.head, c.landmarks, options, context);
  ASSERT_TRUE(static_cast<bool>(t)) << t.error().message();
  EXPECT_EQ(t->upper_centre, *options.upper_centre);
  for (int column = 0; column < t->columns(); ++column) {
    if (t->thickness_mm[static_cast<std::size_t>(column)] < 8.5) continue;
    const Vec3 &outer = t->points[static_cast<std::size_t>(t->point(0, column))],
               &inner = t->points[static_cast<std::size_t>(t->point(1, column))];
    ASSERT_NEAR(distance(outer, inner), 1.5, 1e-9);
  }
}

TEST(LayeredTissue, RefusesLayersWithoutThickness) {
  const auto& c = test::phantom_case();
  Context context;
  TissueOptions options;
  options.fractions = {0.5, -0.5};
  const auto t = build_tissue(c.head, c.landmarks, options, context);
  ASSERT_FALSE(static_cast<bool>(t));
  EXPECT_EQ(t.error().kind, ErrorKind::bad_command);
}

// Uniform strain: the network's energy must be that of the solid it stands for.
TEST(TissueNetwork, HasTheEnergyOfItsMaterialUnderUniformStretch) {
  LayeredTissue t;
  constexpr int n = 9;
  for (int j = 0; j < n; ++j) {
    for (int i = 0; i < n; ++i) t.surface.points.push_back({i + 0.5 * (j % 2), 0.8660254 * j, 0});
  }
  for (int j = 0; j + 1 < n; ++j) {
    for (int i = 0; i + 1 < n; ++i) {
      const int a = j * n + i, b = a + 1, c = a + n, d = c + 1;
      if (j % 2 == 0) {
        t.surface.triangles.insert(t.surface.triangles.end(), {Index3{a, b, c}, Index3{b, d, c}});
      } else {
        t.surface.triangles.insert(t.surface.triangles.end(), {Index3{a, b, d}, Index3{a, d, c}});
      }
    }
  }
  t.sheets = 4;
  for (int s = 0; s < t.sheets; ++s) {
    for (const Vec3& p : t.surface.points) t.points.push_back(p - Vec3{0, 0, 0.8 * s});
  }
  TissueMaterial material;
  material.young_mpa = {0.015};
  material.poisson = 0.25;
  const auto network = make_network(t, material);
  ASSERT_TRUE(static_cast<bool>(network)) << network.error().message();
  EXPECT_EQ(network->springs.size(), static_cast<std::size_t>(spring_count(t)));
  EXPECT_TRUE(network->volumes.empty());
  const double volume = surface_area(t.surface) * 0.8 * 3;
  // Dilatation by ε: the energy density of a Cauchy solid (ν = 1/4) is 9/2 K ε², K = 2E/3.
  constexpr double strain = 1e-4;
  double energy = 0;
  for (const Spring& s : network->springs) {
    energy += respond(s, s.rest_length_mm * (1 + strain)).energy;
  }
  EXPECT_NEAR(energy / volume, 4.5 * (2.0 * 0.015 / 3) * strain * strain, 1e-3 * energy / volume);
}

TEST(TissueNetwork, ChainNetworkHasThePapersRatioOfSpringsToPoints) {
  const auto& c = test::phantom_case();
  Context context;
  TissueOptions options;
  options.columns = 2628;
  options.fractions = {0.4, 0.6};  // three sheets, as in the paper
  const auto t = build_tissue(c.head, c.landmarks, options, context);
  ASSERT_TRUE(static_cast<bool>(t)) << t.error().message();
  const auto network = make_chain_network(*t);
  ASSERT_TRUE(static_cast<bool>(network));
  // The paper's cut-out has less rim for its area than this one.
  const double ratio = static_cast<double>(network->springs.size()) / static_cast<double>(t->points.size());
  EXPECT_NEAR(ratio, 19724.0 / 7884.0, 0.15);
}

}  // namespace
}  // namespace turgor
