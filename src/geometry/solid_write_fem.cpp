// Solids for finite element programs: Gmsh's MSH 4.1 (Gmsh reference manual, "File formats") and the input of
// Abaqus, which CalculiX reads.
#include <algorithm>

#include "geometry/solid_write.hpp"
#include "turgor/core/file.hpp"

namespace turgor::detail {
namespace {

/// Faces S1 to S4 of C3D4 and S1 to S6 of C3D8.
constexpr int kTetrahedronFaces[4][4] = {{0, 1, 2, -1}, {0, 3, 1, -1}, {1, 3, 2, -1}, {2, 3, 0, -1}};
constexpr int kCubeFaces[6][4] = {{0, 1, 2, 3}, {4, 7, 6, 5}, {0, 4, 5, 1},
                                  {1, 5, 6, 2}, {2, 6, 7, 3}, {3, 7, 4, 0}};

/// Which face of the cell holds all corners of the triangle, from 1.
int face_number(std::span<const int> cell, const Index3& triangle) {
  const bool cube = cell.size() == 8;
  const auto holds = [&](const int(&face)[4], int point) {
    return std::any_of(std::begin(face), std::end(face),
                       [&](int c) { return c >= 0 && cell[static_cast<std::size_t>(c)] == point; });
  };
  for (int f = 0; f < (cube ? 6 : 4); ++f) {
    const int(&face)[4] = cube ? kCubeFaces[f] : kTetrahedronFaces[f];
    if (std::all_of(triangle.begin(), triangle.end(), [&](int p) { return holds(face, p); })) return f + 1;
  }
  return 0;
}

/// Cells or faces, numbered on from `number`, corners from 1.
template <class Cell>
void number_cell(TextWriter& out, std::size_t number, const Cell& cell) {
  out.number(number);
  for (const int p : cell) out.number(p + 1);
  out.end();
}

void gmsh_head(TextWriter& out, const SolidMesh& solid) {
  Box3 box;
  for (const Vec3& p : solid.points) box.extend(p);
  const std::string span = fmt::format("1 {} {} {} {} {} {}", box.lower.x, box.lower.y, box.lower.z,
                                       box.upper.x, box.upper.y, box.upper.z);
  out.line("$MeshFormat\n4.1 0 8\n$EndMeshFormat");
  out.line("$PhysicalNames\n2\n2 1 \"surface\"\n3 2 \"solid\"\n$EndPhysicalNames");
  out.line("$Entities\n0 0 1 1\n" + span + " 1 1 0\n" + span + " 1 2 1 1\n$EndEntities");
}

}  // namespace

Result<void> write_gmsh(const std::filesystem::path& path, const SolidView& view) {
  const auto& points = view.solid.points;
  TextWriter out;
  gmsh_head(out, view.solid);
  out.line(fmt::format("$Nodes\n1 {0} 1 {0}\n3 1 0 {0}", points.size()));
  for (std::size_t p = 1; p <= points.size(); ++p) out.number(p), out.end();
  for (const Vec3& p : points) out.number(p.x), out.number(p.y), out.number(p.z), out.end();
  const std::vector<std::vector<int>> faces = view.faces();
  const std::size_t total = faces.size() + view.cell_count();
  const bool cubes = view.corners == 8;
  out.line(
      fmt::format("$EndNodes\n$Elements\n2 {0} 1 {0}\n3 1 {1} {2}", total, cubes ? 5 : 4, view.cell_count()));
  for (std::size_t c = 0; c < view.cell_count(); ++c) number_cell(out, c + 1, view.cell(c));
  out.line(fmt::format("2 1 {} {}", cubes ? 3 : 2, faces.size()));
  for (std::size_t f = 0; f < faces.size(); ++f) number_cell(out, view.cell_count() + f + 1, faces[f]);
  out.line("$EndElements");
  return write_file(path, out.text());
}

Result<void> write_abaqus(const std::filesystem::path& path, const SolidView& view) {
  const SolidMesh& solid = view.solid;
  TextWriter out;
  out.separate_by(',');
  out.line("*HEADING\nTurgor; millimetres\n*NODE, NSET=POINTS");
  for (std::size_t p = 0; p < solid.points.size(); ++p) {
    out.number(p + 1);
    for (int a = 0; a < 3; ++a) out.number(solid.points[p][a]);
    out.end();
  }
  out.line(fmt::format("*ELEMENT, TYPE=C3D{}, ELSET=SOLID", view.corners));
  for (std::size_t c = 0; c < view.cell_count(); ++c) number_cell(out, c + 1, view.cell(c));
  out.line("*NSET, NSET=SURFACE_POINTS");
  for (std::size_t p = 0; p < solid.points.size(); ++p) {
    if (solid.on_surface[p] != 0) out.number(p + 1), out.end();
  }
  out.line("*SURFACE, NAME=SURFACE, TYPE=ELEMENT");
  const std::size_t step = view.corners == 8 ? 2 : 1;  // a cube's side is two triangles
  for (std::size_t t = 0; t < solid.surface_triangles.size(); t += step) {
    const int cell = view.behind(t);
    const int face = face_number(view.cell(static_cast<std::size_t>(cell)), solid.surface_triangles[t]);
    out.line(fmt::format("{},S{}", cell + 1, face));
  }
  return write_file(path, out.text());
}

}  // namespace turgor::detail
