#include <algorithm>
#include <cmath>
#include <string>

#include <fmt/format.h>

#include "render/canvas.hpp"
#include "render/scale.hpp"
#include "turgor/render/annotate.hpp"

namespace turgor {

using namespace render_detail;

namespace {

struct Tick {
  double value;
  std::string label;
};

std::vector<Tick> ticks_between(double lowest, double highest) {
  std::vector<Tick> ticks;
  if (!(std::isfinite(lowest) && std::isfinite(highest))) return ticks;
  const double range = highest - lowest;
  if (!(range > 1e-12 * std::max(std::abs(lowest), std::abs(highest)))) {
    ticks.push_back({lowest, fmt::format("{:.4g}", lowest)});
    return ticks;
  }
  const double step = round_step(range, 5);
  const int decimals = decimals_of(step);
  for (double k = std::ceil(lowest / step - 1e-6); k * step <= highest + 1e-6 * step; ++k)
    ticks.push_back({k * step, number(k * step, decimals)});
  // The ends are what a reader looks for first; a round tick too close to one gives way.
  for (const double end : {lowest, highest}) {
    std::erase_if(ticks, [&](const Tick& t) { return std::abs(t.value - end) < 0.3 * step; });
    const bool round = std::abs(end / step - std::round(end / step)) < 1e-6;
    ticks.push_back({end, number(end, round ? decimals : decimals_of(step / 10))});
  }
  return ticks;
}

}  // namespace

PixelBox draw_legend(Image& image, double lowest, double highest, const std::string& title) {
  return draw_legend(image, lowest, highest, title, colour_map);
}

PixelBox draw_legend(Image& image, double lowest, double highest, const std::string& title, ColourMap map,
                     int size) {
  if (size <= 0) size = std::clamp(image.height / 48, 12, 40);
  const int margin = size;
  const std::vector<Tick> ticks = ticks_between(lowest, highest);
  int labels = 0;
  for (const Tick& t : ticks) labels = std::max(labels, text_width(t.label, size));
  PixelBox bar;
  bar.width = size;
  bar.height = std::max(1, image.height / 2);
  bar.y = (image.height - bar.height) / 2;
  bar.x = std::max(0, image.width - margin - labels - size / 2 - bar.width);
  fill_rect(image, {bar.x - 1, bar.y - 1, bar.x + bar.width + 1, bar.y + bar.height + 1}, {0.1f, 0.1f, 0.1f});
  for (int row = 0; row < bar.height; ++row) {
    const double t = bar.height > 1 ? 1 - static_cast<double>(row) / (bar.height - 1) : 0.5;
    fill_rect(image, {bar.x, bar.y + row, bar.x + bar.width, bar.y + row + 1}, map(t));
  }
  for (const Tick& t : ticks) {
    const double range = highest - lowest, share = range > 0 ? (t.value - lowest) / range : 0.5;
    const double y = bar.y + 0.5 + (1 - share) * (bar.height - 1);
    draw_segment(image, bar.x + bar.width + 1, y, bar.x + bar.width + size / 4.0, y, 1.2, {0.1f, 0.1f, 0.1f});
    draw_text_with_halo(image, bar.x + bar.width + size / 2, static_cast<int>(std::lround(y - 0.407 * size)),
                        size, t.label, {0, 0, 0});
  }
  const int wide = text_width(title, size);
  draw_text_with_halo(image, std::max(2, image.width - margin - wide), bar.y - 2 * size, size, title,
                      {0, 0, 0});
  return bar;
}

void draw_scale_bar(Image& image, const CameraView& camera, int size) {
  const auto frame = camera_frame(camera);
  if (!frame || image.width < 40 || image.height < 40) return;
  const double mm = frame->pixel_mm(frame->target_distance, image.height);
  const double length_mm = round_step(mm * image.width / 5, 1);
  if (size <= 0) size = std::clamp(image.height / 48, 12, 40);
  const int margin = size;
  const double x0 = margin + 1, x1 = x0 + length_mm / mm, y = image.height - margin - 0.5 * size;
  const Vec3f ink{0, 0, 0};
  const std::vector<Capsule> bar{
      {x0, y, x1, y}, {x0, y - 0.3 * size, x0, y + 0.3 * size}, {x1, y - 0.3 * size, x1, y + 0.3 * size}};
  const PixelRect all{0, 0, image.width, image.height};
  draw_capsules(image, bar, 2.5, 2, all, {1, 1, 1}, 0.9);
  draw_capsules(image, bar, 0.9, 1, all, ink, 1);
  draw_text_with_halo(image, margin, static_cast<int>(y - 1.5 * size), size,
                      number(length_mm, decimals_of(length_mm)) + " mm", ink);
}

}  // namespace turgor
