#include "render/canvas.hpp"

#include <array>
#include <cmath>

namespace turgor::render_detail {
namespace {

bool usable(const Image& image) {
  return image.width > 0 && image.height > 0 &&
         image.rgb.size() ==
             3 * static_cast<std::size_t>(image.width) * static_cast<std::size_t>(image.height);
}

std::array<std::uint8_t, 3> bytes_of(const Vec3f& c) {
  return {encode_srgb(c.x), encode_srgb(c.y), encode_srgb(c.z)};
}

/// Mixes in sRGB values, as type is commonly set: thin dark strokes keep their weight on light ground.
void blend(Image& image, int x, int y, const std::array<std::uint8_t, 3>& colour, float alpha) {
  const std::size_t at =
      3 * (static_cast<std::size_t>(y) * static_cast<std::size_t>(image.width) + static_cast<std::size_t>(x));
  for (std::size_t k = 0; k < 3; ++k) {
    const float under = image.rgb[at + k];
    image.rgb[at + k] =
        static_cast<std::uint8_t>(std::lround(under + (static_cast<float>(colour[k]) - under) * alpha));
  }
}

double distance_to(const Capsule& c, double x, double y) {
  const double dx = c.x1 - c.x0, dy = c.y1 - c.y0, square = dx * dx + dy * dy;
  const double t = square > 0 ? std::clamp(((x - c.x0) * dx + (y - c.y0) * dy) / square, 0.0, 1.0) : 0.0;
  return std::hypot(x - c.x0 - t * dx, y - c.y0 - t * dy);
}

}  // namespace

void draw_capsules(Image& image, const std::vector<Capsule>& capsules, double radius, double softness,
                   const PixelRect& clip, const Vec3f& colour, double opacity) {
  if (!usable(image) || !is_finite(colour)) return;
  const PixelRect area = clip.clipped_to(image);
  if (area.x0 >= area.x1 || area.y0 >= area.y1) return;
  const auto width = static_cast<std::size_t>(area.x1 - area.x0);
  std::vector<float> coverage(width * static_cast<std::size_t>(area.y1 - area.y0));
  const double reach = radius + softness / 2 + 1;
  for (const Capsule& c : capsules) {
    if (!std::isfinite(c.x0 + c.y0 + c.x1 + c.y1)) continue;
    const auto within = [](double v, int low, int high) {
      return static_cast<int>(std::clamp(v, static_cast<double>(low), static_cast<double>(high)));
    };
    const int x0 = within(std::floor(std::min(c.x0, c.x1) - reach), area.x0, area.x1);
    const int x1 = within(std::ceil(std::max(c.x0, c.x1) + reach), area.x0, area.x1);
    const int y0 = within(std::floor(std::min(c.y0, c.y1) - reach), area.y0, area.y1);
    const int y1 = within(std::ceil(std::max(c.y0, c.y1) + reach), area.y0, area.y1);
    for (int y = y0; y < y1; ++y)
      for (int x = x0; x < x1; ++x) {
        const double d = distance_to(c, x + 0.5, y + 0.5);
        const auto covered = static_cast<float>(std::clamp(0.5 + (radius - d) / softness, 0.0, 1.0));
        float& kept =
            coverage[static_cast<std::size_t>(y - area.y0) * width + static_cast<std::size_t>(x - area.x0)];
        kept = std::max(kept, covered);
      }
  }
  const auto bytes = bytes_of(colour);
  const float strength = static_cast<float>(std::clamp(opacity, 0.0, 1.0));
  for (int y = area.y0; y < area.y1; ++y)
    for (int x = area.x0; x < area.x1; ++x) {
      const float a =
          coverage[static_cast<std::size_t>(y - area.y0) * width + static_cast<std::size_t>(x - area.x0)] *
          strength;
      if (a > 0) blend(image, x, y, bytes, a);
    }
}

void fill_rect(Image& image, const PixelRect& rect, const Vec3f& colour, double opacity) {
  if (!usable(image) || !is_finite(colour)) return;
  const PixelRect area = rect.clipped_to(image);
  const auto bytes = bytes_of(colour);
  for (int y = area.y0; y < area.y1; ++y)
    for (int x = area.x0; x < area.x1; ++x)
      blend(image, x, y, bytes, static_cast<float>(std::clamp(opacity, 0.0, 1.0)));
}

}  // namespace turgor::render_detail
