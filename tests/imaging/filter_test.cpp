#include "turgor/imaging/filter.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>

#include "imaging/imaging_support.hpp"
#include "turgor/core/parallel.hpp"
#include "turgor/imaging/histogram.hpp"

namespace turgor {
namespace {

using test::grid_of;

CtVolume noise(const Grid& grid, std::uint64_t seed, int lowest, int highest) {
  CtVolume volume(grid);
  const RandomStream random(seed);
  for (std::size_t v = 0; v < volume.voxels.size(); ++v) {
    volume.voxels[v] = static_cast<std::int16_t>(lowest + random.uniform(v) * (highest - lowest + 1));
  }
  return volume;
}

TEST(MedianFilter, IsTheMedianOfTwentySevenInVolumesOfEverySize) {
  for (const Index3 size : {Index3{1, 1, 1}, {2, 1, 3}, {15, 4, 3}, {16, 5, 4}, {17, 3, 6}, {37, 9, 8}}) {
    for (const int spread : {2, 32767}) {
      const CtVolume volume = noise(grid_of(size), 7, -spread, spread), filtered = median_filter(volume);
      for (int k = 0; k < size[2]; ++k) {
        for (int j = 0; j < size[1]; ++j) {
          for (int i = 0; i < size[0]; ++i) {
            std::array<std::int16_t, 27> around;
            for (int d = 0; d < 27; ++d) {
              around[static_cast<std::size_t>(d)] = volume.at(std::clamp(i + d % 3 - 1, 0, size[0] - 1),
                                                              std::clamp(j + d / 3 % 3 - 1, 0, size[1] - 1),
                                                              std::clamp(k + d / 9 - 1, 0, size[2] - 1));
            }
            std::nth_element(around.begin(), around.begin() + 13, around.end());
            ASSERT_EQ(filtered.at(i, j, k), around[13]);
          }
        }
      }
    }
  }
}

TEST(MedianFilter, GivesTheSameBitsOnOneAndTwoThreads) {
  const CtVolume volume = noise(grid_of({100, 70, 30}), 17, -1000, 3000);
  set_thread_count(1);
  const CtVolume one = median_filter(volume);
  set_thread_count(2);
  const CtVolume two = median_filter(volume);
  set_thread_count(0);
  EXPECT_EQ(one.voxels, two.voxels);
}

TEST(Histogram, CountsValuesInRangeAndMask) {
  CtVolume volume(grid_of({6, 1, 1}));
  volume.voxels = {-5, -5, 0, 2, 7, 30000};
  LabelVolume mask(volume.grid, 1);
  mask.voxels[0] = 0;
  const Histogram all = histogram(volume, -5, 7), some = histogram(volume, -5, 2, &mask);
  EXPECT_EQ(all.total(), 5u);
  EXPECT_EQ(all.count(-5), 2u);
  EXPECT_EQ(all.count(7), 1u);
  EXPECT_EQ(all.count(8), 0u);
  EXPECT_NEAR(all.mean(), -0.2, 1e-12);
  EXPECT_EQ(some.total(), 3u);
  EXPECT_EQ(some.count(-5), 1u);
  EXPECT_EQ(histogram(volume, 3, 1).total(), 0u);
}

TEST(Histogram, FindsQuantilesAndTheMode) {
  CtVolume volume = noise(grid_of({100, 100, 10}), 2, 0, 99);
  for (std::size_t v = 0; v < 20000; ++v) volume.voxels[v] = 40;
  const Histogram h = histogram(volume, -1000, 1000);
  EXPECT_EQ(h.quantile(0), 0);
  EXPECT_EQ(h.quantile(1), 99);
  EXPECT_NEAR(*h.quantile(0.1), 12, 1);
  EXPECT_EQ(h.quantile(0.5), 40);  // 33 % are random and at most 40, 20 % were put there
  EXPECT_EQ(h.mode(0), 40);
  EXPECT_NEAR(*h.mode(5), 40, 5);
  EXPECT_FALSE(histogram(volume, 500, 900).quantile(0.5).has_value());
  EXPECT_FALSE(histogram(volume, 500, 900).mode().has_value());
}

/// The variance between the classes below and from `level` on, as Otsu's formula has it.
double between_classes(const CtVolume& volume, double level) {
  double n[2] = {0, 0}, sum[2] = {0, 0};
  for (const std::int16_t v : volume.voxels) {
    const int side = v >= level ? 1 : 0;
    n[side] += 1;
    sum[side] += v;
  }
  const double gap = sum[0] / n[0] - sum[1] / n[1];
  return n[0] * n[1] * gap * gap;
}

TEST(OtsuLevel, HasTheLargestVarianceBetweenClasses) {
  CtVolume volume(grid_of({40, 40, 10}));
  const RandomStream random(3);
  for (std::size_t v = 0; v < volume.voxels.size(); ++v) {
    volume.voxels[v] =
        static_cast<std::int16_t>(v % 5 == 0 ? 1200 + 200 * random.normal(v) : 40 + 60 * random.normal(v));
  }
  const std::optional<double> level = otsu_level(histogram(volume, -2000, 3000), -2000, 3000);
  ASSERT_TRUE(level.has_value());
  const double best = between_classes(volume, *level);
  for (int other = -100; other < 1500; other += 7)
    ASSERT_LE(between_classes(volume, other), best * (1 + 1e-12));
}

TEST(OtsuLevel, LiesMidwayBetweenSeparatePeaksAndNeedsTwoValues) {
  CtVolume volume(grid_of({4, 1, 1}));
  volume.voxels = {0, 0, 100, 100};
  EXPECT_NEAR(*otsu_level(histogram(volume), -1000, 1000), 50.5, 0.51);
  EXPECT_FALSE(otsu_level(histogram(volume), 50, 1000).has_value());
  EXPECT_FALSE(otsu_level(histogram(volume), 2000, 1000).has_value());
}

}  // namespace
}  // namespace turgor
