#include "turgor/world/object.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "world/scene/transforms.hpp"

namespace turgor {
namespace {

Error bad(std::string what) {
  return {ErrorKind::bad_input, std::move(what), {}, "Give values in range"};
}

Result<void> check_colour(const Vec3f& colour, const char* name) {
  if (is_finite(colour) && colour.x >= 0 && colour.y >= 0 && colour.z >= 0) return {};
  return bad(fmt::format("the {} colour has a part that is negative or not a number", name));
}

Result<void> check(const CameraLens& lens) {
  if (!(lens.fov_deg >= 0 && lens.fov_deg < 170)) {
    return bad(fmt::format("the opening angle {} is not between 0 and 170 degrees", lens.fov_deg));
  }
  if (!(lens.height > 0) || !std::isfinite(lens.height)) {
    return bad(fmt::format("the height {} of the picture is not above 0", lens.height));
  }
  if (!(lens.target_distance > 0) || !std::isfinite(lens.target_distance)) {
    return bad(fmt::format("the distance {} of the target is not above 0", lens.target_distance));
  }
  return {};
}

Result<void> check(const Light& light) {
  if (!(light.strength >= 0) || !std::isfinite(light.strength)) {
    return bad(fmt::format("the strength {} of the light is below 0 or not finite", light.strength));
  }
  return check_colour(light.colour, "light's");
}

Result<void> check(const DepthMap& map) {
  if (map.columns < 2 || map.rows < 2) return bad("a depth map needs two columns and two rows or more");
  const auto samples = static_cast<std::size_t>(map.columns) * static_cast<std::size_t>(map.rows);
  if (samples > static_cast<std::size_t>(std::numeric_limits<int>::max())) {
    return bad("the depth map has more samples than can be numbered");
  }
  if (map.heights.size() != samples) {
    return bad(
        fmt::format("the depth map has {} heights, not {} × {}", map.heights.size(), map.columns, map.rows));
  }
  if (!std::all_of(map.heights.begin(), map.heights.end(), [](double h) { return std::isfinite(h); })) {
    return bad("a height of the depth map is not finite");
  }
  return {};
}

Result<void> check(const Polyhedron& polyhedron) {
  return validate(polyhedron);
}

bool same(const Polyhedron& a, const Polyhedron& b) {
  return a.points == b.points && a.corners == b.corners && a.ends == b.ends && a.lines == b.lines;
}
bool same(const CameraLens& a, const CameraLens& b) {
  return a.fov_deg == b.fov_deg && a.height == b.height && a.target_distance == b.target_distance;
}
bool same(const Light& a, const Light& b) {
  return a.colour == b.colour && a.strength == b.strength;
}
bool same(const DepthMap& a, const DepthMap& b) {
  return a.columns == b.columns && a.rows == b.rows && a.heights == b.heights;
}

/// Calls body(point) for every point of the object, in world coordinates.
template <class FleshBody>
void for_each_world_point(const Object& object, FleshBody&& body) {
  if (const auto* polyhedron = std::get_if<Polyhedron>(&object.description)) {
    for (const Vec3& p : polyhedron->points) body(object.transform.point(p));
  } else if (const auto* map = std::get_if<DepthMap>(&object.description)) {
    std::size_t sample = 0;
    for (int j = 0; j < map->rows; ++j) {
      for (int i = 0; i < map->columns; ++i) {
        body(
            object.transform.point({static_cast<double>(i), static_cast<double>(j), map->heights[sample++]}));
      }
    }
  } else {
    body(object.transform.point({}));
  }
}

/// Quadrilaterals over a depth map's samples, anticlockwise seen from above; its points are left out.
Polyhedron depth_map_grid(const DepthMap& map) {
  Polyhedron grid;
  for (int j = 0; j + 1 < map.rows; ++j) {
    for (int i = 0; i + 1 < map.columns; ++i) {
      const int p = j * map.columns + i, q = p + map.columns;
      grid.add_polygon(std::array{p, p + 1, q + 1, q});
    }
  }
  return grid;
}

/// Every polygon the other way round, from the same first corner.
void turn_over(Polyhedron& polyhedron) {
  int begin = 0;
  for (const int end : polyhedron.ends) {
    std::reverse(polyhedron.corners.begin() + begin + 1, polyhedron.corners.begin() + end);
    begin = end;
  }
}

}  // namespace

std::string_view name_of(ObjectKind kind) {
  switch (kind) {
    case ObjectKind::polyhedron:
      return "polyhedron";
    case ObjectKind::camera:
      return "camera";
    case ObjectKind::light:
      return "light";
    case ObjectKind::depth_map:
      break;
  }
  return "depth map";
}

Result<void> validate(const Optics& optics) {
  TURGOR_CHECK(check_colour(optics.diffuse, "diffuse"));
  TURGOR_CHECK(check_colour(optics.highlight, "highlight"));
  if (optics.wire) TURGOR_CHECK(check_colour(*optics.wire, "wire"));
  if (!(optics.specular >= 0) || !std::isfinite(optics.specular)) {
    return bad(fmt::format("the specular exponent {} is below 0 or not finite", optics.specular));
  }
  if (!(optics.line_width > 0 && optics.line_width <= 100)) {
    return bad(fmt::format("the line width {} is not above 0 and at most 100", optics.line_width));
  }
  if (!(optics.opacity >= 0 && optics.opacity <= 1)) {
    return bad(fmt::format("the opacity {} is not between 0 and 1", optics.opacity));
  }
  return {};
}

Result<void> validate(const Object& object) {
  if (!is_finite(object.transform)) return bad("the transform is not finite");
  TURGOR_CHECK(validate(object.optics));
  return std::visit([](const auto& description) { return check(description); }, object.description);
}

bool same_description(const Description& a, const Description& b) {
  return a.index() == b.index() &&
         std::visit(
             [&b](const auto& value) { return same(value, std::get<std::decay_t<decltype(value)>>(b)); }, a);
}

Box3 world_box(const Object& object) {
  Box3 box;
  for_each_world_point(object, [&](const Vec3& p) { box.extend(p); });
  return box;
}

BoundingSphere world_sphere(const Object& object) {
  BoundingSphere sphere{centre_of(object), 0};
  for_each_world_point(
      object, [&](const Vec3& p) { sphere.radius = std::max(sphere.radius, distance(p, sphere.centre)); });
  return sphere;
}

Orientation orientation(const Object& object) {
  return {unit(object.transform.direction({0, 0, 1})), unit(object.transform.direction({0, 1, 0}))};
}

Polyhedron world_polyhedron(const Object& object) {
  Polyhedron out;
  if (const auto* polyhedron = std::get_if<Polyhedron>(&object.description)) {
    out.corners = polyhedron->corners, out.ends = polyhedron->ends, out.lines = polyhedron->lines;
    out.points.reserve(polyhedron->points.size());
  } else if (const auto* map = std::get_if<DepthMap>(&object.description)) {
    out = depth_map_grid(*map);
    out.points.reserve(map->heights.size());
  } else {
    return out;
  }
  for_each_world_point(object, [&](const Vec3& p) { out.points.push_back(p); });
  if (object.transform.linear.determinant() < 0) turn_over(out);
  return out;
}

Polyhedron box_polyhedron(const Box3& box) {
  Polyhedron out;
  for (int i = 0; i < 8; ++i) {
    out.points.push_back({(i & 1) != 0 ? box.upper.x : box.lower.x, (i & 2) != 0 ? box.upper.y : box.lower.y,
                          (i & 4) != 0 ? box.upper.z : box.lower.z});
  }
  constexpr int faces[6][4] = {{0, 2, 3, 1}, {4, 5, 7, 6}, {0, 1, 5, 4},
                               {2, 6, 7, 3}, {0, 4, 6, 2}, {1, 3, 7, 5}};
  for (const auto& face : faces) out.add_polygon(face);
  return out;
}

Mat3 rotation_xyz(const Vec3& angles_deg) {
  return rotation({0, 0, 1}, radians(angles_deg.z)) * rotation({0, 1, 0}, radians(angles_deg.y)) *
         rotation({1, 0, 0}, radians(angles_deg.x));
}

Result<void> harden(Object& object) {
  if (object.kind() == ObjectKind::camera || object.kind() == ObjectKind::light) return {};
  Polyhedron baked = world_polyhedron(object);
  TURGOR_CHECK(validate(baked));
  object.description = std::move(baked);
  object.transform = {Mat3{}, {}, object.transform.point(object.transform.origin)};
  return {};
}

}  // namespace turgor
