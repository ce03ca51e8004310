// What surfaces look like under the studio lights: looks of materials, irradiance, highlights, tone.
#pragma once

#include "render/surface.hpp"
#include "turgor/render/camera.hpp"

namespace turgor::render_detail {

/// One visible point of a surface.
struct Surfel {
  Vec3f position, normal;  ///< normal turned to the viewer
  Vec3f lit_from;          ///< where shadow rays start
  Vec3f albedo;
  float depth = 0;  ///< along the camera ray, mm
  std::uint32_t surface = 0xFFFFFFFFu;
  bool back = false;       ///< the inside of the surface is seen
  bool concealed = false;  ///< of a translucent body, behind the solid ones

  [[nodiscard]] bool hit() const { return surface != 0xFFFFFFFFu; }
  /// Whether it shows, and so needs light.
  [[nodiscard]] bool seen() const { return hit() && !concealed; }
};

/// What shadow rays found at a point.
struct Exposure {
  float key = 0;  ///< share of the key light that is seen
  float sky = 0;  ///< cosine-weighted share of the hemisphere that is open
  Vec3f open{};   ///< mean of the open directions (length at most 1)
};

/// Key above to one side of the viewer, fill from the other, two rims from behind, sky above; turning with
/// the camera, so that all views of a patient are lit alike.
struct StudioLights {
  Vec3f key, key_u, key_v;  ///< direction to the light, and the axes of its disc
  Vec3f fill, rim_left, rim_right;
  Vec3f right, up, toward_viewer;

  static StudioLights for_camera(const CameraFrame& camera);
  /// Direction to a point of the key light's disc; (u, v) in the unit disc.
  [[nodiscard]] Vec3f key_direction(float u, float v) const;
};

/// Mean distance light travels under the surface by channel, mm (zero: none).
Vec3f scatter_mm(MaterialKind kind);
/// Offset of shadow rays off the surface, mm: light enters a scattering medium around the point, not at it.
float shadow_offset_mm(MaterialKind kind);

/// Diffuse reflectance where the surface has the given mean curvature (1/mm): folds are deeper in colour.
Vec3f albedo_at(const Material& material, const Vec3f* point_colour, float curvature, bool back);

Vec3f irradiance(const Surfel& surfel, const Material& material, const Exposure& exposure,
                 const StudioLights& lights);
/// Outgoing light: albedo times (scattered) irradiance, plus highlights, through the tone curve.
Vec3f outgoing(const Surfel& surfel, const Material& material, const Vec3f& scattered_irradiance,
               const Exposure& exposure, const StudioLights& lights, const Vec3f& to_viewer);

}  // namespace turgor::render_detail
