// A picture of where a surface is open.
#pragma once

#include <vector>

#include "turgor/core/context.hpp"
#include "turgor/geometry/surface_holes.hpp"
#include "turgor/geometry/tri_mesh.hpp"
#include "turgor/render/camera.hpp"
#include "turgor/render/image.hpp"

namespace turgor {

struct LeakPictureOptions {
  int size = 720;    ///< pixels, of each of the two panels; 64 to 4096
  int samples = 16;  ///< rays a pixel
};

/// The side from which most of the hole's lid is seen, and most squarely, past the rest of the surface: a
/// unit vector to the viewer.
Vec3 best_view(const TriMesh& surface, const SurfaceHole& hole);

/// The whole surface from the best side, and the widest hole from near. The rim of the widest is drawn in
/// red, through whatever stands before it, and its lid as a red film; the rims of the others are orange.
/// Errors: no hole; a size or samples beyond their limits; those of Renderer::create.
Result<Image> leak_picture(const TriMesh& surface, const std::vector<SurfaceHole>& holes,
                           const LeakPictureOptions& options, Context& context);

}  // namespace turgor
