#include "turgor/geometry/solid_skin.hpp"

#include <gtest/gtest.h>

#include <functional>
#include <limits>
#include <numbers>

#include "shapes.hpp"
#include "turgor/core/parallel.hpp"
#include "turgor/geometry/tetra_embedding.hpp"
#include "turgor/geometry/voxel_solid.hpp"

namespace turgor {
namespace {

using Motion = std::function<Vec3(const Vec3&)>;

std::size_t at(int i) {
  return static_cast<std::size_t>(i);
}

SolidMesh solid_from(const TriMesh& surface, int resolution) {
  VoxelOptions options;
  options.resolution = resolution;
  auto voxels = voxelise(surface, options);
  return *solid_of(*voxels);
}

/// A ball of irregular triangles and its voxels.
struct Ball {
  TriMesh skin = testing::noisy(testing::sphere(30, 5, {5, -20, 900}), 0.05, 3);
  SolidMesh solid = solid_from(skin, 14);
};

/// A bar of 10 × 10 × 60 mm along z, its skin finely divided.
struct Bar {
  TriMesh skin = divided(testing::box({-5, -5, 0}, {5, 5, 60}), 5);
  SolidMesh solid = solid_from(skin, 30);

  static TriMesh divided(TriMesh mesh, int levels) {
    for (int i = 0; i < levels; ++i) mesh = testing::quartered(mesh, [](const Vec3& p) { return p; });
    return mesh;
  }
};

/// By 90 degrees over the bar's length.
Vec3 twisted(const Vec3& p) {
  const double a = radians(90) * p.z / 60, c = std::cos(a), s = std::sin(a);
  return {c * p.x - s * p.y, s * p.x + c * p.y, p.z};
}
/// Into a quarter of a circle in the plane x z, the axis as long as before.
Vec3 bent(const Vec3& p) {
  const double radius = 120 / std::numbers::pi, a = p.z / radius, r = radius - p.x;
  return {radius - r * std::cos(a), p.y, r * std::sin(a)};
}

std::vector<Vec3> moved(std::span<const Vec3> points, const Motion& motion) {
  std::vector<Vec3> out;
  for (const Vec3& p : points) out.push_back(motion(p));
  return out;
}

struct Carried {
  std::vector<Vec3> points, normals;
};
Carried carried(const SolidSkin& skin, std::span<const Vec3> solid_positions) {
  Carried out{std::vector<Vec3>(skin.point_count()), std::vector<Vec3>(skin.point_count())};
  skin.apply(solid_positions, out.points, out.normals);
  return out;
}

SolidSkin bound(const SolidMesh& solid, const TriMesh& skin, int neighbours = SolidSkin::kNeighbours) {
  auto result = SolidSkin::bind(solid, skin, neighbours);
  EXPECT_TRUE(result) << result.error().message();
  return *result;
}

double largest_difference(std::span<const Vec3> a, std::span<const Vec3> b) {
  EXPECT_EQ(a.size(), b.size());
  double largest = 0;
  for (std::size_t i = 0; i < a.size(); ++i) largest = std::max(largest, distance(a[i], b[i]));
  return largest;
}

void expect_unit(std::span<const Vec3> normals) {
  for (const Vec3& n : normals) ASSERT_NEAR(length(n), 1, 1e-12);
}

TEST(SolidSkin, ReproducesRestForAnyNumberOfNeighbours) {
  const Ball ball;
  for (const int neighbours : {1, 2, 5, 13, 64}) {
    const auto out = carried(bound(ball.solid, ball.skin, neighbours), ball.solid.points);
    EXPECT_LT(largest_difference(out.points, ball.skin.points), 1e-12 * 900) << neighbours;
    EXPECT_LT(largest_difference(out.normals, point_normals(ball.skin)), 1e-6) << neighbours;
    expect_unit(out.normals);
  }
}

TEST(SolidSkin, CarriesRigidMotionsExactly) {
  const Ball ball;
  const SolidSkin skin = bound(ball.solid, ball.skin);
  for (const double angle : {1.0, 90.0, 179.0}) {
    const auto turn = RigidTransform::translate({300, -20, 7}) *
                      RigidTransform::rotate_about({0, 50, 800}, normalized(Vec3{1, 2, -1}), radians(angle));
    const Motion motion = [&](const Vec3& p) { return turn.point(p); };
    const auto out = carried(skin, moved(ball.solid.points, motion));
    EXPECT_LT(largest_difference(out.points, moved(ball.skin.points, motion)), 1e-9);
    const auto turned = moved(point_normals(ball.skin), [&](const Vec3& n) { return turn.direction(n); });
    EXPECT_LT(largest_difference(out.normals, turned), 1e-6);
  }
}

/// Section 4.2 as it is printed, its misprint corrected, all in double precision and by the slowest way.
class ByThePaper {
 public:
  ByThePaper(const SolidMesh& solid, int neighbours) : solid_(solid), neighbours_(at(neighbours)) {
    for (const Index3& t : solid.surface_triangles) surface_.insert(surface_.end(), t.begin(), t.end());
    std::sort(surface_.begin(), surface_.end());
    surface_.erase(std::unique(surface_.begin(), surface_.end()), surface_.end());
  }

