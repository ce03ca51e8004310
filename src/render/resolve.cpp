#include "render/resolve.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <span>

#include "turgor/core/parallel.hpp"
#include "turgor/core/random.hpp"

namespace turgor::render_detail {
namespace {

constexpr int rows_per_task = 8;
constexpr float infinity = std::numeric_limits<float>::infinity();

/// One layer's contribution along one camera ray.
struct Fragment {
  float depth = infinity;
  float alpha = 0;
  Vec3f colour{};
};

/// A film of the given opacity seen at a slant is longer to cross (Beer and Lambert).
float film_alpha(double opacity, float cosine) {
  if (opacity >= 1) return 1;
  return 1 - static_cast<float>(std::pow(1 - opacity, 1 / std::max(cosine, 0.3f)));
}

Fragment shade(const ResolveInput& in, const Layer& layer, const Surfel& surfel, const Vec3f& irradiance,
               const Exposure& exposure, const Vec3f& direction) {
  const Material& material = in.surfaces[surfel.surface].material;
  Fragment out;
  out.depth = surfel.depth;
  out.colour = outgoing(surfel, material, irradiance, exposure, in.camera.lights, -direction);
  out.alpha = layer.translucent ? film_alpha(material.opacity, -dot(surfel.normal, direction)) : 1;
  return out;
}

/// Fragments front to back over the background. `fragments` is in the order of the layers, the solid one
/// first.
Vec3f composite(std::vector<Fragment>& fragments, const Vec3f& background) {
  const float solid = fragments.front().alpha > 0 ? fragments.front().depth : infinity;
  for (std::size_t i = 1; i < fragments.size(); ++i) {
    if (fragments[i].alpha <= 0) continue;
    const float t =
        std::clamp((solid - fragments[i].depth - clear_from_mm) / (clear_at_mm - clear_from_mm), 0.0f, 1.0f);
    fragments[i].alpha *= t;
  }
  std::stable_sort(fragments.begin(), fragments.end(),
                   [](const Fragment& a, const Fragment& b) { return a.depth < b.depth; });
  Vec3f colour{};
  float through = 1;
  for (const Fragment& f : fragments) {
    if (f.alpha <= 0) continue;
    colour += f.colour * (through * f.alpha);
    through *= 1 - f.alpha;
  }
  return colour + background * through;
}

/// Whether the pixel's centre does not stand for the whole pixel: outline, step, crease or strong bend near
/// by.
bool needs_more_rays(const LayerPicture& picture, int x, int y, float pixel_mm) {
  const Window& w = picture.window;
  const Surfel* centre = w.contains(x, y) ? &picture.surfels[w.index(x, y)] : nullptr;
  const bool hit = centre && centre->hit();
  for (int dy = -1; dy <= 1; ++dy)
    for (int dx = -1; dx <= 1; ++dx) {
      if (dx == 0 && dy == 0) continue;
      const Surfel* other = w.contains(x + dx, y + dy) ? &picture.surfels[w.index(x + dx, y + dy)] : nullptr;
      const bool other_hit = other && other->hit();
      if (hit != other_hit) return true;
      if (!hit) continue;
      if (centre->surface != other->surface || centre->back != other->back) return true;
      if (dot(centre->normal, other->normal) < 0.9f) return true;
      const Vec3f step = other->position - centre->position;
      if (std::abs(dot(step, centre->normal)) > pixel_mm && std::abs(dot(step, other->normal)) > pixel_mm)
        return true;
    }
  return false;
}

/// Light at a point between pixel centres from those of the 3 × 3 pixels around that lie on the same piece of
/// surface; traced afresh where there is none.
void light_between(const ResolveInput& in, std::size_t layer, const Surfel& s, int x, int y, float px,
                   float py, std::uint32_t sample, Vec3f& light, Exposure& exposure) {
  const LayerPicture& picture = in.pictures[layer];
  const Window& w = picture.window;
  float total = 0;
  light = {}, exposure = {};
  if (s.self_lit) return;
  for (int dy = -1; dy <= 1; ++dy)
    for (int dx = -1; dx <= 1; ++dx) {
      if (!w.contains(x + dx, y + dy)) continue;
      const std::size_t at = w.index(x + dx, y + dy);
      const Surfel& c = picture.surfels[at];
      if (!c.takes_light() || c.surface != s.surface || c.back != s.back) continue;
      const float facing = dot(s.normal, c.normal);
      const Vec3f step = c.position - s.position;
      const float off_plane = std::max(std::abs(dot(step, s.normal)), std::abs(dot(step, c.normal)));
      if (facing < 0.7f || off_plane > 2 * in.camera.pixel_mm) continue;
      const float ex = px - (static_cast<float>(dx) + 0.5f), ey = py - (static_cast<float>(dy) + 0.5f);
      const float near = std::max(0.0f, 2.25f - (ex * ex + ey * ey));
      const float f4 = facing * facing * facing * facing;
      const float weight = near * f4 * f4 / (1 + 4 * off_plane / in.camera.pixel_mm);
      light += picture.irradiance[at] * weight;
      exposure.key += picture.exposure[at].key * weight;
      exposure.sky += picture.exposure[at].sky * weight;
      exposure.open += picture.exposure[at].open * weight;
      total += weight;
    }
  if (total > 0.05f) {
    light /= total;
    exposure.key /= total, exposure.sky /= total, exposure.open /= total;
    return;
  }
  exposure = exposure_of_point(in.layers[layer], s, in.camera, sample, in.sampling);
  light = irradiance(s, in.surfaces[s.surface].material, exposure, in.camera.lights);
}

struct PixelRays {
  RayPacket rays;
  std::array<Sample2, lanes> at{};  ///< within the pixel
};

/// `count` of a pixel's rays, from sample `first` on, in the lanes from `lane` on.
void add_rays(const ResolveInput& in, int x, int y, int first, int count, int lane, PixelRays& out) {
  const RandomStream random(in.options.seed,
                            static_cast<std::uint64_t>(y) << 32 | static_cast<std::uint32_t>(x));
  const auto u = static_cast<std::uint32_t>(random.bits(0)), v = static_cast<std::uint32_t>(random.bits(1));
  for (int i = 0; i < count; ++i) {
    const Sample2 s = net_point(static_cast<std::uint32_t>(first + i), u, v);
    const auto ray = in.camera.ray(x + static_cast<double>(s.u), y + static_cast<double>(s.v));
    out.rays.set(lane + i, ray.origin, ray.direction, 0, infinity);
    out.at[static_cast<std::size_t>(lane + i)] = s;
  }
}

/// What one of the pixel's rays meets in every layer.
void sample_fragments(const ResolveInput& in, int x, int y, const PixelRays& pixel,
                      const std::vector<HitPacket>& hits, int lane, int sample,
                      std::vector<Fragment>& fragments) {
  const auto at = static_cast<std::size_t>(lane);
  const Vec3f direction{pixel.rays.direction_x[at], pixel.rays.direction_y[at], pixel.rays.direction_z[at]};
  fragments.assign(in.layers.size(), {});
  for (std::size_t l = 0; l < in.layers.size(); ++l) {
    const HitPacket& h = hits[l];
    if (h.surface[at] == no_hit) continue;
    if (l > 0 && h.distance[at] >= fragments.front().depth - clear_from_mm)
      continue;  // hidden by the solid layer
    const Surfel s = surfel_at(in.surfaces, in.layers[l].surfaces[h.surface[at]], h.triangle[at], h.u[at],
                               h.v[at], h.distance[at], direction);
    Vec3f light;
    Exposure exposure;
    light_between(in, l, s, x, y, pixel.at[at].u, pixel.at[at].v, static_cast<std::uint32_t>(sample), light,
                  exposure);
    fragments[l] = shade(in, in.layers[l], s, light, exposure, direction);
  }
}

void trace(const ResolveInput& in, const PixelRays& pixels, std::vector<HitPacket>& hits) {
  for (std::size_t l = 0; l < in.layers.size(); ++l) {
    hits[l].surface.fill(no_hit);
    if (!in.layers[l].surfaces.empty()) in.layers[l].scene.intersect(pixels.rays, hits[l], true);
  }
}

Vec3f centre_pixel(const ResolveInput& in, int x, int y, const Vec3f& background,
                   std::vector<Fragment>& fragments) {
  fragments.assign(in.layers.size(), {});
  const Vec3f direction = in.camera.ray(x + 0.5, y + 0.5).direction;
  bool any = false;
  for (std::size_t l = 0; l < in.layers.size(); ++l) {
    const LayerPicture& p = in.pictures[l];
    if (!p.window.contains(x, y)) continue;
    const std::size_t at = p.window.index(x, y);
    if (!p.surfels[at].hit() || p.surfels[at].concealed) continue;
    fragments[l] = shade(in, in.layers[l], p.surfels[at], p.irradiance[at], p.exposure[at], direction);
    any = true;
  }
  return any ? composite(fragments, background) : background;
}

/// The picture's colour with the outlines of translucent layers over it.
Vec3f with_outlines(const ResolveInput& in, int x, int y, Vec3f colour) {
  for (std::size_t l = 1; l < in.layers.size(); ++l) {
    const Material& material = in.surfaces[in.layers[l].surfaces.front()].material;
    if (material.outline) colour = lerp(colour, material.colour, 0.9f * outline_at(in, l, x, y));
  }
  return colour;
}

/// The studio backdrop: a light wall that falls off to the corners.
Vec3f background_at(const RenderOptions& options, int x, int y) {
  if (options.backdrop == Backdrop::flat) return options.background;
  const float u = (static_cast<float>(x) + 0.5f) / static_cast<float>(options.width) - 0.5f;
  const float v = (static_cast<float>(y) + 0.5f) / static_cast<float>(options.height) - 0.45f;
  const float r2 = u * u + v * v;
  return options.background * (1 - 0.75f * r2 / (0.35f + r2));
}

void store(const Vec3f& c, const RenderOptions& options, int x, int y, Image& image) {
  const std::size_t at =
      3 * (static_cast<std::size_t>(y) * static_cast<std::size_t>(image.width) + static_cast<std::size_t>(x));
  float dither = 0;
  if (options.backdrop == Backdrop::studio) {
    // Half a step of 8-bit sRGB (slope about 1 in the light tones) breaks the bands of the gradient.
    const std::uint32_t h =
        (static_cast<std::uint32_t>(x) * 0x9E3779B1u) ^ (static_cast<std::uint32_t>(y) * 0x85EBCA77u);
    dither = (static_cast<float>((h * 0xC2B2AE3Du) >> 8) * 0x1.0p-24f - 0.5f) / 255.0f;
  }
  for (int k = 0; k < 3; ++k) image.rgb[at + static_cast<std::size_t>(k)] = encode_srgb(c[k] + dither);
}

/// What is drawn of a row, and the pixels in it that need more rays.
struct Row {
  std::vector<Fragment> fragments;
  std::vector<int> edges;
};

/// Pixels of row y, each the mean of `options.samples` rays through it. As many pixels as a packet has room
/// for are traced side by side.
void edge_pixels(const ResolveInput& in, int y, Row& row, Image& image) {
  const int samples = in.options.samples;
  const auto share = static_cast<std::size_t>(std::max(1, lanes / samples));
  std::vector<HitPacket> hits(in.layers.size());
  for (std::size_t begin = 0; begin < row.edges.size(); begin += share) {
    const std::span group = std::span(row.edges).subspan(begin, std::min(share, row.edges.size() - begin));
    std::array<Vec3f, lanes> sum{};
    for (int first = 0; first < samples; first += lanes) {
      const int count = std::min(lanes, samples - first);
      PixelRays pixels;
      for (int lane = 0; const int x : group) add_rays(in, x, y, first, count, lane, pixels), lane += count;
      trace(in, pixels, hits);
      for (std::size_t k = 0; k < group.size(); ++k) {
        const Vec3f background = background_at(in.options, group[k], y);
        for (int i = 0; i < count; ++i) {
          const int lane = static_cast<int>(k) * count + i;
          sample_fragments(in, group[k], y, pixels, hits, lane, first + i, row.fragments);
          sum[k] += composite(row.fragments, background);
        }
      }
    }
    for (std::size_t k = 0; k < group.size(); ++k) {
      const Vec3f mean = sum[k] / static_cast<float>(samples);
      store(with_outlines(in, group[k], y, mean), in.options, group[k], y, image);
    }
  }
}

bool near_any_layer(const ResolveInput& in, int x, int y) {
  constexpr int rim = 3;  // the reach of edges and outlines
  return std::any_of(in.pictures.begin(), in.pictures.end(), [&](const LayerPicture& p) {
    const Window& w = p.window;
    return !w.empty() && x >= w.x0 - rim && x < w.x1 + rim && y >= w.y0 - rim && y < w.y1 + rim;
  });
}

void draw_row(const ResolveInput& in, int y, Row& row, Image& image) {
  row.edges.clear();
  for (int x = 0; x < image.width; ++x) {
    const Vec3f background = background_at(in.options, x, y);
    if (!near_any_layer(in, x, y)) {
      store(background, in.options, x, y, image);
    } else if (std::any_of(in.pictures.begin(), in.pictures.end(), [&](const LayerPicture& p) {
                 return needs_more_rays(p, x, y, in.camera.pixel_mm);
               })) {
      row.edges.push_back(x);
    } else {
      const Vec3f colour = centre_pixel(in, x, y, background, row.fragments);
      store(with_outlines(in, x, y, colour), in.options, x, y, image);
    }
  }
  edge_pixels(in, y, row, image);
}

}  // namespace

void resolve(const ResolveInput& in, Image& image, Context& context) {
  const auto rows = static_cast<std::size_t>(image.height);
  parallel_for(rows, rows_per_task, [&](std::size_t begin, std::size_t end) {
    Row row;
    for (int y = static_cast<int>(begin); y < static_cast<int>(end); ++y) {
      if (context.cancelled()) return;
      draw_row(in, y, row, image);
    }
  });
}

}  // namespace turgor::render_detail
