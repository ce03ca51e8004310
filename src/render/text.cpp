#include <algorithm>
#include <cmath>

#include "render/canvas.hpp"
#include "render/stroke_font.hpp"
#include "turgor/render/annotate.hpp"

namespace turgor {

using namespace render_detail;

namespace {

constexpr int largest_size = 1000;

double pen_width(int size) {
  return std::max(1.1, static_cast<double>(pen_units) * size / em_units);
}

std::vector<Capsule> lay_out(int x, int y, int size, const std::string& text) {
  std::vector<Capsule> out;
  const double unit = size / static_cast<double>(em_units);
  const double base = y + size - static_cast<double>(baseline_units) * unit;
  double left = x + static_cast<double>(gap_units) / 2 * unit;
  for (const char32_t letter : decode_utf8(text)) {
    const Glyph& g = glyph(letter);
    for (const Stroke& s : g.strokes)
      out.push_back({left + static_cast<double>(s.x0) * unit, base - static_cast<double>(s.y0) * unit,
                     left + static_cast<double>(s.x1) * unit, base - static_cast<double>(s.y1) * unit});
    left += static_cast<double>(g.width + gap_units) * unit;
  }
  return out;
}

}  // namespace

int text_width(std::string_view text, int size) {
  double units = 0;
  for (const char32_t letter : decode_utf8(text))
    units += static_cast<double>(glyph(letter).width + gap_units);
  return static_cast<int>(
      std::ceil(units * std::clamp(size, 0, largest_size) / static_cast<double>(em_units)));
}

void draw_text(Image& image, int x, int y, int size, const std::string& text, const Vec3f& colour) {
  size = std::clamp(size, 0, largest_size);
  if (size == 0) return;
  const PixelRect clip{x, y, x + text_width(text, size), y + size};
  draw_capsules(image, lay_out(x, y, size, text), pen_width(size) / 2, 1, clip, colour, 1);
}

void draw_text_with_halo(Image& image, int x, int y, int size, const std::string& text, const Vec3f& colour,
                         const Vec3f& halo) {
  size = std::clamp(size, 0, largest_size);
  if (size == 0) return;
  const PixelRect clip{x - 3, y - 3, x + text_width(text, size) + 3, y + size + 3};
  draw_capsules(image, lay_out(x, y, size, text), pen_width(size) / 2 + 1.5, 2.5, clip, halo, 0.9);
  draw_text(image, x, y, size, text, colour);
}

}  // namespace turgor
