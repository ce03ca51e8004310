#include "turgor/render/ray_tracer.hpp"

#include <gtest/gtest.h>

#include <atomic>
#include <limits>
#include <numbers>

#include "support.hpp"
#include "turgor/core/parallel.hpp"

namespace turgor::render_tests {
namespace {

Image picture(const std::vector<Body>& bodies, const CameraView& camera, int side = 200, int samples = 16) {
  Context context;
  RenderOptions options;
  options.width = options.height = side;
  options.samples = samples;
  auto image = render(bodies, camera, options, context);
  EXPECT_TRUE(image) << image.error().message();
  return image ? *std::move(image) : filled_image(side, side, {});
}

CameraView front_camera(double height_mm) {
  CameraView camera;
  camera.eye = {0, -500, 0};
  camera.target = {0, 0, 0};
  camera.height_mm = height_mm;
  return camera;
}

TEST(RayTracer, SilhouetteOfASphereHasItsArea) {
  const TriMesh sphere = sphere_mesh({}, 50, 5);
  const Image image = picture({plain_body(sphere, red)}, front_camera(120), 400);
  const Blob seen = blob(image, [](const auto& c) { return !is_white(c); });
  const double r = 50 * 400 / 120.0, perimeter = 2 * std::numbers::pi * r;
  EXPECT_NEAR(seen.count, std::numbers::pi * r * r + perimeter / 2, perimeter / 2);
  EXPECT_NEAR(seen.x, 200, 0.5);
  EXPECT_NEAR(seen.y, 200, 0.5);
}

TEST(RayTracer, EdgesAreCoveredInProportion) {
  // The upright edge of a plate at x = 0.25 pixels into column 100.
  TriMesh plate = plate_mesh(40, 0);
  for (Vec3& p : plate.points) p.x += 40.25;
  const Image image = picture({plain_body(plate, {0.5f, 0.5f, 0.5f})}, front_camera(200), 200, 64);
  const float inside = linear_at(image, 110, 100).x, edge = linear_at(image, 100, 100).x;
  EXPECT_NEAR((edge - inside) / (1 - inside), 0.25, 0.05);
  EXPECT_EQ(linear_at(image, 99, 100).x, 1.0f);
}

TEST(RayTracer, TheNearerBodyHidesTheOther) {
  const TriMesh near = plate_mesh(30, -20), far = plate_mesh(30, 20);
  for (const bool red_first : {true, false}) {
    const std::vector<Body> bodies = red_first ? std::vector{plain_body(near, red), plain_body(far, blue)}
                                               : std::vector{plain_body(far, blue), plain_body(near, red)};
    EXPECT_TRUE(is_red(bytes_at(picture(bodies, front_camera(100)), 100, 100)));
  }
  CameraView behind = front_camera(100);
  behind.eye = {0, 500, 0};
  EXPECT_TRUE(is_blue(bytes_at(picture({plain_body(near, red), plain_body(far, blue)}, behind), 100, 100)));
}

// A mirrored patient is the worst error a picture can make.
TEST(StandardView, ShowsThePatientsSidesWhereTheyBelong) {
  const TriMesh left_ear = box_mesh({40, -5, -5}, {50, 5, 5}), nose = box_mesh({-5, -50, -5}, {5, -40, 5});
  const auto see = [&](StandardView view) {
    const Image image =
        picture({plain_body(left_ear, red), plain_body(nose, blue)}, standard_view(view, cube_box(50)));
    return std::pair{blob(image, is_red), blob(image, is_blue)};
  };
  const auto [front_ear, front_nose] = see(StandardView::front);
  EXPECT_GT(front_ear.x, 150);
  EXPECT_NEAR(front_nose.x, 100, 1);
  EXPECT_LT(see(StandardView::back).first.x, 50);
  const auto [near_ear, nose_left] = see(StandardView::profile_left);
  EXPECT_NEAR(near_ear.x, 100, 1);
  EXPECT_LT(nose_left.x, 50);
  const auto [far_ear, nose_right] = see(StandardView::profile_right);
  EXPECT_NEAR(far_ear.x, 100, 1);
  EXPECT_GT(nose_right.x, 150);
  EXPECT_LT(see(StandardView::three_quarter_left).second.x,
            80);  // turned to the picture's left: the left cheek shows
  EXPECT_GT(see(StandardView::three_quarter_left).first.x, 130);
  EXPECT_GT(see(StandardView::three_quarter_right).second.x, 120);
  const auto [top_ear, top_nose] = see(StandardView::top);
  EXPECT_GT(top_ear.x, 150);
  EXPECT_GT(top_nose.y, 150);
  const auto [below_ear, below_nose] = see(StandardView::below);
  EXPECT_GT(below_ear.x, 150);
  EXPECT_LT(below_nose.y, 50);
}

TEST(StandardView, ProfileRightHidesTheLeftCheek) {
  const TriMesh left = plate_mesh(1, 0), right_cheek = box_mesh({-50, -20, -20}, {-40, 20, 20}),
                left_cheek = box_mesh({40, -20, -20}, {50, 20, 20});
  const std::vector<Body> bodies{plain_body(right_cheek, red), plain_body(left_cheek, blue)};
  const Image right_profile = picture(bodies, standard_view(StandardView::profile_right, cube_box(50)));
  EXPECT_GT(blob(right_profile, is_red).count, 0);
  EXPECT_EQ(blob(right_profile, is_blue).count, 0);
  const Image left_profile = picture(bodies, standard_view(StandardView::profile_left, cube_box(50)));
  EXPECT_EQ(blob(left_profile, is_red).count, 0);
}

TEST(Project, AgreesWithTheRaysInEveryView) {
  const Vec3 place{31, -17, 23};
  const TriMesh dot = sphere_mesh(place, 2, 3);
  for (const double fov : {0.0, 25.0})
    for (int v = 0; v < 8; ++v) {
      CameraView camera = standard_view(static_cast<StandardView>(v), cube_box(50));
      if (fov > 0) camera = in_perspective(camera, fov);
      const Image image = picture({plain_body(dot, red)}, camera, 300);
      const Blob seen = blob(image, [](const auto& c) { return !is_white(c); });
      const auto at = project(camera, 300, 300, place);
      ASSERT_TRUE(at);
      ASSERT_GT(seen.count, 0) << "view " << v << " fov " << fov;
      EXPECT_NEAR(seen.x, at->x, 0.6) << "view " << v << " fov " << fov;
      EXPECT_NEAR(seen.y, at->y, 0.6) << "view " << v << " fov " << fov;
    }
}

TEST(RayTracer, AFilmMixesWithWhatIsBehindByItsOpacity) {
  const TriMesh film = plate_mesh(30, -10), wall = plate_mesh(60, 30);
  const CameraView camera = front_camera(100);
  const Vec3f alone = linear_at(picture({plain_body(film, blue)}, camera), 100, 100);
  const Vec3f behind = linear_at(picture({plain_body(wall, red)}, camera), 100, 100);
  for (const double opacity : {0.0, 0.3, 0.7}) {
    const Vec3f mixed =
        linear_at(picture({plain_body(wall, red), plain_body(film, blue, opacity)}, camera), 100, 100);
    const Vec3f expected = lerp(behind, alone, static_cast<float>(opacity));
    for (int k = 0; k < 3; ++k) EXPECT_NEAR(mixed[k], expected[k], 0.012) << opacity;
  }
}

TEST(RayTracer, OfATranslucentBodyOnlyTheFrontIsSeen) {
  const TriMesh box = box_mesh({-20, -20, -20}, {20, 20, 20}), front = plate_mesh(20, -20);
  const CameraView camera = front_camera(100);
  const auto closed = linear_at(picture({plain_body(box, blue, 0.4)}, camera), 100, 100);
  const auto sheet = linear_at(picture({plain_body(front, blue, 0.4)}, camera), 100, 100);
  for (int k = 0; k < 3; ++k) EXPECT_NEAR(closed[k], sheet[k], 0.012);
}

TEST(RayTracer, AFilmThatLiesOnASolidBodyDoesNotFlickerOverIt) {
  const TriMesh sphere = sphere_mesh({0, 0, 0}, 40, 4);
  const Body solid{&sphere, {MaterialKind::skin}, {}};
  const Image with = picture({solid, plain_body(sphere, blue, 0.5)}, front_camera(100));
  EXPECT_EQ(with.rgb, picture({solid}, front_camera(100)).rgb);
}

TEST(RayTracer, OutlinesShowWhatLiesBelowTheNewSurface) {
  const TriMesh after = sphere_mesh({}, 40, 5), before = sphere_mesh({}, 30, 5);
  const Body solid = plain_body(after, {0.6f, 0.6f, 0.6f});
  Body film = plain_body(before, blue, 0.4);
  const Image plain = picture({solid, film}, front_camera(100));
  EXPECT_EQ(blob(plain, is_blue).count, 0);
  film.material.outline = true;
  const Image lined = picture({solid, film}, front_camera(100));
  const Blob ring = blob(lined, is_blue);
  EXPECT_GT(ring.count, 200);
  EXPECT_NEAR(ring.x, 100, 0.5);
  for (int y = 0; y < 200; ++y)
    for (int x = 0; x < 200; ++x)
      if (is_blue(bytes_at(lined, x, y))) {
        EXPECT_NEAR(std::hypot(x - 99.5, y - 99.5), 60, 2.5);
      }
  // Where nothing moved there is no line.
  const Body same{&after, {MaterialKind::plain, blue, 0.4, true}, {}};
  EXPECT_EQ(picture({solid, same}, front_camera(100)).rgb, picture({solid}, front_camera(100)).rgb);
}

TEST(RayTracer, AFacetFoldedOverIsNoHole) {
  // Two facets of a smooth ball turned inside out, as edge collapse leaves them at times.
  TriMesh ball = sphere_mesh({}, 40, 5);
  const Image whole = picture({plain_body(ball, {0.6f, 0.6f, 0.6f})}, front_camera(100));
  int turned = 0;
  for (Index3& t : ball.triangles)
    if (turned < 2 && triangle_normal(ball, t).y < -0.99 * length(triangle_normal(ball, t))) {
      std::swap(t[1], t[2]);
      ++turned;
    }
  ASSERT_EQ(turned, 2);
  const Image folded = picture({plain_body(ball, {0.6f, 0.6f, 0.6f})}, front_camera(100));
  int darkest = 255;
  for (int y = 80; y < 120; ++y)
    for (int x = 80; x < 120; ++x)
      darkest = std::min(darkest, bytes_at(folded, x, y)[0] - bytes_at(whole, x, y)[0]);
  EXPECT_GT(darkest, -40);
}

TEST(RayTracer, SkinIsTheSameBitsOnOneAndTwoThreadsAndOnRepeat) {
  const TriMesh head = sphere_mesh({}, 40, 5), nose = sphere_mesh({0, -42, 0}, 8, 3),
                ghost = sphere_mesh({4, -6, 0}, 42, 4);
  const std::vector<Body> bodies{
      {&head, {MaterialKind::skin}, {}}, {&nose, {MaterialKind::mucosa}, {}}, plain_body(ghost, blue, 0.3)};
  set_thread_count(1);
  const Image one = picture(bodies, front_camera(100));
  set_thread_count(2);
  const Image two = picture(bodies, front_camera(100));
  set_thread_count(0);
  EXPECT_EQ(one.rgb, two.rgb);
  EXPECT_EQ(two.rgb, picture(bodies, front_camera(100)).rgb);
}

TEST(RayTracer, InsidesOfOpenSurfacesAreDarker) {
  const TriMesh plate = plate_mesh(30, 0);
  TriMesh turned = plate;
  for (Index3& t : turned.triangles) std::swap(t[1], t[2]);
  const auto outside =
      linear_at(picture({plain_body(plate, {0.5f, 0.5f, 0.5f})}, front_camera(100)), 100, 100);
  const auto inside =
      linear_at(picture({plain_body(turned, {0.5f, 0.5f, 0.5f})}, front_camera(100)), 100, 100);
  EXPECT_LT(inside.x, 0.7f * outside.x);
  EXPECT_GT(inside.x, 0.05f);
}

TEST(RayTracer, BodiesShadeOneAnotherSoftly) {
  const TriMesh wall = plate_mesh(100, 0), ball = sphere_mesh({0, -25, 0}, 10, 4);
  const Body bone{&wall, {MaterialKind::bone}, {}};
  const Image lit = picture({bone}, front_camera(150)),
              shaded = picture({bone, plain_body(ball, red)}, front_camera(150));
  // The key stands above to the left: the shadow falls below to the right, and fades over several pixels.
  EXPECT_LT(linear_at(shaded, 118, 124).y, 0.8f * linear_at(lit, 118, 124).y);
  EXPECT_NEAR(linear_at(shaded, 20, 20).y, linear_at(lit, 20, 20).y, 0.03);
  int between = 0;
  for (int x = 100; x < 200; ++x) {
    const float share = linear_at(shaded, x, 130).y / linear_at(lit, x, 130).y;
    between += share > 0.75f && share < 0.95f;
  }
  EXPECT_GT(between, 4);
}

TEST(RayTracer, CornersOfABoxStaySharpWhileASphereIsSmooth) {
  const TriMesh box = box_mesh({-20, -20, -20}, {20, 20, 20});
  CameraView camera = front_camera(100);
  camera.eye = {-300, -500, 0};
  const Image image = picture({plain_body(box, {0.6f, 0.6f, 0.6f})}, camera);
  // Left and right of the upright edge nearest to the viewer the faces keep one tone each.
  const auto edge = project(camera, 200, 200, {-20, -20, 0});
  ASSERT_TRUE(edge);
  const int x = static_cast<int>(edge->x);
  EXPECT_NEAR(bytes_at(image, x + 3, 100)[0], bytes_at(image, x + 20, 100)[0], 6);
  EXPECT_NEAR(bytes_at(image, x - 3, 100)[0], bytes_at(image, x - 12, 100)[0], 6);
  EXPECT_GT(std::abs(bytes_at(image, x + 3, 100)[0] - bytes_at(image, x - 3, 100)[0]), 8);
  // A coarse ball shows no facets: neighbouring pixels differ little.
  const TriMesh ball = sphere_mesh({}, 40, 3);
  const Image round = picture({plain_body(ball, {0.6f, 0.6f, 0.6f})}, front_camera(100));
  for (int u = 60; u < 140; ++u)
    EXPECT_LE(std::abs(bytes_at(round, u, 90)[0] - bytes_at(round, u + 1, 90)[0]), 5);
}

TEST(RayTracer, PointColoursAreReadAgainstTheLegend) {
  TriMesh plate = plate_mesh(30, 0);
  const Vec3f colour = colour_map(0.6);
  const Body body{&plate, {}, std::vector<Vec3f>(plate.points.size(), colour)};
  const Vec3f seen = linear_at(picture({body}, front_camera(100)), 100, 100);
  EXPECT_NEAR(seen.x / seen.y, colour.x / colour.y, 0.15);
  EXPECT_NEAR(seen.z / seen.y, colour.z / colour.y, 0.15);
  EXPECT_NEAR(seen.y, colour.y, 0.15 * colour.y);
}

TEST(RayTracer, SkinIsWarmerThanBoneAndBothAreLit) {
  const TriMesh ball = sphere_mesh({}, 40, 5);
  const auto tone = [&](MaterialKind kind) {
    return linear_at(picture({{&ball, {kind}, {}}}, front_camera(100)), 90, 85);
  };
  const Vec3f skin = tone(MaterialKind::skin), bone = tone(MaterialKind::bone),
              mucosa = tone(MaterialKind::mucosa);
  EXPECT_GT(skin.x / skin.z, 1.25f * bone.x / bone.z);
  EXPECT_GT(mucosa.x / mucosa.y, 1.3f * skin.x / skin.y);
  EXPECT_GT(skin.x, 0.3f);
  EXPECT_GT(bone.y, 0.3f);
}

TEST(RayTracer, AnEmptySceneIsBackground) {
  Context context;
  RenderOptions options;
  options.width = 31, options.height = 17;
  options.background = {0.2f, 0.4f, 0.6f};
  const auto image = render({}, front_camera(100), options, context);
  ASSERT_TRUE(image) << image.error().message();
  EXPECT_EQ(image->rgb, filled_image(31, 17, options.background).rgb);
}

TEST(RayTracer, BodiesOutsideThePictureLeaveBackground) {
  const TriMesh ball = sphere_mesh({500, 0, 0}, 20, 3), behind = sphere_mesh({0, -900, 0}, 20, 3);
  for (const double fov : {0.0, 30.0}) {
    CameraView camera = front_camera(100);
    camera.fov_deg = fov;
    const Image image = picture({plain_body(ball, red), plain_body(behind, blue)}, camera);
    EXPECT_EQ(blob(image, [](const auto& c) { return !is_white(c); }).count, 0);
  }
}

TEST(RayTracer, FarFromTheOriginThePictureIsTheSame) {
  const TriMesh ball = sphere_mesh({}, 40, 4);
  TriMesh moved = ball;
  const Vec3 away{4096, -8192, 2048};
  for (Vec3& p : moved.points) p += away;
  CameraView camera = front_camera(100), moved_camera = camera;
  moved_camera.eye += away, moved_camera.target += away;
  const Image here = picture({{&ball, {MaterialKind::skin}, {}}}, camera);
  const Image there = picture({{&moved, {MaterialKind::skin}, {}}}, moved_camera);
  int worst = 0;
  for (std::size_t i = 0; i < here.rgb.size(); ++i)
    worst = std::max(worst, std::abs(here.rgb[i] - there.rgb[i]));
  EXPECT_LE(worst, 2);
}

TEST(Renderer, OneSceneServesManyPicturesAndOutlivesItsMeshes) {
  Context context;
  RenderOptions options;
  options.width = options.height = 100;
  const TriMesh ball = sphere_mesh({}, 40, 3);
  auto renderer = [&] {
    const TriMesh copy = ball;
    return Renderer::create({{&copy, {MaterialKind::bone}, {}}}, context);
  }();
  ASSERT_TRUE(renderer);
  for (const StandardView view : {StandardView::front, StandardView::top}) {
    const CameraView camera = standard_view(view, cube_box(50));
    const auto one = renderer->render(camera, options, context);
    const auto other = render({{&ball, {MaterialKind::bone}, {}}}, camera, options, context);
    ASSERT_TRUE(one && other);
    EXPECT_EQ(one->rgb, other->rgb);
  }
}

TEST(RayTracer, BadInputEndsInOneSentence) {
  Context context;
  const RenderOptions options;
  const auto error_of = [&](const Body& body) {
    const auto image = render({body}, front_camera(100), options, context);
    EXPECT_FALSE(image);
    EXPECT_TRUE(image || image.error().kind == ErrorKind::bad_input);
    return image ? std::string() : image.error().message();
  };
  const TriMesh empty;
  EXPECT_NE(error_of({&empty, {}, {}}).find("no triangles"), std::string::npos);
  EXPECT_NE(error_of({}).find("no triangles"), std::string::npos);
  TriMesh nan = plate_mesh(10, 0);
  nan.points[2].y = std::nan("");
  EXPECT_NE(error_of(plain_body(nan, red)).find("point 2"), std::string::npos);
  TriMesh torn = plate_mesh(10, 0);
  torn.triangles[1][2] = 4;
  EXPECT_NE(error_of(plain_body(torn, red)).find("triangle 1"), std::string::npos);
  const TriMesh plate = plate_mesh(10, 0);
  EXPECT_NE(error_of({&plate, {}, {red}}).find("1 colours do not match 4 points"), std::string::npos);
  EXPECT_NE(error_of(plain_body(plate, red, 1.5)).find("opacity"), std::string::npos);
}

TEST(RayTracer, BadCamerasAndSizesAreRefused) {
  Context context;
  const TriMesh plate = plate_mesh(10, 0);
  const auto refused = [&](const CameraView& camera, const RenderOptions& options) {
    const auto image = render({plain_body(plate, red)}, camera, options, context);
    return !image && image.error().kind == ErrorKind::bad_input;
  };
  const RenderOptions options;
  CameraView camera = front_camera(100);
  camera.eye = camera.target;
  EXPECT_TRUE(refused(camera, options));
  camera = front_camera(0);
  EXPECT_TRUE(refused(camera, options));
  camera = front_camera(100);
  camera.fov_deg = 180;
  EXPECT_TRUE(refused(camera, options));
  camera = front_camera(100);
  camera.up = {0, 1, 0};  // along the line of sight: another one is taken
  EXPECT_FALSE(refused(camera, options));
  for (const auto& [width, height, samples] :
       {std::array{0, 10, 4}, {10, -1, 4}, {100'000, 10, 4}, {10'000, 10'000, 4}, {10, 10, 0}}) {
    RenderOptions bad;
    bad.width = width, bad.height = height, bad.samples = samples;
    EXPECT_TRUE(refused(front_camera(100), bad));
  }
}

TEST(RayTracer, TrianglesWithoutAreaDoNoHarm) {
  TriMesh plate = plate_mesh(30, 0);
  plate.points.push_back(plate.points[0]);
  plate.triangles.push_back({0, 4, 1});
  plate.triangles.push_back({2, 2, 2});
  const Image image = picture({{&plate, {MaterialKind::skin}, {}}}, front_camera(100));
  EXPECT_GT(linear_at(image, 100, 100).x, 0.2f);
}

TEST(RayTracer, StopsWhenTheUserAsks) {
  std::atomic<int> asked = 0;
  Context context({}, {}, [&] { return ++asked > 5; });
  const TriMesh ball = sphere_mesh({}, 40, 5);
  const auto image = render({{&ball, {MaterialKind::skin}, {}}}, front_camera(100), RenderOptions{}, context);
  ASSERT_FALSE(image);
  EXPECT_EQ(image.error().kind, ErrorKind::cancelled);
}

TEST(RayTracer, LampsThatCannotShineAreErrors) {
  const TriMesh plate = plate_mesh(40, 0);
  Context context;
  const auto fails = [&](const RenderOptions& options) {
    const auto image = render({plain_body(plate, red)}, front_camera(100), options, context);
    return !image && image.error().kind == ErrorKind::bad_input;
  };
  RenderOptions options;
  options.width = options.height = 8;
  const double nan = std::numeric_limits<double>::quiet_NaN();
  for (const Vec3& along : {Vec3{}, Vec3{nan, 0, 1}, Vec3{1e308, 1e308, 0}}) {
    options.lights = {{along, {1, 1, 1}}};
    EXPECT_TRUE(fails(options));
  }
  options.lights = {{{0, 0, -1}, {static_cast<float>(nan), 1, 1}}};
  EXPECT_TRUE(fails(options));
  options.lights.clear();
  for (const int rays : {-1, 257}) {
    options.light_rays = rays;
    EXPECT_TRUE(fails(options));
  }
  options.light_rays = 256;
  EXPECT_FALSE(fails(options));
}

TEST(RayTracer, GlossyBodiesLookAlikeFromBothSides) {
  TriMesh plate = plate_mesh(40, 0);
  Body body = plain_body(plate, red);
  body.material.kind = MaterialKind::glossy;
  const Image front = picture({body}, front_camera(60), 40);
  for (Index3& t : plate.triangles) std::swap(t[1], t[2]);
  EXPECT_EQ(picture({body}, front_camera(60), 40).rgb, front.rgb);
  body.material.exponent = -1;
  Context context;
  EXPECT_FALSE(render({body}, front_camera(60), {}, context));
}

}  // namespace
}  // namespace turgor::render_tests
