#include "render/shading.hpp"

#include <algorithm>
#include <cmath>

namespace turgor::render_detail {
namespace {

constexpr float key_disc_radius = 0.24f;  // tangent of the half angle: a soft box, about 27° across
constexpr Vec3f key_colour{0.97f, 0.93f, 0.88f}, fill_colour{0.17f, 0.165f, 0.165f};
constexpr Vec3f sky_colour{0.30f, 0.30f, 0.305f}, floor_colour{0.165f, 0.14f, 0.125f};
constexpr Vec3f rim_colour{0.17f, 0.165f, 0.165f};

/// A grey sheen on matte bodies: without it the dark end of a colour map swallows the form.
constexpr float plain_sheen = 0.03f;

struct Look {
  Vec3f albedo;
  Vec3f wrap;                       ///< how far light reaches round the terminator, by channel
  Vec3f scatter;                    ///< mm
  Vec3f fold, ridge;                ///< factors on the albedo in deep folds and on sharp ridges
  float f0;                         ///< reflectance at normal incidence
  float roughness, coat_roughness;  ///< of the broad and of the tight lobe (GGX alpha)
  float gloss, coat;                ///< strengths of the two lobes
};

const Look& look_of(MaterialKind kind) {
  static constexpr Look skin{{0.64f, 0.385f, 0.290f},
                             {0.18f, 0.07f, 0.04f},
                             {2.4f, 1.05f, 0.65f},
                             {0.80f, 0.57f, 0.60f},
                             {1.00f, 0.84f, 0.86f},
                             0.028f,
                             0.30f,
                             0.17f,
                             0.85f,
                             0.30f};
  static constexpr Look bone{{0.76f, 0.638f, 0.475f},
                             {0.04f, 0.03f, 0.02f},
                             {0.5f, 0.4f, 0.3f},
                             {0.80f, 0.72f, 0.62f},
                             {1.06f, 1.06f, 1.07f},
                             0.035f,
                             0.34f,
                             0.22f,
                             0.65f,
                             0.12f};
  static constexpr Look teeth{{0.80f, 0.765f, 0.66f},
                              {0.06f, 0.05f, 0.05f},
                              {0.8f, 0.7f, 0.6f},
                              {0.85f, 0.76f, 0.66f},
                              {1.00f, 1.00f, 1.00f},
                              0.050f,
                              0.20f,
                              0.10f,
                              0.70f,
                              0.60f};
  static constexpr Look mucosa{{0.50f, 0.165f, 0.145f},
                               {0.16f, 0.05f, 0.04f},
                               {2.2f, 0.7f, 0.5f},
                               {0.75f, 0.55f, 0.55f},
                               {1.00f, 0.95f, 0.95f},
                               0.035f,
                               0.22f,
                               0.09f,
                               0.80f,
                               0.90f};
  static constexpr Look plain{{0.8f, 0.8f, 0.8f}, {0, 0, 0}, {0, 0, 0}, {1, 1, 1}, {1, 1, 1}, 0, 1, 1, 0, 0};
  switch (kind) {
    case MaterialKind::skin:
      return skin;
    case MaterialKind::bone:
      return bone;
    case MaterialKind::teeth:
      return teeth;
    case MaterialKind::mucosa:
      return mucosa;
    case MaterialKind::plain:
      break;
  }
  return plain;
}

Vec3f times(const Vec3f& a, const Vec3f& b) {
  return {a.x * b.x, a.y * b.y, a.z * b.z};
}

Vec3f wrapped_cosine(float cosine, const Vec3f& wrap) {
  const auto channel = [&](float w) { return std::max(0.0f, (cosine + w) / ((1 + w) * (1 + w))); };
  return {channel(wrap.x), channel(wrap.y), channel(wrap.z)};
}

/// Light that reaches an occluded point after bouncing between surfaces of that albedo: the cubic fit of
/// Jimenez, Wu, Pesce and Jarabo, Practical Real-Time Strategies for Accurate Indirect Occlusion, 2016,
/// section 5.
float with_bounces(float open, float albedo) {
  const float a = 2.0404f * albedo - 0.3324f, b = -4.7951f * albedo + 0.6417f, c = 2.7552f * albedo + 0.6903f;
  return std::max(open, ((open * a + b) * open + c) * open);
}

/// The angles between a light, the viewer and the surface that a highlight depends on.
struct Glance {
  float nl, nv, nh, fresnel;

