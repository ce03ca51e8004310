#include "turgor/geometry/polyhedron.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstdint>

#include "turgor/core/index.hpp"

namespace turgor {
namespace {

Error broken(std::string what) {
  return {ErrorKind::bad_input, std::move(what), "surface", "Repair the surface"};
}

// Of polygon `number`; `corners` is scratch space.
Result<void> check_polygon(const Polyhedron& polyhedron, int number, std::vector<int>& corners) {
  const auto polygon = polyhedron.polygon(number);
  const int points = static_cast<int>(polyhedron.points.size());
  for (const int p : polygon) {
    if (p < 0 || p >= points)
      return broken(fmt::format("polygon {} names point {} of {}", number, p, points));
  }
  corners.assign(polygon.begin(), polygon.end());
  std::sort(corners.begin(), corners.end());
  if (const auto twice = std::adjacent_find(corners.begin(), corners.end()); twice != corners.end()) {
    return broken(fmt::format("polygon {} names point {} twice", number, *twice));
  }
  return {};
}

Result<void> check_polygons(const Polyhedron& polyhedron) {
  const std::size_t corners = polyhedron.corners.size();
  int begin = 0;
  for (int i = 0; i < polyhedron.polygon_count(); ++i) {
    const int end = polyhedron.ends[at(i)];
    if (end < begin || at(end) > corners) {
      return broken(
          fmt::format("polygon {} ends at corner {}, but begins at {} of {}", i, end, begin, corners));
    }
    if (end - begin < 3)
      return broken(fmt::format("polygon {} has {} corners, not 3 or more", i, end - begin));
    begin = end;
  }
  if (at(begin) == corners) return {};
  return broken(fmt::format("{} corners belong to no polygon", corners - at(begin)));
}

// Unit normal of the vector area; zero where there is none. Lengths are measured in the polygon's own size,
// so that no product overflows or vanishes.
Vec3 unit_normal(const Polyhedron& polyhedron, std::span<const int> polygon) {
  const Vec3& origin = polyhedron.points[at(polygon[0])];
  double size = 0;
  for (const int p : polygon) {
    const Vec3 d = polyhedron.points[at(p)] - origin;
    size = std::max({size, std::abs(d.x), std::abs(d.y), std::abs(d.z)});
  }
  if (!(size > 0) || !std::isfinite(size)) return {};
  Vec3 area;
  for (std::size_t i = 1; i + 1 < polygon.size(); ++i) {
    area += cross((polyhedron.points[at(polygon[i])] - origin) / size,
                  (polyhedron.points[at(polygon[i + 1])] - origin) / size);
  }
  return normalized(area);
}

}  // namespace

Result<void> validate(const Polyhedron& polyhedron) {
  for (std::size_t i = 0; i < polyhedron.points.size(); ++i) {
    if (!is_finite(polyhedron.points[i])) return broken(fmt::format("point {} is not a finite number", i));
  }
  TURGOR_CHECK(check_polygons(polyhedron));
  std::vector<int> scratch;
  for (int i = 0; i < polyhedron.polygon_count(); ++i) TURGOR_CHECK(check_polygon(polyhedron, i, scratch));
  const int points = static_cast<int>(polyhedron.points.size());
  for (std::size_t i = 0; i < polyhedron.lines.size(); ++i) {
    const auto [a, b] = polyhedron.lines[i];
    for (const int p : {a, b}) {
      if (p < 0 || p >= points) return broken(fmt::format("line {} names point {} of {}", i, p, points));
    }
    if (a == b) return broken(fmt::format("line {} joins point {} to itself", i, a));
  }
  return {};
}

Polyhedron to_polyhedron(const TriMesh& mesh) {
  Polyhedron polyhedron;
  polyhedron.points = mesh.points;
  polyhedron.corners.reserve(3 * mesh.triangles.size());
  polyhedron.ends.reserve(mesh.triangles.size());
  for (const Index3& t : mesh.triangles) polyhedron.add_polygon(t);
  return polyhedron;
}

TriMesh triangulated(const Polyhedron& polyhedron) {
  // Diagonals of a regular grid differ by rounding alone, and must not be chosen by it.
  constexpr double equal = 1 + 1e-9;
  TriMesh mesh;
  mesh.points = polyhedron.points;
  mesh.triangles.reserve(polyhedron.corners.size() -
                         std::min(polyhedron.corners.size(), 2 * polyhedron.ends.size()));
  for (int i = 0; i < polyhedron.polygon_count(); ++i) {
    const auto p = polyhedron.polygon(i);
    if (p.size() == 4 && distance(mesh.points[at(p[0])], mesh.points[at(p[2])]) >
                             equal * distance(mesh.points[at(p[1])], mesh.points[at(p[3])])) {
      mesh.triangles.insert(mesh.triangles.end(), {{p[1], p[2], p[3]}, {p[1], p[3], p[0]}});
      continue;
    }
    for (std::size_t k = 1; k + 1 < p.size(); ++k) mesh.triangles.push_back({p[0], p[k], p[k + 1]});
  }
  return mesh;
}

std::vector<Edge> edges(const Polyhedron& polyhedron) {
  std::vector<std::uint64_t> keys;
  keys.reserve(polyhedron.corners.size() + polyhedron.lines.size());
  const auto add = [&](int a, int b) {
    keys.push_back(static_cast<std::uint64_t>(std::min(a, b)) << 32 |
                   static_cast<std::uint64_t>(std::max(a, b)));
  };
  for (int i = 0; i < polyhedron.polygon_count(); ++i) {
    const auto p = polyhedron.polygon(i);
    for (std::size_t k = 0; k < p.size(); ++k) add(p[k], p[k + 1 < p.size() ? k + 1 : 0]);
  }
  for (const auto& [a, b] : polyhedron.lines) add(a, b);
  std::sort(keys.begin(), keys.end());
  keys.erase(std::unique(keys.begin(), keys.end()), keys.end());
  std::vector<Edge> result;
  result.reserve(keys.size());
  for (const std::uint64_t key : keys) {
    result.push_back({static_cast<int>(key >> 32), static_cast<int>(key & 0xffffffff)});
  }
  return result;
}

std::vector<Vec3> vertex_normals(const Polyhedron& polyhedron) {
  std::vector<Vec3> normals(polyhedron.points.size());
  for (int i = 0; i < polyhedron.polygon_count(); ++i) {
    const auto polygon = polyhedron.polygon(i);
    const Vec3 normal = unit_normal(polyhedron, polygon);
    for (const int p : polygon) normals[at(p)] += normal;
  }
  // Normals that cancel leave only rounding, which is no direction.
  for (Vec3& n : normals) n = length(n) > 1e-9 ? normalized(n) : Vec3{};
  return normals;
}

}  // namespace turgor
