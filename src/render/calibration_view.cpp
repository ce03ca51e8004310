#include "render/calibration_view.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace turgor::render_detail {

CameraView camera_about(std::span<const Vec3> points, const Vec3& to_viewer, int width, int height) {
  constexpr double kRoom = 1.12;
  CameraView camera;
  const Vec3 direction = to_viewer / length(to_viewer);
  if (std::abs(direction.z) > 0.95) camera.up = {0, 1, 0};
  camera.eye = direction;
  const auto frame = camera_frame(camera);
  if (!frame) return camera;
  Box3 box;  // along the picture's right, up and depth
  for (const Vec3& p : points) box.extend({dot(p, frame->right), dot(p, frame->up), dot(p, frame->forward)});
  const Vec3 middle = box.centre(), size = box.size();
  camera.target = frame->right * middle.x + frame->up * middle.y + frame->forward * middle.z;
  camera.eye = camera.target + direction * (length(size) + 1);
  camera.height_mm = kRoom * std::max({size.y, size.x * height / width, std::numeric_limits<double>::min()});
  return camera;
}

int letters(const Image& panel) {
  return std::clamp(panel.height / 24, 12, 40);
}

Image captioned(const Image& image, const std::string& caption) {
  const int size = letters(image);
  Image out = filled_image(image.width, image.height + 2 * size, {1, 1, 1});
  paste(out, image, 0, 0);
  draw_text(out, (image.width - text_width(caption, size)) / 2, image.height + size / 3, size, caption);
  return out;
}

Image with_legend(const Image& image, double low, double high, const std::string& title, ColourMap map,
                  int size) {
  const int strip = std::max(10 * size, text_width(title, size) + 2 * size);
  Image out = filled_image(image.width + strip, image.height, {1, 1, 1});
  paste(out, image, 0, 0);
  draw_legend(out, low, high, title, map, size);
  return out;
}

void draw_arrow(Image& image, const CameraView& camera, const Vec3& tip, const Vec3& along, double length_mm,
                const Vec3f& colour) {
  const double size = length(along);
  if (!(size > 0)) return;
  const auto head = project(camera, image.width, image.height, tip),
             tail = project(camera, image.width, image.height, tip - along * (length_mm / size));
  if (!head || !tail) return;
  const double width = std::max(2.0, image.height / 180.0), dx = head->x - tail->x, dy = head->y - tail->y;
  const double long_px = std::hypot(dx, dy);
  if (long_px < 2 * width) {  // along the line of sight
    draw_disc(image, head->x, head->y, 1.6 * width, colour);
    return;
  }
  draw_segment(image, tail->x, tail->y, head->x, head->y, width, colour);
  const double barb = std::min(0.4 * long_px, 5 * width);
  for (const double side : {-0.5, 0.5}) {
    const double bx = -dx / long_px + side * dy / long_px, by = -dy / long_px - side * dx / long_px;
    draw_segment(image, head->x, head->y, head->x + barb * bx, head->y + barb * by, width, colour);
  }
}

double round_up(double greatest) {
  if (!(greatest > 0) || !std::isfinite(greatest)) return 1;
  const double power = std::pow(10.0, std::floor(std::log10(greatest)));
  for (const double lead : {1.0, 1.5, 2.0, 3.0, 4.0, 5.0, 6.0, 8.0})
    if (greatest <= lead * power * (1 + 1e-9)) return lead * power;
  return 10 * power;
}

}  // namespace turgor::render_detail
