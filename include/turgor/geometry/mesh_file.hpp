// Surfaces and meshes to and from files. Readers are our own: they hold on damaged files.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "turgor/core/error.hpp"
#include "turgor/geometry/tri_mesh.hpp"

namespace turgor {

/// PLY (ascii, binary little and big endian), STL (ascii, binary), OBJ or OFF, chosen by content and
/// extension. Polygons are fanned into triangles. Coordinates are taken as they are. Duplicate STL points are
/// merged. Triangles that name a point twice are left out; all points are kept, in order (STL: of first use).
/// Errors name the file and the line or byte: truncated, index out of range, NaN, no triangles.
Result<TriMesh> read_mesh(const std::filesystem::path& path);
/// The same from memory; `name` stands for the path in errors, and its extension helps where the content
/// leaves doubt.
Result<TriMesh> parse_mesh(std::span<const std::byte> bytes, const std::string& name);

/// Binary little-endian PLY, float32 positions; fields become float properties. LPS mm, said in a comment.
Result<void> write_ply(const std::filesystem::path& path, const TriMesh& mesh,
                       const std::vector<MeshField>& point_fields = {});
/// VTK XML PolyData, appended raw binary, float32 positions.
Result<void> write_vtp(const std::filesystem::path& path, const TriMesh& mesh,
                       const std::vector<MeshField>& point_fields = {});

/// One body of a glTF scene.
struct GltfBody {
  std::string name;
  const TriMesh* mesh = nullptr;
  Vec3f base_colour{0.8f, 0.8f, 0.8f};  ///< linear RGB
  float roughness = 0.6f;
  std::vector<Vec3f> point_colours;  ///< empty, or linear RGB per point
};
/// glTF 2.0 binary: metres, y up, facing +z, as the standard asks; the LPS patient is rotated, never
/// mirrored.
Result<void> write_glb(const std::filesystem::path& path, const std::vector<GltfBody>& bodies);

/// Cells of any of VTK's linear types over shared points: the tissue model and solids.
struct CellMesh {
  std::vector<Vec3> points;
  std::vector<int> connectivity;  ///< point numbers, cell after cell
  std::vector<int> offsets;       ///< end of each cell in `connectivity`
  std::vector<std::uint8_t>
      types;  ///< VTK cell types: 3 line, 5 triangle, 10 tetrahedron, 12 hexahedron, 13 wedge
};
/// VTK XML UnstructuredGrid, appended raw binary.
Result<void> write_vtu(const std::filesystem::path& path, const CellMesh& mesh,
                       const std::vector<MeshField>& point_fields = {},
                       const std::vector<MeshField>& cell_fields = {});

}  // namespace turgor
