// From shadow rays to light on the surface: noise filter, irradiance, spreading under the surface.
#include <algorithm>
#include <array>
#include <cmath>

#include "render/layer.hpp"
#include "turgor/core/parallel.hpp"

namespace turgor::render_detail {
namespace {

constexpr std::size_t rows_per_task = 16;

template <class Body>
void for_each_row(const Window& window, Context& context, Body&& body) {
  if (window.empty()) return;
  parallel_for(static_cast<std::size_t>(window.height()), rows_per_task,
               [&](std::size_t begin, std::size_t end) {
                 if (context.cancelled()) return;
                 for (std::size_t row = begin; row < end; ++row) body(window.y0 + static_cast<int>(row));
               });
}

/// How much b tells about the light at a: near 1 on the same smooth piece of surface, 0 across edges.
float likeness(const Surfel& a, const Surfel& b, float tolerance_mm) {
  if (!b.takes_light()) return 0;
  const float off_plane = std::abs(dot(a.normal, b.position - a.position)) / tolerance_mm;
  const float facing = dot(a.normal, b.normal);
  if (off_plane >= 1 || facing <= 0) return 0;
  const float f2 = facing * facing, f4 = f2 * f2;
  return (1 - off_plane) * f4 * f4;
}

/// One direction of the filter: a tent over 7 pixels, which is two boxes over the 4 pixels of the
/// interleaving and so leaves none of its pattern.
void filter_line(const PictureCamera& camera, const LayerPicture& picture, int dx, int dy,
                 const PixelArray<Exposure>& from, PixelArray<Exposure>& to, Context& context) {
  static constexpr std::array<float, 7> tent{1, 2, 3, 4, 3, 2, 1};
  const Window& w = picture.window;
  for_each_row(w, context, [&](int y) {
    for (int x = w.x0; x < w.x1; ++x) {
      const Surfel& centre = picture.surfels[w.index(x, y)];
      if (!centre.takes_light()) continue;
      Exposure sum;
      float total = 0;
      for (int k = -3; k <= 3; ++k) {
        const int u = x + k * dx, v = y + k * dy;
        if (!w.contains(u, v)) continue;
        const std::size_t at = w.index(u, v);
        const float tolerance = camera.pixel_mm * static_cast<float>(1 + std::abs(k));
        const float weight = tent[static_cast<std::size_t>(k + 3)] *
                             (k == 0 ? 1.0f : likeness(centre, picture.surfels[at], tolerance));
        sum.key += from[at].key * weight;
        sum.sky += from[at].sky * weight;
        sum.open += from[at].open * weight;
        total += weight;
      }
      to[w.index(x, y)] = {sum.key / total, sum.sky / total, sum.open / total};
    }
  });
}

constexpr int scatter_taps = 6;  // on either side

/// Weights by tap and channel for one material: a Gaussian of the channel's scatter distance.
struct ScatterKernel {
  int stride = 0;  ///< pixels between taps; 0: nothing to spread at this scale
  float reach_mm = 0;
  std::array<Vec3f, scatter_taps + 1> weights{};
};

ScatterKernel scatter_kernel(MaterialKind kind, float pixel_mm) {
  const Vec3f sigma = scatter_mm(kind);
  ScatterKernel kernel;
  const float widest = std::max({sigma.x, sigma.y, sigma.z});
  if (widest < pixel_mm / 2) return kernel;
  kernel.reach_mm = 2 * widest;
  kernel.stride = std::max(1, static_cast<int>(std::lround(kernel.reach_mm / pixel_mm / scatter_taps)));
  for (int k = 0; k <= scatter_taps; ++k) {
    const float d = static_cast<float>(k * kernel.stride) * pixel_mm;
    const auto gauss = [&](float s) { return k == 0 ? 1.0f : s > 0 ? std::exp(-d * d / (2 * s * s)) : 0.0f; };
    kernel.weights[static_cast<std::size_t>(k)] = {gauss(sigma.x), gauss(sigma.y), gauss(sigma.z)};
  }
  return kernel;
}

/// What decides whether light spreads between two pixels, packed for the many reads of the filter.
struct ScatterKey {
  float depth = 0;
  std::uint32_t piece = no_hit;  ///< surface and side
};

PixelArray<ScatterKey> scatter_keys(const LayerPicture& picture, Context& context) {
  PixelArray<ScatterKey> keys(picture.surfels.size());
  const Window& w = picture.window;
  for_each_row(w, context, [&](int y) {
    for (int x = w.x0; x < w.x1; ++x) {
      const std::size_t at = w.index(x, y);
      const Surfel& s = picture.surfels[at];
      if (s.takes_light()) keys[at] = {s.depth, 2 * s.surface + (s.back ? 1u : 0u)};
    }
  });
  return keys;
}

/// One direction of the screen-space diffusion of Jimenez, Sundstedt and Gutierrez, Screen-Space Perceptual
/// Rendering of Human Skin, 2009: the irradiance is spread by channel, and not across steps in depth.
void scatter_line(const std::vector<Surface>& surfaces, const std::vector<ScatterKernel>& kernels,
                  const Window& w, const PixelArray<ScatterKey>& keys, int dx, int dy,
                  const PixelArray<Vec3f>& from, PixelArray<Vec3f>& to, Context& context) {
  for_each_row(w, context, [&](int y) {
    for (int x = w.x0; x < w.x1; ++x) {
      const std::size_t centre_at = w.index(x, y);
      const ScatterKey centre = keys[centre_at];
      to[centre_at] = from[centre_at];
      if (centre.piece == no_hit) continue;
      const auto kind = surfaces[centre.piece / 2].material.kind;
      const ScatterKernel& kernel = kernels[static_cast<std::size_t>(kind)];
      if (kernel.stride == 0) continue;
      const float per_reach = 1 / kernel.reach_mm;
      Vec3f sum{}, total{};
      for (int k = -scatter_taps; k <= scatter_taps; ++k) {
        const int u = x + k * dx * kernel.stride, v = y + k * dy * kernel.stride;
        if (!w.contains(u, v)) continue;
        const std::size_t at = w.index(u, v);
        if (keys[at].piece != centre.piece) continue;
        const float step = (keys[at].depth - centre.depth) * per_reach;
        const float keep = std::max(0.0f, 1 - step * step);
        const Vec3f weight = kernel.weights[static_cast<std::size_t>(std::abs(k))] * keep;
        sum += {from[at].x * weight.x, from[at].y * weight.y, from[at].z * weight.z};
        total += weight;
      }
      to[centre_at] = {sum.x / total.x, sum.y / total.y, sum.z / total.z};
    }
  });
}

}  // namespace

void filter_exposure(const PictureCamera& camera, LayerPicture& picture, Context& context) {
  PixelArray<Exposure> half(picture.exposure.size());
  filter_line(camera, picture, 1, 0, picture.exposure, half, context);
  filter_line(camera, picture, 0, 1, half, picture.exposure, context);
}

void light_surfels(const std::vector<Surface>& surfaces, const PictureCamera& camera, LayerPicture& picture,
                   Context& context) {
  const Window& w = picture.window;
  picture.irradiance = PixelArray<Vec3f>(picture.surfels.size());
  for_each_row(w, context, [&](int y) {
    for (int x = w.x0; x < w.x1; ++x) {
      const std::size_t at = w.index(x, y);
      const Surfel& s = picture.surfels[at];
      if (s.takes_light())
        picture.irradiance[at] =
            irradiance(s, surfaces[s.surface].material, picture.exposure[at], camera.lights);
    }
  });
  std::vector<ScatterKernel> kernels(static_cast<std::size_t>(MaterialKind::line) + 1);
  bool any = false;
  for (const Surface& s : surfaces) {
    ScatterKernel& kernel = kernels[static_cast<std::size_t>(s.material.kind)];
    kernel = scatter_kernel(s.material.kind, camera.pixel_mm);
    any = any || kernel.stride > 0;
  }
  if (!any) return;
  PixelArray<Vec3f> half(picture.irradiance.size());
  const PixelArray<ScatterKey> keys = scatter_keys(picture, context);
  scatter_line(surfaces, kernels, w, keys, 1, 0, picture.irradiance, half, context);
  scatter_line(surfaces, kernels, w, keys, 0, 1, half, picture.irradiance, context);
}

}  // namespace turgor::render_detail