  Glance(const Vec3f& n, const Vec3f& v, const Vec3f& l, float f0) : nl(dot(n, l)) {
    const Vec3f h = normalized(v + l);
    nv = std::max(dot(n, v), 0.05f);
    nh = std::max(dot(n, h), 0.0f);
    const float m = 1 - std::max(dot(v, h), 0.0f), m2 = m * m;
    fresnel = f0 + (1 - f0) * m2 * m2 * m;  // Schlick 1994
  }
};

/// Microfacet reflection times the cosine (GGX, Walter et al. 2007; visibility term of Karis 2013) of a light
/// of unit irradiance.
float highlight(const Glance& g, float roughness) {
  if (g.nl <= 0) return 0;
  const float a2 = roughness * roughness, k = roughness / 2;
  const float denominator = g.nh * g.nh * (a2 - 1) + 1;
  const float visibility = 1 / (4 * (g.nl * (1 - k) + k) * (g.nv * (1 - k) + k));
  return a2 / (denominator * denominator) * visibility * g.fresnel * g.nl;
}

/// Identity up to `knee`, then rolls off to 1 by the brightest channel, so that hues stay; what is lost in
/// the highlights turns slowly to white.
Vec3f tone(const Vec3f& c) {
  constexpr float knee = 0.72f;
  const float top = std::max({c.x, c.y, c.z, 0.0f});
  if (top <= knee) return {std::max(c.x, 0.0f), std::max(c.y, 0.0f), std::max(c.z, 0.0f)};
  const float over = (top - knee) / (1 - knee);
  const float rolled = knee + (1 - knee) * (over / (1 + over));
  const float white = 0.25f * over / (2 + over);
  return lerp(c * (rolled / top), Vec3f{rolled, rolled, rolled}, white);
}

/// Matte and neutral: form stays visible, colours keep to what the legend shows.
Vec3f plain_irradiance(const Surfel& surfel, const Exposure& exposure, const StudioLights& lights) {
  const float key = std::max(0.0f, dot(surfel.normal, lights.key)) * exposure.key;
  const float front = std::max(0.0f, dot(surfel.normal, lights.toward_viewer));
  const float level = 0.20f + 0.42f * exposure.sky + 0.22f * key + 0.20f * front;
  return {level, level, level};
}

}  // namespace

StudioLights StudioLights::for_camera(const CameraFrame& camera) {
  StudioLights lights;
  lights.right = to_float(camera.right);
  lights.up = to_float(camera.up);
  lights.toward_viewer = to_float(-camera.forward);
  const auto direction = [&](float r, float u, float v) {
    return normalized(lights.right * r + lights.up * u + lights.toward_viewer * v);
  };
  // The key stands on the side to which the face (-y) is turned, so that a profile is not seen from its
  // shadow.
  const float turn = std::clamp(dot(Vec3f{0, -1, 0}, lights.right) / 0.5f, 0.0f, 1.0f);
  const float side = -0.50f + turn * turn * (3 - 2 * turn);
  lights.key = direction(side, 0.58f, 0.80f);
  lights.key_u = normalized(cross(lights.up, lights.key));
  lights.key_v = cross(lights.key, lights.key_u);
  lights.fill = direction(-1.5f * side, 0.05f, 0.75f);
  lights.rim_left = direction(-0.85f, 0.35f, -0.50f);
  lights.rim_right = direction(0.85f, 0.30f, -0.45f);
  return lights;
}

Vec3f StudioLights::key_direction(float u, float v) const {
  return normalized(key + key_u * (u * key_disc_radius) + key_v * (v * key_disc_radius));
}

Vec3f scatter_mm(MaterialKind kind) {
  return look_of(kind).scatter;
}

float shadow_offset_mm(MaterialKind kind) {
  return 0.02f + 0.25f * look_of(kind).scatter.x;
}

Vec3f albedo_at(const Material& material, const Vec3f* point_colour, float curvature, bool back) {
  const Look& look = look_of(material.kind);
  Vec3f albedo = point_colour                           ? *point_colour
                 : material.kind == MaterialKind::plain ? material.colour
                                                        : look.albedo;
  const float fold = std::clamp(-7 * curvature, 0.0f, 1.0f),
              ridge = std::clamp(8 * (curvature - 0.04f), 0.0f, 1.0f);
  albedo = times(albedo, lerp(Vec3f{1, 1, 1}, look.fold, fold));
  albedo = times(albedo, lerp(Vec3f{1, 1, 1}, look.ridge, ridge));
  return back ? albedo * 0.45f : albedo;
}

Vec3f irradiance(const Surfel& surfel, const Material& material, const Exposure& exposure,
                 const StudioLights& lights) {
  if (material.kind == MaterialKind::plain) return plain_irradiance(surfel, exposure, lights);
  const Look& look = look_of(material.kind);
  const Vec3f& n = surfel.normal;
  Vec3f sum = times(key_colour, wrapped_cosine(dot(n, lights.key), look.wrap)) * exposure.key;
  // Fill and rims are broad: a light is seen as far as the open part of the hemisphere leans to it.
  const auto seen = [&](const Vec3f& light) {
    return std::clamp(dot(exposure.open, light) * 1.5f + 0.5f * exposure.sky, 0.0f, 1.0f);
  };
  sum += times(fill_colour, wrapped_cosine(dot(n, lights.fill), look.wrap)) * seen(lights.fill);
  sum += times(rim_colour, wrapped_cosine(dot(n, lights.rim_left), look.wrap)) * seen(lights.rim_left);
  sum += times(rim_colour, wrapped_cosine(dot(n, lights.rim_right), look.wrap)) * seen(lights.rim_right);
  const Vec3f open = normalized(exposure.open + n * 0.05f);
  const Vec3f ambient = lerp(floor_colour, sky_colour, 0.5f + 0.5f * dot(open, lights.up));
  const Vec3f bounced{with_bounces(exposure.sky, surfel.albedo.x),
                      with_bounces(exposure.sky, surfel.albedo.y),
                      with_bounces(exposure.sky, surfel.albedo.z)};
  return sum + times(ambient, bounced);
}

Vec3f outgoing(const Surfel& surfel, const Material& material, const Vec3f& scattered_irradiance,
               const Exposure& exposure, const StudioLights& lights, const Vec3f& to_viewer) {
  const Look& look = look_of(material.kind);
  Vec3f colour = times(surfel.albedo, scattered_irradiance);
  if (material.kind == MaterialKind::plain) colour += scattered_irradiance * plain_sheen;
  if (look.gloss > 0 && !surfel.back) {
    const Vec3f& n = surfel.normal;
    const float open = exposure.sky * exposure.sky;
    const auto broad = [&](const Vec3f& light) {
      return look.gloss * highlight(Glance(n, to_viewer, light, look.f0), look.roughness);
    };
    if (exposure.key > 0) {
      const Glance key(n, to_viewer, lights.key, look.f0);
      const float both =
          look.gloss * highlight(key, look.roughness) + look.coat * highlight(key, look.coat_roughness);
      colour += key_colour * (both * exposure.key);
    }
    colour += fill_colour * (broad(lights.fill) * open);
    colour += rim_colour * ((broad(lights.rim_left) + broad(lights.rim_right)) * open);
    // Reflection of the sky, growing towards grazing angles.
    const float grazing = 1 - std::max(dot(n, to_viewer), 0.0f), g2 = grazing * grazing;
    const float fresnel = look.f0 + (0.5f - look.roughness) * g2 * g2 * grazing;
    colour += sky_colour * (0.4f * fresnel * open * (look.gloss + look.coat));
  }
  return tone(colour);
}

}  // namespace turgor::render_detail
