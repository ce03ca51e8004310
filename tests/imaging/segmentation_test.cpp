#include "turgor/imaging/segmentation.hpp"

#include <gtest/gtest.h>

#include <deque>

#include "imaging/bit_volume.hpp"
#include "imaging/imaging_support.hpp"
#include "turgor/core/parallel.hpp"
#include "turgor/imaging/voxel_box.hpp"

namespace turgor {
namespace {

using test::grid_of;
using test::random_mask;

template <class Visit>
void for_each_voxel(const Grid& grid, Visit&& visit) {
  for (int k = 0; k < grid.size[2]; ++k) {
    for (int j = 0; j < grid.size[1]; ++j) {
      for (int i = 0; i < grid.size[0]; ++i) visit(i, j, k);
    }
  }
}

constexpr int kFaces[6][3] = {{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}};

/// Voxels of `mask` reached through faces from one voxel, breadth first.
std::vector<std::size_t> flood(const LabelVolume& mask, Index3 start, std::vector<bool>& seen) {
  std::vector<std::size_t> reached;
  std::deque<Index3> front{start};
  seen[mask.grid.offset(start[0], start[1], start[2])] = true;
  while (!front.empty()) {
    const Index3 v = front.front();
    front.pop_front();
    reached.push_back(mask.grid.offset(v[0], v[1], v[2]));
    for (const auto& f : kFaces) {
      const Index3 w{v[0] + f[0], v[1] + f[1], v[2] + f[2]};
      if (!mask.grid.contains(w[0], w[1], w[2])) continue;
      const std::size_t offset = mask.grid.offset(w[0], w[1], w[2]);
      if (seen[offset] || !mask.voxels[offset]) continue;
      seen[offset] = true;
      front.push_back(w);
    }
  }
  return reached;
}

/// Distance to the nearest set voxel, by trying them all.
Volume<double> brute_distance(const LabelVolume& mask) {
  const Vec3 s = mask.grid.spacing;
  std::vector<Vec3> set;
  for_each_voxel(mask.grid, [&](int i, int j, int k) {
    if (mask.at(i, j, k)) set.push_back({i * s.x, j * s.y, k * s.z});
  });
  Volume<double> distance(mask.grid, 1e30);
  for_each_voxel(mask.grid, [&](int i, int j, int k) {
    double least = 1e60;
    for (const Vec3& p : set) least = std::min(least, squared_length(p - Vec3{i * s.x, j * s.y, k * s.z}));
    distance.at(i, j, k) = std::sqrt(least);
  });
  return distance;
}

std::size_t count(const LabelVolume& mask) {
  std::size_t n = 0;
  for (const std::uint8_t v : mask.voxels) n += v != 0;
  return n;
}

LabelVolume inverse(LabelVolume mask) {
  for (std::uint8_t& v : mask.voxels) v = v ? 0 : 1;
  return mask;
}

TEST(BitVolume, PacksAndUnpacksRowsOfEveryLength) {
  for (const int n : {1, 7, 8, 63, 64, 65, 127, 128, 130}) {
    for (const int pad : {0, 1}) {
      const LabelVolume mask = random_mask(grid_of({n, 3, 2}), 0.5, static_cast<std::uint64_t>(n));
      const detail::BitVolume bits = detail::pack_nonzero(mask, pad);
      for_each_voxel(mask.grid, [&](int i, int j, int k) {
        ASSERT_EQ(bits.test(i + pad, j + pad, k + pad), mask.at(i, j, k) != 0);
      });
      std::size_t set = 0;
      for (const std::uint64_t word : bits.bits) set += static_cast<std::size_t>(std::popcount(word));
      EXPECT_EQ(set, count(mask));
      if (!pad) {
        EXPECT_EQ(detail::unpack(bits, mask.grid).voxels, mask.voxels);
        EXPECT_EQ(detail::unpack(detail::complement(bits), mask.grid).voxels, inverse(mask).voxels);
      }
    }
  }
}

TEST(Threshold, TakesBothEndsAndAnyInteger) {
  CtVolume volume(grid_of({5, 1, 1}));
  volume.voxels = {-32768, -1, 0, 1, 32767};
  EXPECT_EQ(threshold(volume, -1, 1).voxels, (std::vector<std::uint8_t>{0, 1, 1, 1, 0}));
  EXPECT_EQ(threshold(volume, -100000, 100000).voxels, (std::vector<std::uint8_t>{1, 1, 1, 1, 1}));
  EXPECT_EQ(threshold(volume, 40000, 50000).voxels, (std::vector<std::uint8_t>{0, 0, 0, 0, 0}));
  EXPECT_EQ(threshold(volume, 1, -1).voxels, (std::vector<std::uint8_t>{0, 0, 0, 0, 0}));
}

TEST(Components, AgreeWithFloodFillOnRandomMasks) {
  for (const double density : {0.2, 0.33, 0.6}) {
    const LabelVolume mask = random_mask(grid_of({70, 23, 21}), density, 4);
    const Components components = connected_components(mask);
    std::vector<bool> seen(mask.voxels.size(), false);
    std::size_t found = 0;
    for_each_voxel(mask.grid, [&](int i, int j, int k) {
      const std::size_t offset = mask.grid.offset(i, j, k);
      if (!mask.voxels[offset]) {
        ASSERT_EQ(components.labels.voxels[offset], 0);
        return;
      }
      if (seen[offset]) return;
      const std::vector<std::size_t> voxels = flood(mask, {i, j, k}, seen);
      const int label = components.labels.voxels[offset];
      ASSERT_GE(label, 1);
      ASSERT_EQ(components.sizes.at(static_cast<std::size_t>(label) - 1), voxels.size());
      for (const std::size_t v : voxels) ASSERT_EQ(components.labels.voxels[v], label);
      ++found;
    });
    EXPECT_EQ(found, components.sizes.size());
    EXPECT_TRUE(std::is_sorted(components.sizes.rbegin(), components.sizes.rend()));
  }
}

TEST(Components, OfNothingAreNone) {
  EXPECT_TRUE(connected_components(LabelVolume(grid_of({4, 4, 4}))).sizes.empty());
  EXPECT_EQ(count(largest_component(LabelVolume(grid_of({4, 4, 4})))), 0u);
  EXPECT_TRUE(connected_components(LabelVolume{}).sizes.empty());
}

TEST(Components, AreTheSameOnOneAndTwoThreads) {
  const LabelVolume mask = random_mask(grid_of({90, 80, 70}), 0.32, 9);
  set_thread_count(1);
  const Components one = connected_components(mask);
  set_thread_count(2);
  const Components two = connected_components(mask);
  set_thread_count(0);
  EXPECT_EQ(one.labels.voxels, two.labels.voxels);
  EXPECT_EQ(one.sizes, two.sizes);
}

TEST(Components, CanBeChosenBySizeAndBySeed) {
  LabelVolume mask(grid_of({9, 3, 3}));
  mask.at(0, 0, 0) = mask.at(1, 0, 0) = 1;
  mask.at(3, 1, 1) = mask.at(4, 1, 1) = mask.at(4, 1, 2) = 1;
  mask.at(8, 2, 2) = 1;
  const Components components = connected_components(mask);
  EXPECT_EQ(components.sizes, (std::vector<std::size_t>{3, 2, 1}));
  EXPECT_EQ(largest_component(mask).voxels, component_mask(components, 1).voxels);
  EXPECT_EQ(component_mask(components, 2).at(1, 0, 0), 1);
  EXPECT_EQ(count(remove_small_components(mask, 2)), 5u);
  const LabelVolume reached = reachable_from(mask, {{4, 1, 2}, {8, 2, 2}, {7, 2, 2}, {-1, 0, 40}});
  EXPECT_EQ(count(reached), 4u);
  EXPECT_EQ(reached.at(3, 1, 1), 1);
  EXPECT_EQ(reached.at(8, 2, 2), 1);
}

TEST(FillHoles, ClosesCavitiesAndLeavesOpenOnes) {
  LabelVolume mask(grid_of({9, 9, 9}));
  for_each_voxel(mask.grid, [&](int i, int j, int k) {
    const int d = std::max({std::abs(i - 4), std::abs(j - 4), std::abs(k - 4)});
    if (d == 3) mask.at(i, j, k) = 1;
  });
  EXPECT_EQ(count(fill_holes(mask)), 343u);
  mask.at(4, 4, 1) = 0;  // a door of one voxel
  EXPECT_EQ(fill_holes(mask).voxels, mask.voxels);
}

TEST(FillHoles, AgreesWithFloodFromTheBorderOnRandomMasks) {
  const LabelVolume mask = random_mask(grid_of({67, 20, 18}), 0.72, 8);
  const LabelVolume empty = inverse(mask), filled = fill_holes(mask);
  std::vector<bool> seen(mask.voxels.size(), false);
  for_each_voxel(mask.grid, [&](int i, int j, int k) {
    const bool border = i == 0 || j == 0 || k == 0 || i == 66 || j == 19 || k == 17;
    const std::size_t offset = mask.grid.offset(i, j, k);
    if (border && empty.voxels[offset] && !seen[offset]) flood(empty, {i, j, k}, seen);
  });
  for (std::size_t v = 0; v < mask.voxels.size(); ++v) ASSERT_EQ(filled.voxels[v] != 0, !seen[v]);
  EXPECT_GT(count(filled), count(mask));
}

TEST(Distance, IsExactWithAnisotropicSpacing) {
  for (const double density : {0.0005, 0.02, 0.5}) {
    const LabelVolume mask = random_mask(grid_of({37, 21, 18}, {0.9, 0.7, 1.9}), density, 6);
    ASSERT_GT(count(mask), 0u);
    const Volume<float> distance = distance_to(mask);
    const Volume<double> brute = brute_distance(mask);
    for (std::size_t v = 0; v < mask.voxels.size(); ++v)
      ASSERT_NEAR(distance.voxels[v], brute.voxels[v], 2e-5);
  }
}

TEST(Distance, CappedIsTheSmallerOfDistanceAndCap) {
  const LabelVolume mask = random_mask(grid_of({37, 24, 19}, {0.9, 0.7, 1.9}), 0.002, 16);
  const Volume<float> whole = distance_to(mask);
  for (const double cap : {0.0, 0.5, 3.0, 6.0, 12.0}) {
    const Volume<float> capped = distance_to(mask, cap);
    for (std::size_t v = 0; v < mask.voxels.size(); ++v) {
      ASSERT_NEAR(capped.voxels[v], std::min<double>(whole.voxels[v], cap), 1e-5) << cap;
    }
  }
  const LabelVolume nothing(grid_of({5, 6, 7}));
  for (const float d : distance_to(nothing, 9).voxels) ASSERT_EQ(d, 9.0F);
  for (const float d : distance_to(mask, -1).voxels) ASSERT_EQ(d, 0.0F);
}

TEST(Distance, IsTheSameOnOneAndTwoThreads) {
  const LabelVolume mask = random_mask(grid_of({70, 60, 50}, {0.9, 0.9, 1.5}), 0.001, 2);
  set_thread_count(1);
  const Volume<float> one = distance_to(mask);
  set_thread_count(2);
  const Volume<float> two = distance_to(mask);
  set_thread_count(0);
  EXPECT_EQ(one.voxels, two.voxels);
}

TEST(Morphology, IsByTheBallOfTheRadius) {
  const LabelVolume mask = random_mask(grid_of({70, 19, 15}, {0.9, 0.8, 1.5}), 0.004, 3);
  const LabelVolume dense = random_mask(grid_of({70, 19, 15}, {0.9, 0.8, 1.5}), 0.996, 3);
  const Volume<double> to_mask = brute_distance(mask), to_gap = brute_distance(inverse(dense));
  // 2.7 is three voxels along i, but for the last bit; 30 goes by the distance transform.
  for (const double radius : {0.5, 2.7, 4.0, 30.0}) {
    const LabelVolume grown = dilate(mask, radius), shrunk = erode(dense, radius);
    for (std::size_t v = 0; v < mask.voxels.size(); ++v) {
      ASSERT_EQ(grown.voxels[v] != 0, to_mask.voxels[v] <= radius + 1e-5) << radius;
      ASSERT_EQ(shrunk.voxels[v] != 0, to_gap.voxels[v] > radius + 1e-5) << radius;
    }
  }
}

TEST(Morphology, ClosingAddsAndOpeningRemovesAndBothAreIdempotent) {
  const LabelVolume mask = random_mask(grid_of({66, 30, 25}), 0.4, 12);
  const LabelVolume closed = close_gaps(mask, 1.5), opened = open_gaps(mask, 1.0);
  for (std::size_t v = 0; v < mask.voxels.size(); ++v) {
    ASSERT_GE(closed.voxels[v], mask.voxels[v]);
    ASSERT_LE(opened.voxels[v], mask.voxels[v]);
  }
  EXPECT_GT(count(closed), count(mask));
  EXPECT_LT(count(opened), count(mask));
  EXPECT_EQ(close_gaps(closed, 1.5).voxels, closed.voxels);
  EXPECT_EQ(open_gaps(opened, 1.0).voxels, opened.voxels);
  EXPECT_EQ(dilate(mask, 0).voxels, mask.voxels);
  EXPECT_EQ(close_gaps(mask, -1).voxels, mask.voxels);
}

TEST(Morphology, DoesNotErodeABodyFromTheEndOfTheVolume) {
  const LabelVolume solid(grid_of({10, 10, 10}), 1);
  EXPECT_EQ(erode(solid, 3).voxels, solid.voxels);
}

/// Two rooms joined by a corridor round a wall.
LabelVolume rooms() {
  LabelVolume mask(grid_of({21, 9, 1}, {0.5, 0.5, 1}));
  for_each_voxel(mask.grid, [&](int i, int j, int k) {
    if (i != 10 || j == 8) mask.at(i, j, k) = 1;
  });
  return mask;
}

TEST(Geodesic, DistanceGoesRoundWalls) {
  const LabelVolume mask = rooms();
  LabelVolume seed(mask.grid);
  seed.at(9, 0, 0) = 1;
  const Volume<float> distance = geodesic_distance(mask, seed, 100);
  EXPECT_NEAR(distance.at(9, 8, 0), 4.0, 1e-5);
  EXPECT_NEAR(distance.at(10, 8, 0), 0.5 * (7 + std::sqrt(2.0)), 1e-5);
  EXPECT_NEAR(distance.at(11, 0, 0), 0.5 * (14 + 2 * std::sqrt(2.0)), 1e-5);  // 1 mm as the crow flies
  EXPECT_EQ(distance.at(10, 0, 0), 100.0F);
}

TEST(Geodesic, DistanceAgreesWithRelaxationOnRandomMasks) {
  const LabelVolume mask = random_mask(grid_of({30, 20, 12}, {0.9, 0.7, 1.9}), 0.25, 31);
  LabelVolume seeds = random_mask(mask.grid, 0.002, 32);
  const Volume<float> distance = geodesic_distance(mask, seeds, 1000);
  Volume<float> slow(mask.grid, 1000.0F);
  for (std::size_t v = 0; v < mask.voxels.size(); ++v) {
    if (mask.voxels[v] && seeds.voxels[v]) slow.voxels[v] = 0;
  }
  for (bool changed = true; changed;) {
    changed = false;
    for_each_voxel(mask.grid, [&](int i, int j, int k) {
      if (!mask.at(i, j, k)) return;
      for (int d = 0; d < 27; ++d) {
        const int di = d % 3 - 1, dj = d / 3 % 3 - 1, dk = d / 9 - 1;
        if (!mask.grid.contains(i + di, j + dj, k + dk) || !mask.at(i + di, j + dj, k + dk)) continue;
        const auto step = static_cast<float>(length(Vec3{0.9 * di, 0.7 * dj, 1.9 * dk}));
        const float through = slow.at(i + di, j + dj, k + dk) + step;
        if (through < slow.at(i, j, k)) slow.at(i, j, k) = through, changed = true;
      }
    });
  }
  for (std::size_t v = 0; v < mask.voxels.size(); ++v) ASSERT_NEAR(distance.voxels[v], slow.voxels[v], 1e-4);
}

TEST(Geodesic, LabelsGrowOnlyThroughTheMaskToTheNearestSeed) {
  const LabelVolume mask = rooms();
  LabelVolume seeds(mask.grid);
  seeds.at(0, 0, 0) = 2;
  seeds.at(11, 0, 0) = 5;
  seeds.at(10, 3, 0) = 9;  // in the wall
  const LabelVolume grown = grow_labels(mask, seeds);
  EXPECT_EQ(grown.at(8, 0, 0), 2);
  EXPECT_EQ(grown.at(20, 8, 0), 5);
  EXPECT_EQ(grown.at(10, 3, 0), 0);
  EXPECT_EQ(count(grown), count(mask));
  EXPECT_EQ(grow_labels(mask, seeds, 1.0).at(2, 0, 0), 2);
  EXPECT_EQ(grow_labels(mask, seeds, 1.0).at(3, 0, 0), 0);
}

TEST(Geodesic, GivesTheSmallerLabelWhereSeedsAreEquallyNear) {
  const LabelVolume mask(grid_of({7, 1, 1}), 1);
  LabelVolume seeds(mask.grid);
  seeds.at(0, 0, 0) = 8;
  seeds.at(6, 0, 0) = 3;
  EXPECT_EQ(grow_labels(mask, seeds).voxels, (std::vector<std::uint8_t>{8, 8, 8, 3, 3, 3, 3}));
}

TEST(VoxelBox, BoundsCropsAndPastesBack) {
  const Grid grid = grid_of({80, 12, 9}, {0.5, 1, 2}, {3, 4, 5}, rotation({0, 0, 1}, 0.3));
  LabelVolume mask(grid);
  EXPECT_TRUE(bounding_box(mask).empty());
  mask.at(3, 4, 5) = 1;
  mask.at(70, 4, 7) = 2;
  EXPECT_EQ(bounding_box(mask), (VoxelBox{{3, 4, 5}, {70, 4, 7}}));
  const VoxelBox box = bounding_box(mask, 2);
  EXPECT_EQ(box, (VoxelBox{{1, 2, 3}, {72, 6, 8}}));
  const LabelVolume part = crop(mask, box);
  EXPECT_EQ(part.grid.size, box.size());
  EXPECT_EQ(part.at(2, 2, 2), 1);
  EXPECT_EQ(part.at(69, 2, 4), 2);
  EXPECT_LT(distance(part.grid.to_patient({2, 2, 2}), grid.to_patient({3, 4, 5})), 1e-12);
  LabelVolume copy(grid);
  paste(copy, part, box.lower);
  EXPECT_EQ(copy.voxels, mask.voxels);
  EXPECT_TRUE(crop(mask, VoxelBox{{90, 0, 0}, {95, 3, 3}}).voxels.empty());
  paste(copy, part, {79, 11, 8});  // all but one voxel lies outside
  EXPECT_EQ(copy.at(79, 11, 8), part.at(0, 0, 0));
}

}  // namespace
}  // namespace turgor
