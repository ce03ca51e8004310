// What surfaces look like under their lights: looks of materials, irradiance, highlights, tone.
#pragma once

#include <vector>

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
  bool self_lit = false;   ///< shows its colour without light

  [[nodiscard]] bool hit() const { return surface != 0xFFFFFFFFu; }
  /// Whether it shows, and needs light for it.
  [[nodiscard]] bool takes_light() const { return hit() && !concealed && !self_lit; }
};

/// What shadow rays found at a point.
struct Exposure {
  float key = 0;  ///< share of the key light that is seen
  float sky = 0;  ///< cosine-weighted share of the hemisphere that is open
  Vec3f open{};   ///< mean of the open directions (length at most 1)
};

/// A light so wide that only the open share of the hemisphere dims it.
struct BroadLight {
  Vec3f direction;  ///< to the light
  Vec3f colour;
};

/// The key light, which casts shadows, broad lights, and light from all around.
struct Lights {
  Vec3f key, key_u, key_v;  ///< direction to the light, and the axes of its disc
  Vec3f key_colour;
  float key_radius = 0;  ///< tangent of the half angle of the disc
  std::vector<BroadLight> broad;
  Vec3f sky, floor;  ///< light from above and below
  Vec3f right, up, toward_viewer;

  /// Key above to one side of the viewer, fill from the other, two rims from behind, sky above; turning with
  /// the camera, so that all views of a patient are lit alike.
  static Lights studio(const CameraFrame& camera);
  /// Those given, at least one, the strongest as the key.
  static Lights of_scene(const CameraFrame& camera, const std::vector<DirectionalLight>& lights);
  /// Direction to a point of the key light's disc; (u, v) in the unit disc.
  [[nodiscard]] Vec3f key_direction(float u, float v) const;

 private:
  static Lights facing(const CameraFrame& camera);
  void set_key(const Vec3f& direction, const Vec3f& colour, float radius);
};

/// Whether folds and ridges of the material have colours of their own.
bool shows_curvature(MaterialKind kind);
/// Whether the material shows its colour without light, and casts no shadow.
bool self_lit(MaterialKind kind);
/// Mean distance light travels under the surface by channel, mm (zero: none).
Vec3f scatter_mm(MaterialKind kind);
/// Offset of shadow rays off the surface, mm: light enters a scattering medium around the point, not at it.
float shadow_offset_mm(MaterialKind kind);

/// Diffuse reflectance where the surface has the given mean curvature (1/mm): folds are deeper in colour.
Vec3f albedo_at(const Material& material, const Vec3f* point_colour, float curvature, bool back);

Vec3f irradiance(const Surfel& surfel, const Material& material, const Exposure& exposure,
                 const Lights& lights);
/// Outgoing light: albedo times (scattered) irradiance, plus highlights, through the tone curve.
Vec3f outgoing(const Surfel& surfel, const Material& material, const Vec3f& scattered_irradiance,
               const Exposure& exposure, const Lights& lights, const Vec3f& to_viewer);

}  // namespace turgor::render_detail
