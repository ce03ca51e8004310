#include "render/shading.hpp"

#include <algorithm>
#include <cmath>

namespace turgor::render_detail {
namespace {

constexpr float studio_key_radius = 0.24f;  // a soft box, about 27° across
constexpr float scene_key_radius = 0.12f;
constexpr Vec3f studio_key{0.97f, 0.93f, 0.88f}, studio_fill{0.17f, 0.165f, 0.165f};
constexpr Vec3f studio_sky{0.30f, 0.30f, 0.305f}, studio_floor{0.165f, 0.14f, 0.125f};
constexpr Vec3f studio_rim{0.17f, 0.165f, 0.165f};
constexpr Vec3f scene_ambient{0.22f, 0.22f, 0.225f};

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
    case MaterialKind::glossy:
    case MaterialKind::line:
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

/// Whether the material's colour is given with it and not by its kind.
bool own_colour(MaterialKind kind) {
  return kind == MaterialKind::plain || kind == MaterialKind::glossy || kind == MaterialKind::line;
}

/// Whether its back is the dark inside of a body.
bool has_inside(MaterialKind kind) {
  return kind != MaterialKind::glossy && kind != MaterialKind::line;
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

/// The cosine between the mirrored light and the viewer, to the power of `exponent` (Phong, Illumination for
/// computer generated pictures, 1975).
float phong(const Vec3f& n, const Vec3f& v, const Vec3f& l, double exponent) {
  const float nl = dot(n, l);
  if (nl <= 0) return 0;
  const float cosine = dot(n * (2 * nl) - l, v);
  // c^n ≤ exp(−n (1 − c)), which is nothing to see over most of a surface.
  if (cosine <= 0 || exponent * (1 - static_cast<double>(cosine)) > 12) return 0;
  return static_cast<float>(std::pow(static_cast<double>(cosine), exponent));
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
Vec3f plain_irradiance(const Surfel& surfel, const Exposure& exposure, const Lights& lights) {
  const float key = std::max(0.0f, dot(surfel.normal, lights.key)) * exposure.key;
  const float front = std::max(0.0f, dot(surfel.normal, lights.toward_viewer));
  const float level = 0.20f + 0.42f * exposure.sky + 0.22f * key + 0.20f * front;
  return {level, level, level};
}

}  // namespace

void Lights::set_key(const Vec3f& direction, const Vec3f& colour, float radius) {
  key = direction;
  key_colour = colour;
  key_radius = radius;
  const Vec3f across = cross(up, key);
  key_u = length(across) > 1e-3f ? normalized(across) : right;
  key_v = cross(key, key_u);
}

Lights Lights::facing(const CameraFrame& camera) {
  Lights lights;
  lights.right = to_float(camera.right);
  lights.up = to_float(camera.up);
  lights.toward_viewer = to_float(-camera.forward);
  return lights;
}

Lights Lights::studio(const CameraFrame& camera) {
  Lights lights = facing(camera);
  const auto direction = [&](float r, float u, float v) {
    return normalized(lights.right * r + lights.up * u + lights.toward_viewer * v);
  };
  // The key stands on the side to which the face (-y) is turned, so that a profile is not seen from its
  // shadow.
  const float turn = std::clamp(dot(Vec3f{0, -1, 0}, lights.right) / 0.5f, 0.0f, 1.0f);
  const float side = -0.50f + turn * turn * (3 - 2 * turn);
  lights.set_key(direction(side, 0.58f, 0.80f), studio_key, studio_key_radius);
  lights.broad = {{direction(-1.5f * side, 0.05f, 0.75f), studio_fill},
                  {direction(-0.85f, 0.35f, -0.50f), studio_rim},
                  {direction(0.85f, 0.30f, -0.45f), studio_rim}};
  lights.sky = studio_sky;
  lights.floor = studio_floor;
  return lights;
}

Lights Lights::of_scene(const CameraFrame& camera, const std::vector<DirectionalLight>& given) {
  Lights lights = facing(camera);
  const auto strength = [](const DirectionalLight& l) { return luminance(l.colour); };
  const auto strongest = std::max_element(
      given.begin(), given.end(),
      [&](const DirectionalLight& a, const DirectionalLight& b) { return strength(a) < strength(b); });
  for (auto l = given.begin(); l != given.end(); ++l) {
    const Vec3f direction = to_float(-normalized(l->shines_along));
    if (l == strongest)
      lights.set_key(direction, l->colour, scene_key_radius);
    else
      lights.broad.push_back({direction, l->colour});
  }
  lights.sky = lights.floor = scene_ambient;
  return lights;
}

Vec3f Lights::key_direction(float u, float v) const {
  return normalized(key + key_u * (u * key_radius) + key_v * (v * key_radius));
}

bool shows_curvature(MaterialKind kind) {
  const Look& look = look_of(kind);
  return !(look.fold == Vec3f{1, 1, 1} && look.ridge == Vec3f{1, 1, 1});
}

Vec3f scatter_mm(MaterialKind kind) {
  return look_of(kind).scatter;
}

float shadow_offset_mm(MaterialKind kind) {
  return 0.02f + 0.25f * look_of(kind).scatter.x;
}

bool self_lit(MaterialKind kind) {
  return kind == MaterialKind::line;
}

Vec3f albedo_at(const Material& material, const Vec3f* point_colour, float curvature, bool back) {
  const Look& look = look_of(material.kind);
  Vec3f albedo = point_colour ? *point_colour : own_colour(material.kind) ? material.colour : look.albedo;
  const float fold = std::clamp(-7 * curvature, 0.0f, 1.0f),
              ridge = std::clamp(8 * (curvature - 0.04f), 0.0f, 1.0f);
  albedo = times(albedo, lerp(Vec3f{1, 1, 1}, look.fold, fold));
  albedo = times(albedo, lerp(Vec3f{1, 1, 1}, look.ridge, ridge));
  return back && has_inside(material.kind) ? albedo * 0.45f : albedo;
}

Vec3f irradiance(const Surfel& surfel, const Material& material, const Exposure& exposure,
                 const Lights& lights) {
  if (material.kind == MaterialKind::plain) return plain_irradiance(surfel, exposure, lights);
  const Look& look = look_of(material.kind);
  const Vec3f& n = surfel.normal;
  Vec3f sum = times(lights.key_colour, wrapped_cosine(dot(n, lights.key), look.wrap)) * exposure.key;
  // Broad lights are seen as far as the open part of the hemisphere leans to them.
  for (const BroadLight& light : lights.broad) {
    const float seen =
        std::clamp(dot(exposure.open, light.direction) * 1.5f + 0.5f * exposure.sky, 0.0f, 1.0f);
    sum += times(light.colour, wrapped_cosine(dot(n, light.direction), look.wrap)) * seen;
  }
  const Vec3f open = normalized(exposure.open + n * 0.05f);
  const Vec3f ambient = lerp(lights.floor, lights.sky, 0.5f + 0.5f * dot(open, lights.up));
  const Vec3f bounced{with_bounces(exposure.sky, surfel.albedo.x),
                      with_bounces(exposure.sky, surfel.albedo.y),
                      with_bounces(exposure.sky, surfel.albedo.z)};
  return sum + times(ambient, bounced);
}

Vec3f outgoing(const Surfel& surfel, const Material& material, const Vec3f& scattered_irradiance,
               const Exposure& exposure, const Lights& lights, const Vec3f& to_viewer) {
  if (surfel.self_lit) return surfel.albedo;
  const Look& look = look_of(material.kind);
  Vec3f colour = times(surfel.albedo, scattered_irradiance);
  if (material.kind == MaterialKind::plain) colour += scattered_irradiance * plain_sheen;
  const Vec3f& n = surfel.normal;
  const float open = exposure.sky * exposure.sky;
  if (material.kind == MaterialKind::glossy) {
    const auto shine = [&](const Vec3f& light) { return phong(n, to_viewer, light, material.exponent); };
    Vec3f sum = lights.key_colour * (shine(lights.key) * exposure.key);
    for (const BroadLight& light : lights.broad) sum += light.colour * (shine(light.direction) * open);
    colour += times(material.highlight, sum);
  }
  if (look.gloss > 0 && !surfel.back) {
    const auto broad = [&](const Vec3f& light) {
      return look.gloss * highlight(Glance(n, to_viewer, light, look.f0), look.roughness);
    };
    if (exposure.key > 0) {
      const Glance key(n, to_viewer, lights.key, look.f0);
      const float both =
          look.gloss * highlight(key, look.roughness) + look.coat * highlight(key, look.coat_roughness);
      colour += lights.key_colour * (both * exposure.key);
    }
    for (const BroadLight& light : lights.broad) colour += light.colour * (broad(light.direction) * open);
    // Reflection of the sky, growing towards grazing angles.
    const float grazing = 1 - std::max(dot(n, to_viewer), 0.0f), g2 = grazing * grazing;
    const float fresnel = look.f0 + (0.5f - look.roughness) * g2 * g2 * grazing;
    colour += lights.sky * (0.4f * fresnel * open * (look.gloss + look.coat));
  }
  return tone(colour);
}

}  // namespace turgor::render_detail
