#include "turgor/geometry/tri_mesh.hpp"

#include <fmt/format.h>

#include <cmath>

#include "turgor/core/parallel.hpp"

namespace turgor {
namespace {

constexpr std::size_t grain = 8192;

/// Sum over all triangles, the same bits for any number of threads.
template <class Term>
double triangle_sum(const TriMesh& mesh, Term&& term) {
  return parallel_reduce(
      mesh.triangles.size(), grain, 0.0,
      [&](std::size_t begin, std::size_t end) {
        double sum = 0;
        for (std::size_t i = begin; i < end; ++i) sum += term(mesh.triangles[i]);
        return sum;
      },
      [](double a, double b) { return a + b; });
}

/// Angle at `a` of the triangle abc.
double angle_at(const Vec3& a, const Vec3& b, const Vec3& c) {
  const Vec3 u = b - a, v = c - a;
  return std::atan2(length(cross(u, v)), dot(u, v));
}

}  // namespace

Result<void> validate(const TriMesh& mesh) {
  for (std::size_t i = 0; i < mesh.points.size(); ++i) {
    if (is_finite(mesh.points[i])) continue;
    return Error{ErrorKind::bad_input,
                 fmt::format("point {} of the surface is not a finite number", i),
                 {},
                 "Repair the surface"};
  }
  const auto count = mesh.points.size();
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    const Index3& t = mesh.triangles[i];
    for (const int p : t) {
      if (p >= 0 && static_cast<std::size_t>(p) < count) continue;
      return Error{ErrorKind::bad_input,
                   fmt::format("triangle {} names point {} of {}", i, p, count),
                   {},
                   "Repair the surface"};
    }
    if (t[0] == t[1] || t[1] == t[2] || t[2] == t[0]) {
      return Error{
          ErrorKind::bad_input, fmt::format("triangle {} names a point twice", i), {}, "Repair the surface"};
    }
  }
  return {};
}

Box3 bounds(const TriMesh& mesh) {
  Box3 box;
  for (const Vec3& p : mesh.points) box.extend(p);
  return box;
}

double surface_area(const TriMesh& mesh) {
  return triangle_sum(mesh, [&](const Index3& t) { return 0.5 * length(triangle_normal(mesh, t)); });
}

double enclosed_volume(const TriMesh& mesh) {
  if (mesh.points.empty()) return 0;
  // About a point of the surface rather than the far origin: less cancellation.
  const Vec3 o = bounds(mesh).centre();
  return triangle_sum(mesh, [&](const Index3& t) {
    return dot(mesh.points[static_cast<std::size_t>(t[0])] - o, triangle_normal(mesh, t)) / 6;
  });
}

std::vector<Vec3> point_normals(const TriMesh& mesh) {
  std::vector<Vec3> units(mesh.triangles.size()), angles(mesh.triangles.size());
  parallel_for(mesh.triangles.size(), grain, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      const Index3& t = mesh.triangles[i];
      const Vec3& a = mesh.points[static_cast<std::size_t>(t[0])];
      const Vec3& b = mesh.points[static_cast<std::size_t>(t[1])];
      const Vec3& c = mesh.points[static_cast<std::size_t>(t[2])];
      units[i] = normalized(triangle_normal(mesh, t));
      angles[i] = {angle_at(a, b, c), angle_at(b, c, a), angle_at(c, a, b)};
    }
  });
  std::vector<Vec3> normals(mesh.points.size());
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    for (int k = 0; k < 3; ++k) {
      const int p = mesh.triangles[i][static_cast<std::size_t>(k)];
      normals[static_cast<std::size_t>(p)] += units[i] * angles[i][k];
    }
  }
  parallel_for(normals.size(), grain, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) normals[i] = normalized(normals[i]);
  });
  return normals;
}

TriMesh submesh(const TriMesh& mesh, const std::vector<bool>& keep, std::vector<int>* point_map) {
  std::vector<int> map(mesh.points.size(), -1);
  TriMesh part;
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    if (!keep[i]) continue;
    part.triangles.push_back(mesh.triangles[i]);
    for (const int p : mesh.triangles[i]) map[static_cast<std::size_t>(p)] = 0;
  }
  for (std::size_t p = 0; p < map.size(); ++p) {
    if (map[p] < 0) continue;
    map[p] = static_cast<int>(part.points.size());
    part.points.push_back(mesh.points[p]);
  }
  for (Index3& t : part.triangles) {
    for (int& p : t) p = map[static_cast<std::size_t>(p)];
  }
  if (point_map) *point_map = std::move(map);
  return part;
}

TriMesh append(TriMesh a, const TriMesh& b) {
  const int shift = static_cast<int>(a.points.size());
  a.points.insert(a.points.end(), b.points.begin(), b.points.end());
  a.triangles.reserve(a.triangles.size() + b.triangles.size());
  for (const Index3& t : b.triangles) a.triangles.push_back({t[0] + shift, t[1] + shift, t[2] + shift});
  return a;
}

TriMesh transformed(TriMesh mesh, const RigidTransform& transform) {
  for (Vec3& p : mesh.points) p = transform.point(p);
  return mesh;
}

}  // namespace turgor
