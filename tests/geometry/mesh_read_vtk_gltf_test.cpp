// Surfaces of VTK and glTF. The files of VTK under tests/fuzz/seeds/mesh were written by VTK 9.1, all from
// one box of 1 x 2 x 3: four sides as polygons, one as triangles, one as a strip, and a line and a point
// besides.
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>

#include "shapes.hpp"
#include "turgor/core/file.hpp"
#include "turgor/geometry/mesh_file.hpp"

namespace turgor {
namespace {

namespace fs = std::filesystem;

fs::path seeds() {
  return fs::path(TURGOR_SOURCE_DIR) / "tests" / "fuzz" / "seeds" / "mesh";
}
std::vector<fs::path> files_of(std::initializer_list<std::string> extensions) {
  std::vector<fs::path> files;
  for (const auto& entry : fs::directory_iterator(seeds()))
    for (const std::string& e : extensions)
      if (entry.path().extension() == e) files.push_back(entry.path());
  std::sort(files.begin(), files.end());
  return files;
}
std::string content(const fs::path& path) {
  const auto bytes = read_file(path);
  EXPECT_TRUE(bytes);
  return bytes ? std::string(reinterpret_cast<const char*>(bytes->data()), bytes->size()) : std::string();
}
Result<TriMesh> parse(const std::string& text, const std::string& name) {
  return parse_mesh(std::as_bytes(std::span(text.data(), text.size())), name);
}
std::string error_of(const std::string& text, const std::string& name) {
  const auto mesh = parse(text, name);
  if (mesh) return "no error";
  EXPECT_EQ(mesh.error().kind, ErrorKind::bad_input);
  EXPECT_NE(mesh.error().where.find(name), std::string::npos);
  EXPECT_FALSE(mesh.error().remedy.empty());
  return mesh.error().message();
}
::testing::AssertionResult contains(const std::string& text, const std::string& part) {
  if (text.find(part) != std::string::npos) return ::testing::AssertionSuccess();
  return ::testing::AssertionFailure() << '"' << text << "\" does not hold \"" << part << '"';
}
std::string replaced(std::string text, const std::string& from, const std::string& to) {
  const std::size_t at = text.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  return at == std::string::npos ? text : text.replace(at, from.size(), to);
}

void expect_box(const TriMesh& mesh, const std::string& name, double scale = 1) {
  EXPECT_TRUE(validate(mesh)) << name;
  EXPECT_EQ(mesh.points.size(), 8U) << name;
  EXPECT_EQ(mesh.triangles.size(), 12U) << name;
  EXPECT_TRUE(topology(mesh).closed()) << name;
  EXPECT_NEAR(enclosed_volume(mesh), 6 * scale * scale * scale, 1e-6 * scale * scale * scale) << name;
}

TEST(VtkFiles, EveryEncodingGivesTheSameSurface) {
  const std::vector<fs::path> files = files_of({".vtk", ".vtp", ".vtu"});
  EXPECT_EQ(files.size(), 16U);
  for (const fs::path& file : files) {
    const auto mesh = read_mesh(file);
    ASSERT_TRUE(mesh) << mesh.error().message();
    expect_box(*mesh, file.filename());
  }
}

TEST(SurfaceFiles, AreToldByTheirExtension) {
  for (const char* name : {"a.ply", "b.STL", "c.Obj", "d.off", "e.vtk", "f.vtp", "g.vtu", "h.glb", "i.gltf"})
    EXPECT_TRUE(is_surface_file(name)) << name;
  for (const char* name : {"a.node", "ply", "vtk.txt", ""}) EXPECT_FALSE(is_surface_file(name)) << name;
}

TEST(VtkFiles, WhatWeWriteIsReadAgain) {
  const fs::path file = fs::path(::testing::TempDir()) / "again.vtp";
  const TriMesh ball = testing::sphere(10, 2, {1, 2, 3});
  ASSERT_TRUE(write_vtp(file, ball));
  const auto again = read_mesh(file);
  ASSERT_TRUE(again) << again.error().message();
  EXPECT_EQ(again->triangles, ball.triangles);
  for (std::size_t p = 0; p < ball.points.size(); ++p)
    ASSERT_LT(distance(again->points[p], ball.points[p]), 1e-5);
  fs::remove(file);
}

Result<CellFile> parse_cells(const std::string& text, const std::string& name) {
  return parse_vtu(std::as_bytes(std::span(text.data(), text.size())), name);
}

TEST(VtkFiles, CellsAndTheirFieldsAreReadAgain) {
  const fs::path file = fs::path(::testing::TempDir()) / "again.vtu";
  const CellMesh mesh{
      {{0, 0, 0}, {1, 0, 0}, {0, 2, 0}, {0, 0, 4}}, {0, 1, 0, 1, 2, 0, 1, 2, 3}, {2, 5, 9}, {3, 5, 10}};
  const MeshField one{"one", 1, {1, NAN, 3}}, three{"three", 3, {1, 2, 3, 4, 5, 6, 7, 8, 9}};
  ASSERT_TRUE(write_vtu(file, mesh, {{"of_points", 1, {0, 1, 2, 3}}}, {one, three}));
  const auto again = read_vtu(file);
  ASSERT_TRUE(again) << again.error().message();
  EXPECT_EQ(again->mesh.points, mesh.points);
  EXPECT_EQ(again->mesh.connectivity, mesh.connectivity);
  EXPECT_EQ(again->mesh.offsets, mesh.offsets);
  EXPECT_EQ(again->mesh.types, mesh.types);
  ASSERT_EQ(again->cell_fields.size(), 2U);
  EXPECT_EQ(again->cell_fields[0].name, "one");
  EXPECT_TRUE(std::isnan(again->cell_fields[0].values.at(1)));
  EXPECT_EQ(again->cell_fields[1].components, 3);
  EXPECT_EQ(again->cell_fields[1].values, (std::vector<double>{1, 2, 3, 4, 5, 6, 7, 8, 9}));
  fs::remove(file);
}

TEST(VtkFiles, CellsOfAnyEncodingAreRead) {
  const auto cells = read_vtu(seeds() / "vtu_zlib.vtu");
  ASSERT_TRUE(cells) << cells.error().message();
  EXPECT_EQ(cells->mesh.points.size(), 8U);
  EXPECT_FALSE(cells->mesh.types.empty());
}

TEST(VtkFiles, OfCellsErrorsSayWhatIsWrong) {
  const auto error = [](const std::string& text) {
    const auto cells = parse_cells(text, "a.vtu");
    return cells ? "no error" : cells.error().message();
  };
  const auto file = [](const std::string& type, const std::string& field) {
    return "<VTKFile type=\"UnstructuredGrid\"><UnstructuredGrid><Piece NumberOfPoints=\"2\" "
           "NumberOfCells=\"1\"><Points>"
           "<DataArray type=\"Float32\" NumberOfComponents=\"3\" format=\"ascii\">0 0 0 1 0 "
           "0</DataArray></Points><Cells>"
           "<DataArray type=\"Int32\" Name=\"connectivity\" format=\"ascii\">0 1</DataArray>"
           "<DataArray type=\"Int32\" Name=\"offsets\" format=\"ascii\">2</DataArray>"
           "<DataArray type=\"Int32\" Name=\"types\" format=\"ascii\">" +
           type +
           "</DataArray></Cells><CellData><DataArray type=\"Float64\" Name=\"f\" NumberOfComponents=\"1\" "
           "format=\"ascii\">" +
           field + "</DataArray></CellData></Piece></UnstructuredGrid></VTKFile>";
  };
  EXPECT_EQ(error(file("3", "1e308")), "no error");
  EXPECT_TRUE(contains(error(file("300", "1")), "type 300"));
  EXPECT_TRUE(contains(error(file("-1", "1")), "type -1"));
  EXPECT_TRUE(contains(error(file("3", "1 2")), "field \"f\" holds 2 numbers for 1 cells"));
  EXPECT_TRUE(contains(error("ply"), "not a file of VTK's XML"));
  EXPECT_TRUE(contains(error(""), "not a file of VTK's XML"));
  EXPECT_TRUE(contains(error(content(seeds() / "vtp_ascii.vtp")), "no unstructured grid"));
  const std::string one = file("3", "1");
  const std::size_t begin = one.find("<Piece"), end = one.find("</Piece>") + 8;
  EXPECT_TRUE(contains(error(one.substr(0, end) + one.substr(begin)), "more than one piece"));
  EXPECT_TRUE(contains(read_vtu("none.vtu").error().message(), "none.vtu"));
}

TEST(VtkFiles, PiecesAreJoined) {
  const std::string text = content(seeds() / "vtp_ascii.vtp");
  const std::size_t begin = text.find("<Piece"), end = text.find("</Piece>") + 8;
  const auto mesh = parse(text.substr(0, end) + text.substr(begin), "two.vtp");
  ASSERT_TRUE(mesh) << mesh.error().message();
  EXPECT_EQ(mesh->points.size(), 16U);
  EXPECT_NEAR(enclosed_volume(*mesh), 12, 1e-6);
}

TEST(VtkFiles, ErrorsSayWhatIsWrong) {
  const std::string legacy = content(seeds() / "vtk_legacy4_ascii.vtk"),
                    xml = content(seeds() / "vtp_ascii.vtp");
  EXPECT_TRUE(contains(error_of(replaced(legacy, "DATASET POLYDATA", "DATASET STRUCTURED_POINTS"), "a.vtk"),
                       "structured_points, not a surface"));
  EXPECT_TRUE(contains(error_of(replaced(legacy, "POINTS 8", "POINTS 800"), "a.vtk"), "line"));
  EXPECT_TRUE(
      contains(error_of(replaced(legacy, "0 0 0 1", "0 0 zero 1"), "a.vtk"), "\"zero\" is not a number"));
  EXPECT_TRUE(contains(error_of(replaced(legacy, "0 0 0 1", "0 0 nan 1"), "a.vtk"), "not finite"));
  EXPECT_TRUE(contains(error_of(replaced(legacy, "4 0 2 3 1", "4 0 2 3 8"), "a.vtk"), "point 8 of 8"));
  EXPECT_TRUE(contains(error_of(replaced(legacy, "4 0 2 3 1", "4000 0 2 3 1"), "a.vtk"), "does not end"));
  EXPECT_TRUE(contains(error_of(replaced(legacy, "POLYGONS", "PENTAGONS"), "a.vtk"), "pentagons"));
  EXPECT_TRUE(contains(error_of("solid\n", "a.vtk"), "does not begin with"));
  EXPECT_TRUE(contains(error_of(replaced(xml, "\"PolyData\"", "\"ImageData\""), "a.vtp"), "ImageData"));
  EXPECT_TRUE(contains(
      error_of(replaced(xml, "<VTKFile ", "<VTKFile compressor=\"vtkLZ4DataCompressor\" "), "a.vtp"), "LZ4"));
  EXPECT_TRUE(contains(error_of(replaced(xml, "NumberOfPoints=\"8\"", "NumberOfPoints=\"9\""), "a.vtp"),
                       "24 coordinates of 9 points"));
  EXPECT_TRUE(contains(error_of(replaced(xml, "<Points>", "<Points"), "a.vtp"), "damaged XML"));
  const std::string grid = content(seeds() / "vtk_grid4.vtk");
  EXPECT_TRUE(
      contains(error_of("# vtk DataFile Version 3.0\nt\nASCII\nDATASET UNSTRUCTURED_GRID\nPOINTS 4 float\n"
                        "0 0 0 1 0 0 0 1 0 0 0 1\nCELLS 1 5\n4 0 1 2 3\nCELL_TYPES 1\n10\n",
                        "a.vtk"),
               "Extract Surface"));
  EXPECT_TRUE(
      contains(error_of(replaced(grid, "CELL_TYPES 9", "CELL_TYPES 8"), "a.vtk"), "unknown section \"10\""));
}

TEST(GltfFiles, NodesMoveTheirMeshes) {
  // Turned by 90 degrees about z, flattened and mirrored along z, moved by 5 m along x; then metres to mm.
  for (const char* name : {"box.gltf", "box.glb"}) {
    const auto mesh = read_mesh(seeds() / name);
    ASSERT_TRUE(mesh) << mesh.error().message();
    TriMesh metres = *mesh;
    for (Vec3& p : metres.points) p /= 1000;
    EXPECT_NEAR(enclosed_volume(metres), 3, 1e-5) << name;
    EXPECT_TRUE(topology(*mesh).closed());
    const Box3 box = bounds(metres);
    // glTF: x from 3 to 5, y from 0 to 1, z from -1.5 to 0; ours are x, -z, y.
    EXPECT_LT(distance(box.lower, {3, 0, 0}), 1e-5) << name;
    EXPECT_LT(distance(box.upper, {5, 1.5, 1}), 1e-5) << name;
  }
}

TEST(GltfFiles, WhatWeWriteIsReadAgainInPlace) {
  const fs::path file = fs::path(::testing::TempDir()) / "again.glb";
  const TriMesh ball = testing::sphere(40, 2, {10, -20, 300}), cube = testing::box({50, 0, 0}, {60, 20, 30});
  ASSERT_TRUE(write_glb(file, {{"ball", &ball, {}, 0.6F, {}}, {"cube", &cube, {}, 0.6F, {}}}));
  const auto again = read_mesh(file);
  ASSERT_TRUE(again) << again.error().message();
  EXPECT_EQ(again->triangles.size(), ball.triangles.size() + cube.triangles.size());
  EXPECT_NEAR(enclosed_volume(*again), enclosed_volume(ball) + 6000, 1);
  const Box3 box = bounds(*again);
  EXPECT_LT(distance(box.lower, {-30, -60, 0}), 1e-3);
  EXPECT_LT(distance(box.upper, {60, 20, 340}), 1e-3);
  fs::remove(file);
}

TEST(GltfFiles, BuffersMayLieBesideTheFileOnly) {
  const std::string inside = content(seeds() / "box.gltf");
  const std::size_t from = inside.find("data:"), to = inside.find('"', from);
  const auto with_uri = [&](const std::string& uri) {
    return inside.substr(0, from) + uri + inside.substr(to);
  };
  const fs::path folder = fs::path(::testing::TempDir()) / "turgor_gltf";
  fs::create_directories(folder);
  const std::string glb = content(seeds() / "box.glb");
  const std::size_t chunk = glb.find(std::string("BIN\0", 4)) + 4;
  ASSERT_TRUE(write_file(folder / "a box.bin", std::string_view(glb).substr(chunk)));
  ASSERT_TRUE(write_file(folder / "box.gltf", with_uri("a%20box.bin")));
  const auto mesh = read_mesh(folder / "box.gltf");
  ASSERT_TRUE(mesh) << mesh.error().message();
  EXPECT_TRUE(topology(*mesh).closed());
  const std::string name = (folder / "other.gltf").string();
  for (const char* uri : {"../a.bin", "/etc/passwd", "http://example.org/a.bin", ""})
    EXPECT_TRUE(contains(error_of(with_uri(uri), name), "not beside it")) << uri;
  const auto missing = parse(with_uri("none.bin"), name);
  ASSERT_FALSE(missing);
  EXPECT_TRUE(contains(missing.error().message(), "none.bin"));
  EXPECT_TRUE(contains(error_of(with_uri("data:application/octet-stream;base64,AAAA"), name), "data URI"));
  fs::remove_all(folder);
}

TEST(GltfFiles, ErrorsSayWhatIsWrong) {
  const std::string good = content(seeds() / "box.gltf");
  const auto fault = [&](const char* from, const char* to) {
    return error_of(replaced(good, from, to), "a.gltf");
  };
  EXPECT_TRUE(
      contains(fault("\"asset\"", "\"extensionsRequired\":[\"KHR_draco_mesh_compression\"],\"asset\""),
               "KHR_draco_mesh_compression"));
  EXPECT_TRUE(contains(fault("\"children\":[1]", "\"children\":[0]"), "two places"));
  EXPECT_TRUE(contains(fault("\"children\":[1]", "\"children\":[9]"), "not there"));
  EXPECT_TRUE(contains(fault("\"count\":8", "\"count\":800000000"), "beyond its buffer"));
  EXPECT_TRUE(contains(fault("\"count\":8", "\"count\":7"), "names point 7 of 7"));
  EXPECT_TRUE(contains(fault("\"byteOffset\":0", "\"byteOffset\":99999"), "beyond its buffer"));
  EXPECT_TRUE(contains(fault("5123", "5126"), "components of type 5126"));
  EXPECT_TRUE(contains(fault("{\"asset\"", "{{\"asset\""), "JSON"));
  EXPECT_TRUE(contains(fault("\"mesh\":0", "\"mesh\":\"box\""), "mesh that is not there"));
  EXPECT_TRUE(contains(error_of("{}", "a.gltf"), "no triangles"));
  const std::string glb = content(seeds() / "box.glb");
  EXPECT_TRUE(contains(error_of(glb.substr(0, glb.size() - 1), "a.glb"), "truncated"));
  EXPECT_TRUE(contains(error_of(glb.substr(0, 16), "a.glb"), "truncated"));
}

TEST(DamagedFiles, NestedWithoutEndAreRefused) {
  for (const char* open : {"[", "{\"a\":", "<a>"}) {
    std::string text;
    while (text.size() < 1000000) text += open;
    for (const char* name : {"a.gltf", "a.vtp"}) EXPECT_FALSE(parse(text, name));
  }
}

TEST(DamagedFiles, OfVtkAndGltfAreRefusedOrSound) {
  for (const fs::path& file : files_of({".vtk", ".vtp", ".vtu", ".gltf", ".glb"})) {
    const std::string text = content(file), name = file.filename().string();
    const auto sound = [&](const std::string& changed) {
      const auto cells = parse_cells(changed, name);
      if (cells && cells->mesh.types.size() != cells->mesh.offsets.size()) return false;
      const auto mesh = parse(changed, name);
      if (mesh) return !mesh->empty() && static_cast<bool>(validate(*mesh));
      return !mesh.error().what.empty() && !mesh.error().where.empty() && !mesh.error().remedy.empty();
    };
    for (std::size_t n = 0; n < text.size(); n += 3)
      ASSERT_TRUE(sound(text.substr(0, n))) << name << ' ' << n;
    for (std::size_t i = 0; i<text.size(); i += text.size()> 1000 ? 3 : 1) {
      for (const char c : {'\xff', '9', '-'}) {
        std::string changed = text;
        changed[i] = c;
        ASSERT_TRUE(sound(changed)) << name << ' ' << i << ' ' << int{c};
      }
    }
  }
}

}  // namespace
}  // namespace turgor