  [[nodiscard]] Vec3 carried(const Vec3& point, std::span<const Vec3> positions) const {
    std::vector<int> near = surface_;
    const auto far = [&](int v) { return squared_length(solid_.points[at(v)] - point); };
    std::stable_sort(near.begin(), near.end(), [&](int a, int b) { return far(a) < far(b); });
    near.resize(neighbours_);
    Vec3 sum;
    double weights = 0;
    for (const int v : near) {
      const Vec3 offset = frame(v, solid_.points).transposed() * (point - solid_.points[at(v)]);
      sum += (positions[at(v)] + frame(v, positions) * offset) / far(v);
      weights += 1 / far(v);
    }
    return sum / weights;
  }

 private:
  [[nodiscard]] Mat3 frame(int v, std::span<const Vec3> positions) const {
    Vec3 normal;
    int first = -1;
    for (const Index3& t : solid_.surface_triangles) {
      const auto here = std::find(t.begin(), t.end(), v);
      if (here == t.end()) continue;
      if (first < 0) first = t[at(static_cast<int>(here - t.begin() + 1) % 3)];
      const Vec3& a = positions[at(t[0])];
      normal += cross(positions[at(t[1])] - a, positions[at(t[2])] - a);
    }
    const Vec3 x = normalized(normal), edge = positions[at(first)] - positions[at(v)];
    const Vec3 y = normalized(edge - x * dot(edge, x));
    return Mat3{{x, y, cross(x, y)}};
  }

