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

/// `plain` is matte, for colours that are to be read against a legend. `glossy` has a highlight (Phong 1975)
/// and the same colour on both sides, for the objects of scenes. `line` is for thin rods: its colour shows as
/// it is, without light, and it casts no shadow. The others look like what they are named.
enum class MaterialKind { skin, bone, teeth, mucosa, plain, glossy, line };
struct Material {
  MaterialKind kind = MaterialKind::plain;
  /// Linear RGB; used by `plain`, `glossy` and `line` where point colours are absent.
  Vec3f colour{0.8f, 0.8f, 0.8f};
  /// Below 1 the body is a thin coloured film: seen by its front-most surface only, denser where seen
  /// edge-on, casting no shadow on other bodies and lit as though it stood alone.
  double opacity = 1.0;
  /// Of a translucent body: also draws its outline as a line in its colour, through whatever stands before
  /// it, except where it lies on the solid bodies. Shows where a face was that now lies below the new one.
  /// Opacity may then be 0.
  bool outline = false;
  Vec3f highlight{0.3f, 0.3f, 0.3f};  ///< of `glossy`: colour of the highlight, linear RGB
  double exponent = 32;               ///< of `glossy`: of the cosine, ≥ 0; larger is sharper
};

struct Body {
  const TriMesh* mesh = nullptr;
  Material material;
  std::vector<Vec3f> point_colours;  ///< empty, or linear RGB per point (overrides the material's colour)
};

enum class Backdrop { flat, studio };

/// A far lamp.
struct DirectionalLight {
  Vec3 shines_along;      ///< from the lamp, any length
  Vec3f colour{1, 1, 1};  ///< linear RGB; 1 lights white paper at right angles fully
};

struct RenderOptions {
  int width = 900, height = 1000;
  int samples = 16;    ///< rays a pixel where the picture has edges; light takes its share of them everywhere
  int light_rays = 0;  ///< to each kind of light, a pixel, rounded down to a power of two; 0: samples / 8
  Vec3f background{1, 1, 1};
  std::uint64_t seed = 1;
  Backdrop backdrop = Backdrop::flat;  ///< `studio` darkens the background softly towards the corners
  /// In place of the studio's, with a weak even light about them. The strongest casts soft shadows, the
  /// others are dimmed where surfaces stand close. `plain` bodies keep their even light.
  std::vector<DirectionalLight> lights;
};

/// Bodies made ready for any number of pictures. Holds copies; the meshes need not outlive create().
class Renderer {
 public:
  /// Errors: a mesh that is missing, empty or not valid, colours that do not match it, opacity outside [0,
  /// 1], a highlight that is not finite.
  static Result<Renderer> create(const std::vector<Body>& bodies, Context& context);
  Renderer(Renderer&&) noexcept;
  Renderer& operator=(Renderer&&) noexcept;
  ~Renderer();

  /// The same bits for any number of threads. Errors: a camera without a frame, a size outside 1 … 16384 or
  /// more than 40 million pixels, samples below 1 or above 4096, light
  /// rays outside 0 to 256, a background or light that is not finite.
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
