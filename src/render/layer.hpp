// A layer is what is lit and traced together: all solid bodies, or one translucent body. These are the steps
// from a layer to a lit picture of it.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "render/pixel_array.hpp"
#include "render/ray_scene.hpp"
#include "render/sampling.hpp"
#include "render/shading.hpp"
#include "render/surface.hpp"
#include "turgor/core/context.hpp"

namespace turgor::render_detail {

struct Layer {
  std::vector<std::uint32_t> surfaces;  ///< numbers in the renderer's list, by number in the scene
  RayScene scene;
  std::optional<RayScene> casters;  ///< what casts shadows, where that is not all
  bool translucent = false;
  Vec3f lower, upper;  ///< box of its points

  [[nodiscard]] const RayScene& shadow_scene() const { return casters ? *casters : scene; }
};

/// The camera in the renderer's own coordinates.
struct PictureCamera {
  CameraFrame frame;  ///< eye relative to the renderer's origin
  Lights lights;
  int width = 0, height = 0;
  double start = 0;    ///< camera rays begin here, mm from the eye: just before the bodies
  float pixel_mm = 1;  ///< size of a pixel at the bodies' centre

  struct Ray {
    Vec3f origin, direction;
  };
  /// Through the picture point (x, y), in pixels.
  [[nodiscard]] Ray ray(double x, double y) const;
};

/// Half-open rectangle of pixels.
struct Window {
  int x0 = 0, y0 = 0, x1 = 0, y1 = 0;

  [[nodiscard]] int width() const { return x1 - x0; }
  [[nodiscard]] int height() const { return y1 - y0; }
  [[nodiscard]] bool empty() const { return x0 >= x1 || y0 >= y1; }
  [[nodiscard]] bool contains(int x, int y) const { return x >= x0 && x < x1 && y >= y0 && y < y1; }
  [[nodiscard]] std::size_t index(int x, int y) const {
    return static_cast<std::size_t>(y - y0) * static_cast<std::size_t>(width()) +
           static_cast<std::size_t>(x - x0);
  }
};

/// What is known of a layer at each pixel's centre.
struct LayerPicture {
  Window window;
  PixelArray<Surfel> surfels;
  PixelArray<Exposure> exposure;
  PixelArray<Vec3f> irradiance;
};

/// Two bodies that share a surface (a face before and after, away from the operation) must not flicker: a
/// translucent one shows only where it stands clear in front of the solid one; fully from the second distance
/// on.
inline constexpr float clear_from_mm = 0.05f, clear_at_mm = 0.35f;

/// The pixels that the layer may touch, with a rim of one.
Window window_of(const Layer& layer, const PictureCamera& camera);

/// Fills in a surfel from a hit.
Surfel surfel_at(const std::vector<Surface>& surfaces, std::uint32_t surface, std::uint32_t triangle, float u,
                 float v, float depth, const Vec3f& direction);

struct LightSampling {
  std::uint32_t per_pixel = 4;  ///< rays to the key light, and as many to the sky; a power of two
  std::uint64_t seed = 1;
};

// Each of the following works on rows or tiles in parallel and stops early, leaving the rest undone, when the
// context is cancelled; the caller checks.

/// Camera rays through the pixels' centres.
void trace_surfels(const Layer& layer, const std::vector<Surface>& surfaces, const PictureCamera& camera,
                   LayerPicture& picture, Context& context);
/// Marks what of a translucent layer the solid one hides.
void conceal(const LayerPicture& solid, LayerPicture& film, Context& context);
/// Shadow rays, from what is seen.
void trace_exposure(const Layer& layer, const PictureCamera& camera, const LightSampling& sampling,
                    LayerPicture& picture, Context& context);
/// Exposure of one point with `lanes` rays, for points that no pixel's centre stands for.
Exposure exposure_of_point(const Layer& layer, const Surfel& surfel, const PictureCamera& camera,
                           std::uint32_t index, const LightSampling& sampling);
/// Joint bilateral filter of the exposure over 7 × 7 pixels of the same smooth piece of surface.
void filter_exposure(const PictureCamera& camera, LayerPicture& picture, Context& context);
/// Irradiance from exposure, then spread below the surface of scattering materials.
void light_surfels(const std::vector<Surface>& surfaces, const PictureCamera& camera, LayerPicture& picture,
                   Context& context);

}  // namespace turgor::render_detail
