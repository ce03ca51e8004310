// New solids about bodies that have deformed, against the motion that deformed them.
#include "turgor/geometry/solid_remesh.hpp"

#include <gtest/gtest.h>

#include <chrono>
#include <functional>
#include <limits>
#include <thread>

#include "geometry/shapes.hpp"
#include "geometry/solid_checks.hpp"
#include "turgor/core/parallel.hpp"
#include "turgor/geometry/solid_quality.hpp"

namespace turgor {
namespace {

using Motion = std::function<Vec3(const Vec3&)>;

/// A bar of 20 x 20 x 100 mm along z, its skin in triangles of about 3 mm.
TriMesh bar() {
  TriMesh mesh = testing::box({-10, -10, 0}, {10, 10, 100});
  for (int level = 0; level < 4; ++level) mesh = testing::quartered(mesh, [](const Vec3& p) { return p; });
  return mesh;
}
/// Into a quarter of a circle in the plane x, z.
Vec3 bent(const Vec3& p) {
  const double radius = 200 / 3.141592653589793, angle = p.z / radius;
  return {radius - (radius - p.x) * std::cos(angle), p.y, (radius - p.x) * std::sin(angle)};
}
/// By 120 degrees from end to end.
Vec3 twisted(const Vec3& p) {
  return rotation({0, 0, 1}, radians(1.2 * p.z)) * p;
}
/// By 30 % along z, at constant volume.
Vec3 squeezed(const Vec3& p) {
  const double wide = 1 / std::sqrt(0.7);
  return {p.x * wide, p.y * wide, p.z * 0.7};
}

std::vector<Vec3> moved(std::span<const Vec3> points, const Motion& motion) {
  std::vector<Vec3> out;
  for (const Vec3& p : points) out.push_back(motion(p));
  return out;
}
TriMesh moved(TriMesh mesh, const Motion& motion) {
  mesh.points = moved(mesh.points, motion);
  return mesh;
}

SolidMesh solid_about(const TriMesh& skin, int resolution) {
  VoxelOptions options;
  options.resolution = resolution;
  const auto voxels = voxelise(skin, options);
  EXPECT_TRUE(voxels);
  return *solid_of(*voxels);
}

/// The skin as a solid carries it from its rest to positions.
TriMesh carried(const TriMesh& skin, std::span<const Vec3> rest,
                std::span<const std::array<int, 4>> tetrahedra, std::span<const Vec3> positions) {
  const auto embedding = TetraEmbedding::bind(rest, tetrahedra, skin.points);
  EXPECT_TRUE(embedding);
  TriMesh out = skin;
  embedding->apply(positions, out.points);
  return out;
}

struct Case {
  const char* name;
  TriMesh skin;  ///< at rest
  Motion motion;
  int before, after;  ///< resolutions
};
std::vector<Case> cases() {
  return {{"bent", bar(), bent, 40, 30},
          {"bent, finer", bar(), bent, 25, 50},
          {"twisted", bar(), twisted, 40, 30},
          {"squeezed", testing::sphere(30, 4), squeezed, 20, 24}};
}

RemeshSnapshot snapshot_of(const Case& c) {
  const SolidMesh old = solid_about(c.skin, c.before);
  RemeshSnapshot s;
  s.rest.assign(old.points.begin(), old.points.end());
  s.tetrahedra.assign(old.tetrahedra.begin(), old.tetrahedra.end());
  s.positions = moved(s.rest, c.motion);
  s.skin = carried(c.skin, s.rest, s.tetrahedra, s.positions);
  return s;
}
RemeshOptions options_of(const Case& c) {
  RemeshOptions options;
  options.voxels.resolution = c.after;
  return options;
}
RemeshedSolid remeshed(const RemeshSnapshot& s, const RemeshOptions& options) {
  auto out = remesh_solid(s, options);
  EXPECT_TRUE(out) << (out ? "" : out.error().message());
  return out ? *std::move(out) : RemeshedSolid{};
}

/// Volumes within 1 %, and points within 1 % of the size.
void expect_same(const TriMesh& a, const TriMesh& b, const char* name) {
  const double size = length(bounds(b).size());
  double worst = 0;
  for (std::size_t p = 0; p < a.points.size(); ++p)
    worst = std::max(worst, distance(a.points[p], b.points[p]));
  EXPECT_LT(worst, 0.01 * size) << name;
  EXPECT_NEAR(enclosed_volume(a), enclosed_volume(b), 0.01 * enclosed_volume(b)) << name;
  ::testing::Test::RecordProperty(std::string(name) + " points", std::to_string(worst / size));
  ::testing::Test::RecordProperty(std::string(name) + " volume",
                                  std::to_string(enclosed_volume(a) / enclosed_volume(b) - 1));
}

TEST(SolidRemesh, TheSkinKeepsShapeAndVolumeAtTheSwap) {
  for (const Case& c : cases()) {
    const RemeshSnapshot s = snapshot_of(c);
    const RemeshedSolid now = remeshed(s, options_of(c));
    test::expect_conforming(now.solid);
    const SolidQuality rest = solid_quality(now.solid.points, now.solid.tetrahedra);
    EXPECT_GT(rest.least_volume, 0) << c.name;
    RecordProperty(std::string(c.name) + " repaired", now.repaired);
    RecordProperty(std::string(c.name) + " least dihedral", std::to_string(rest.least_dihedral_deg));
    // The skin at rest, carried by the new solid, stands where the old one had it …
    expect_same(carried(c.skin, now.solid.points, now.solid.tetrahedra, now.positions), s.skin, c.name);
    // … and the skin as it stands goes back to rest.
    expect_same(carried(s.skin, now.positions, now.solid.tetrahedra, now.solid.points), c.skin, c.name);
  }
}

TEST(SolidRemesh, StateIsCarriedFromWhereTheOldSolidHasGoneMeanwhile) {
  for (const Case& c : cases()) {
    const RemeshSnapshot s = snapshot_of(c);
    const RemeshedSolid now = remeshed(s, options_of(c));
    std::vector<Vec3> same(now.positions.size());
    now.from_old.apply(s.positions, same);
    for (std::size_t p = 0; p < same.size(); ++p) ASSERT_LT(distance(same[p], now.positions[p]), 1e-9);
    // The simulation has gone on: a turn, a move, a little stretch.
    const Motion later = [](const Vec3& p) {
      return rotation(normalized(Vec3{1, 2, 3}), 0.3) * Vec3{1.05 * p.x, p.y, p.z} + Vec3{5, -7, 9};
    };
    const std::vector<Vec3> current = moved(s.positions, later);
    std::vector<Vec3> positions(now.positions.size());
    now.from_old.apply(current, positions);
    expect_same(carried(c.skin, now.solid.points, now.solid.tetrahedra, positions),
                carried(c.skin, s.rest, s.tetrahedra, current), c.name);
    // A rigid motion's velocities stay those of a rigid motion.
    const Vec3 spin{0.1, -0.2, 0.3};
    std::vector<Vec3> velocities(positions.size());
    now.from_old.apply(moved(s.positions, [&](const Vec3& p) { return cross(spin, p); }), velocities);
    for (std::size_t p = 0; p < velocities.size(); ++p)
      ASSERT_LT(distance(velocities[p], cross(spin, now.positions[p])), 1e-9);
  }
}

TEST(SolidRemesh, CanBeDoneAgainAndAgain) {
  const Case c{"bent in steps", bar(), bent, 30, 30};
  RemeshSnapshot s = snapshot_of({c.name, c.skin, [](const Vec3& p) { return p; }, 30, 30});
  for (int step = 1; step <= 3; ++step) {
    s.positions = moved(s.rest, [&](const Vec3& p) { return lerp(p, bent(p), step / 3.0); });
    s.skin = moved(c.skin, [&](const Vec3& p) { return lerp(p, bent(p), step / 3.0); });
    RemeshOptions options;
    options.voxels.resolution = 28 + 2 * step;
    const RemeshedSolid now = remeshed(s, options);
    s.rest.assign(now.solid.points.begin(), now.solid.points.end());
    s.tetrahedra.assign(now.solid.tetrahedra.begin(), now.solid.tetrahedra.end());
    s.positions = now.positions;
  }
  expect_same(carried(s.skin, s.positions, s.tetrahedra, s.rest), c.skin, c.name);
}

TEST(SolidRemesh, RepairsRestPositionsThatTurnOver) {
  // Noise in the positions near the surface turns over what hangs on it from outside.
  Case c{"crumpled", testing::sphere(30, 4), squeezed, 16, 30};
  RemeshSnapshot s = snapshot_of(c);
  const RandomStream random(3);
  for (std::size_t p = 0; p < s.positions.size(); ++p)
    if (length(s.rest[p]) > 28)
      s.positions[p] += Vec3{random.normal(3 * p), random.normal(3 * p + 1), random.normal(3 * p + 2)} * 0.55;
  const RemeshedSolid now = remeshed(s, options_of(c));
  EXPECT_GT(now.repaired, 0);
  EXPECT_GT(solid_quality(now.solid.points, now.solid.tetrahedra).least_volume, 0);
  // Noise cannot be undone, but neither volume nor shape goes with it.
  const TriMesh back = carried(s.skin, now.positions, now.solid.tetrahedra, now.solid.points);
  EXPECT_NEAR(enclosed_volume(back), enclosed_volume(c.skin), 0.01 * enclosed_volume(c.skin));
  for (std::size_t p = 0; p < back.points.size(); ++p)
    ASSERT_LT(distance(back.points[p], c.skin.points[p]), 2.5);
  RemeshOptions without = options_of(c);
  without.repair_sweeps = 0;
  const auto refused = remesh_solid(s, without);
  ASSERT_FALSE(refused);
  EXPECT_NE(refused.error().message().find("turned over or flat at rest"), std::string::npos);
}

TEST(SolidRemesh, RefusesWhatItCannotUse) {
  const Case c{"bar", testing::box({0, 0, 0}, {10, 10, 10}), [](const Vec3& p) { return p; }, 5, 5};
  const RemeshSnapshot good = snapshot_of(c);
  RemeshSnapshot s = good;
  s.positions.pop_back();
  EXPECT_FALSE(remesh_solid(s, options_of(c)));
  s = good, s.positions[3].x = std::nan("");
  EXPECT_FALSE(remesh_solid(s, options_of(c)));
  s = good, s.rest[3].x = std::numeric_limits<double>::infinity();
  EXPECT_FALSE(remesh_solid(s, options_of(c)));
  s = good, s.tetrahedra[0][2] = 1 << 20;
  EXPECT_FALSE(remesh_solid(s, options_of(c)));
  s = good, s.skin = {};
  EXPECT_FALSE(remesh_solid(s, options_of(c)));
  s = good, s.tetrahedra.clear();
  EXPECT_FALSE(remesh_solid(s, options_of(c)));
}

TEST(SolidRemesh, TheSameBitsOnAnyNumberOfThreadsAndInTheBackground) {
  const Case c = cases()[2];
  const RemeshSnapshot s = snapshot_of(c);
  set_thread_count(1);
  const RemeshedSolid one = remeshed(s, options_of(c));
  set_thread_count(3);
  const RemeshedSolid three = remeshed(s, options_of(c));
  set_thread_count(0);
  BackgroundRemesh background;
  ASSERT_TRUE(background.start(s, options_of(c)));
  const auto behind = background.take();
  ASSERT_TRUE(behind);
  for (const RemeshedSolid* other : {&three, &*behind}) {
    EXPECT_TRUE(one.solid.points == other->solid.points);
    EXPECT_TRUE(one.solid.tetrahedra == other->solid.tetrahedra);
    EXPECT_TRUE(one.positions == other->positions);
  }
}

TEST(BackgroundRemesh, StartsIsReadyIsTakenAndCancelled) {
  const Case c = cases()[3];
  const RemeshSnapshot s = snapshot_of(c);
  BackgroundRemesh background;
  EXPECT_FALSE(background.started() || background.ready());
  EXPECT_FALSE(background.take());
  ASSERT_TRUE(background.start(s, options_of(c)));
  EXPECT_TRUE(background.started());
  while (!background.ready()) std::this_thread::sleep_for(std::chrono::milliseconds(1));
  EXPECT_TRUE(background.take());
  EXPECT_FALSE(background.started());
  ASSERT_TRUE(background.start(s, options_of(c)));
  background.cancel();
  EXPECT_FALSE(background.started());
  ASSERT_TRUE(background.start(s, options_of(c)));
  ASSERT_TRUE(background.start(s, options_of(c)));
  BackgroundRemesh other = std::move(background);
  EXPECT_TRUE(other.take());
  RemeshSnapshot none;
  ASSERT_TRUE(other.start(none, {}));
  EXPECT_FALSE(other.take());
  ASSERT_TRUE(other.start(s, options_of(c)));  // ended by the destructor
}

}  // namespace
}  // namespace turgor
