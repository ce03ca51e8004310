#include "turgor/render/leak_picture.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>

#include "geometry/shapes.hpp"

namespace turgor {
namespace {

/// A sphere about `centre` with a round hole of about `radius` towards `towards`.
TriMesh open_sphere(const Vec3& centre, const Vec3& towards, double radius) {
  TriMesh ball = testing::sphere(50, 5, centre);
  std::erase_if(ball.triangles, [&](const Index3& t) {
    Vec3 middle;
    for (const int p : t) middle += ball.points[static_cast<std::size_t>(p)] / 3;
    return distance(middle, centre + towards * 50) < radius;
  });
  return ball;
}

std::vector<SurfaceHole> holes_of(const TriMesh& mesh) {
  auto holes = surface_holes(mesh);
  EXPECT_TRUE(holes) << (holes ? "" : holes.error().message());
  return holes ? *std::move(holes) : std::vector<SurfaceHole>{};
}

TEST(SurfaceHoles, HavePlaceNormalAndRadius) {
  const Vec3 towards = normalized(Vec3{1, -2, 0.5}), centre{10, 20, -30};
  const auto holes = holes_of(open_sphere(centre, towards, 12));
  ASSERT_EQ(holes.size(), 1U);
  EXPECT_LT(distance(holes[0].middle, centre + towards * std::sqrt(2500 - 144)), 1);
  EXPECT_GT(std::abs(dot(holes[0].normal, towards)), 0.999);
  EXPECT_NEAR(holes[0].radius, 12, 1.5);
  EXPECT_EQ(holes[0].text().substr(0, 8), "hole of ");
  EXPECT_TRUE(holes_of(testing::sphere(50, 3)).empty());
  EXPECT_FALSE(surface_holes(TriMesh{}));
}

TEST(LeakPicture, LooksThroughTheHoleFromOutside) {
  const Vec3 towards = normalized(Vec3{1, -2, 0.5});
  const TriMesh ball = open_sphere({}, towards, 12);
  EXPECT_GT(dot(best_view(ball, holes_of(ball)[0]), towards), 0.9);
}

TEST(LeakPicture, LooksPastWhatStandsBeforeTheHole) {
  const Vec3 towards{0, -1, 0};
  const TriMesh ball = open_sphere({}, towards, 12);
  const TriMesh shield = testing::box({-12, -75, -12}, {12, -70, 12});
  const Vec3 view = best_view(append(ball, shield), holes_of(ball)[0]);
  EXPECT_GT(dot(view, towards), 0.3);
  EXPECT_LT(dot(view, towards), 0.999);
}

TEST(LeakPicture, ShowsTheRimInRed) {
  const TriMesh ball = open_sphere({}, normalized(Vec3{1, -2, 0.5}), 12);
  Context context;
  LeakPictureOptions options;
  options.size = 200, options.samples = 4;
  const auto picture = leak_picture(ball, holes_of(ball), options, context);
  ASSERT_TRUE(picture) << picture.error().message();
  EXPECT_GE(picture->width, 400);
  int red = 0;
  for (std::size_t p = 0; p + 2 < picture->rgb.size(); p += 3)
    red += picture->rgb[p] > 180 && picture->rgb[p + 1] < 90 && picture->rgb[p + 2] < 90 ? 1 : 0;
  EXPECT_GT(red, 400);
  if (const char* folder = std::getenv("TURGOR_KEEP_PICTURES"))
    EXPECT_TRUE(write_png(std::filesystem::path(folder) / "leak.png", *picture));
}

TEST(LeakPicture, RefusesWhatItCannotDraw) {
  Context context;
  const TriMesh ball = testing::sphere(50, 3);
  EXPECT_FALSE(leak_picture(ball, {}, {}, context));
  const TriMesh open = open_sphere({}, {0, 0, 1}, 12);
  LeakPictureOptions options;
  options.size = 1 << 20;
  EXPECT_FALSE(leak_picture(open, holes_of(open), options, context));
}

}  // namespace
}  // namespace turgor
