#include "turgor/render/ray_tracer.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <string>
#include <utility>

#include "render/layer.hpp"
#include "render/resolve.hpp"

namespace turgor {

using namespace render_detail;

struct Renderer::Implementation {
  Vec3 origin;
  double radius = 0;  ///< of a ball about the origin that holds all
  std::vector<Surface> surfaces;
  std::vector<Layer> layers;  ///< the solid one first (perhaps without surfaces)
};

namespace {

constexpr int max_side = 16384;
constexpr std::int64_t max_pixels = 40'000'000;

Result<void> check_options(const RenderOptions& options) {
  const auto bad = [](std::string what, std::string remedy) {
    return Error{ErrorKind::bad_input, std::move(what), "picture options", std::move(remedy)};
  };
  const bool sides =
      options.width >= 1 && options.height >= 1 && options.width <= max_side && options.height <= max_side;
  if (!sides || static_cast<std::int64_t>(options.width) * options.height > max_pixels)
    return bad("a picture of " + std::to_string(options.width) + " by " + std::to_string(options.height) +
                   " pixels cannot be made",
               "Use sides from 1 to 16384 and at most 40 million pixels");
  if (options.samples < 1 || options.samples > 4096)
    return bad(std::to_string(options.samples) + " samples a pixel are outside 1 to 4096", "Use 16 or so");
  if (options.light_rays < 0 || options.light_rays > 256)
    return bad(std::to_string(options.light_rays) + " light rays a pixel are outside 0 to 256", "Use 0");
  if (!is_finite(options.background)) return bad("the background is not a finite colour", "Give linear RGB");
  for (const DirectionalLight& light : options.lights)
    if (!is_finite(light.colour) || !is_finite(normalized(light.shines_along)) ||
        !(length(normalized(light.shines_along)) > 0.5))
      return bad("a light's direction or colour is not usable", "Give a direction and linear RGB");
  return {};
}

Box3 box_of(const std::vector<Body>& bodies) {
  Box3 box;
  for (const Body& body : bodies)
    if (body.mesh)
      for (const Vec3& p : body.mesh->points)
        if (is_finite(p)) box.extend(p);
  return box;
}

Result<Layer> make_layer(const std::vector<Surface>& surfaces, std::vector<std::uint32_t> members,
                         bool translucent) {
  std::vector<SceneSurface> parts, casters;
  Vec3f lower{0, 0, 0}, upper{0, 0, 0};
  bool first = true;
  for (const std::uint32_t m : members) {
    parts.push_back({&surfaces[m].points, &surfaces[m].triangles});
    if (!self_lit(surfaces[m].material.kind)) casters.push_back(parts.back());
    for (const Vec3f& p : surfaces[m].points) {
      if (first) lower = upper = p, first = false;
      for (int k = 0; k < 3; ++k) lower[k] = std::min(lower[k], p[k]), upper[k] = std::max(upper[k], p[k]);
    }
  }
  TURGOR_TRY(RayScene scene, RayScene::build(parts));
  Layer layer{std::move(members), std::move(scene), std::nullopt, translucent, lower, upper};
  if (casters.size() == parts.size()) return layer;
  TURGOR_TRY(layer.casters, RayScene::build(casters));
  return layer;
}

PictureCamera picture_camera(const CameraFrame& frame, const Vec3& origin, double radius,
                             const RenderOptions& options) {
  PictureCamera camera;
  camera.frame = frame;
  camera.frame.eye = frame.eye - origin;
  camera.lights = options.lights.empty() ? Lights::studio(frame) : Lights::of_scene(frame, options.lights);
  camera.width = options.width;
  camera.height = options.height;
  const double ahead = -dot(camera.frame.eye, frame.forward);  // depth of the bodies' centre
  const double gap = frame.fov_deg > 0 ? length(camera.frame.eye) : ahead;
  camera.start = std::max(0.0, gap - radius - 1);
  const double depth = frame.fov_deg > 0 ? std::max(ahead, 1e-3 * frame.target_distance) : ahead;
  camera.pixel_mm = static_cast<float>(camera.frame.pixel_mm(depth, options.height));
  return camera;
}

void light_layer(const Layer& layer, const std::vector<Surface>& surfaces, const PictureCamera& camera,
                 const LightSampling& sampling, const LayerPicture* solid, LayerPicture& picture,
                 Context& context) {
  if (layer.surfaces.empty()) return;
  picture.window = window_of(layer, camera);
  if (picture.window.empty()) return;
  const std::size_t pixels =
      static_cast<std::size_t>(picture.window.width()) * static_cast<std::size_t>(picture.window.height());
  picture.surfels = PixelArray<Surfel>(pixels);
  picture.exposure = PixelArray<Exposure>(pixels);
  trace_surfels(layer, surfaces, camera, picture, context);
  if (solid) conceal(*solid, picture, context);
  trace_exposure(layer, camera, sampling, picture, context);
  filter_exposure(camera, picture, context);
  light_surfels(surfaces, camera, picture, context);
}

}  // namespace

Renderer::Renderer(std::unique_ptr<Implementation> impl) : impl_(std::move(impl)) {}
Renderer::Renderer(Renderer&&) noexcept = default;
Renderer& Renderer::operator=(Renderer&&) noexcept = default;
Renderer::~Renderer() = default;

Result<Renderer> Renderer::create(const std::vector<Body>& bodies, Context& context) {
  auto impl = std::make_unique<Implementation>();
  const Box3 box = box_of(bodies);
  if (!box.empty()) {
    impl->origin = box.centre();
    impl->radius = length(box.size()) / 2;
  }
  std::vector<std::uint32_t> solid;
  std::vector<std::vector<std::uint32_t>> films;
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    TURGOR_CHECK(context.check());
    TURGOR_TRY(Surface surface, prepare_surface(bodies[i], i + 1, impl->origin));
    const auto number = static_cast<std::uint32_t>(impl->surfaces.size());
    if (surface.material.opacity >= 1)
      solid.push_back(number);
    else
      films.push_back({number});
    impl->surfaces.push_back(std::move(surface));
  }
  TURGOR_TRY(Layer base, make_layer(impl->surfaces, std::move(solid), false));
  impl->layers.push_back(std::move(base));
  for (auto& film : films) {
    TURGOR_CHECK(context.check());
    TURGOR_TRY(Layer layer, make_layer(impl->surfaces, std::move(film), true));
    impl->layers.push_back(std::move(layer));
  }
  return Renderer(std::move(impl));
}

