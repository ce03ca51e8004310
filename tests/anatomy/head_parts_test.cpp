// The steps from scan to head, each on input made for it.
#include <gtest/gtest.h>

#include <cmath>

#include "anatomy/body_mask.hpp"
#include "anatomy/bone_flood.hpp"
#include "anatomy/head_surface.hpp"
#include "anatomy/symmetry.hpp"
#include "anatomy/teeth.hpp"
#include "anatomy/tissue_levels.hpp"
#include "turgor/core/random.hpp"
#include "turgor/imaging/isosurface.hpp"
#include "turgor/imaging/segmentation.hpp"

namespace turgor {
namespace {

Grid cube(int n, double spacing) {
  Grid g;
  g.size = {n, n, n};
  g.spacing = {spacing, spacing, spacing};
  const double half = -0.5 * spacing * (n - 1);
  g.origin = {half, half, half};
  return g;
}

template <class T, class Value>
Volume<T> made(const Grid& g, Value&& value) {
  Volume<T> volume(g);
  for (int k = 0; k < g.size[2]; ++k) {
    for (int j = 0; j < g.size[1]; ++j) {
      for (int i = 0; i < g.size[0]; ++i) {
        volume.at(i, j, k) = static_cast<T>(value(g.to_patient({double(i), double(j), double(k)})));
      }
    }
  }
  return volume;
}

TEST(TissueLevels, SkinLevelIsMidwayAndBoneLevelAQuarterUp) {
  const Grid g = cube(60, 4);
  const RandomStream random(5);
  CtVolume hu = made<std::int16_t>(g, [](const Vec3& p) {
    const double r = length(p);
    return r < 70 ? 40 : r < 80 ? 1000 : r < 90 ? 40 : -1000;
  });
  for (std::size_t v = 0; v < hu.voxels.size(); ++v) {
    hu.voxels[v] = static_cast<std::int16_t>(hu.voxels[v] + std::lround(10 * random.normal(v)));
  }
  auto levels = measure_air_and_soft_tissue(hu);
  ASSERT_TRUE(levels) << levels.error().message();
  EXPECT_NEAR(levels->skin_level, -480, 6);
  EXPECT_NEAR(levels->soft_sigma, 10, 3);
  const LabelVolume body = threshold(hu, static_cast<int>(levels->skin_level), 4000);
  ASSERT_TRUE(measure_bone(hu, body, {}, *levels));
  EXPECT_NEAR(levels->bone, 1000, 6);
  EXPECT_NEAR(levels->bone_level, 40 + 0.25 * 960, 6);
  HeadOptions fixed;
  fixed.refine_bone_threshold = false;
  fixed.bone_threshold_hu = 300;
  ASSERT_TRUE(measure_bone(hu, body, fixed, *levels));
  EXPECT_NEAR(levels->bone_level, 300, 1);
}

TEST(AttachedObjects, PlateGoesEarStaysAndPlainBodyIsUntouched) {
  const Grid g = cube(130, 2);
  const auto head = [](const Vec3& p) { return length(Vec3{p.x, p.y * 0.85, p.z * 0.8}) < 70; };
  const auto ear = [](const Vec3& p) {
    return std::abs(p.x - 72) < 14 && std::abs(p.y) < 3 && std::abs(p.z) < 26;
  };
  const auto plate = [](const Vec3& p) {
    return std::abs(p.y - 84) < 3 && std::abs(p.x) < 90 && std::abs(p.z) < 90;
  };
  const LabelVolume plain = made<std::uint8_t>(g, [&](const Vec3& p) { return head(p) || ear(p); });
  int removed = 0;
  EXPECT_EQ(without_attached_objects(plain, removed).voxels, plain.voxels);
  EXPECT_EQ(removed, 0);

  const LabelVolume held =
      made<std::uint8_t>(g, [&](const Vec3& p) { return head(p) || ear(p) || plate(p); });
  const LabelVolume freed = without_attached_objects(held, removed);
  EXPECT_EQ(removed, 1);
  std::size_t lost = 0, lost_of_ear = 0, kept_of_plate = 0;
  for (int k = 0; k < g.size[2]; ++k) {
    for (int j = 0; j < g.size[1]; ++j) {
      for (int i = 0; i < g.size[0]; ++i) {
        const Vec3 p = g.to_patient({double(i), double(j), double(k)});
        if (ear(p)) lost_of_ear += freed.at(i, j, k) == 0;
        if (head(p) && p.y < 70) lost += freed.at(i, j, k) == 0;
        if (plate(p) && !head(p)) kept_of_plate += freed.at(i, j, k) != 0;
      }
    }
  }
  EXPECT_EQ(lost_of_ear, 0U);
  EXPECT_LT(lost, 100U);
  EXPECT_LT(kept_of_plate, 200U);
}

/// The density of the best path from the label's markers to every voxel by relaxation until nothing changes.
std::vector<int> bottlenecks(const CtVolume& hu, const LabelVolume& bone, const LabelVolume& markers,
                             std::uint8_t label) {
  const Grid& g = hu.grid;
  const auto level = [&](std::size_t v) { return (hu.voxels[v] + 1024) / 16; };
  std::vector<int> best(hu.voxels.size(), -1);
  for (std::size_t v = 0; v < best.size(); ++v) {
    if (bone.voxels[v] != 0 && markers.voxels[v] == label) best[v] = level(v);
  }
  for (bool changed = true; changed;) {
    changed = false;
    for (int k = 0; k < g.size[2]; ++k) {
      for (int j = 0; j < g.size[1]; ++j) {
        for (int i = 0; i < g.size[0]; ++i) {
          const std::size_t v = g.offset(i, j, k);
          if (bone.voxels[v] == 0 || markers.voxels[v] != 0) continue;
          for (const Index3 d : {Index3{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}}) {
            if (!g.contains(i + d[0], j + d[1], k + d[2])) continue;
            const int through = std::min(best[g.offset(i + d[0], j + d[1], k + d[2])], level(v));
            if (through > best[v]) best[v] = through, changed = true;
          }
        }
      }
    }
  }
  return best;
}

TEST(BoneFlood, GivesEachVoxelToTheMarkerWithTheDensestPath) {
  const Grid g = cube(9, 1);
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    const RandomStream random(seed);
    CtVolume hu(g);
    LabelVolume bone(g), markers(g);
    for (std::size_t v = 0; v < hu.voxels.size(); ++v) {
      hu.voxels[v] = static_cast<std::int16_t>(250 + 1500 * random.uniform(2 * v));
      bone.voxels[v] = random.uniform(2 * v + 1) < 0.7;
    }
    markers.voxels[g.offset(0, 0, 0)] = 1;
    markers.voxels[g.offset(8, 8, 8)] = 2;
    bone.voxels[g.offset(0, 0, 0)] = bone.voxels[g.offset(8, 8, 8)] = 1;
    const LabelVolume labels = flood_by_density(hu, bone, markers);
    const std::vector<int> first = bottlenecks(hu, bone, markers, 1),
                           second = bottlenecks(hu, bone, markers, 2);
    for (std::size_t v = 0; v < labels.voxels.size(); ++v) {
      if (first[v] == second[v] && first[v] >= 0) {
        EXPECT_NE(labels.voxels[v], 0);
        continue;
      }
      const int expected = first[v] < 0 && second[v] < 0 ? 0 : first[v] > second[v] ? 1 : 2;
      EXPECT_EQ(int(labels.voxels[v]), expected) << "seed " << seed << " voxel " << v;
    }
  }
}

TEST(BoneFlood, PartsTwoBallsAtTheirBridge) {
  const Grid g = cube(61, 1);
  const CtVolume hu = made<std::int16_t>(g, [](const Vec3& p) {
    const double first = length(p - Vec3{-11, 0, 0}), second = length(p - Vec3{11, 0, 0});
    return first < 10 || second < 10 ? 1200 : std::hypot(p.y, p.z) < 4 && std::abs(p.x) < 11 ? 500 : 0;
  });
  const LabelVolume bone = threshold(hu, 250, 4000);
  LabelVolume markers(g);
  markers.at(10, 30, 30) = 1;
  markers.at(50, 30, 30) = 2;
  const LabelVolume labels = flood_by_density(hu, bone, markers);
  for (int k = 0; k < 61; ++k) {
    for (int j = 0; j < 61; ++j) {
      for (int i = 0; i < 61; ++i) {
        if (hu.at(i, j, k) == 1200) {
          EXPECT_EQ(int(labels.at(i, j, k)), i < 30 ? 1 : 2);
        }
      }
    }
  }
}

TEST(OcclusalPlane, LiesInTheGapBetweenTwoTiltedRows) {
  const Vec3 up = normalized(Vec3{0.05, -0.12, 1});
  const double height = 3;
  const Grid g = cube(90, 1);
  const auto density = [&](const Vec3& p) {
    const double h = dot(p, up) - height;
    const double arch = std::hypot(p.x / 26, (p.y - 20) / 40);
    const bool row = arch > 0.82 && arch < 1.1 && p.y < 20;
    const double tooth = std::fmod(std::atan2(p.x, 20 - p.y) + 10, 0.2) < 0.16 ? 1 : 0;
    if (!row || tooth == 0) return 60.0;
    return std::abs(h) < 0.6 ? 500.0 : std::abs(h) < 8 ? 2400.0 : std::abs(h) < 18 ? 1700.0 : 60.0;
  };
  const CtVolume hu = made<std::int16_t>(g, density);
  const LabelVolume teeth = threshold(hu, 1500, 4000);
  const auto plane = find_occlusal_plane(teeth, hu);
  ASSERT_TRUE(plane);
  EXPECT_LT(length(cross(plane->normal, up)), radians(1.5));
  EXPECT_GT(plane->normal.z, 0);
  EXPECT_NEAR(plane->signed_distance({0, -20, height / up.z - 20 * 0.12}), 0, 1.0);
  EXPECT_FALSE(find_occlusal_plane(LabelVolume(g), hu));
}

TEST(SymmetryPlane, IsFoundThoughTurnedAndPartlyDamaged) {
  // An egg with a nose and two ears, a piece of one side cut off.
  const Grid g = cube(100, 2);
  const LabelVolume mask = made<std::uint8_t>(g, [](const Vec3& p) {
    const bool egg = length(Vec3{p.x / 55, p.y / 75, p.z / 65}) < 1;
    const bool nose = length(p - Vec3{0, -78, -10}) < 12;
    const bool ears = length(Vec3{std::abs(p.x) - 58, p.y - 10, (p.z + 5) / 2}) < 10;
    const bool brow = length(Vec3{std::abs(p.x) - 25, p.y + 60, p.z - 20}) < 20;
    return (egg || nose || ears || brow) && !(p.x > 20 && p.z > 35);
  });
  const RigidTransform pose =
      RigidTransform::translate({7, -4, 3}) *
      RigidTransform::rotate_about({0, 0, 0}, normalized(Vec3{0.1, 0.5, 1}), radians(11));
  const TriMesh surface = transformed(isosurface(mask), pose);
  const Plane found = find_symmetry_plane(surface, {{1, 0, 0}, 0});
  const Vec3 truth = pose.direction({1, 0, 0});
  EXPECT_LT(length(cross(found.normal, truth)), radians(0.7));
  EXPECT_GT(found.normal.x, 0.9);
  EXPECT_LT(std::abs(found.signed_distance(pose.point({0, 0, 0}))), 0.7);
}

TEST(LabelSurface, KeepsTheLargestPieceAndSpansAMembraneOverAFilledDent) {
  const Grid g = cube(60, 1);
  const Vec3 dent{20, 0, 0};
  const CtVolume hu = made<std::int16_t>(g, [&](const Vec3& p) {
    const double ball = length(p) - 20, hole = std::hypot(p.y, p.z) - 4;
    const double inside = p.x > 5 ? std::max(ball, -hole) : ball;
    const double crumb = length(p - Vec3{-26, -26, 0}) - 3;
    return std::clamp(-480 - 520 * std::min(inside, crumb), -1000.0, 40.0);
  });
  const LabelVolume solid = made<std::uint8_t>(g, [](const Vec3& p) { return length(p) < 20; });
  const LabelSurface surface = surface_of_label(hu, solid, 1, {-480, 0, true, nullptr});
  EXPECT_EQ(topology(surface.mesh).components, 1);
  EXPECT_TRUE(topology(surface.mesh).closed());
  int membrane = 0;
  for (std::size_t p = 0; p < surface.mesh.points.size(); ++p) {
    const Vec3& q = surface.mesh.points[p];
    if (distance(q, dent) > 8) {
      EXPECT_NEAR(length(q), 20, 0.35);
    }
    if (!surface.placed_by_label[p]) continue;
    ++membrane;
    EXPECT_LT(distance(q, dent), 7);
    EXPECT_GT(q.x, 18);
  }
  EXPECT_GT(membrane, 20);
}

}  // namespace
}  // namespace turgor
