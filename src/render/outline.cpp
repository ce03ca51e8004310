// The outline of a body drawn as a line.
#include <algorithm>
#include <array>
#include <cmath>

#include "render/resolve.hpp"

namespace turgor::render_detail {
namespace {

/// A step of the surface along the line of sight that is drawn as an edge, mm: the nose before the cheek.
constexpr float step_mm = 4;
/// Where the body lies this close to the solid one all around, there is nothing to tell apart.
constexpr float same_from_mm = 0.2f, same_to_mm = 0.8f;

const Surfel* surfel_at_pixel(const LayerPicture& picture, int x, int y) {
  if (!picture.window.contains(x, y)) return nullptr;
  const Surfel& s = picture.surfels[picture.window.index(x, y)];
  return s.hit() ? &s : nullptr;
}

bool same_side(const Surfel* a, const Surfel* b) {
  if (!a || !b) return !a && !b;
  const Vec3f step = b->position - a->position;
  return std::min(std::abs(dot(step, a->normal)), std::abs(dot(step, b->normal))) < step_mm;
}

float gap_mm(const Surfel* film, const Surfel* solid) {
  if (!film || !solid) return !film && !solid ? 0 : same_to_mm;
  return std::abs(film->depth - solid->depth);
}

}  // namespace

float outline_at(const ResolveInput& in, std::size_t layer, int x, int y) {
  // Share of a small Gaussian window that lies on this pixel's side of an edge: one half on the edge itself.
  static constexpr std::array<float, 3> weights{1.0f, 0.6f, 0.13f};
  const LayerPicture& film = in.pictures[layer];
  const Surfel* centre = surfel_at_pixel(film, x, y);
  const int reach = 2 * std::max(1, in.options.height / 1000);
  const int stride = reach / 2;
  // Most pixels are far from any edge: the ends of a cross tell.
  const auto same_at = [&](int dx, int dy) {
    return same_side(centre, surfel_at_pixel(film, x + dx, y + dy));
  };
  if (same_at(reach, 0) && same_at(-reach, 0) && same_at(0, reach) && same_at(0, -reach)) return 0;
  float here = 0, all = 0, gap = 0;
  for (int dy = -2; dy <= 2; ++dy)
    for (int dx = -2; dx <= 2; ++dx) {
      const int u = x + dx * stride, v = y + dy * stride;
      const Surfel* other = surfel_at_pixel(film, u, v);
      const float w =
          weights[static_cast<std::size_t>(std::abs(dx))] * weights[static_cast<std::size_t>(std::abs(dy))];
      all += w;
      if (same_side(centre, other)) here += w;
      gap = std::max(gap, gap_mm(other, surfel_at_pixel(in.pictures.front(), u, v)));
    }
  const float share = here / all, line = std::min(1.0f, 5 * share * (1 - share));
  return line * std::clamp((gap - same_from_mm) / (same_to_mm - same_from_mm), 0.0f, 1.0f);
}

}  // namespace turgor::render_detail