Result<Image> Renderer::render(const CameraView& view, const RenderOptions& options, Context& context) const {
  TURGOR_CHECK(check_options(options));
  TURGOR_TRY(const CameraFrame frame, camera_frame(view));
  const PictureCamera camera = picture_camera(frame, impl_->origin, impl_->radius, options);
  LightSampling sampling;
  const auto rays =
      static_cast<std::uint32_t>(options.light_rays > 0 ? options.light_rays : options.samples / 8);
  sampling.per_pixel = std::clamp(std::bit_floor(rays), 1u, 256u);
  sampling.seed = options.seed;

  std::vector<LayerPicture> pictures(impl_->layers.size());
  for (std::size_t l = 0; l < impl_->layers.size(); ++l) {
    light_layer(impl_->layers[l], impl_->surfaces, camera, sampling, l > 0 ? &pictures[0] : nullptr,
                pictures[l], context);
    TURGOR_CHECK(context.check());
  }
  Image image = filled_image(options.width, options.height, options.background);
  resolve({impl_->surfaces, impl_->layers, pictures, camera, options, sampling}, image, context);
  TURGOR_CHECK(context.check());
  return image;
}

Result<Image> render(const std::vector<Body>& bodies, const CameraView& camera, const RenderOptions& options,
                     Context& context) {
  TURGOR_TRY(const Renderer renderer, Renderer::create(bodies, context));
  return renderer.render(camera, options, context);
}

}  // namespace turgor
