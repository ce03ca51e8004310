// A triangulated surface and the elementary measures on it.
#pragma once

#include <string>
#include <vector>

#include "turgor/core/error.hpp"
#include "turgor/math/vec.hpp"

namespace turgor {

/// Points in millimetres (LPS), triangles anticlockwise seen from outside.
/// Invariant (see validate): every index is in [0, points.size()), no triangle names a point twice,
/// every coordinate is finite.
struct TriMesh {
  std::vector<Vec3> points;
  std::vector<Index3> triangles;

  [[nodiscard]] bool empty() const { return triangles.empty(); }
};

/// Values that travel with a mesh into files: `components` numbers per point (or per triangle), row by row.
struct MeshField {
  std::string name;
  int components = 1;
  std::vector<float> values;
};

Result<void> validate(const TriMesh& mesh);

Box3 bounds(const TriMesh& mesh);
/// mm²
double surface_area(const TriMesh& mesh);
/// mm³; positive for a closed surface oriented outwards.
double enclosed_volume(const TriMesh& mesh);
/// Unit normals averaged by angle at the point; zero where no triangle uses the point.
std::vector<Vec3> point_normals(const TriMesh& mesh);
/// Area-weighted (unnormalised) normal of one triangle: length is twice the area.
inline Vec3 triangle_normal(const TriMesh& mesh, const Index3& t) {
  const Vec3& a = mesh.points[static_cast<std::size_t>(t[0])];
  return cross(mesh.points[static_cast<std::size_t>(t[1])] - a,
               mesh.points[static_cast<std::size_t>(t[2])] - a);
}

/// How a surface is joined together.
struct Topology {
  int components = 0;
  int boundary_edges = 0;      ///< used by one triangle
  int non_manifold_edges = 0;  ///< used by three or more, or twice in the same direction
  [[nodiscard]] bool closed() const { return boundary_edges == 0 && non_manifold_edges == 0; }
};
Topology topology(const TriMesh& mesh);

/// Component number of each triangle (joined through shared points), components numbered by falling area.
std::vector<int> triangle_components(const TriMesh& mesh);
/// The points reached by `keep` triangles, renumbered in order. `point_map` (optional) receives new index or
/// -1.
TriMesh submesh(const TriMesh& mesh, const std::vector<bool>& keep, std::vector<int>* point_map = nullptr);
TriMesh append(TriMesh a, const TriMesh& b);
TriMesh transformed(TriMesh mesh, const RigidTransform& transform);

/// Neighbouring points of each point, ascending, as offsets into one list.
struct PointAdjacency {
  std::vector<int> offsets;  ///< size points + 1
  std::vector<int> neighbours;
};
PointAdjacency point_adjacency(const TriMesh& mesh);

/// Whether each point lies on an edge used by one triangle only.
std::vector<bool> boundary_points(const TriMesh& mesh);

}  // namespace turgor
