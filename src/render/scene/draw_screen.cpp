#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "render/canvas.hpp"
#include "render/scene/view_scene.hpp"
#include "turgor/render/annotate.hpp"

namespace turgor {

using namespace render_detail;

namespace {

constexpr Vec3f bar_colour{0.045f, 0.05f, 0.06f}, bar_ink{0.9f, 0.9f, 0.9f}, border_colour{0.2f, 0.2f, 0.21f};
constexpr int largest_side = 16384;
/// The fewest with which the edges of soft shadows do not break up.
constexpr int light_rays = 4;

Error bad(std::string what, std::string where, std::string remedy) {
  return {ErrorKind::bad_input, std::move(what), std::move(where), std::move(remedy)};
}

Result<void> check(const Screen& screen, const ScenePictureOptions& options) {
  if (screen.width < 1 || screen.height < 1 || screen.width > largest_side || screen.height > largest_side)
    return bad("a screen of " + std::to_string(screen.width) + " by " + std::to_string(screen.height) +
                   " pixels cannot be drawn",
               "screen", "Use sides from 1 to 16384");
  if (!is_finite(screen.background))
    return bad("the background is not a finite colour", "screen", "Give RGB");
  if (!(options.line_pixels > 0 && options.line_pixels <= 1000))
    return bad("the lines' thickness is not above 0 and at most 1000 pixels", "picture options", "Use 1.5");
  return {};
}

/// The viewport's pixels, which may reach beyond the screen.
Result<PixelRect> pixels_of(const Viewport& viewport, const Screen& screen) {
  const auto pixel = [](double fraction, int side) {
    return static_cast<int>(std::lround(std::clamp(fraction, -100.0, 100.0) * side));
  };
  for (const double v : {viewport.left, viewport.bottom, viewport.right, viewport.top})
    if (!std::isfinite(v))
      return bad("a side is not a finite number", "viewport '" + viewport.name + "'",
                 "Give fractions of the screen from 0 to 1");
  return PixelRect{pixel(viewport.left, screen.width), pixel(1 - viewport.top, screen.height),
                   pixel(viewport.right, screen.width), pixel(1 - viewport.bottom, screen.height)};
}

int bar_height(const Viewport& viewport, const PixelRect& rect) {
  return viewport.title ? std::min(std::clamp((rect.y1 - rect.y0) / 18, 16, 32), rect.y1 - rect.y0) : 0;
}

/// The picture of the left eye in red, that of the right one in green.
Image anaglyph(const Image& left, const Image& right, int shift, int width) {
  Image out = filled_image(width, left.height, {});
  const auto light = [](const Image& image, int x, int y) {
    const std::size_t at = 3 * (static_cast<std::size_t>(y) * static_cast<std::size_t>(image.width) +
                                static_cast<std::size_t>(x));
    const std::uint8_t* c = &image.rgb[at];
    return encode_srgb(luminance({decode_srgb(c[0]), decode_srgb(c[1]), decode_srgb(c[2])}));
  };
  for (int y = 0; y < out.height; ++y)
    for (int x = 0; x < width; ++x) {
      const std::size_t at =
          3 * (static_cast<std::size_t>(y) * static_cast<std::size_t>(width) + static_cast<std::size_t>(x));
      out.rgb[at] = light(left, x + 2 * shift, y);
      out.rgb[at + 1] = light(right, x, y);
    }
  return out;
}

/// One eye's picture after the other from the same scene. The eyes look in parallel, and their pictures are
/// slid over one another until the target's plane coincides: unlike eyes that turn to the target, they see
/// no point at different heights. They are parted by a whole number of pixels, so that the fit is exact.
Result<Image> stereo_picture(const Renderer& renderer, const CameraView& camera, double separation,
                             const RenderOptions& options, Context& context) {
  TURGOR_TRY(const CameraFrame frame, camera_frame(camera));
  const double pixel = frame.pixel_mm(frame.target_distance, options.height);
  const double half = 0.5 * separation * frame.target_distance / pixel;
  if (camera.fov_deg == 0) {  // parallel rays: each eye turns about the target
    const auto eye = [&](double side) {
      CameraView view = camera;
      view.eye += frame.right * (side * 0.5 * separation * frame.target_distance);
      return renderer.render(view, options, context);
    };
    TURGOR_TRY(const Image left, eye(-1));
    TURGOR_TRY(const Image right, eye(1));
    return anaglyph(left, right, 0, options.width);
  }
  const int shift = static_cast<int>(std::lround(std::min(half, 1.0 * largest_side)));
  RenderOptions wide = options;
  wide.width += 2 * shift;
  const auto eye = [&](int side) {
    CameraView view = camera;
    const Vec3 aside = frame.right * (side * shift * pixel);
    view.eye += aside, view.target += aside;
    return renderer.render(view, wide, context);
  };
  TURGOR_TRY(const Image left, eye(-1));
  TURGOR_TRY(const Image right, eye(1));
  return anaglyph(left, right, shift, options.width);
}

Result<Image> view_picture(const Scene& scene, const Viewport& viewport, int width, int height,
                           const ScenePictureOptions& options, Context& context) {
  TURGOR_TRY(const ViewScene view, view_scene(scene, viewport, height, options));
  RenderOptions render_options;
  render_options.width = width, render_options.height = height;
  render_options.samples = options.samples;
  render_options.light_rays = light_rays;
  render_options.background = scene.screen.background;
  render_options.lights = view.lights;
  TURGOR_TRY(const Renderer renderer, Renderer::create(view.bodies, context));
  if (!viewport.stereo) return renderer.render(view.camera, render_options, context);
  if (!(viewport.eye_separation >= 0 && viewport.eye_separation <= 1))
    return bad("the eyes' separation is not in [0, 1]", "viewport '" + viewport.name + "'",
               "Give it as a fraction of the distance to the target: 0.03");
  return stereo_picture(renderer, view.camera, viewport.eye_separation, render_options, context);
}

void draw_title(Image& image, const Viewport& viewport, const PixelRect& rect, int bar) {
  if (bar == 0) return;
  fill_rect(image, {rect.x0, rect.y0, rect.x1, rect.y0 + bar}, bar_colour);
  const int size = bar * 7 / 10;
  Image strip = filled_image(rect.x1 - rect.x0, bar, bar_colour);  // cuts off long names
  draw_text(strip, size / 2, (bar - size) / 2 + 1, size, viewport.name, bar_ink);
  paste(image, strip, rect.x0, rect.y0);
}

void draw_border(Image& image, const PixelRect& r) {
  fill_rect(image, {r.x0, r.y0, r.x1, r.y0 + 1}, border_colour);
  fill_rect(image, {r.x0, r.y1 - 1, r.x1, r.y1}, border_colour);
  fill_rect(image, {r.x0, r.y0, r.x0 + 1, r.y1}, border_colour);
  fill_rect(image, {r.x1 - 1, r.y0, r.x1, r.y1}, border_colour);
}

}  // namespace

Result<Image> draw_screen(const Scene& scene, const ScenePictureOptions& options, Context& context) {
  const Screen& screen = scene.screen;
  TURGOR_CHECK(check(screen, options));
  Image image = filled_image(screen.width, screen.height, screen.background);
  for (const Viewport& viewport : screen.viewports) {
    if (!viewport.visible) continue;
    TURGOR_TRY(const PixelRect rect, pixels_of(viewport, screen));
    if (rect.x0 >= rect.x1 || rect.y0 >= rect.y1) continue;
    const int bar = bar_height(viewport, rect);
    if (const int height = rect.y1 - rect.y0 - bar; height > 0) {
      TURGOR_TRY(const Image picture,
                 view_picture(scene, viewport, rect.x1 - rect.x0, height, options, context));
      paste(image, picture, rect.x0, rect.y0 + bar);
    }
    draw_title(image, viewport, rect, bar);
    if (viewport.border) draw_border(image, rect);
  }
  return image;
}

}  // namespace turgor
