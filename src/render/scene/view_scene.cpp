#include "render/scene/view_scene.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "render/scene/rods.hpp"
#include "turgor/geometry/subdivide.hpp"

namespace turgor::render_detail {
namespace {

constexpr double picture_height_mm = 240;
/// Beyond this from the target, in picture heights, single precision no longer tells points of a picture
/// apart.
constexpr double farthest_mm = 1e5 * picture_height_mm;
constexpr std::size_t most_lines = 1'000'000;
/// Refinement stops before it makes more corners than this.
constexpr std::size_t most_corners = 1'000'000;

Error bad(std::string what, std::string where, std::string remedy) {
  return {ErrorKind::bad_input, std::move(what), std::move(where), std::move(remedy)};
}

std::string place_of(const Object& object) {
  return "object '" + object.name + "'";
}

/// An eye at the camera's origin that looks along its −z axis with +y up.
Result<CameraView> camera_of(const Scene& scene, const Viewport& viewport) {
  const std::string where = "viewport '" + viewport.name + "'";
  const Object* object = scene.find(viewport.camera);
  if (!object)
    return bad("there is no camera '" + viewport.camera + "'", where,
               "Give the viewport a camera that exists");
  const auto* lens = std::get_if<CameraLens>(&object->description);
  if (!lens) return bad("'" + viewport.camera + "' is not a camera", where, "Give the viewport a camera");
  CameraView view;
  const Vec3 forward = normalized(object->transform.direction({0, 0, -1}));
  view.eye = object->transform.point({});
  view.target = view.eye + forward * lens->target_distance;
  view.up = object->transform.direction({0, 1, 0});
  view.fov_deg = lens->fov_deg;
  view.height_mm = lens->height;
  if (!(lens->target_distance > 0))
    return bad("the camera's target is not in front of it", place_of(*object), "Give a distance above 0");
  if (auto frame = camera_frame(view); !frame) {
    Error error = frame.error();
    error.where = place_of(*object);
    return error;
  }
  return view;
}

/// From the world to the coordinates of the view.
struct ViewUnits {
  Vec3 target;
  double scale = 1;

  [[nodiscard]] Vec3 point(const Vec3& p) const { return (p - target) * scale; }
};

class Builder {
 public:
  Builder(const ViewUnits& units, DrawStyle style, RodSet rods, int curved_levels)
      : units_(units), style_(style), curved_levels_(curved_levels), rods_(std::move(rods)) {}

  Result<void> add(const Object& object) {
    Polyhedron shape = world_polyhedron(object);
    for (Vec3& p : shape.points) {
      p = units_.point(p);
      if (!(length(p) < farthest_mm))
        return bad("the object reaches too far from what the camera looks at to be drawn", place_of(object),
                   "Move or scale it, or hide it");
    }
    Drawn drawn = drawn_shape(std::move(shape), object);
    TURGOR_CHECK(add_lines(drawn, object));
    if (style_ == DrawStyle::shaded && drawn.surface.polygon_count() > 0 && object.optics.opacity > 0)
      add_faces(drawn.surface, object.optics);
    return {};
  }

  void finish(ViewScene& view) {
    view.meshes = std::move(meshes_);
    for (std::size_t i = 0; i < materials_.size(); ++i)
      view.bodies.push_back({&view.meshes[i], materials_[i], {}});
    for (const auto& [colour, mesh] : rods_.by_colour()) {
      if (mesh.empty()) continue;
      view.meshes.push_back(mesh);
      view.bodies.push_back(
          {&view.meshes.back(), {MaterialKind::line, Vec3f{colour[0], colour[1], colour[2]}}, {}});
    }
  }

 private:
  /// A surface, and which of its edges stand for those of the object's polygons.
  struct Drawn {
    Polyhedron surface;
    std::vector<Edge> wires;
  };

  Drawn drawn_shape(Polyhedron&& shape, const Object& object) const {
    Drawn drawn{std::move(shape), {}};
    const bool wires = style_ == DrawStyle::wire || object.optics.wire.has_value();
    if (object.optics.curved) refine(drawn, wires);
    if (object.triangulated) {
      Polyhedron triangles = to_polyhedron(triangulated(drawn.surface));
      triangles.lines = std::move(drawn.surface.lines);
      drawn.surface = std::move(triangles);
    }
    if (wires && drawn.wires.empty()) drawn.wires = edges(drawn.surface);
    return drawn;
  }

  /// Refines level by level, so that the edges of the object's own polygons can be followed over the smooth
  /// surface: corner k of a polygon becomes the quadrilateral of that corner, the middle of the edge to the
  /// next one, the polygon's centre, and the middle of the edge from the one before.
  void refine(Drawn& drawn, bool wires) const {
    std::vector<Edge> kept = wires ? edges(drawn.surface) : std::vector<Edge>{};
    for (int level = 0; level < curved_levels_ && 4 * drawn.surface.corners.size() <= most_corners; ++level) {
      Polyhedron fine = subdivided(drawn.surface, 1);
      if (fine.points.size() == drawn.surface.points.size()) break;  // nothing to refine
      std::vector<Edge> halves = fine.lines;
      for (int i = 0, corner = 0; i < drawn.surface.polygon_count(); ++i) {
        const auto polygon = drawn.surface.polygon(i);
        for (std::size_t k = 0; k < polygon.size(); ++k, ++corner) {
          const auto [low, high] = std::minmax(polygon[k], polygon[(k + 1) % polygon.size()]);
          if (!std::binary_search(kept.begin(), kept.end(), Edge{low, high})) continue;
          const int middle = fine.polygon(corner)[1];
          halves.push_back({low, middle});
          halves.push_back({high, middle});
        }
      }
      kept = wires ? unique(std::move(halves)) : kept;
      drawn.surface = std::move(fine);
    }
    drawn.wires = std::move(kept);
  }

