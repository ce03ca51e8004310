// From lit layers to pixels: edges by more rays, translucent layers over solid ones, background, sRGB.
#pragma once

#include <vector>

#include "render/layer.hpp"

namespace turgor::render_detail {

struct ResolveInput {
  const std::vector<Surface>& surfaces;
  const std::vector<Layer>& layers;
  const std::vector<LayerPicture>& pictures;  ///< by layer
  const PictureCamera& camera;
  const RenderOptions& options;
  const LightSampling& sampling;
};

/// How strongly the outline of translucent layer `layer` is drawn at a pixel, 0 to 1.
float outline_at(const ResolveInput& input, std::size_t layer, int x, int y);

/// Stops early, leaving the rest undone, when the context is cancelled; the caller checks.
void resolve(const ResolveInput& input, Image& image, Context& context);

}  // namespace turgor::render_detail
