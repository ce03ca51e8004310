#include "turgor/world/solid_objects.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "turgor/core/index.hpp"
#include "world/scene/drawing.hpp"
#include "world/scene/transforms.hpp"

namespace turgor {
namespace {

constexpr Vec3f kMeshLines{0.10f, 0.10f, 0.12f};

Polyhedron boundary(const SolidMesh& mesh, std::span<const Vec3> positions) {
  TriMesh surface{{positions.begin(), positions.end()},
                  {mesh.surface_triangles.begin(), mesh.surface_triangles.end()}};
  std::vector<bool> all(surface.triangles.size(), true);
  return to_polyhedron(submesh(surface, all));
}

}  // namespace

Result<void> voxelize_object(Scene& scene, const std::string& source, const SolidOptions& options,
                             const Context& context) {
  TURGOR_TRY(const int id, scene.require(source));
  const Object& object = *scene.find(id);
  if (object.kind() != ObjectKind::polyhedron) {
    return Error{ErrorKind::bad_input, fmt::format("'{}' is a {}", source, name_of(object.kind())), "",
                 "A solid is made of a polyhedron"};
  }
  TURGOR_TRY(SolidPart part, make_solid_part(triangulated(world_polyhedron(object)), options, context));
  const Optics looks = object.optics;
  TURGOR_TRY(const int body, scene.specimen.add_solid(source, std::move(part)));
  scene.set_visible(id, false);
  const TissueBody& made = scene.specimen.bodies()[at(body)];
  Optics lines = looks;
  lines.shading = Shading::faceted;
  lines.wire = kMeshLines;
  const auto& mesh = made.solid->mesh;
  TURGOR_CHECK(show_drawing(scene, skin_drawing_of_solid(source), to_polyhedron(made.solid->skin), looks));
  TURGOR_CHECK(show_drawing(scene, mesh_drawing_of_solid(source), boundary(mesh, mesh.points), lines));
  scene.set_visible(scene.id_of(mesh_drawing_of_solid(source)), false);
  return {};
}

Result<void> update_solid_objects(Scene& scene) {
  for (const TissueBody& body : scene.specimen.bodies()) {
    if (!body.solid) continue;
    const std::vector<Vec3> positions = scene.specimen.positions_of(body);
    const auto update = [&](const std::string& name, auto&& shape) {
      const int id = scene.id_of(name);
      // A hidden one is brought up to date when it is shown.
      if (id >= 0 && scene.find(id)->visible) scene.set_description(id, shape());
    };
    update(skin_drawing_of_solid(body.name), [&] { return to_polyhedron(body.solid->shown(positions)); });
    update(mesh_drawing_of_solid(body.name), [&] { return boundary(body.solid->mesh, positions); });
  }
  return {};
}

void update_holds(Scene& scene, double duration) {
  Specimen& specimen = scene.specimen;
  specimen.forget_attachments([&](const Attachment& a) { return scene.find(a.object) == nullptr; });
  for (const Attachment& a : specimen.attachments()) specimen.lead(a, scene.pose(a.object), duration);
  const std::vector<NamedGrab> grabs = specimen.grabs();
  for (NamedGrab grab : grabs) {
    if (!grab.object) continue;
    if (scene.find(*grab.object) == nullptr) {
      grab.object.reset();
    } else {
      grab.target = scene.pose(*grab.object).point(grab.place);
    }
    // The same grab elsewhere: it cannot fail where the target is finite, and stays as it was where not.
    (void)specimen.set_grab(std::move(grab));
  }
}

Result<Vec3> place_in_frame(const Scene& scene, int object, const Vec3& point) {
  const ObjectTransform back = inverse(scene.pose(object));
  if (!is_finite(back)) {
    return Error{ErrorKind::bad_input, "is flat: nothing can keep a place in it", scene.find(object)->name,
                 "Scale it"};
  }
  return back.point(point);
}

std::vector<SolidMeasures> measure_solids(const Specimen& specimen) {
  std::vector<SolidMeasures> out;
  for (const TissueBody& body : specimen.bodies()) {
    if (!body.solid) continue;
    const SolidMesh& mesh = body.solid->mesh;
    const std::vector<Vec3> x = specimen.positions_of(body);
    SolidMeasures m;
    m.name = body.name;
    m.points = body.count;
    m.tetrahedra = static_cast<int>(mesh.tetrahedra.size());
    m.fixed = static_cast<int>(std::count(body.solid->mobile.begin(), body.solid->mobile.end(), char{0}));
    for (const auto& t : mesh.tetrahedra) {
      const double v = signed_volume(x[at(t[0])], x[at(t[1])], x[at(t[2])], x[at(t[3])]);
      m.volume += v;
      m.rest_volume += signed_volume(mesh.points[at(t[0])], mesh.points[at(t[1])], mesh.points[at(t[2])],
                                     mesh.points[at(t[3])]);
      if (v <= 0) ++m.inverted;
    }
    for (std::size_t i = 0; i < x.size(); ++i) {
      m.box.extend(x[i]);
      m.greatest_displacement = std::max(m.greatest_displacement, distance(x[i], mesh.points[i]));
      m.greatest_speed = std::max(m.greatest_speed, length(specimen.state().velocity[at(body.offset) + i]));
    }
    out.push_back(std::move(m));
  }
  return out;
}

}  // namespace turgor
