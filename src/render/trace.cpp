// Camera rays and shadow rays of one layer.
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "render/layer.hpp"
#include "turgor/core/parallel.hpp"
#include "turgor/core/random.hpp"

namespace turgor::render_detail {
namespace {

constexpr int tile = 16;
/// Beyond this open space counts as open: occlusion is to show folds, nostrils and lips, not the room.
constexpr float sky_reach_mm = 70;
constexpr float infinity = std::numeric_limits<float>::infinity();

/// Calls body(x, y) for the top left corner of each tile of the window, a row of tiles per task. Shadow
/// sampling repeats every four pixels of the picture, so tiles are aligned to the picture and not to the
/// window.
template <class Body>
void for_each_tile(const Window& window, Context& context, Body&& body) {
  if (window.empty()) return;
  const int first_x = window.x0 / tile * tile, first_y = window.y0 / tile * tile;
  const auto rows = static_cast<std::size_t>((window.y1 - first_y + tile - 1) / tile);
  parallel_for(rows, 1, [&](std::size_t begin, std::size_t end) {
    for (std::size_t row = begin; row < end; ++row) {
      if (context.cancelled()) return;
      for (int x = first_x; x < window.x1; x += tile) body(x, first_y + static_cast<int>(row) * tile);
    }
  });
}

struct Scrambles {
  std::uint32_t key_u, key_v, sky_u, sky_v, reach;
  explicit Scrambles(std::uint64_t seed) {
    const RandomStream random(seed, 0x7E57);
    const auto bits = [&](std::uint64_t i) { return static_cast<std::uint32_t>(random.bits(i)); };
    key_u = bits(0), key_v = bits(1), sky_u = bits(2), sky_v = bits(3), reach = bits(4);
  }
};

/// A direction of the sky about +z, cosine-weighted, and how far it is looked along.
struct SkySample {
  Vec3f local;
  float reach;
};

SkySample sky_sample(std::uint32_t index, const Scrambles& s) {
  const Sample2 disc = to_disc(net_point(index, s.sky_u, s.sky_v));
  const float z = std::sqrt(std::max(0.0f, 1 - disc.u * disc.u - disc.v * disc.v));
  // Occluders count less with distance: a ray of random reach, uniform over the range, sees a linear
  // fall-off. The reach follows a third, independent stratification (golden ratio).
  const float t = static_cast<float>((index * 2654435769u + s.reach) >> 8) * 0x1.0p-24f;
  return {{disc.u, disc.v, z}, sky_reach_mm * (0.1f + 0.9f * t)};
}

Frame frame_at(const Vec3f& normal, const Lights& lights) {
  return frame_about(normal, lights.toward_viewer, lights.right, lights.up);
}

Vec3f to_world(const Vec3f& local, const Frame& frame, const Vec3f& normal) {
  return frame.u * local.x + frame.v * local.y + normal * local.z;
}

Vec3f key_sample(std::uint32_t index, const Scrambles& s, const Lights& lights) {
  const Sample2 disc = to_disc(net_point(index, s.key_u, s.key_v));
  return lights.key_direction(disc.u, disc.v);
}

/// The up to 16 surfels of a tile that share one set of light samples: their rays run side by side.
struct Group {
  std::array<const Surfel*, lanes> surfels{};
  std::array<Exposure*, lanes> exposure{};
  int count = 0;
};

/// Key rays of one sample index; returns the lanes that see the light.
std::uint32_t trace_key(const Layer& layer, const Group& group, const Vec3f& key) {
  RayPacket rays;
  for (int i = 0; i < group.count; ++i) {
    const Surfel& s = *group.surfels[static_cast<std::size_t>(i)];
    if (dot(s.normal, key) > -0.25f) rays.set(i, s.lit_from, key, 0, infinity);
  }
  const std::uint32_t hidden = layer.shadow_scene().occluded(rays, true);
  std::uint32_t seen = 0;
  for (int i = 0; i < group.count; ++i)
    if (rays.active[static_cast<std::size_t>(i)] && !(hidden >> i & 1)) seen |= 1u << i;
  return seen;
}

void expose_to_key(const Layer& layer, const PictureCamera& camera, const Group& group,
                   std::uint32_t first_index, std::uint32_t samples, const Scrambles& scrambles) {
  const std::uint32_t all = (1u << group.count) - 1;
  std::array<int, lanes> counts{};
  std::uint32_t taken = 0, ever = 0, always = all;
  while (taken < samples) {
    const std::uint32_t seen =
        trace_key(layer, group, key_sample(first_index + taken, scrambles, camera.lights));
    for (int i = 0; i < group.count; ++i)
      counts[static_cast<std::size_t>(i)] += static_cast<int>(seen >> i & 1);
    ever |= seen, always &= seen;
    ++taken;
    // In full light or full shadow all over the tile, half the rays say it as well.
    if (taken >= 4 && 2 * taken >= samples && (ever == 0 || always == all)) break;
  }
  for (int i = 0; i < group.count; ++i)
    group.exposure[static_cast<std::size_t>(i)]->key =
        static_cast<float>(counts[static_cast<std::size_t>(i)]) / static_cast<float>(taken);
}

void expose_to_sky(const Layer& layer, const PictureCamera& camera, const Group& group,
                   std::uint32_t first_index, std::uint32_t samples, const Scrambles& scrambles) {
  const float share = 1.0f / static_cast<float>(samples);
  std::array<Frame, lanes> frames{};
  for (int i = 0; i < group.count; ++i)
    frames[static_cast<std::size_t>(i)] =
        frame_at(group.surfels[static_cast<std::size_t>(i)]->normal, camera.lights);
  for (std::uint32_t j = 0; j < samples; ++j) {
    const SkySample sky = sky_sample(first_index + j, scrambles);
    RayPacket rays;
    std::array<Vec3f, lanes> directions{};
    for (int i = 0; i < group.count; ++i) {
      const auto at = static_cast<std::size_t>(i);
      directions[at] = to_world(sky.local, frames[at], group.surfels[at]->normal);
      rays.set(i, group.surfels[at]->lit_from, directions[at], 0, sky.reach);
    }
    const std::uint32_t hidden = layer.shadow_scene().occluded(rays, false);
    for (int i = 0; i < group.count; ++i) {
      if (hidden >> i & 1) continue;
      Exposure& e = *group.exposure[static_cast<std::size_t>(i)];
      e.sky += share;
      e.open += directions[static_cast<std::size_t>(i)] * share;
    }
  }
}

}  // namespace

PictureCamera::Ray PictureCamera::ray(double x, double y) const {
  const double mm = frame.height_mm / height;
  const Vec3 offset = frame.right * ((x - 0.5 * width) * mm) + frame.up * ((0.5 * height - y) * mm);
  if (frame.fov_deg == 0)
    return {to_float(frame.eye + offset + frame.forward * start), to_float(frame.forward)};
  const Vec3 direction = normalized(frame.forward * frame.target_distance + offset);
  return {to_float(frame.eye + direction * start), to_float(direction)};
}

Window window_of(const Layer& layer, const PictureCamera& camera) {
  const Window all{0, 0, camera.width, camera.height};
  double x0 = camera.width, y0 = camera.height, x1 = 0, y1 = 0;
  for (int corner = 0; corner < 8; ++corner) {
    const Vec3 p{corner & 1 ? layer.upper.x : layer.lower.x, corner & 2 ? layer.upper.y : layer.lower.y,
                 corner & 4 ? layer.upper.z : layer.lower.z};
    const Vec3 d = p - camera.frame.eye;
    const double depth = dot(d, camera.frame.forward);
    if (camera.frame.fov_deg > 0 && depth < 1e-3 * camera.frame.target_distance) return all;
    const double mm = camera.frame.pixel_mm(depth, camera.height);
    const double x = 0.5 * camera.width + dot(d, camera.frame.right) / mm;
    const double y = 0.5 * camera.height - dot(d, camera.frame.up) / mm;
    x0 = std::min(x0, x), x1 = std::max(x1, x), y0 = std::min(y0, y), y1 = std::max(y1, y);
  }
  const auto pixel = [](double v, int top) {
    return static_cast<int>(std::clamp(v, 0.0, static_cast<double>(top)));
  };
  return {pixel(std::floor(x0) - 1, camera.width), pixel(std::floor(y0) - 1, camera.height),
          pixel(std::ceil(x1) + 1, camera.width), pixel(std::ceil(y1) + 1, camera.height)};
}

Surfel surfel_at(const std::vector<Surface>& surfaces, std::uint32_t surface, std::uint32_t triangle, float u,
                 float v, float depth, const Vec3f& direction) {
  const Surface& s = surfaces[surface];
  const auto& t = s.triangles[triangle];
  const std::array<float, 3> weight{1 - u - v, u, v};
  const std::array<const Vec3f*, 3> p{&s.points[t[0]], &s.points[t[1]], &s.points[t[2]]};
  const Vec3f* n = &s.corner_normals[3 * static_cast<std::size_t>(triangle)];
  Vec3f face = normalized(cross(*p[1] - *p[0], *p[2] - *p[0]));
  Surfel out;
  out.surface = surface;
  out.depth = depth;
  out.self_lit = self_lit(s.material.kind);
  float curvature = 0;
  Vec3f colour{};
  for (std::size_t k = 0; k < 3; ++k) {
    out.position += *p[k] * weight[k];
    out.normal += n[k] * weight[k];
    curvature += s.curvature[t[k]] * weight[k];
    if (!s.colours.empty()) colour += s.colours[t[k]] * weight[k];
  }
  // The facet and the smooth surface must agree that the inside is seen: a facet folded over by reduction is
  // no hole, and at outlines the smooth normal leans away though the facet does not.
  out.back = dot(face, direction) > 0 && dot(out.normal, direction) > 0;
  const float side = out.back ? -1.0f : 1.0f;
  if (dot(face, direction) > 0) face *= -1.0f;
  out.normal = normalized(out.normal) * side;
  if (!(squared_length(out.normal) > 0)) out.normal = face;
  out.albedo = albedo_at(s.material, s.colours.empty() ? nullptr : &colour, curvature * side, out.back);

  // Shadow rays start on the smooth surface that the normals describe, not on the facet, which would shade
  // itself (Hanika, Hacking the Shadow Terminator, Ray Tracing Gems II, 2021).
  for (std::size_t k = 0; k < 3; ++k) {
    const Vec3f normal = n[k] * side;
    out.lit_from += (out.position - normal * std::min(0.0f, dot(out.position - *p[k], normal))) * weight[k];
  }
  out.lit_from += face * shadow_offset_mm(s.material.kind);
  return out;
}

void trace_surfels(const Layer& layer, const std::vector<Surface>& surfaces, const PictureCamera& camera,
                   LayerPicture& picture, Context& context) {
  const Window& w = picture.window;
  for_each_tile(w, context, [&](int tile_x, int tile_y) {
    for (int block = 0; block < 16; ++block) {
      RayPacket rays;
      const int x0 = tile_x + 4 * (block & 3), y0 = tile_y + 4 * (block >> 2);
      bool any = false;
      for (int i = 0; i < lanes; ++i) {
        const int x = x0 + (i & 3), y = y0 + (i >> 2);
        if (!w.contains(x, y)) continue;
        const auto ray = camera.ray(x + 0.5, y + 0.5);
        rays.set(i, ray.origin, ray.direction, 0, infinity);
        any = true;
      }
      if (!any) continue;
      HitPacket hits;
      layer.scene.intersect(rays, hits, true);
      for (int i = 0; i < lanes; ++i) {
        const auto at = static_cast<std::size_t>(i);
        if (!rays.active[at] || hits.surface[at] == no_hit) continue;
        const Vec3f direction{rays.direction_x[at], rays.direction_y[at], rays.direction_z[at]};
        picture.surfels[w.index(x0 + (i & 3), y0 + (i >> 2))] =
            surfel_at(surfaces, layer.surfaces[hits.surface[at]], hits.triangle[at], hits.u[at], hits.v[at],
                      hits.distance[at], direction);
      }
    }
  });
}

void conceal(const LayerPicture& solid, LayerPicture& film, Context& context) {
  const Window& w = film.window;
  for_each_tile(w, context, [&](int tile_x, int tile_y) {
    for (int y = std::max(tile_y, w.y0); y < std::min(tile_y + tile, w.y1); ++y)
      for (int x = std::max(tile_x, w.x0); x < std::min(tile_x + tile, w.x1); ++x) {
        if (!solid.window.contains(x, y)) continue;
        const Surfel& wall = solid.surfels[solid.window.index(x, y)];
        Surfel& s = film.surfels[w.index(x, y)];
        s.concealed = wall.hit() && s.depth >= wall.depth - clear_from_mm;
      }
  });
}

void trace_exposure(const Layer& layer, const PictureCamera& camera, const LightSampling& sampling,
                    LayerPicture& picture, Context& context) {
  const Scrambles scrambles(sampling.seed);
  const Window& w = picture.window;
  for_each_tile(w, context, [&](int tile_x, int tile_y) {
    for (int phase = 0; phase < 16; ++phase) {
      Group group;
      for (int i = 0; i < lanes; ++i) {
        const int x = tile_x + 4 * (i & 3) + (phase & 3), y = tile_y + 4 * (i >> 2) + (phase >> 2);
        if (!w.contains(x, y) || !picture.surfels[w.index(x, y)].takes_light()) continue;
        const auto at = static_cast<std::size_t>(group.count++);
        group.surfels[at] = &picture.surfels[w.index(x, y)];
        group.exposure[at] = &picture.exposure[w.index(x, y)];
      }
      if (group.count == 0) continue;
      const std::uint32_t first = interleave[static_cast<std::size_t>(phase)] * sampling.per_pixel;
      expose_to_key(layer, camera, group, first, sampling.per_pixel, scrambles);
      expose_to_sky(layer, camera, group, first, sampling.per_pixel, scrambles);
    }
  });
}

Exposure exposure_of_point(const Layer& layer, const Surfel& surfel, const PictureCamera& camera,
                           std::uint32_t index, const LightSampling& sampling) {
  const Scrambles scrambles(sampling.seed);
  RayPacket rays;
  std::array<Vec3f, lanes> directions{};
  constexpr int half = lanes / 2;
  const std::uint32_t first = index * half;
  const Frame frame = frame_at(surfel.normal, camera.lights);
  for (int i = 0; i < half; ++i) {
    const std::uint32_t sample = first + static_cast<std::uint32_t>(i);
    const Vec3f key = key_sample(sample, scrambles, camera.lights);
    if (dot(surfel.normal, key) > -0.25f) rays.set(i, surfel.lit_from, key, 0, infinity);
    const SkySample sky = sky_sample(sample, scrambles);
    directions[static_cast<std::size_t>(half + i)] = to_world(sky.local, frame, surfel.normal);
    rays.set(half + i, surfel.lit_from, directions[static_cast<std::size_t>(half + i)], 0, sky.reach);
  }
  const std::uint32_t hidden = layer.shadow_scene().occluded(rays, false);
  Exposure out;
  for (int i = 0; i < lanes; ++i) {
    if (!rays.active[static_cast<std::size_t>(i)] || (hidden >> i & 1)) continue;
    if (i < half)
      out.key += 1.0f / half;
    else
      out.sky += 1.0f / half, out.open += directions[static_cast<std::size_t>(i)] / static_cast<float>(half);
  }
  return out;
}

}  // namespace turgor::render_detail
