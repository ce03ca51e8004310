// Surfaces and meshes to and from files. Readers are our own: they hold on damaged files.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "turgor/core/error.hpp"
#include "turgor/geometry/tri_mesh.hpp"

namespace turgor {

/// What read_mesh reads.
inline constexpr std::string_view surface_file_help =
    "PLY, STL, OBJ, OFF, VTK (.vtk, .vtp, the surface cells of .vtu) or glTF (.glb, .gltf)";

/// Whether a file of this name is for read_mesh: by its extension, in any case.
bool is_surface_file(const std::filesystem::path& path);

/// PLY (ascii, binary little and big endian), STL (ascii, binary), OBJ, OFF, VTK's legacy files to
/// version 5.1 (ascii, binary; polygons and strips, and the surface cells of unstructured grids), VTK's XML
/// PolyData and UnstructuredGrid (ascii, base64, appended raw or base64; plain or zlib) or glTF 2.0 (binary
/// or JSON with its buffers within or beside it, the default scene with the transforms of its nodes), chosen
/// by content and extension. Polygons are fanned into triangles. Coordinates are taken as they are; of glTF
/// alone, whose standard says metres with y up, they become mm in LPS, as write_glb writes them. Equal points
/// of STL and glTF are merged. Triangles that name a point twice are left out; all points are kept, in order
/// (STL and glTF: those used, in order of first use). Errors name the file and the line or byte: truncated,
/// index out of range, NaN, no triangles.
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

struct CellField {
  std::string name;
  int components = 1;
  std::vector<double> values;
};
/// What a .vtu file holds, without its point fields.
struct CellFile {
  CellMesh mesh;
  std::vector<CellField> cell_fields;
};
/// A .vtu file, in the encodings of read_mesh. Errors name the file: another file, more than one piece,
/// damaged, truncated, cells of points that are not there, coordinates that are not finite, fields that are
/// not of the cells. Values of fields may be anything.
Result<CellFile> read_vtu(const std::filesystem::path& path);
/// The same from memory; `name` stands for the path in errors.
Result<CellFile> parse_vtu(std::span<const std::byte> bytes, const std::string& name);

}  // namespace turgor
