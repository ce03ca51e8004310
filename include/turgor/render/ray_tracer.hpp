// Pictures of surfaces by ray tracing on the CPU: no display, no GPU.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "turgor/core/context.hpp"
#include "turgor/geometry/tri_mesh.hpp"
#include "turgor/render/annotate.hpp"
#include "turgor/render/camera.hpp"
#include "turgor/render/colour_map.hpp"
#include "turgor/render/image.hpp"

namespace turgor {

/// `plain` is matte, for colours that are to be read against a legend; the others look like what they are
/// named.
enum class MaterialKind { skin, bone, teeth, mucosa, plain };
struct Material {
  MaterialKind kind = MaterialKind::plain;
  Vec3f colour{0.8f, 0.8f, 0.8f};  ///< linear RGB; used by `plain` where point colours are absent
  /// Below 1 the body is a thin coloured film: seen by its front-most surface only, denser where seen
  /// edge-on, casting no shadow on other bodies and lit as though it stood alone.
  double opacity = 1.0;
  /// Of a translucent body: also draws its outline as a line in its colour, through whatever stands before
  /// it, except where it lies on the solid bodies. Shows where a face was that now lies below the new one.
  /// Opacity may then be 0.
  bool outline = false;
};

struct Body {
  const TriMesh* mesh = nullptr;
  Material material;
  std::vector<Vec3f> point_colours;  ///< empty, or linear RGB per point (overrides the material's colour)
};

enum class Backdrop { flat, studio };

struct RenderOptions {
  int width = 900, height = 1000;
  int samples = 16;  ///< rays a pixel where the picture has edges; light takes its share of them everywhere
  Vec3f background{1, 1, 1};
  std::uint64_t seed = 1;
  Backdrop backdrop = Backdrop::flat;  ///< `studio` darkens the background softly towards the corners
};

/// Bodies made ready for any number of pictures. Holds copies; the meshes need not outlive create().
class Renderer {
 public:
  /// Errors: a mesh that is missing, empty or not valid, colours that do not match it, opacity outside [0,
  /// 1].
  static Result<Renderer> create(const std::vector<Body>& bodies, Context& context);
  Renderer(Renderer&&) noexcept;
  Renderer& operator=(Renderer&&) noexcept;
  ~Renderer();

  /// The same bits for any number of threads. Errors: a camera without a frame, a size outside 1 … 16384 or
  /// more than 40 million pixels, samples below 1 or above 4096, a background that is not finite.
  Result<Image> render(const CameraView& camera, const RenderOptions& options, Context& context) const;

 private:
  struct Implementation;
  explicit Renderer(std::unique_ptr<Implementation> impl);
  std::unique_ptr<Implementation> impl_;
};

/// One picture: Renderer::create and render.
Result<Image> render(const std::vector<Body>& bodies, const CameraView& camera, const RenderOptions& options,
                     Context& context);

}  // namespace turgor
