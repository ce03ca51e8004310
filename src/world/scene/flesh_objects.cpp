#include "turgor/world/flesh_objects.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <map>

#include "turgor/core/index.hpp"
#include "turgor/geometry/surface_query.hpp"
#include "world/scene/drawing.hpp"

namespace turgor {
namespace {

// The mesh of the skin's polygons shows how it stretches and bulges. The lines of the layers within are thin,
// so that what stands behind them can be seen, and muscles and sutures stand out from both.
constexpr Vec3f kSkinColour{0.66f, 0.36f, 0.25f}, kSkinLight{0.16f, 0.15f, 0.14f},
    kSkinMesh{0.34f, 0.15f, 0.10f};
constexpr Vec3f kSmasColour{0.42f, 0.13f, 0.05f}, kBoneColour{0.16f, 0.17f, 0.20f};
constexpr Vec3f kMuscleColour{0.78f, 0.0f, 0.02f};
constexpr double kMeshWidth = 0.8, kLayerWidth = 0.6, kMuscleWidth = 2;

// Of three layers the thesis's names; others between bone and skin are counted.
std::string layer_name(int layer, int layers) {
  if (layer == layers - 1) return "skin";
  if (layer == 0) return "bone";
  return layers == 3 ? "smas" : fmt::format("layer{}", layer);
}

std::string drawing(const std::string& layer, const std::string& flesh) {
  return layer + ".face." + flesh;
}

Polyhedron skin_shape(const TissueBody& body, const std::vector<Vec3>& positions) {
  Polyhedron shape = body.flesh.surface;
  const int top = body.flesh.layers - 1;
  for (int c = 0; c < body.flesh.columns(); ++c)
    shape.points[at(c)] = positions[at(body.flesh.sample(top, c))];
  return shape;
}

// The springs within a layer, as lines.
Polyhedron layer_lines(const TissueBody& body, int layer, const std::vector<Vec3>& positions) {
  Polyhedron shape;
  const int columns = body.flesh.columns(), first = layer * columns;
  shape.points.assign(positions.begin() + first, positions.begin() + first + columns);
  const auto& springs = body.parts.network.springs;
  for (std::size_t i = 0; i < springs.size(); ++i) {
    const Spring& s = springs[i];
    if (body.parts.layer_of_spring[i] != layer) continue;
    if (s.kind != SpringKind::membrane && s.kind != SpringKind::plate) continue;
    const auto [low, high] = std::minmax({s.a - first, s.b - first});
    shape.lines.push_back({low, high});
  }
  return shape;
}

Polyhedron fibre_lines(const Specimen& specimen, const Muscle& muscle) {
  Polyhedron shape;
  for (const Fibre& fibre : muscle.fibres) {
    const int first = static_cast<int>(shape.points.size());
    shape.points.push_back(specimen.position(fibre.a));
    shape.points.push_back(specimen.position(fibre.b));
    shape.lines.push_back({first, first + 1});
  }
  return shape;
}

Polyhedron drawn_shape(const TissueBody& body, int layer, const std::vector<Vec3>& positions) {
  return layer == body.flesh.layers - 1 ? skin_shape(body, positions) : layer_lines(body, layer, positions);
}

Optics optics_of(int layer, int layers) {
  Optics optics;
  optics.highlight = kSkinLight;
  optics.specular = 20;
  optics.curved = layer == layers - 1;
  if (optics.curved) optics.wire = kSkinMesh;
  optics.diffuse = optics.curved ? kSkinColour : layer == 0 ? kBoneColour : kSmasColour;
  optics.line_width = optics.curved ? kMeshWidth : kLayerWidth;
  return optics;
}

}  // namespace

Result<void> flesh_out_object(Scene& scene, const std::string& source, const FleshOptions& options,
                              double viscosity) {
  TURGOR_TRY(const int id, scene.require(source));
  const Object& object = *scene.find(id);
  if (object.kind() != ObjectKind::polyhedron) {
    return Error{ErrorKind::bad_input, fmt::format("'{}' is a {}", source, name_of(object.kind())), "",
                 "Tissue is built on a polyhedron"};
  }
  TURGOR_TRY(Flesh flesh, flesh_out(world_polyhedron(object), options));
  TURGOR_TRY([[maybe_unused]] const int body, scene.specimen.add_flesh(source, std::move(flesh), viscosity));
  return update_flesh_objects(scene);
}

Result<void> update_flesh_objects(Scene& scene) {
  const auto& bodies = scene.specimen.bodies();
  for (std::size_t b = 1; b < bodies.size(); ++b) {
    if (bodies[b].solid) continue;
    const std::vector<Vec3> positions = scene.specimen.positions_of(bodies[b]);
    const int layers = bodies[b].flesh.layers;
    for (int layer = 0; layer < layers; ++layer) {
      const std::string name = drawing(layer_name(layer, layers), bodies[b].name);
      TURGOR_CHECK(
          show_drawing(scene, name, drawn_shape(bodies[b], layer, positions), optics_of(layer, layers)));
    }
  }
  return update_muscle_objects(scene);
}

Result<void> update_muscle_objects(Scene& scene) {
  Optics red;
  red.diffuse = kMuscleColour;
  red.line_width = kMuscleWidth;
  for (const Muscle& muscle : scene.specimen.muscles()) {
    TURGOR_CHECK(show_drawing(scene, "muscles." + muscle.name, fibre_lines(scene.specimen, muscle), red));
  }
  return {};
}

bool is_drawing(const Specimen& specimen, const std::string& name) {
  for (const Muscle& muscle : specimen.muscles()) {
    if (name == "muscles." + muscle.name) return true;
  }
  for (std::size_t b = 1; b < specimen.bodies().size(); ++b) {
    const TissueBody& body = specimen.bodies()[b];
    if (body.solid) {
      if (name == skin_drawing_of_solid(body.name) || name == mesh_drawing_of_solid(body.name)) return true;
      continue;
    }
    const int layers = body.flesh.layers;
    for (int layer = 0; layer < layers; ++layer) {
      if (name == drawing(layer_name(layer, layers), body.name)) return true;
    }
  }
  return false;
}

// ---- collisions ----

Result<Barrier> barrier_of(const Scene& scene, int object, RegionShape shape) {
  const Object& o = *scene.find(object);
  const auto wrong = [&](const char* needs) {
    return Error{ErrorKind::bad_input, fmt::format("'{}' is a {}", o.name, name_of(o.kind())), "", needs};
  };
  Barrier barrier;
  switch (shape) {
    case RegionShape::sphere: {
      const BoundingSphere sphere = world_sphere(o);
      barrier.shape = Barrier::Shape::sphere;
      barrier.centre = sphere.centre;
      barrier.radius_mm = sphere.radius;
      return barrier;
    }
    case RegionShape::plane: {
      const Vec3 normal = orientation(o).normal;
      if (!(squared_length(normal) > 0)) return wrong("Its transform flattens it: it has no normal");
      barrier.shape = Barrier::Shape::plane;
      barrier.plane = Plane::through(o.transform.point(o.transform.origin), normal);
      return barrier;
    }
    case RegionShape::depth_map: {
      const auto* map = std::get_if<DepthMap>(&o.description);
      if (map == nullptr) return wrong("This region needs a depth map");
      barrier.shape = Barrier::Shape::depth_map;
      barrier.depth_map = std::make_shared<const HeightField>(
          HeightField{map->columns, map->rows, map->heights, o.transform.linear, o.transform.point({})});
      return barrier;
    }
    case RegionShape::mesh: {
      const TriMesh mesh = triangulated(world_polyhedron(o));
      if (mesh.empty()) return wrong("This region needs a closed surface");
      if (!topology(mesh).closed()) {
        return Error{ErrorKind::bad_input, fmt::format("the surface of '{}' is not closed", o.name), "",
                     "Close it, or use its bounding sphere (-s) or plane (-p)"};
      }
      barrier.shape = Barrier::Shape::mesh;
      barrier.mesh = std::make_shared<const SurfaceQuery>(mesh);
      return barrier;
    }
  }
  return wrong("");
}

Result<void> update_collisions(Scene& scene) {
  scene.specimen.forget_collisions([&](const Collision& c) { return scene.find(c.object) == nullptr; });
  const auto& collisions = scene.specimen.collisions();
  for (std::size_t i = 0; i < collisions.size(); ++i) {
    const Object& object = *scene.find(collisions[i].object);
    if (object.transform == collisions[i].placed) continue;
    TURGOR_TRY(const Barrier shape, barrier_of(scene, collisions[i].object, collisions[i].shape));
    TURGOR_CHECK(scene.specimen.reshape_collision(i, shape, object.transform));
  }
  return {};
}

}  // namespace turgor