  static std::vector<Edge> unique(std::vector<Edge> all) {
    for (Edge& e : all)
      if (e[0] > e[1]) std::swap(e[0], e[1]);
    std::sort(all.begin(), all.end());
    all.erase(std::unique(all.begin(), all.end()), all.end());
    return all;
  }

  Result<void> add_lines(const Drawn& drawn, const Object& object) {
    const Optics& o = object.optics;
    const std::vector<Edge>& segments = drawn.wires.empty() ? drawn.surface.lines : drawn.wires;
    lines_ += segments.size();
    if (lines_ > most_lines)
      return bad("more than a million lines cannot be drawn", place_of(object), "Hide some objects");
    rods_.add(drawn.surface.points, segments, o.wire.value_or(o.diffuse), o.line_width);
    return {};
  }

  void add_faces(const Polyhedron& surface, const Optics& o) {
    TriMesh mesh = o.shading == Shading::faceted ? facets(surface) : triangulated(surface);
    if (mesh.empty()) return;
    meshes_.push_back(std::move(mesh));
    Material material{MaterialKind::glossy, o.diffuse, o.opacity};
    material.highlight = o.highlight;
    material.exponent = o.specular;
    materials_.push_back(material);
  }

  /// Each polygon with points of its own, so that no normal is shared across an edge.
  static TriMesh facets(const Polyhedron& surface) {
    Polyhedron apart;
    for (int i = 0; i < surface.polygon_count(); ++i) {
      std::vector<int> corners;
      for (const int p : surface.polygon(i)) {
        corners.push_back(static_cast<int>(apart.points.size()));
        apart.points.push_back(surface.points[static_cast<std::size_t>(p)]);
      }
      apart.add_polygon(corners);
    }
    return triangulated(apart);
  }

  ViewUnits units_;
  DrawStyle style_;
  int curved_levels_;
  RodSet rods_;
  std::size_t lines_ = 0;
  std::deque<TriMesh> meshes_;
  std::vector<Material> materials_;  ///< of `meshes_`
};

Result<DirectionalLight> lamp_of(const Object& object, const Light& light) {
  const Vec3 along = object.transform.direction({0, 0, -1});
  const Vec3f colour = light.colour * static_cast<float>(light.strength);
  if (!is_finite(normalized(along)) || !(length(normalized(along)) > 0.5) || !is_finite(colour))
    return bad("the light's direction or colour is not usable", place_of(object), "Give finite numbers");
  return DirectionalLight{along, colour};
}

/// Where a world has no lamp: a key above to the viewer's left, which shows form better than one from the
/// front, and a weak fill from the right. White, so that a white floor is white.
std::vector<DirectionalLight> studio(const CameraFrame& frame) {
  const auto from = [&](double right, double up, double toward_viewer) {
    return frame.forward * toward_viewer - frame.right * right - frame.up * up;
  };
  constexpr float key = 0.92f, fill = 0.16f;
  return {{from(-0.75, 0.95, 0.55), {key, key, key}}, {from(0.9, 0.1, 0.8), {fill, fill, fill}}};
}

}  // namespace

Result<ViewScene> view_scene(const Scene& scene, const Viewport& viewport, int height,
                             const ScenePictureOptions& options) {
  const World* world = scene.find_world(viewport.world);
  if (!world)
    return bad("there is no world '" + viewport.world + "'", "viewport '" + viewport.name + "'",
               "Give the viewport a world that exists");
  ViewScene view;
  TURGOR_TRY(view.camera, camera_of(scene, viewport));
  TURGOR_TRY(const CameraFrame frame, camera_frame(view.camera));
  const ViewUnits units{view.camera.target, picture_height_mm / frame.height_mm};
  view.camera.eye = units.point(view.camera.eye);
  view.camera.target = {};
  view.camera.height_mm = picture_height_mm;
  const double radius = 0.5 * options.line_pixels * picture_height_mm / height;
  const Vec3 depth = view.camera.fov_deg > 0 ? frame.forward / length(view.camera.eye) : Vec3{};
  Builder builder(units, viewport.style, {radius, depth}, options.curved_levels);
  for (const std::string& name : world->objects) {
    const Object* object = scene.find(name);
    if (!object || !object->visible) continue;
    if (const auto* light = std::get_if<Light>(&object->description)) {
      TURGOR_TRY(DirectionalLight lamp, lamp_of(*object, *light));
      view.lights.push_back(lamp);
    } else if (object->kind() != ObjectKind::camera) {
      TURGOR_CHECK(builder.add(*object));
    }
  }
  builder.finish(view);
  if (view.lights.empty()) view.lights = studio(frame);
  return view;
}

}  // namespace turgor::render_detail
