#include "turgor/anatomy/phantom.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "turgor/anatomy/landmarks.hpp"
#include "turgor/core/parallel.hpp"
#include "turgor/core/random.hpp"
#include "turgor/imaging/segmentation.hpp"

namespace turgor {
namespace {

Phantom make(const PhantomParameters& parameters = {}) {
  auto phantom = Phantom::create(parameters);
  EXPECT_TRUE(phantom) << (phantom ? "" : phantom.error().message());
  return *std::move(phantom);
}

const Phantom& standard() {
  static const Phantom phantom = make();
  return phantom;
}

double distance_to(const Phantom& phantom, PhantomSurface surface, const Vec3& p) {
  switch (surface) {
    case PhantomSurface::skin:
      return phantom.skin(p);
    case PhantomSurface::skull:
      return phantom.skull(p);
    default:
      return phantom.mandible(p);
  }
}

Vec3 gradient(const Phantom& phantom, PhantomSurface surface, const Vec3& p) {
  constexpr double h = 1e-3;
  Vec3 g;
  for (int a = 0; a < 3; ++a) {
    Vec3 step;
    step[a] = h;
    g[a] = (distance_to(phantom, surface, p + step) - distance_to(phantom, surface, p - step)) / (2 * h);
  }
  return g;
}

// Points of a surface hit by rays from all sides towards points of the head.
std::vector<Vec3> surface_points(const Phantom& phantom, PhantomSurface surface, int rays) {
  const RandomStream random(21);
  std::vector<Vec3> points;
  for (int i = 0; i < rays; ++i) {
    const auto n = static_cast<std::uint64_t>(i) * 5;
    const double z = 2 * random.uniform(n) - 1, angle = 2 * std::numbers::pi * random.uniform(n + 1);
    const double r = std::sqrt(1 - z * z);
    const Vec3 away{r * std::cos(angle), r * std::sin(angle), z};
    const Vec3 target{80 * (random.uniform(n + 2) - 0.5), -30 + 120 * (random.uniform(n + 3) - 0.5),
                      -20 + 120 * (random.uniform(n + 4) - 0.5)};
    const auto hit = phantom.trace(surface, target + away * 250.0, -away, 240);
    if (hit) points.push_back(target + away * (250 - *hit));
  }
  return points;
}

Grid coarse_grid(const Phantom& phantom, double spacing) {
  const Box3 box = phantom.extent();
  Grid grid;
  grid.spacing = {spacing, spacing, spacing};
  for (int a = 0; a < 3; ++a)
    grid.size[static_cast<std::size_t>(a)] = static_cast<int>(box.size()[a] / spacing);
  grid.origin = box.lower + grid.spacing * 0.5;
  return grid;
}

PhantomParameters coarse() {
  PhantomParameters parameters;
  parameters.voxel_mm = parameters.slice_mm = 3;
  return parameters;
}

TEST(Phantom, DistancesHaveSlopeOneAtTheSurfaces) {
  for (const auto surface : {PhantomSurface::skin, PhantomSurface::skull, PhantomSurface::mandible}) {
    const std::vector<Vec3> points = surface_points(standard(), surface, 1500);
    ASSERT_GT(points.size(), 100u);
    std::size_t good = 0;
    for (const Vec3& p : points) good += std::abs(length(gradient(standard(), surface, p)) - 1) < 0.01;
    // Where two teeth touch, or a bone's edge is sharp, no gradient exists.
    EXPECT_GE(good, points.size() * 97 / 100);
  }
}

TEST(Phantom, DistancesAreExactToFirstOrderOffTheSurfaces) {
  for (const auto surface : {PhantomSurface::skin, PhantomSurface::skull, PhantomSurface::mandible}) {
    const std::vector<Vec3> points = surface_points(standard(), surface, 400);
    std::size_t good = 0;
    for (const Vec3& p : points) {
      const Vec3 normal = normalized(gradient(standard(), surface, p));
      good += std::abs(distance_to(standard(), surface, p + normal * 0.1) - 0.1) < 0.01 &&
              std::abs(distance_to(standard(), surface, p - normal * 0.1) + 0.1) < 0.01;
    }
    EXPECT_GE(good, points.size() * 95 / 100);
  }
}

TEST(Phantom, IsSymmetricAboutItsMidplane) {
  for (const Vec3& p : surface_points(standard(), PhantomSurface::skin, 100)) {
    const Vec3 twin{-p.x, p.y, p.z};
    EXPECT_NEAR(standard().skin(p), standard().skin(twin), 1e-6);
    EXPECT_NEAR(standard().skull(p), standard().skull(twin), 1e-6);
    EXPECT_NEAR(standard().mandible(p), standard().mandible(twin), 1e-6);
  }
}

TEST(Phantom, TraceEndsOnTheSurfaceAndReportsAMiss) {
  const Vec3 origin{3, -200, -60}, direction{0, 1, 0};
  const auto skin = standard().trace(PhantomSurface::skin, origin, direction, 300);
  const auto bone = standard().trace(PhantomSurface::bone, origin, direction, 300);
  ASSERT_TRUE(skin && bone);
  EXPECT_NEAR(standard().skin(origin + direction * *skin), 0, 1e-6);
  EXPECT_NEAR(standard().mandible(origin + direction * *bone), 0, 1e-6);
  EXPECT_LT(*skin, *bone);
  EXPECT_FALSE(standard().trace(PhantomSurface::skin, origin, direction, 50));
  EXPECT_FALSE(standard().trace(PhantomSurface::skin, origin, -direction, 300));
  // From inside, the way out.
  const auto out = standard().trace(PhantomSurface::skin, origin + direction * (*skin + 5), -direction, 300);
  ASSERT_TRUE(out);
  EXPECT_NEAR(*out, 5, 1e-6);
}

TEST(Phantom, KnowsEveryLandmarkAndEachLiesOnItsSurface) {
  for (const double jaw : {-12.0, 0.0, 12.0}) {
    PhantomParameters parameters;
    parameters.jaw_protrusion_mm = jaw;
    const Phantom phantom = make(parameters);
    const auto& landmarks = phantom.landmarks();
    for (const LandmarkKind& kind : landmark_kinds()) {
      const auto found = landmarks.find(std::string(kind.name));
      ASSERT_NE(found, landmarks.end()) << kind.name;
      const Vec3& p = found->second;
      const double off = kind.on_bone ? std::min(std::abs(phantom.skull(p)), std::abs(phantom.mandible(p)))
                                      : std::abs(phantom.skin(p));
      EXPECT_LT(off, 1e-3) << kind.name << ", jaw " << jaw;
    }
    EXPECT_EQ(landmarks.size(), landmark_kinds().size());
  }
}

// Also where the lips stand far apart in depth.
TEST(Phantom, LandmarksOfTheProfileFallInOrderAtEveryProtrusion) {
  for (const double jaw : {-12.0, -6.0, 6.0, 12.0}) {
    PhantomParameters parameters;
    parameters.jaw_protrusion_mm = jaw;
    const Phantom phantom = make(parameters);
    double last = 1e9;
    for (const char* name : {"soft_nasion", "pronasale", "subnasale", "soft_a_point", "labrale_superius",
                             "stomion", "labrale_inferius", "soft_b_point", "soft_pogonion", "soft_menton"}) {
      EXPECT_LT(phantom.landmarks().at(name).z, last - 3) << name << ", jaw " << jaw;
      last = phantom.landmarks().at(name).z;
    }
  }
}

TEST(Phantom, LandmarksStandInAnatomicalOrder) {
  const auto& at = standard().landmarks();
  const auto falls = [&](std::initializer_list<const char*> names) {
    double last = 1e9;
    for (const char* name : names) {
      EXPECT_LT(at.at(name).z, last) << name;
      last = at.at(name).z;
    }
  };
  falls({"nasion", "ans", "a_point", "upper_incisor", "lower_incisor", "b_point", "pogonion", "menton"});
  falls({"soft_nasion", "pronasale", "subnasale", "soft_a_point", "labrale_superius", "stomion",
         "labrale_inferius", "soft_b_point", "soft_pogonion", "soft_menton"});
  const auto before = [&](const char* front, const char* back) {
    EXPECT_LT(at.at(front).y, at.at(back).y) << front;
  };
  before("pronasale", "subnasale");
  before("ans", "a_point");
  before("pogonion", "b_point");
  before("soft_pogonion", "soft_b_point");
  before("labrale_superius", "stomion");
  before("labrale_inferius", "stomion");
  before("upper_incisor", "lower_incisor");
  before("gonion_left", "condylion_left");
  EXPECT_GT(at.at("condylion_left").z, at.at("gonion_left").z + 50);
  for (const char* name : {"gonion", "condylion", "orbitale", "zygion", "cheilion", "alare"}) {
    const Vec3 left = at.at(std::string(name) + "_left"), right = at.at(std::string(name) + "_right");
    EXPECT_GT(left.x, 10) << name;
    EXPECT_EQ(left.x, -right.x) << name;
  }
}

TEST(Phantom, HasTheProportionsOfAnAdultHead) {
  const auto& at = standard().landmarks();
  const auto span = [](const Vec3& from, const Vec3& direction) {
    const auto hit = standard().trace(PhantomSurface::skin, from, direction, 200);
    return hit ? 200 - *hit : 0;
  };
  const double vertex = span({0, 2, 200}, {0, 0, -1});
  EXPECT_NEAR(vertex - at.at("soft_menton").z, 225, 8);
  EXPECT_NEAR(2 * span({200, 15, 50}, {-1, 0, 0}), 150, 6);
  EXPECT_NEAR(span({0, -200, 38}, {0, 1, 0}) + span({0, 200, 30}, {0, -1, 0}), 190, 8);
  EXPECT_NEAR(2 * at.at("zygion_left").x, 130, 4);
}

TEST(Phantom, SoftTissueIsAsThickAsMeasuredInAdults) {
  // Millimetres straight back from the skin, unless named otherwise; bands around the means of the
  // literature.
  const auto thickness = [](const Vec3& from, const Vec3& towards) {
    const Vec3 direction = normalized(towards);
    const auto skin = standard().trace(PhantomSurface::skin, from, direction, 300);
    const auto bone = standard().trace(PhantomSurface::bone, from, direction, 300);
    return skin && bone ? *bone - *skin : -1;
  };
  const Vec3 back{0, 1, 0};
  const auto& at = standard().landmarks();
  const auto in_front = [&](const char* name) { return Vec3{at.at(name).x, -180, at.at(name).z}; };
  EXPECT_NEAR(thickness({0, -180, 38}, back), 5.5, 1.5);
  EXPECT_NEAR(thickness(in_front("nasion"), back), 6.5, 1.5);
  EXPECT_NEAR(thickness({0, -104 - 40, 6 + 20}, {0, 40, -20}), 3.1, 2.0);  // rhinion, across the nasal bones
  EXPECT_NEAR(thickness(in_front("ans"), back), 15.6, 3.5);
  EXPECT_NEAR(thickness(in_front("pogonion"), back), 11.5, 1.5);
  EXPECT_NEAR(thickness(in_front("b_point"), back), 11, 2.5);
  EXPECT_NEAR(thickness({0, at.at("menton").y, -180}, {0, 0, 1}), 7, 1.5);
  EXPECT_NEAR(thickness({180, at.at("zygion_left").y, at.at("zygion_left").z}, {-1, 0, 0}), 7, 1.5);
  const Vec3 gonion = at.at("gonion_left"), outwards = normalized(Vec3{0.7, 0.5, -0.5});
  EXPECT_NEAR(thickness(gonion + outwards * 100, -outwards), 11, 2.5);
  EXPECT_GT(thickness({180, -30, -35}, {-1, 0, 0}), 10);
}

TEST(Phantom, BoneStaysUnderTheSkinAtEveryExtreme) {
  for (const double jaw : {-12.0, 12.0}) {
    for (const double thickness : {0.6, 1.6}) {
      PhantomParameters parameters;
      parameters.jaw_protrusion_mm = jaw;
      parameters.thickness = thickness;
      const Phantom phantom = make(parameters);
      for (const auto surface : {PhantomSurface::skull, PhantomSurface::mandible}) {
        for (const Vec3& p : surface_points(phantom, surface, 400)) {
          EXPECT_LT(phantom.skin(p), -0.2) << p.x << " " << p.y << " " << p.z << " jaw " << jaw;
        }
      }
    }
  }
}

// The dermis alone is 1.8 mm; less than this over bone would let it show in a scan of 1 mm voxels.
TEST(Phantom, SkinLiesWellOverTheBoneWhereverItIsOuter) {
  for (const double jaw : {-8.0, 0.0, 8.0}) {
    for (const double thickness : {0.8, 1.0, 1.3}) {
      PhantomParameters parameters;
      parameters.jaw_protrusion_mm = jaw;
      parameters.thickness = thickness;
      const Phantom phantom = make(parameters);
      for (const auto surface : {PhantomSurface::skull, PhantomSurface::mandible}) {
        const std::vector<Vec3> points = surface_points(phantom, surface, 5000);
        ASSERT_GT(points.size(), 600u);
        double highest = -1e9;
        Vec3 where;
        for (const Vec3& p : points) {
          const double height = phantom.skin(p);
          if (height > highest) highest = height, where = p;
        }
        EXPECT_LT(highest, -1.5) << "at " << where.x << " " << where.y << " " << where.z << ", jaw " << jaw
                                 << ", thickness " << thickness;
      }
    }
  }
}

TEST(Phantom, ProtrusionMovesTheChinAndLowerTeethAndLeavesTheCondyles) {
  const auto& rest = standard().landmarks();
  for (const double jaw : {-8.0, 5.0, 12.0}) {
    PhantomParameters parameters;
    parameters.jaw_protrusion_mm = jaw;
    const Phantom phantom = make(parameters);
    const auto& moved = phantom.landmarks();
    const auto forward = [&](const char* name) { return rest.at(name).y - moved.at(name).y; };
    EXPECT_NEAR(forward("pogonion"), jaw, 0.3);
    EXPECT_NEAR(forward("b_point"), jaw, 0.3);
    EXPECT_NEAR(forward("menton"), jaw, 0.3);
    EXPECT_NEAR(forward("lower_incisor"), jaw, 0.3);
    EXPECT_NEAR(forward("soft_pogonion"), jaw, 0.3);
    EXPECT_NEAR(distance(rest.at("condylion_left"), moved.at("condylion_left")), 0, 1e-9);
    for (const char* name : {"nasion", "ans", "a_point", "upper_incisor", "pronasale", "zygion_left"}) {
      EXPECT_NEAR(distance(rest.at(name), moved.at(name)), 0, 1e-9) << name;
    }
    // The lower lip goes with the chin for the most part, the upper stays, and where they meet lies between.
    EXPECT_NEAR(forward("labrale_inferius") / jaw, 0.78, 0.08);
    EXPECT_NEAR(forward("stomion") / jaw, 0.37, 0.06);
    EXPECT_NEAR(forward("cheilion_left") / jaw, 0.33, 0.06);
    EXPECT_NEAR(forward("labrale_superius") / jaw, 0.03, 0.01);
  }
}

TEST(Phantom, ThicknessMovesTheSkinAndNotTheBone) {
  PhantomParameters parameters;
  parameters.thickness = 1.4;
  const Phantom thick = make(parameters);
  const auto& rest = standard().landmarks();
  EXPECT_EQ(thick.landmarks().at("pogonion"), rest.at("pogonion"));
  EXPECT_EQ(thick.landmarks().at("nasion"), rest.at("nasion"));
  EXPECT_LT(thick.landmarks().at("soft_pogonion").y, rest.at("soft_pogonion").y - 1.5);
  EXPECT_LT(thick.landmarks().at("soft_nasion").y, rest.at("soft_nasion").y - 1);
}

TEST(Phantom, SizeScalesEverything) {
  PhantomParameters parameters;
  parameters.size = 0.8;
  const Phantom small = make(parameters);
  for (const auto& [name, p] : small.landmarks()) {
    EXPECT_NEAR(distance(p, standard().landmarks().at(name) * 0.8), 0, 0.02) << name;
  }
  for (const Vec3& p : surface_points(standard(), PhantomSurface::skin, 50)) {
    EXPECT_NEAR(small.skin(p * 0.8), 0, 1e-6);
  }
}

TEST(Phantom, JointSpaceIsOpenUnlessTheCondylesTouch) {
  const Vec3 condylion = standard().landmarks().at("condylion_left");
  EXPECT_NEAR(standard().skull(condylion), 2.2, 0.4);
  PhantomParameters parameters;
  parameters.condyles_touch = true;
  const Phantom touching = make(parameters);
  const double gap = touching.skull(touching.landmarks().at("condylion_left"));
  EXPECT_GT(gap, 0.05);
  EXPECT_LT(gap, 0.5);
  const auto teeth = [](const Phantom& phantom) {
    return phantom.landmarks().at("upper_incisor").z - phantom.landmarks().at("lower_incisor").z;
  };
  EXPECT_NEAR(teeth(standard()), 1.3, 0.6);
  EXPECT_LT(teeth(touching), teeth(standard()) - 0.8);
}

TEST(Phantom, EachTissueHasItsHounsfieldNumber) {
  const auto expect = [](const Vec3& p, PhantomLabel label, double low, double high) {
    EXPECT_EQ(standard().label(p), label) << p.x << " " << p.y << " " << p.z;
    EXPECT_GE(standard().hounsfield(p), low);
    EXPECT_LE(standard().hounsfield(p), high);
  };
  const auto& at = standard().landmarks();
  expect({0, -130, 0}, PhantomLabel::air, -1000, -1000);
  expect({0, 10, 70}, PhantomLabel::brain, 30, 45);
  expect({31.5, -72.5, 14}, PhantomLabel::eye, 0, 40);
  expect({0, -16, -60}, PhantomLabel::airway, -1000, -1000);
  expect(at.at("soft_pogonion") + Vec3{0, 0.8, 0}, PhantomLabel::skin, 0, 100);
  expect(at.at("soft_pogonion") + Vec3{0, 4, 0}, PhantomLabel::fat, -120, -60);
  expect(at.at("pogonion") + Vec3{0, 1, 0}, PhantomLabel::mandible, 1300, 1600);
  expect(at.at("pogonion") + Vec3{0, 5, 0}, PhantomLabel::mandible, 400, 700);
  expect(at.at("nasion") + Vec3{0, 1, 0}, PhantomLabel::skull, 1300, 1600);
  expect(at.at("upper_incisor") + Vec3{0, 0, 0.6}, PhantomLabel::upper_teeth, 2400, 2600);
  expect(at.at("lower_incisor") - Vec3{0, 0, 0.6}, PhantomLabel::lower_teeth, 2400, 2600);
  expect({50, -30, -36}, PhantomLabel::muscle, 40, 70);
}

TEST(Phantom, TheMouthIsOpenToItsSlitAndTheSkinClosedOverIt) {
  const auto& at = standard().landmarks();
  const Vec3 slit = at.at("stomion") + Vec3{0, 6, 0};
  EXPECT_LT(standard().skin(slit), -1);
  double least = 1e9;
  for (double z = -3; z <= 3; z += 0.05) least = std::min(least, standard().hounsfield(slit + Vec3{0, 0, z}));
  EXPECT_EQ(least, -1000);
}

TEST(Phantom, PartsHavePlausibleVolumes) {
  const Grid grid = coarse_grid(standard(), 2);
  Context context;
  const auto labels = standard().labels(grid, context);
  ASSERT_TRUE(labels);
  std::array<double, 13> ml{};
  for (const std::uint8_t label : labels->voxels) ml.at(label) += 8e-3;
  const auto of = [&](PhantomLabel label) { return ml.at(static_cast<std::size_t>(label)); };
  EXPECT_NEAR(of(PhantomLabel::brain), 1350, 150);
  EXPECT_NEAR(of(PhantomLabel::mandible), 70, 20);
  EXPECT_NEAR(of(PhantomLabel::eye), 14.5, 1.5);
  EXPECT_GT(of(PhantomLabel::skull), 600);
  EXPECT_LT(of(PhantomLabel::skull), 1100);
  EXPECT_GT(of(PhantomLabel::upper_teeth), 5);
  EXPECT_LT(of(PhantomLabel::upper_teeth), 16);
  EXPECT_GT(of(PhantomLabel::airway), 25);
  for (const double volume : ml) EXPECT_GT(volume, 0);
}

// On voxels finer than the thinnest bone, the walls of the sinuses.
TEST(Phantom, SkinSkullMandibleAndAirwayAreOnePieceEach) {
  const Grid grid = coarse_grid(standard(), 1.25);
  Context context;
  const auto labels = standard().labels(grid, context);
  ASSERT_TRUE(labels);
  const auto pieces = [&](auto&& member) {
    LabelVolume mask(grid);
    for (std::size_t v = 0; v < mask.voxels.size(); ++v) {
      mask.voxels[v] = member(static_cast<PhantomLabel>(labels->voxels[v])) ? 1 : 0;
    }
    return connected_components(mask).sizes;
  };
  EXPECT_EQ(pieces([](PhantomLabel l) { return l != PhantomLabel::air && l != PhantomLabel::holder; }).size(),
            1u);
  EXPECT_EQ(pieces([](PhantomLabel l) {
              return l == PhantomLabel::skull || l == PhantomLabel::upper_teeth;
            }).size(),
            1u);
  EXPECT_EQ(pieces([](PhantomLabel l) {
              return l == PhantomLabel::mandible || l == PhantomLabel::lower_teeth;
            }).size(),
            1u);
  EXPECT_EQ(pieces([](PhantomLabel l) { return l == PhantomLabel::holder; }).size(), 2u);
  // Nose, mouth and throat hang together; sinuses and ear canals are their own.
  const auto air = pieces([](PhantomLabel l) { return l == PhantomLabel::airway; });
  EXPECT_GT(air.front(), 2 * air.at(1));
}

TEST(Phantom, TheHolderKeepsClearOfTheHead) {
  const Grid grid = coarse_grid(standard(), 3);
  Context context;
  const auto labels = standard().labels(grid, context);
  ASSERT_TRUE(labels);
  int holder = 0;
  for (int k = 0; k < grid.size[2]; ++k) {
    for (int j = 0; j < grid.size[1]; ++j) {
      for (int i = 0; i < grid.size[0]; ++i) {
        if (labels->at(i, j, k) != static_cast<std::uint8_t>(PhantomLabel::holder)) continue;
        ++holder;
        EXPECT_GT(standard().skin(grid.to_patient({1.0 * i, 1.0 * j, 1.0 * k})), 4);
      }
    }
  }
  EXPECT_GT(holder, 100);
}

TEST(Phantom, LabelVolumeHoldsTheLabelOfEachVoxelCentreOnATurnedGrid) {
  Grid grid;
  grid.size = {50, 44, 60};
  grid.spacing = {2.5, 3, 2};
  grid.direction = rotation(normalized(Vec3{1, 2, 3}), 0.4);
  grid.origin = Vec3{-40, -110, -90};
  Context context;
  const auto labels = standard().labels(grid, context);
  ASSERT_TRUE(labels);
  std::size_t wrong = 0;
  for (int k = 0; k < 60; k += 3) {
    for (int j = 0; j < 44; j += 2) {
      for (int i = 0; i < 50; i += 3) {
        const Vec3 p = grid.to_patient({1.0 * i, 1.0 * j, 1.0 * k});
        wrong += labels->at(i, j, k) != static_cast<std::uint8_t>(standard().label(p));
      }
    }
  }
  EXPECT_EQ(wrong, 0u);
}

TEST(Phantom, ScanHoldsTheMeanHounsfieldNumberOfEachVoxel) {
  PhantomParameters parameters = coarse();
  parameters.noise_hu = parameters.blur_mm = 0;
  const Phantom phantom = make(parameters);
  Context context;
  const auto scan = phantom.scan(context);
  ASSERT_TRUE(scan);
  const RandomStream random(4);
  double error = 0;
  constexpr int count = 400, n = 9;
  for (std::uint64_t v = 0; v < count; ++v) {
    const Index3& size = scan->grid.size;
    const int i = static_cast<int>(random.uniform(3 * v) * size[0]),
              j = static_cast<int>(random.uniform(3 * v + 1) * size[1]),
              k = static_cast<int>(random.uniform(3 * v + 2) * size[2]);
    double mean = 0;
    for (int s = 0; s < n * n * n; ++s) {
      const Vec3 index{i + (s % n + 0.5) / n - 0.5, j + (s / n % n + 0.5) / n - 0.5,
                       k + (s / n / n + 0.5) / n - 0.5};
      mean += phantom.hounsfield(scan->grid.to_patient(index)) / (n * n * n);
    }
    const double off = std::abs(scan->at(i, j, k) - mean);
    EXPECT_LT(off, 130) << i << " " << j << " " << k;
    error += off / count;
  }
  EXPECT_LT(error, 3);
}

TEST(Phantom, ScanGivesTheSameBitsOnOneAndTwoThreadsAndOnRepeat) {
  const Phantom phantom = make(coarse());
  Context context;
  set_thread_count(1);
  const auto one = phantom.scan(context);
  set_thread_count(2);
  const auto two = phantom.scan(context);
  const auto again = make(coarse()).scan(context);
  set_thread_count(0);
  ASSERT_TRUE(one && two && again);
  EXPECT_EQ(one->voxels, two->voxels);
  EXPECT_EQ(two->voxels, again->voxels);
}

TEST(Phantom, SeedChangesTheNoiseAndNothingElse) {
  PhantomParameters parameters = coarse();
  Context context;
  const auto first = make(parameters).scan(context);
  parameters.seed = 2;
  const auto second = make(parameters).scan(context);
  ASSERT_TRUE(first && second);
  double sum = 0, squares = 0;
  std::size_t count = 0;
  for (std::size_t v = 0; v < first->voxels.size(); ++v) {
    if (first->voxels[v] < -900) continue;  // air is clamped
    const double d = first->voxels[v] - second->voxels[v];
    sum += d, squares += d * d, ++count;
  }
  const auto n = static_cast<double>(count);
  EXPECT_NEAR(sum / n, 0, 0.3);
  EXPECT_NEAR(std::sqrt(squares / n), parameters.noise_hu * std::numbers::sqrt2, 0.5);
}

TEST(Phantom, ScanLiesUprightWithAirAllAround) {
  const Phantom phantom = make(coarse());
  Context context;
  const auto scan = phantom.scan(context);
  ASSERT_TRUE(scan);
  const Grid& grid = scan->grid;
  EXPECT_EQ(grid.direction.c, Mat3{}.c);
  EXPECT_NEAR(scan->sample({0, 10, 70}), 35, 40);
  EXPECT_LT(scan->sample({0, -120, 20}), -900);
  for (int k = 0; k < grid.size[2]; ++k) {
    for (int j = 0; j < grid.size[1]; ++j) EXPECT_LT(scan->at(0, j, k), -900);
    for (int i = 0; i < grid.size[0]; ++i) EXPECT_LT(scan->at(i, 0, k), -900);
  }
  for (int j = 0; j < grid.size[1]; ++j) {
    for (int i = 0; i < grid.size[0]; ++i) EXPECT_LT(scan->at(i, j, grid.size[2] - 1), 600);
  }
}

TEST(Phantom, ThicknessMapIsTheWayToTheFirstBone) {
  const std::vector<Vec3> points = surface_points(standard(), PhantomSurface::skin, 60);
  const Vec3 target{0, -20, -10};
  Context context;
  const auto map = standard().thickness_map(points, std::vector{target}, context);
  ASSERT_TRUE(map);
  ASSERT_EQ(map->size(), points.size());
  for (std::size_t i = 0; i < points.size(); ++i) {
    const auto hit = standard().trace(PhantomSurface::bone, points[i], normalized(target - points[i]),
                                      distance(points[i], target));
    if (hit) {
      EXPECT_EQ(map->at(i), *hit);
    } else {
      EXPECT_TRUE(std::isnan(map->at(i)));
    }
  }
  const auto short_of = standard().thickness_map(points, std::vector{target, target}, context);
  ASSERT_FALSE(short_of);
  EXPECT_EQ(short_of.error().kind, ErrorKind::bad_input);
  const auto missed =
      standard().thickness_map(std::vector{Vec3{0, -150, 0}}, std::vector{Vec3{0, -200, 0}}, context);
  ASSERT_TRUE(missed);
  EXPECT_TRUE(std::isnan(missed->front()));
}

TEST(Phantom, ScanStopsWhenCancelled) {
  Context context({}, {}, [] { return true; });
  const auto scan = standard().scan(context);
  ASSERT_FALSE(scan);
  EXPECT_EQ(scan.error().kind, ErrorKind::cancelled);
}

TEST(Phantom, RefusesParametersOutOfRangeByName) {
  const auto refuse = [](auto&& change, const char* word) {
    PhantomParameters parameters;
    change(parameters);
    const auto phantom = Phantom::create(parameters);
    ASSERT_FALSE(phantom) << word;
    EXPECT_EQ(phantom.error().kind, ErrorKind::bad_input);
    EXPECT_NE(phantom.error().message().find(word), std::string::npos) << phantom.error().message();
    EXPECT_FALSE(phantom.error().remedy.empty());
  };
  refuse([](auto& p) { p.size = 0.5; }, "size");
  refuse([](auto& p) { p.size = std::nan(""); }, "size");
  refuse([](auto& p) { p.jaw_protrusion_mm = 13; }, "jaw");
  refuse([](auto& p) { p.thickness = 2; }, "thickness");
  refuse([](auto& p) { p.voxel_mm = 0; }, "voxel");
  refuse([](auto& p) { p.slice_mm = 6; }, "slice");
  refuse([](auto& p) { p.noise_hu = -1; }, "noise");
  refuse([](auto& p) { p.blur_mm = 3; }, "blur");
}

}  // namespace
}  // namespace turgor
