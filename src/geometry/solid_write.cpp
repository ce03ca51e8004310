#include "geometry/solid_write.hpp"

#include <algorithm>
#include <array>
#include <string>

#include "turgor/core/file.hpp"
#include "turgor/core/lower_case.hpp"
#include "turgor/geometry/mesh_file.hpp"

namespace turgor {
namespace {

using detail::SolidView;
using Writer = Result<void> (*)(const std::filesystem::path&, const SolidView&);

Writer writer_for(const std::filesystem::path& path) {
  const std::string extension = lower_case(path.extension().string());
  if (extension == ".node" || extension == ".ele" || extension == ".face") return detail::write_tetgen;
  if (extension == ".vtu") return detail::write_solid_vtu;
  if (extension == ".msh") return detail::write_gmsh;
  if (extension == ".inp") return detail::write_abaqus;
  if (extension == ".solid") return detail::write_plain_solid;
  return nullptr;
}

}  // namespace

Result<void> check_solid_file(const std::filesystem::path& path, SolidCells cells) {
  const Writer writer = writer_for(path);
  if (writer == nullptr) {
    return Error{ErrorKind::bad_input, "solids are not written to files of this kind", path.string(),
                 fmt::format("Give one of {}", solid_file_help)};
  }
  if (writer == detail::write_tetgen && cells == SolidCells::hexahedra) {
    return Error{ErrorKind::bad_input, "TetGen's files hold tetrahedra only", path.string(),
                 "Leave -hexahedra out, or write .vtu, .msh, .inp or .solid"};
  }
  return {};
}

Result<void> write_solid(const std::filesystem::path& path, const SolidMesh& solid, SolidCells cells) {
  TURGOR_CHECK(check_solid_file(path, cells));
  if (cells == SolidCells::tetrahedra) {
    const std::size_t count = 4 * solid.tetrahedra.size();
    return writer_for(path)(path, {solid, 4, {count > 0 ? solid.tetrahedra[0].data() : nullptr, count}});
  }
  const std::vector<std::array<int, 8>> cubes = hexahedra(solid);
  return writer_for(path)(path, {solid, 8, {cubes.empty() ? nullptr : cubes[0].data(), 8 * cubes.size()}});
}

namespace detail {

std::vector<std::vector<int>> SolidView::faces() const {
  std::vector<std::vector<int>> faces;
  const auto& triangles = solid.surface_triangles;
  if (corners == 4) {
    for (const Index3& t : triangles) faces.emplace_back(t.begin(), t.end());
    return faces;
  }
  // A side's two triangles follow one another and share their last two corners, turned about.
  for (std::size_t t = 0; t + 1 < triangles.size(); t += 2)
    faces.push_back({triangles[t][0], triangles[t][1], triangles[t + 1][0], triangles[t][2]});
  return faces;
}

Result<void> write_tetgen(const std::filesystem::path& path, const SolidView& view) {
  const SolidMesh& solid = view.solid;
  TextWriter node, ele, face;
  node.line(fmt::format("# mm\n{} 3 0 1", solid.points.size()));
  for (std::size_t p = 0; p < solid.points.size(); ++p) {
    node.number(p);
    for (int a = 0; a < 3; ++a) node.number(solid.points[p][a]);
    node.number(int{solid.on_surface[p]}), node.end();
  }
  ele.line(fmt::format("{} 4 0", view.cell_count()));
  for (std::size_t c = 0; c < view.cell_count(); ++c) {
    ele.number(c);
    for (const int p : view.cell(c)) ele.number(p);
    ele.end();
  }
  face.line(fmt::format("{} 1", solid.surface_triangles.size()));
  for (std::size_t t = 0; t < solid.surface_triangles.size(); ++t) {
    face.number(t);
    for (const int p : solid.surface_triangles[t]) face.number(p);
    face.number(1), face.end();
  }
  std::vector<std::filesystem::path> written;
  for (const auto& [extension, text] : {std::pair{".node", &node}, {".ele", &ele}, {".face", &face}}) {
    std::filesystem::path part = path;
    part.replace_extension(extension);
    if (const auto done = write_file(part, text->text()); !done) {
      std::error_code ignored;
      for (const auto& other : written) std::filesystem::remove(other, ignored);
      return done.error();
    }
    written.push_back(std::move(part));
  }
  return {};
}

Result<void> write_solid_vtu(const std::filesystem::path& path, const SolidView& view) {
  CellMesh mesh;
  mesh.points.assign(view.solid.points.begin(), view.solid.points.end());
  mesh.connectivity.assign(view.connectivity.begin(), view.connectivity.end());
  for (std::size_t c = 1; c <= view.cell_count(); ++c)
    mesh.offsets.push_back(static_cast<int>(c) * view.corners);
  mesh.types.assign(view.cell_count(), view.corners == 4 ? 10 : 12);
  MeshField points{"surface", 1, {view.solid.on_surface.begin(), view.solid.on_surface.end()}};
  MeshField cells{"surface", 1, std::vector<float>(view.cell_count(), 0)};
  for (const std::vector<int>& face : view.faces()) {
    mesh.connectivity.insert(mesh.connectivity.end(), face.begin(), face.end());
    mesh.offsets.push_back(static_cast<int>(mesh.connectivity.size()));
    mesh.types.push_back(face.size() == 3 ? 5 : 9);
    cells.values.push_back(1);
  }
  return write_vtu(path, mesh, {points}, {cells});
}

}  // namespace detail
}  // namespace turgor
