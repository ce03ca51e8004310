#include <vector>

#include "turgor/core/index.hpp"
#include "turgor/core/parallel.hpp"
#include "turgor/geometry/mesh_edit.hpp"

namespace turgor {
namespace {

// Area-weighted normals: the large triangles around a fold say which way the surface looks.
std::vector<Vec3> area_normals(const TriMesh& mesh) {
  std::vector<Vec3> normals(mesh.points.size());
  for (const Index3& t : mesh.triangles) {
    const Vec3 n = triangle_normal(mesh, t);
    for (const int p : t) normals[at(p)] += n;
  }
  return normals;
}

std::vector<int> turned_triangles(const TriMesh& mesh) {
  const std::vector<Vec3> normals = area_normals(mesh);
  std::vector<std::uint8_t> turned(mesh.triangles.size(), 0);
  parallel_for(mesh.triangles.size(), 8192, [&](std::size_t begin, std::size_t end) {
    for (std::size_t t = begin; t < end; ++t) {
      const Index3& v = mesh.triangles[t];
      const Vec3 around =
          normalized(normals[at(v[0])]) + normalized(normals[at(v[1])]) + normalized(normals[at(v[2])]);
      turned[t] = dot(triangle_normal(mesh, v), around) <= 0;
    }
  });
  std::vector<int> out;
  for (std::size_t t = 0; t < turned.size(); ++t) {
    if (turned[t]) out.push_back(static_cast<int>(t));
  }
  return out;
}

// Points on edges that one triangle uses.
std::vector<bool> boundary_points(const TriMesh& mesh, const PointAdjacency& adjacency) {
  std::vector<int> triangles_at(mesh.points.size(), 0);
  for (const Index3& t : mesh.triangles) {
    for (const int p : t) ++triangles_at[at(p)];
  }
  std::vector<bool> boundary(mesh.points.size());
  for (std::size_t p = 0; p < boundary.size(); ++p) {
    // Inside, a point has as many neighbours as triangles.
    boundary[p] = adjacency.offsets[p + 1] - adjacency.offsets[p] != triangles_at[p];
  }
  return boundary;
}

}  // namespace

int unfold(TriMesh& mesh, int rounds) {
  std::vector<int> turned = turned_triangles(mesh);
  if (turned.empty()) return 0;
  const PointAdjacency adjacency = point_adjacency(mesh);
  const std::vector<bool> boundary = boundary_points(mesh, adjacency);
  for (int round = 0; round < rounds && !turned.empty(); ++round) {
    std::vector<bool> moves(mesh.points.size(), false);
    for (const int t : turned) {
      for (const int p : mesh.triangles[at(t)]) moves[at(p)] = !boundary[at(p)];
    }
    const std::vector<Vec3> before = mesh.points;
    for (std::size_t p = 0; p < moves.size(); ++p) {
      if (!moves[p]) continue;
      Vec3 mean{};
      const int begin = adjacency.offsets[p], end = adjacency.offsets[p + 1];
      for (int k = begin; k < end; ++k)
        mean += before[at(adjacency.neighbours[at(k)])] / static_cast<double>(end - begin);
      mesh.points[p] = mean;
    }
    turned = turned_triangles(mesh);
  }
  return static_cast<int>(turned.size());
}

}  // namespace turgor
