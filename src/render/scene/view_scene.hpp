// The objects that one viewport shows, made ready for tracing.
#pragma once

#include <deque>
#include <string>
#include <vector>

#include "turgor/render/ray_tracer.hpp"
#include "turgor/render/scene_pictures.hpp"

namespace turgor::render_detail {

/// A viewport's camera and objects in coordinates about the camera's target in which the picture there is
/// as high as that of a head: scenes have units of their own, the tracer's soft shadows are in mm.
struct ViewScene {
  CameraView camera;
  std::vector<DirectionalLight> lights;
  std::deque<TriMesh> meshes;
  std::vector<Body> bodies;  ///< of `meshes`
};

/// `height`: of the picture, pixels. Errors: no such camera or world, a camera that is none or sees nothing,
/// an object whose numbers cannot be drawn.
Result<ViewScene> view_scene(const Scene& scene, const Viewport& viewport, int height,
                             const ScenePictureOptions& options);

}  // namespace turgor::render_detail