  const SolidMesh& solid_;
  std::vector<int> surface_;
  std::size_t neighbours_;
};

TEST(SolidSkin, FollowsSectionFourPointTwo) {
  TriMesh surface = testing::sphere(30, 3);
  const SolidMesh solid = solid_from(surface, 9);
  for (Vec3& p : surface.points) p = p * 0.97 + Vec3{0.3, 0.21, -0.17};  // no two neighbours equally far
  const auto positions = moved(solid.points, [](const Vec3& p) {
    return twisted(p) + Vec3{0.01 * p.z * p.z, 0, 0.2 * p.x};
  });
  for (const int neighbours : {1, 5}) {
    const ByThePaper paper(solid, neighbours);
    const auto out = carried(bound(solid, surface, neighbours), positions);
    // What single precision costs: nothing with one neighbour, else 1e-7 of the offsets.
    const double tolerance = neighbours == 1 ? 1e-11 : 1e-6;
    for (std::size_t i = 0; i < surface.points.size(); ++i)
      EXPECT_LT(distance(out.points[i], paper.carried(surface.points[i], positions)), tolerance) << i;
  }
}

TEST(SolidSkin, TakesTheLowestNumberOfEquallyFarNeighbours) {
  const SolidMesh solid = solid_from(testing::box({0, 0, 0}, {8, 8, 8}), 4);
  const auto positions = moved(solid.points, [](const Vec3& p) {
    return p + Vec3{std::sin(7 * p.z), p.x * p.y, 0};
  });
  TriMesh middles;  // four surface points are equally far, eight more the next
  for (const Vec3& p : {Vec3{1, 1, 8}, {3, 5, 8}, {8, 3, 3}, {5, 8, 1}}) middles.points.push_back(p);
  for (const int neighbours : {1, 2, 3, 5, 7}) {
    const ByThePaper paper(solid, neighbours);
    const auto out = carried(bound(solid, middles, neighbours), positions);
    for (std::size_t i = 0; i < out.points.size(); ++i)
      EXPECT_LT(distance(out.points[i], paper.carried(middles.points[i], positions)), 1e-5) << neighbours;
  }
}

TEST(SolidSkin, TakesASimulationPointAloneWhereItLiesOnOne) {
  const Ball ball;
  TriMesh skin;
  std::vector<int> of;
  for (std::size_t p = 0; p < ball.solid.points.size(); ++p) {
    if (ball.solid.on_surface[p])
      skin.points.push_back(ball.solid.points[p]), of.push_back(static_cast<int>(p));
  }
  const auto positions = moved(ball.solid.points, [](const Vec3& p) {
    return p + Vec3{std::sin(p.y), 3 * std::sin(p.z), 0};
  });
  const auto out = carried(bound(ball.solid, skin), positions);
  for (std::size_t i = 0; i < of.size(); ++i) EXPECT_EQ(out.points[i], positions[at(of[i])]);
  expect_unit(out.normals);  // without triangles: of the frames
}

TEST(SolidSkin, TurnsNormalsWithTheSkin) {
  const Bar bar;
  const SolidSkin skin = bound(bar.solid, bar.skin);
  for (const Motion& motion : {Motion(twisted), Motion(bent)}) {
    const auto out = carried(skin, moved(bar.solid.points, motion));
    const auto truth = point_normals({moved(bar.skin.points, motion), bar.skin.triangles});
    expect_unit(out.normals);
    double sum = 0;
    for (std::size_t i = 0; i < truth.size(); ++i) sum += distance(out.normals[i], truth[i]);
    EXPECT_LT(sum / static_cast<double>(truth.size()), radians(1.5));
    std::vector<Vec3> positions(skin.point_count());
    skin.apply(moved(bar.solid.points, motion), positions, {});
    EXPECT_TRUE(positions == out.points);
  }
}

TEST(SolidSkin, StaysFiniteWhereFramesDegenerate) {
  const Ball ball;
  const SolidSkin skin = bound(ball.solid, ball.skin);
  const RandomStream random(2);
  for (const Motion& motion :
       {Motion([](const Vec3&) {
          return Vec3{1, 2, 3};
        }),
        Motion([](const Vec3& p) {
          return Vec3{p.x, p.y, 0};
        }),
        Motion([](const Vec3& p) {
          return Vec3{p.x, 0, 0};
        }),
        Motion([](const Vec3& p) { return -p; }), Motion([](const Vec3& p) { return p * 1e30; }),
        Motion([](const Vec3& p) { return p * 1e-60; }), Motion([&](const Vec3& p) {
          return testing::random_direction(random, static_cast<std::uint64_t>(std::abs(p.x * p.y * 1000)));
        })}) {
    const auto out = carried(skin, moved(ball.solid.points, motion));
    for (const Vec3& p : out.points) ASSERT_TRUE(is_finite(p));
    expect_unit(out.normals);
  }
  auto positions = moved(ball.solid.points, [](const Vec3& p) { return p; });
  positions[0].x = std::numeric_limits<double>::quiet_NaN();  // spoils what follows it, no more
  positions.back().y = 1e308;
  (void)carried(skin, positions);
}

TEST(SolidSkin, FindsFramesWhereCubesTouchInACornerOrAnEdge) {
  for (const Index3& second : {Index3{2, 2, 2}, Index3{2, 2, 1}}) {
    VoxelGrid grid({4, 4, 4});
    grid.set(1, 1, 1);
    grid.set(second[0], second[1], second[2]);
    const auto solid = solid_of(grid);
    ASSERT_TRUE(solid);
    const TriMesh surface = testing::sphere(0.9, 3, {2, 2, second[2] == 2 ? 2 : 1.5});
    const SolidSkin skin = bound(*solid, surface);
    const auto turn = RigidTransform::rotate_about({1, 2, 3}, normalized(Vec3{3, -2, 1}), 2);
    const Motion motion = [&](const Vec3& p) { return turn.point(p); };
    const auto out = carried(skin, moved(solid->points, motion));
    EXPECT_LT(largest_difference(out.points, moved(surface.points, motion)), 1e-12);
    expect_unit(out.normals);
  }
}

TEST(SolidSkin, TakesFewerNeighboursWhereTheSolidHasFewer) {
  SolidMesh solid;
  solid.points = {{0, 0, 0}, {10, 0, 0}, {0, 10, 0}, {0, 0, 10}};
  solid.tetrahedra = {{0, 1, 2, 3}};
  solid.surface_triangles = {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {0, 3, 2}};
  const TriMesh surface = testing::sphere(6, 2, {2, 2, 2});
  const auto out = carried(bound(solid, surface, 64), solid.points);
  EXPECT_LT(largest_difference(out.points, surface.points), 1e-13);
}

TEST(SolidSkin, RefusesWildInput) {
  const Ball ball;
  const auto fails = [](const SolidMesh& solid, const TriMesh& skin, int neighbours = 5) {
    const auto result = SolidSkin::bind(solid, skin, neighbours);
    return !result && result.error().kind == ErrorKind::bad_input && !result.error().what.empty();
  };
  EXPECT_TRUE(fails(SolidMesh{}, ball.skin));
  for (const int n : {0, -1, 65, std::numeric_limits<int>::max()})
    EXPECT_TRUE(fails(ball.solid, ball.skin, n));
  for (const double wild :
       {std::numeric_limits<double>::quiet_NaN(), 1e308, -std::numeric_limits<double>::infinity()}) {
    SolidMesh solid = ball.solid;
    solid.points[17].z = wild;
    EXPECT_TRUE(fails(solid, ball.skin));
    TriMesh skin = ball.skin;
    skin.points[17].z = wild;
    EXPECT_TRUE(fails(ball.solid, skin));
  }
  SolidMesh solid = ball.solid;
  solid.surface_triangles[3][1] = static_cast<int>(solid.points.size());
  EXPECT_TRUE(fails(solid, ball.skin));
  for (Vec3& p : solid.points) p = {};
  solid.surface_triangles = ball.solid.surface_triangles;
  EXPECT_TRUE(fails(solid, ball.skin));
  TriMesh skin = ball.skin;
  skin.triangles[0][0] = -1;
  EXPECT_TRUE(fails(ball.solid, skin));
  EXPECT_EQ(bound(ball.solid, {}).point_count(), 0U);
}

TEST(SolidSkin, HasTheSameBitsOnAnyNumberOfThreads) {
  const Bar bar;
  const auto positions = moved(bar.solid.points, twisted);
  const auto run = [&](int threads) {
    set_thread_count(threads);
    auto out = carried(bound(bar.solid, bar.skin), positions);
    set_thread_count(0);
    return out;
  };
  const auto one = run(1), two = run(2);
  EXPECT_TRUE(one.points == two.points);
  EXPECT_TRUE(one.normals == two.normals);
}

/// Both ways against the motion itself, which the solid's points follow exactly.
TEST(SkinDifference, TellsBothWaysToFollowATwistAndABendApart) {
  const Bar bar;
  const SolidSkin skin = bound(bar.solid, bar.skin);
  const auto embedding = TetraEmbedding::bind(bar.solid.points, bar.solid.tetrahedra, bar.skin.points);
  ASSERT_TRUE(embedding);
  for (const Motion& motion : {Motion(twisted), Motion(bent)}) {
    const TriMesh truth{moved(bar.skin.points, motion), bar.skin.triangles};
    TriMesh framed = truth, embedded = truth;
    const auto positions = moved(bar.solid.points, motion);
    skin.apply(positions, framed.points, {});
    embedding->apply(positions, embedded.points);
    const auto by_frames = difference(truth, framed), by_tetrahedra = difference(truth, embedded);
    const auto between = difference(framed, embedded);
    ASSERT_TRUE(by_frames && by_tetrahedra && between);
    EXPECT_LT(by_frames->root_mean_square_mm, 0.03);
    EXPECT_LT(by_tetrahedra->root_mean_square_mm, 0.012);
    EXPECT_LT(by_frames->mean_normal_angle_deg, 1);
    EXPECT_LT(by_tetrahedra->mean_normal_angle_deg, 0.6);
    EXPECT_LT(between->greatest_mm, 0.1);
    for (const TriMesh& mesh : {framed, embedded})
      EXPECT_NEAR(enclosed_volume(mesh) / enclosed_volume(truth), 1, 1e-3);
  }
}

TEST(SkinDifference, MeasuresHowFarTwoSurfacesAreApart) {
  const TriMesh flat = testing::sheet(4, 100);
  TriMesh tilted = flat;
  for (Vec3& p : tilted.points) p = {p.x * std::cos(0.1), p.y, p.x * std::sin(0.1)};
  const auto turned = difference(flat, tilted);
  ASSERT_TRUE(turned);
  EXPECT_NEAR(turned->mean_normal_angle_deg, degrees(0.1), 1e-9);
  EXPECT_NEAR(turned->greatest_mm, 200 * std::sin(0.05), 1e-9);
  EXPECT_NEAR(turned->mean_mm, 100 * std::sin(0.05), 1e-9);
  EXPECT_NEAR(turned->root_mean_square_mm, 200 * std::sin(0.05) * std::sqrt(30.0 / 80), 1e-9);
  EXPECT_EQ(turned->greatest_at, 4);
  const auto same = difference(flat, flat);
  ASSERT_TRUE(same);
  EXPECT_EQ(same->greatest_mm, 0);
  EXPECT_EQ(same->mean_normal_angle_deg, 0);
}

TEST(SkinDifference, RefusesWhatCannotBeCompared) {
  const TriMesh flat = testing::sheet(4, 100);
  EXPECT_FALSE(difference(flat, testing::sheet(5, 100)));
  EXPECT_FALSE(difference({}, {}));
  TriMesh bad = flat;
  bad.points[3].x = std::numeric_limits<double>::infinity();
  EXPECT_FALSE(difference(flat, bad));
  bad.points[3].x = 1e200;
  EXPECT_FALSE(difference(bad, flat));
}

}  // namespace
}  // namespace turgor
