// The thesis's scene: a sheet of tissue over a ball on a floor with grid lines, its layers as lines below.
#pragma once

#include <cmath>
#include <string>
#include <utility>

#include "turgor/world/object_constraints.hpp"
#include "turgor/world/object_file.hpp"
#include "turgor/world/scene.hpp"

namespace turgor::render_tests {

/// Height over the floor of a cloth over a ball of radius ½ that stands on it: cap, then folds that hang.
inline double drape(double x, double y) {
  const double r = std::hypot(x, y), angle = std::atan2(y, x), edge = 0.47, over = 0.515;
  if (r < edge) return 0.5 + std::sqrt(over * over - r * r);
  const double at_edge = 0.5 + std::sqrt(over * over - edge * edge);
  const double out = r - edge, sway = 1 + 0.22 * std::cos(8 * angle) * std::min(1.0, out / 0.3);
  return 0.04 + (at_edge - 0.04) * std::exp(-3.2 * out * sway - 4 * out * out);
}

inline Object primitive(const std::string& shape, const std::string& name) {
  auto object = make_primitive(shape);
  Object out = object ? *std::move(object) : Object{};
  out.name = name;
  return out;
}

/// The lines of `layers` layers under a sheet of points × points, and of the columns between them.
inline Polyhedron springs_under(const Polyhedron& sheet, int points, int layers) {
  Polyhedron net;
  const auto normals = vertex_normals(sheet);
  const int count = static_cast<int>(sheet.points.size());
  for (int layer = 0; layer <= layers; ++layer)
    for (int i = 0; i < count; ++i) {
      const auto at = static_cast<std::size_t>(i);
      net.points.push_back(sheet.points[at] - normals[at] * (0.05 * layer));
      if (layer == 0) continue;
      const int here = layer * count + i;
      net.lines.push_back({here - count, here});
      if (i % points + 1 < points) net.lines.push_back({here, here + 1});
      if (i + points < count) net.lines.push_back({here, here + points});
    }
  return net;
}

/// With `points` along each side of the sheet, seen by the scene's first camera. False where the scene does
/// not let one of them in.
inline bool add_draped_scene(Scene& scene, int points, int layers) {
  Object floor = primitive("grid.17.17", "floor");
  floor.transform.linear = {{Vec3{5, 0, 0}, Vec3{0, 5, 0}, Vec3{0, 0, 1}}};
  floor.optics.diffuse = {0.86f, 0.86f, 0.86f};
  floor.optics.highlight = {0, 0, 0};
  floor.optics.wire = Vec3f{0.36f, 0.38f, 0.42f};
  Object ball = primitive("sphere", "ball");
  ball.transform.translation = {0, 0, 0.5};
  ball.optics.diffuse = {0.55f, 0.06f, 0.05f};
  ball.optics.specular = 60;
  Object skin = primitive("grid." + std::to_string(points) + "." + std::to_string(points), "skin");
  auto& sheet = std::get<Polyhedron>(skin.description);
  for (Vec3& p : sheet.points) p = {1.7 * p.x, 1.7 * p.y, drape(1.7 * p.x, 1.7 * p.y)};
  skin.optics.diffuse = {0.74f, 0.43f, 0.31f};
  skin.optics.highlight = {0.12f, 0.11f, 0.1f};
  skin.optics.specular = 24;
  Object springs;
  springs.name = "springs";
  springs.description = springs_under(sheet, points, layers);
  springs.optics.diffuse = {0.02f, 0.12f, 0.4f};
  bool all = true;
  for (Object* o : {&floor, &ball, &skin, &springs}) all = scene.add_object(std::move(*o)) && all;
  const Vec3 eye{2.2, -3.4, 2.0}, target{0, 0, 0.42};
  const int camera = scene.id_of("camera");
  scene.set_description(camera, CameraLens{32, 1, distance(eye, target)});
  if (const auto place = look_at(eye, target, {0, 0, 1})) scene.set_transform(camera, *place);
  return all;
}

}  // namespace turgor::render_tests
