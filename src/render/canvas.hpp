// Anti-aliased round strokes onto an image.
#pragma once

#include <algorithm>
#include <vector>

#include "turgor/render/image.hpp"

namespace turgor::render_detail {

/// A line with round ends, in pixels.
struct Capsule {
  double x0, y0, x1, y1;
};

struct PixelRect {
  int x0 = 0, y0 = 0, x1 = 0, y1 = 0;  ///< half-open

  [[nodiscard]] PixelRect clipped_to(const Image& image) const {
    return {std::max(x0, 0), std::max(y0, 0), std::min(x1, image.width), std::min(y1, image.height)};
  }
};

/// Draws the union of the capsules, each `radius` thick on either side of its line, with an edge `softness`
/// pixels wide, within `clip`. Overlapping capsules do not add up.
void draw_capsules(Image& image, const std::vector<Capsule>& capsules, double radius, double softness,
                   const PixelRect& clip, const Vec3f& colour, double opacity);
void fill_rect(Image& image, const PixelRect& rect, const Vec3f& colour, double opacity = 1);

}  // namespace turgor::render_detail
