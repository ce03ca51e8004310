#include "turgor/render/scene_pictures.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "draped_scene.hpp"
#include "support.hpp"
#include "turgor/core/parallel.hpp"

namespace turgor::render_tests {
namespace {

constexpr double nan = std::numeric_limits<double>::quiet_NaN();

Image drawn(const Scene& scene, const ScenePictureOptions& options = {}) {
  Context context;
  auto image = draw_screen(scene, options, context);
  EXPECT_TRUE(image) << image.error().message();
  return image ? *std::move(image) : filled_image(scene.screen.width, scene.screen.height, {});
}

void expect_error(const Scene& scene, const std::string& word, const ScenePictureOptions& options = {}) {
  Context context;
  const auto image = draw_screen(scene, options, context);
  ASSERT_FALSE(image) << word;
  EXPECT_EQ(image.error().kind, ErrorKind::bad_input);
  EXPECT_NE(image.error().message().find(word), std::string::npos) << image.error().message();
}

/// A small screen with the camera at (0, 0, distance) that looks down on the origin, x to the right.
Scene scene_from_above(double distance = 4) {
  Scene scene;
  scene.screen.width = 200, scene.screen.height = 160;
  const int camera = scene.id_of("camera");
  CameraLens lens;
  lens.target_distance = distance;
  scene.set_description(camera, lens);
  ObjectTransform transform;
  transform.translation = {0, 0, distance};
  scene.set_transform(camera, transform);
  return scene;
}

/// The camera of scene_from_above as the tracer has it.
CameraView view_from_above(double distance = 4) {
  return {{0, 0, distance}, {}, {0, 1, 0}, 35, 1};
}

int add(Scene& scene, const std::string& shape, const std::string& name, const Vec3f& colour,
        const Vec3& place = {}, double size = 1) {
  Object object = primitive(shape, name);
  object.transform.translation = place;
  object.transform.linear = {{Vec3{size, 0, 0}, Vec3{0, size, 0}, Vec3{0, 0, size}}};
  object.optics.diffuse = colour;
  auto id = scene.add_object(std::move(object));
  EXPECT_TRUE(id) << id.error().message();
  return id ? *id : -1;
}

std::array<int, 3> at_point(const Image& image, const Vec3& p, double distance = 4) {
  const auto at = project(view_from_above(distance), image.width, image.height, p);
  return bytes_at(image, static_cast<int>(at->x), static_cast<int>(at->y));
}

template <class Change>
void with_optics(Scene& scene, int id, Change&& change) {
  Optics optics = scene.find(id)->optics;
  change(optics);
  scene.set_optics(id, optics);
}

TEST(DrawScreen, ObjectsAreWhereTheCameraSeesThem) {
  Scene scene = scene_from_above();
  const Vec3 place{0.5, -0.3, 0};
  add(scene, "sphere", "ball", red, place, 0.6);
  const Image image = drawn(scene);
  EXPECT_EQ(image.width, 200);
  EXPECT_EQ(image.height, 160);
  EXPECT_TRUE(is_red(at_point(image, place)));
  EXPECT_TRUE(is_white(at_point(image, place + Vec3{0.4, 0, 0})));
  EXPECT_TRUE(is_white(at_point(image, {-0.5, 0.3, 0})));
  const Blob ball = blob(image, [](const auto& c) { return !is_white(c); });
  const auto centre = project(view_from_above(), 200, 160, place);
  EXPECT_NEAR(ball.x, centre->x, 1.5);
  EXPECT_NEAR(ball.y, centre->y, 1.5);
}

TEST(DrawScreen, UnitsDoNotMatter) {
  // The same scene a thousand times larger and far off gives the same picture.
  Scene small = scene_from_above(), large = scene_from_above(4000);
  add(small, "sphere", "ball", red, {0.2, 0, 0});
  add(large, "sphere", "ball", red, {200, 0, 0}, 1000);
  const Image a = drawn(small), b = drawn(large);
  int differences = 0;
  for (std::size_t i = 0; i < a.rgb.size(); ++i) differences += std::abs(a.rgb[i] - b.rgb[i]) > 3 ? 1 : 0;
  EXPECT_LT(differences, static_cast<int>(a.rgb.size() / 500));
}

TEST(DrawScreen, BackgroundIsTheScreens) {
  Scene scene = scene_from_above();
  scene.screen.background = {0, 0, 0.5f};
  const auto expected = bytes_at(filled_image(1, 1, scene.screen.background), 0, 0);
  EXPECT_EQ(bytes_at(drawn(scene), 3, 3), expected);
  scene.screen.viewports.clear();
  EXPECT_EQ(bytes_at(drawn(scene), 100, 80), expected);
}

TEST(DrawScreen, InvisibleObjectsAreAbsent) {
  Scene scene = scene_from_above();
  const int id = add(scene, "sphere", "ball", red);
  scene.set_visible(id, false);
  EXPECT_EQ(blob(drawn(scene), [](const auto& c) { return !is_white(c); }).count, 0);
}

TEST(DrawScreen, OnlyTheWorldsObjectsAreDrawn) {
  Scene scene = scene_from_above();
  add(scene, "sphere", "ball", red);
  scene.worlds.push_back({"other", {"gone"}});
  scene.screen.viewports[0].world = "other";
  EXPECT_TRUE(is_white(bytes_at(drawn(scene), 100, 80)));
}

TEST(DrawScreen, SurfacesHideLines) {
  Scene scene = scene_from_above();
  add(scene, "grid.2.2", "sheet", {0.8f, 0.8f, 0.8f}, {0, 0, 0.3});
  add(scene, "wiregrid.9.9", "net", blue, {}, 2);
  const Image image = drawn(scene);
  int hidden = 0, seen = 0;
  for (int y = 0; y < image.height; ++y)
    for (int x = 0; x < image.width; ++x) {
      if (!is_blue(bytes_at(image, x, y))) continue;
      const auto corner = project(view_from_above(), 200, 160, {0.5, 0.5, 0.3});
      const bool under =
          std::abs(x + 0.5 - 100) < corner->x - 101 && std::abs(y + 0.5 - 80) < corner->x - 101;
      ++(under ? hidden : seen);
    }
  EXPECT_EQ(hidden, 0);
  EXPECT_GT(seen, 300);
}

TEST(DrawScreen, LinesHaveTheirThicknessAtTheTarget) {
  // A line across the whole picture: its area over its length is its width.
  for (const double pixels : {1.5, 4.0}) {
    Scene scene = scene_from_above();
    add(scene, "line", "line", {0, 0, 0}, {0.003, 0.011, 0}, 20);
    ScenePictureOptions options;
    options.line_pixels = pixels, options.samples = 64;
    const Image image = drawn(scene, options);
    double covered = 0;
    for (int y = 0; y < image.height; ++y)
      for (int x = 0; x < image.width; ++x) covered += 1 - static_cast<double>(linear_at(image, x, y).x);
    const double length = image.width;
    EXPECT_NEAR(covered / length, pixels, 0.15 * pixels);
  }
}

TEST(DrawScreen, AnObjectsLineWidthMultipliesThePictures) {
  const auto covered = [](double width) {
    Scene scene = scene_from_above();
    const int id = add(scene, "line", "line", {0, 0, 0}, {0.003, 0.011, 0}, 20);
    with_optics(scene, id, [&](Optics& o) { o.line_width = width; });
    const Image image = drawn(scene, {64, 2, 2});
    double sum = 0;
    for (int y = 0; y < image.height; ++y)
      for (int x = 0; x < image.width; ++x) sum += 1 - static_cast<double>(linear_at(image, x, y).x);
    return sum / image.width;
  };
  EXPECT_NEAR(covered(1), 2, 0.15 * 2);
  EXPECT_NEAR(covered(3), 6, 0.15 * 6);
  // A width that cannot be drawn is not taken.
  EXPECT_EQ(covered(0), covered(1));
  EXPECT_EQ(covered(nan), covered(1));
  EXPECT_EQ(covered(1e300), covered(1));
}

TEST(DrawScreen, WireStyleDrawsEdgesAlone) {
  Scene scene = scene_from_above();
  add(scene, "grid.3.3", "sheet", red);
  add(scene, "sphere", "ball", blue, {0, 0, -1}, 0.4);
  scene.screen.viewports[0].style = DrawStyle::wire;
  const Image image = drawn(scene);
  EXPECT_TRUE(is_white(at_point(image, {0.25, 0.25, 0})));  // inside a square
  EXPECT_TRUE(is_red(at_point(image, {0.25, 0, 0})) || is_red(at_point(image, {0.25, 0.01, 0})));
  EXPECT_GT(blob(image, is_blue).count, 20);  // seen through the sheet
}

TEST(DrawScreen, WiresLieOnTheirSurface) {
  for (const bool curved : {false, true}) {
    Scene scene = scene_from_above();
    const int id = add(scene, "cube", "cube", {0.8f, 0.8f, 0.8f});
    const auto count = [&] { return blob(drawn(scene), is_blue).count; };
    with_optics(scene, id, [&](Optics& o) { o.curved = curved; });
    EXPECT_EQ(count(), 0);
    with_optics(scene, id, [&](Optics& o) { o.wire = blue; });
    const int quads = count();
    EXPECT_GT(quads, 40) << curved;
    scene.set_triangulated(id, true);
    if (curved) {
      EXPECT_EQ(count(), quads);  // the edges of its own polygons still
    } else {
      EXPECT_GT(count(), quads + 10);  // diagonals
    }
  }
}

TEST(DrawScreen, CurvedObjectsAreRound) {
  Scene scene = scene_from_above();
  const int id = add(scene, "cube", "cube", red);
  const Vec3 corner{0.45, 0.45, 0.45};
  EXPECT_TRUE(is_red(at_point(drawn(scene), corner)));
  with_optics(scene, id, [](Optics& o) { o.curved = true; });
  const Image round = drawn(scene);
  EXPECT_TRUE(is_white(at_point(round, corner)));
  EXPECT_TRUE(is_red(at_point(round, {})));
}

TEST(DrawScreen, FacetsAreFlatAndSmoothSurfacesAreNot) {
  Scene scene = scene_from_above();
  const int id = add(scene, "sphere", "ball", {0.5f, 0.5f, 0.5f});
  const auto levels = [&] {
    std::array<bool, 256> seen{};
    const Image image = drawn(scene);
    for (int y = 40; y < 120; ++y)
      for (int x = 60; x < 140; ++x) seen[static_cast<std::size_t>(bytes_at(image, x, y)[1])] = true;
    // Equal neighbours: inside a facet light changes little.
    int equal = 0;
    for (int y = 60; y < 100; ++y)
      for (int x = 80; x < 120; ++x)
        equal += std::abs(bytes_at(image, x, y)[1] - bytes_at(image, x + 1, y)[1]) <= 0 ? 1 : 0;
    return equal;
  };
  with_optics(scene, id, [](Optics& o) { o.highlight = {0, 0, 0}; });
  const int smooth = levels();
  with_optics(scene, id, [](Optics& o) { o.shading = Shading::faceted; });
  EXPECT_GT(levels(), smooth + 50);
}

TEST(DrawScreen, HighlightsHaveTheirColour) {
  Scene scene = scene_from_above();
  const int id = add(scene, "sphere", "ball", {0.02f, 0.02f, 0.02f});
  with_optics(scene, id, [](Optics& o) { o.highlight = blue, o.specular = 10; });
  EXPECT_GT(blob(drawn(scene), is_blue).count, 50);
  with_optics(scene, id, [](Optics& o) { o.highlight = {0, 0, 0}; });
  EXPECT_EQ(blob(drawn(scene), is_blue).count, 0);
}

TEST(DrawScreen, LampsReplaceTheStudio) {
  Scene scene = scene_from_above();
  add(scene, "sphere", "ball", {0.8f, 0.8f, 0.8f});
  Object lamp;
  lamp.name = "lamp";
  lamp.description = Light{{1, 0.05f, 0.05f}, 1.0};
  lamp.transform.linear = rotation_xyz({0, 90, 0});  // −z turned to −x: shines from the right
  const auto id = scene.add_object(lamp);
  ASSERT_TRUE(id);
  const Image image = drawn(scene);
  const Vec3f lit = linear_at(image, 110, 80), dark = linear_at(image, 90, 80);
  EXPECT_GT(lit.x, dark.x);
  EXPECT_GT(lit.x, 2 * lit.z);
  scene.set_visible(*id, false);
  const Vec3f white = linear_at(drawn(scene), 100, 80);
  EXPECT_NEAR(white.x, white.z, 0.02);
}

TEST(DrawScreen, SurfacesShadeTheFloor) {
  Scene scene = scene_from_above();
  Object lamp;
  lamp.name = "lamp";
  lamp.description = Light{};  // straight down
  ASSERT_TRUE(scene.add_object(lamp));
  add(scene, "grid.2.2", "floor", {0.8f, 0.8f, 0.8f}, {0, 0, -1}, 10);
  // A slanting lamp throws the ball's shadow beside it.
  scene.set_transform(scene.id_of("lamp"), {rotation_xyz({0, 45, 0}), {}, {}});
  add(scene, "sphere", "ball", red, {0, 0, -0.4}, 0.6);
  const Image image = drawn(scene);
  const Vec3 shadow{-0.6, 0, -1};
  EXPECT_LT(at_point(image, shadow)[1], at_point(image, -shadow + Vec3{0, 0, -2})[1] - 30);
}

TEST(DrawScreen, LinesCastNoShadow) {
  Scene scene = scene_from_above();
  add(scene, "grid.2.2", "floor", {0.8f, 0.8f, 0.8f}, {0, 0, -0.5}, 10);
  const Image bare = drawn(scene);
  add(scene, "wiregrid.4.4", "net", blue);
  const Image image = drawn(scene);
  for (int y = 0; y < image.height; ++y)
    for (int x = 0; x < image.width; ++x)
      if (bytes_at(image, x, y) != bytes_at(bare, x, y)) {
        const auto c = bytes_at(image, x, y);
        ASSERT_GT(c[2], c[0]) << x << ' ' << y;  // only ever bluer, never a grey shadow
      }
}

TEST(DrawScreen, StereoChannelsMeetAtTheTarget) {
  // Where each eye sees a small sheet at a height above the target.
  const auto shift = [&](double height) {
    Scene s = scene_from_above();
    s.screen.viewports[0].stereo = true;
    s.screen.viewports[0].eye_separation = 0.1;
    s.screen.background = {0, 0, 0};
    add(s, "grid.2.2", "sheet", {0.9f, 0.9f, 0.9f}, {0, 0, height}, 0.3);
    const Image image = drawn(s);
    const Blob left = blob(image, [](const auto& c) { return c[0] > 128; });
    const Blob right = blob(image, [](const auto& c) { return c[1] > 128; });
    EXPECT_GT(left.count, 100);
    EXPECT_EQ(blob(image, [](const auto& c) { return c[2] > 0; }).count, 0);
    EXPECT_NEAR(left.y, right.y, 0.1);
    return left.x - right.x;
  };
  EXPECT_NEAR(shift(0), 0, 0.05);  // rays at edges are spread by the pixel
  EXPECT_GT(shift(1), 1);          // nearer: crossed
  EXPECT_LT(shift(-1), -1);        // farther: uncrossed
  // By similar triangles, in pixels: separation (1/depth − 1/distance) focal length.
  const double focal = 160 / (2 * std::tan(radians(35) / 2));
  EXPECT_NEAR(shift(1), 0.4 * (1 / 3.0 - 1 / 4.0) * focal, 1);
}

TEST(DrawScreen, StereoWithoutPerspectiveTurnsAboutTheTarget) {
  const auto shift = [&](double height) {
    Scene s = scene_from_above();
    s.set_description(s.id_of("camera"), CameraLens{0, 3, 4});
    s.screen.viewports[0].stereo = true;
    s.screen.background = {0, 0, 0};
    add(s, "grid.2.2", "sheet", {0.9f, 0.9f, 0.9f}, {0, 0, height}, 0.3);
    const Image image = drawn(s);
    return blob(image, [](const auto& c) { return c[0] > 128; }).x -
           blob(image, [](const auto& c) { return c[1] > 128; }).x;
  };
  EXPECT_NEAR(shift(0), 0, 0.05);
  EXPECT_GT(shift(1), 1);
  EXPECT_LT(shift(-1), -1);
}

TEST(DrawScreen, LaterViewportsCoverEarlierOnes) {
  Scene scene = scene_from_above();
  scene.screen.background = {1, 1, 1};
  add(scene, "grid.2.2", "sheet", red, {}, 10);
  scene.worlds.push_back({"blue", {}});
  scene.current_world = "blue";
  add(scene, "grid.2.2", "blue_sheet", blue, {}, 10);
  Viewport second = scene.screen.viewports[0];
  second.name = "second", second.world = "blue";
  second.left = 0.5, second.bottom = 0.5, second.right = 0.9, second.top = 0.9;
  scene.screen.viewports.push_back(second);
  Image image = drawn(scene);
  EXPECT_TRUE(is_blue(bytes_at(image, 140, 40)));
  EXPECT_TRUE(is_red(bytes_at(image, 95, 40)));    // left of it
  EXPECT_TRUE(is_red(bytes_at(image, 140, 100)));  // below: the rectangle counts from the lower left
  EXPECT_TRUE(is_red(bytes_at(image, 190, 5)));
  std::swap(scene.screen.viewports[0], scene.screen.viewports[1]);
  EXPECT_TRUE(is_red(bytes_at(drawn(scene), 140, 40)));
  scene.screen.viewports[1].visible = false;
  image = drawn(scene);
  EXPECT_TRUE(is_blue(bytes_at(image, 140, 40)));
  EXPECT_TRUE(is_white(bytes_at(image, 20, 20)));
}

TEST(DrawScreen, TitlesAndBordersFrameAViewport) {
  Scene scene = scene_from_above();
  Viewport& viewport = scene.screen.viewports[0];
  viewport.left = 0.25, viewport.right = 0.75, viewport.bottom = 0.25, viewport.top = 0.75;
  const auto dark = [](const Image& image, int x, int y) { return bytes_at(image, x, y)[1] < 140; };
  EXPECT_EQ(blob(drawn(scene), [](const auto& c) { return !is_white(c); }).count, 0);
  viewport.border = true;
  Image image = drawn(scene);
  EXPECT_TRUE(dark(image, 50, 80) && dark(image, 149, 80) && dark(image, 100, 40) && dark(image, 100, 119));
  EXPECT_TRUE(is_white(bytes_at(image, 100, 44)));
  viewport.border = false, viewport.title = true;
  viewport.name = "a name that is far too long to fit into the bar of so small a viewport";
  image = drawn(scene);
  EXPECT_TRUE(dark(image, 60, 41));
  EXPECT_TRUE(is_white(bytes_at(image, 49, 45)) && is_white(bytes_at(image, 152, 45)));
  EXPECT_TRUE(is_white(bytes_at(image, 100, 100)));
}

TEST(DrawScreen, TheSameBitsForAnyNumberOfThreads) {
  Scene scene;
  scene.screen.width = 240, scene.screen.height = 180;
  ASSERT_TRUE(add_draped_scene(scene, 13, 2));
  with_optics(scene, scene.id_of("skin"), [](Optics& o) { o.opacity = 0.6, o.wire = red; });
  scene.screen.viewports[0].stereo = true;
  set_thread_count(1);
  const Image one = drawn(scene);
  set_thread_count(2);
  const Image two = drawn(scene);
  set_thread_count(0);
  EXPECT_EQ(one.rgb, two.rgb);
}

TEST(DrawScreen, MissingCamerasAndWorldsAreErrors) {
  Scene scene = scene_from_above();
  add(scene, "sphere", "ball", red);
  scene.screen.viewports[0].camera = "nobody";
  expect_error(scene, "nobody");
  scene.screen.viewports[0].camera = "ball";
  expect_error(scene, "not a camera");
  scene.screen.viewports[0].camera = "camera", scene.screen.viewports[0].world = "nowhere";
  expect_error(scene, "nowhere");
  scene.screen.viewports[0].visible = false;
  drawn(scene);
}

TEST(DrawScreen, WildSizesAreErrorsOrEmpty) {
  const auto with_ball = [] {
    Scene scene = scene_from_above();
    add(scene, "sphere", "ball", red);
    return scene;
  };
  for (const auto& [width, height] :
       {std::pair{0, 10}, {10, -1}, {2'000'000'000, 2'000'000'000}, {16384, 16384}}) {
    Scene s = with_ball();
    s.screen.width = width, s.screen.height = height;
    expect_error(s, "pixels");
  }
  for (const double right : {0.3, 0.2, -5.0}) {  // no pixels at all
    Scene s = with_ball();
    s.screen.viewports[0].left = 0.3, s.screen.viewports[0].right = right;
    EXPECT_EQ(blob(drawn(s), [](const auto& c) { return !is_white(c); }).count, 0);
  }
  Scene s = with_ball();
  s.screen.viewports[0].right = nan;
  expect_error(s, "main");
  s.screen.viewports[0].right = 1e308;
  expect_error(s, "pixels");
  s = with_ball();  // partly outside
  s.screen.viewports[0].left = -0.5, s.screen.viewports[0].top = 1.5;
  drawn(s);
  Scene scene = with_ball();
  ScenePictureOptions options;
  for (const double line : {0.0, -1.0, nan, 1e300}) {
    options.line_pixels = line;
    expect_error(scene, "thick", options);
  }
  options = {};
  options.samples = 0;
  expect_error(scene, "samples", options);
  options = {};
  with_optics(scene, scene.id_of("ball"), [](Optics& o) { o.curved = true; });
  for (const int levels : {-1, 1'000'000}) {  // refines as far as it is of use
    options.curved_levels = levels;
    EXPECT_TRUE(is_red(bytes_at(drawn(scene, options), 100, 80)));
  }
}

TEST(DrawScreen, WildCamerasAreErrors) {
  const auto camera = [&](const CameraLens& lens) {
    Scene s = scene_from_above();
    Object object;
    object.name = "wild", object.description = lens;
    if (!s.add_object(object)) return;  // not let in at all
    s.screen.viewports[0].camera = "wild";
    expect_error(s, "wild");
  };
  camera({nan, 1, 1});
  camera({180, 1, 1});
  camera({-5, 1, 1});
  camera({0, 0, 1});
  camera({0, nan, 1});
  camera({35, 1, 0});
  camera({35, 1, -1});
  camera({35, 1, nan});
  Scene flat = scene_from_above();
  flat.set_transform(flat.id_of("camera"), {Mat3{{Vec3{}, Vec3{}, Vec3{}}}, {}, {}});
  expect_error(flat, "camera");
}

TEST(DrawScreen, WildObjectsAreErrors) {
  const auto wild = [](auto&& change, const std::string& word) {
    Scene scene = scene_from_above();
    Object object = primitive("sphere", "wild");
    change(object);
    ASSERT_TRUE(scene.add_object(object)) << word;
    expect_error(scene, word);
  };
  wild([](Object& o) { o.transform.translation.x = 1e300; }, "wild");
  wild([](Object& o) { o.transform.translation.x = 1e308, o.transform.origin.x = 1e308; }, "wild");
  wild([](Object& o) { o.transform.linear.c[0].x = 1e308; }, "wild");
  wild([](Object& o) { o.description = Light{}, o.transform.linear = {{Vec3{}, Vec3{}, Vec3{}}}; }, "light");
  Scene scene = scene_from_above();  // an object squashed to a point is nothing to see
  const int id = add(scene, "sphere", "point", red);
  scene.set_transform(id, {Mat3{{Vec3{}, Vec3{}, Vec3{}}}, {}, {}});
  drawn(scene);
  with_optics(scene, id, [](Optics& o) { o.wire = red, o.curved = true; });
  drawn(scene);
}

TEST(DrawScreen, DepthMapsAreSurfaces) {
  Scene scene = scene_from_above();
  Object map;
  map.name = "map";
  map.description = DepthMap{3, 3, {0, 0, 0, 0, 1, 0, 0, 0, 0}};
  map.transform.translation = {-1, -1, 0};
  map.transform.linear = {{Vec3{1, 0, 0}, Vec3{0, 1, 0}, Vec3{0, 0, 0.3}}};
  map.optics.diffuse = red;
  ASSERT_TRUE(scene.add_object(map));
  EXPECT_TRUE(is_red(bytes_at(drawn(scene), 100, 80)));
}

TEST(DrawScreen, StopsWhenCancelled) {
  Scene scene;
  ASSERT_TRUE(add_draped_scene(scene, 9, 1));
  Context context({}, {}, [] { return true; });
  const auto image = draw_screen(scene, {}, context);
  ASSERT_FALSE(image);
  EXPECT_EQ(image.error().kind, ErrorKind::cancelled);
}

}  // namespace
}  // namespace turgor::render_tests
