// Solids to files, and the plain binary one back.
#pragma once

#include <array>
#include <filesystem>
#include <string_view>
#include <vector>

#include "turgor/core/error.hpp"
#include "turgor/geometry/voxel_solid.hpp"

namespace turgor {

enum class SolidCells {
  tetrahedra,
  hexahedra,  ///< the cubes, over the same points
};

/// What write_solid writes, by extension.
inline constexpr std::string_view solid_file_help =
    ".node, .ele (TetGen: .node, .ele and .face beside each other), .vtu, .msh (Gmsh 4.1), .inp (Abaqus, "
    "CalculiX), .solid (plain binary)";

/// Error where the extension is none of these, or TetGen is asked for cubes. To be asked before long work.
Result<void> check_solid_file(const std::filesystem::path& path, SolidCells cells);

/// Points of the surface and the faces on it are marked in each format:
/// - TetGen: numbered from 0; boundary marker 1 of points and faces.
/// - .vtu: point field `surface`; the faces follow the cells as triangles, cell field `surface`.
/// - .msh: physical groups `solid` and `surface`; numbered from 1.
/// - .inp: C3D4 or C3D8 in the set SOLID, node set SURFACE_POINTS, surface SURFACE; numbered from 1.
/// - .solid, little endian: 8 bytes "TURGSOL1"; uint64 points, cells, corners of a cell (4 or 8), surface
///   triangles; float64 edge of a cube; then float64 x y z of the points, int32 corners of the cells, int32
///   corners of the surface triangles, int32 the cell behind each, uint8 whether each point is on the
///   surface.
/// Lengths in mm. Corners of cubes in the order of VTK. Errors: as check_solid_file; disk full, permission.
Result<void> write_solid(const std::filesystem::path& path, const SolidMesh& solid, SolidCells cells);

/// What a .solid file holds.
struct SolidFile {
  double spacing = 1;  ///< mm
  std::vector<Vec3> points;
  int corners = 4;         ///< of a cell
  std::vector<int> cells;  ///< corner after corner
  std::vector<Index3> surface_triangles;
  std::vector<int> surface_cells;
  std::vector<std::uint8_t> on_surface;
};
/// Errors: not such a file, truncated, longer than it says, an index out of range, a coordinate not finite.
Result<SolidFile> read_solid(const std::filesystem::path& path);

}  // namespace turgor
