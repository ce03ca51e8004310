#include <gtest/gtest.h>

#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>

#include "shapes.hpp"
#include "turgor/core/file.hpp"
#include "turgor/geometry/mesh_file.hpp"

namespace turgor {
namespace {

namespace fs = std::filesystem;

Result<TriMesh> parse(std::string_view text, const std::string& name) {
  return parse_mesh(std::as_bytes(std::span(text.data(), text.size())), name);
}

void expect_fault(std::string_view text, const std::string& name, const std::string& where,
                  const std::string& what) {
  const auto mesh = parse(text, name);
  ASSERT_FALSE(mesh) << text;
  EXPECT_EQ(mesh.error().kind, ErrorKind::bad_input);
  EXPECT_NE(mesh.error().where.find(where), std::string::npos) << mesh.error().message();
  EXPECT_NE(mesh.error().what.find(what), std::string::npos) << mesh.error().message();
  EXPECT_FALSE(mesh.error().remedy.empty());
}

template <class T>
void put(std::string& out, T value, bool big = false) {
  char raw[sizeof(T)];
  std::memcpy(raw, &value, sizeof(T));
  if (big) std::reverse(raw, raw + sizeof(T));
  out.append(raw, sizeof(T));
}

const std::string ascii_ply =
    "ply\nformat ascii 1.0\ncomment made by hand\nelement vertex 5\nproperty float x\nproperty float nx\n"
    "property float y\nproperty double z\nproperty list uchar float extras\nelement face 2\n"
    "property uchar red\nproperty list uchar int vertex_indices\nelement edge 1\nproperty int a\nend_header\n"
    "0 9 0 0 0\n1 9 0 0 1 7\n1 9 1 0.5 2 7 8\n0 9 1 0 0\n-2.5e-1 9 +3 1 0\n255 4 0 1 2 3\n1 3 0 3 4\n77\n";

/// The same mesh in binary.
std::string binary_ply(bool big) {
  std::string out =
      std::string("ply\r\nformat binary_") + (big ? "big" : "little") +
      "_endian 1.0\r\nelement vertex 5\r\nproperty float32 x\r\nproperty short nx\r\nproperty float y\r\n"
      "property float64 z\r\nproperty list uint8 uint16 extras\r\nelement face 2\r\n"
      "property list ushort uint32 vertex_index\r\nproperty int8 flag\r\nend_header\r\n";
  const double points[5][3] = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0.5}, {0, 1, 0}, {-0.25, 3, 1}};
  for (int i = 0; i < 5; ++i) {
    put(out, static_cast<float>(points[i][0]), big);
    put(out, std::int16_t{-3}, big);
    put(out, static_cast<float>(points[i][1]), big);
    put(out, points[i][2], big);
    put(out, static_cast<std::uint8_t>(i % 3), big);
    for (int k = 0; k < i % 3; ++k) put(out, std::uint16_t{500}, big);
  }
  put(out, std::uint16_t{4}, big);
  for (const std::uint32_t v : {0U, 1U, 2U, 3U}) put(out, v, big);
  put(out, std::int8_t{-1}, big);
  put(out, std::uint16_t{3}, big);
  for (const std::uint32_t v : {0U, 3U, 4U}) put(out, v, big);
  put(out, std::int8_t{1}, big);
  return out;
}

void expect_house(const Result<TriMesh>& mesh) {
  ASSERT_TRUE(mesh) << mesh.error().message();
  ASSERT_EQ(mesh->points.size(), 5U);
  EXPECT_EQ(mesh->points[2], (Vec3{1, 1, 0.5}));
  EXPECT_EQ(mesh->points[4], (Vec3{-0.25, 3, 1}));
  EXPECT_EQ(mesh->triangles, (std::vector<Index3>{{0, 1, 2}, {0, 2, 3}, {0, 3, 4}}));
}

const std::string off =
    "OFF # a house\n\n5 2 0\n0 0 0\n1 0 0 255 0 0\n1 1 0.5\n# between\n0 1 0\n-0.25 3 1\n4 0 1 2 3\n3 0 3 4 "
    "1 0 0\n";
const std::string obj =
    "# a house\r\nmtllib x.mtl\r\no house\r\nv 0 0 0\r\nv 1 0 0 1\r\nv 1 1 .5\r\nvt 0 0\r\nvn 0 0 1\r\nv 0 1 "
    "0\r\nf 1/1 2/1 3/1 \\\r\n4/1\r\n"
    "v -0.25 3 1\r\ns off\r\nf -5//1 -2//1 -1/1/1 # roof\r\n";
const std::string ascii_stl =
    "solid house\n facet normal 0 0 1\n  outer loop\n   vertex 0 0 0\n   vertex 1 0 0\n   vertex 1 1 0.5\n  "
    "endloop\n endfacet\n"
    "FACET NORMAL 0 0 1\nOUTER LOOP\nVERTEX -0 0 0\nVERTEX 1 1 0.5\nVERTEX 0 1 0\nENDLOOP\nENDFACET\n"
    "facet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 0 1 0\nvertex -2.5E-1 3 "
    "1\nendloop\nendfacet\nendsolid house\n";

std::string binary_stl() {
  std::string out(80, ' ');
  out.replace(0, 5, "solid");
  put(out, std::uint32_t{3});
  const float p[5][3] = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0.5F}, {0, 1, 0}, {-0.25F, 3, 1}};
  for (const Index3& t : {Index3{0, 1, 2}, {0, 2, 3}, {0, 3, 4}}) {
    for (int i = 0; i < 3; ++i) put(out, 0.0F);
    for (const int corner : t) {
      for (int i = 0; i < 3; ++i) put(out, p[corner][i]);
    }
    put(out, std::uint16_t{0});
  }
  return out;
}

TEST(ReadMesh, TakesTheSameSurfaceFromEveryFormat) {
  expect_house(parse(ascii_ply, "a.ply"));
  expect_house(parse(binary_ply(false), "a.ply"));
  expect_house(parse(binary_ply(true), "a"));
  expect_house(parse(off, "a.off"));
  expect_house(parse("COFF" + off.substr(3), "a"));
  expect_house(parse(obj, "a.obj"));
  expect_house(parse(ascii_stl, "a.stl"));
  expect_house(parse(binary_stl(), "a.stl"));
  expect_house(parse(binary_stl(), "a.STL"));
}

TEST(ReadMesh, ContentDecidesWhereTheExtensionIsWrong) {
  expect_house(parse(ascii_ply, "a.stl"));
  expect_house(parse(ascii_stl, "a.dat"));
  expect_house(parse(obj, "a.txt"));
}

TEST(ReadMesh, NamesFileAndPlaceOfEachFault) {
  const auto broken = [](std::string text, const std::string& from, const std::string& to) {
    const auto at = text.find(from);
    EXPECT_NE(at, std::string::npos) << from;
    return text.replace(at, from.size(), to);
  };
  expect_fault("", "x.ply", "x.ply", "empty");
  expect_fault("hello\n", "x.abc", "x.abc", "not a surface file");
  expect_fault("hello\n", "x.ply", "x.ply, byte 0", "does not begin");
  expect_fault(broken(ascii_ply, "3 0 3 4", "3 0 3 5"), "x.ply", "x.ply, line 22",
               "face 1 names point 5 of 5");
  expect_fault(broken(ascii_ply, "3 0 3 4", "3 0 -1 4"), "x.ply", "line 22", "names point -1");
  expect_fault(broken(ascii_ply, "1 9 1 0.5", "1 9 nan 0.5"), "x.ply", "line 18",
               "point 2 is not a finite number");
  expect_fault(broken(ascii_ply, "1 9 1 0.5", "1 9 1e999 0.5"), "x.ply", "line 18", "not a number");
  expect_fault(broken(ascii_ply, "1 9 1 0.5", "1 9 one 0.5"), "x.ply", "line 18", "not a number: vertex 2");
  expect_fault(broken(ascii_ply, "element vertex 5", "element vertex 9000000000000000000"), "x.ply", "x.ply",
               "");
  expect_fault(broken(ascii_ply, "element vertex 5", "element vertex 2000000000"), "x.ply", "line",
               "truncated");
  expect_fault(broken(ascii_ply, "element vertex 5", "element vertex -5"), "x.ply", "line 4",
               "element without a number");
  expect_fault(broken(ascii_ply, "property float nx", "property quad nx"), "x.ply", "line 6",
               "property not understood");
  expect_fault(broken(ascii_ply, "property float y", "property float why"), "x.ply", "x.ply",
               "no property \"y\"");
  expect_fault(broken(ascii_ply, "vertex_indices", "vertices"), "x.ply", "x.ply", "vertex_indices");
  expect_fault(broken(ascii_ply, "format ascii", "format runes"), "x.ply", "line 2", "unknown PLY format");
  expect_fault(broken(ascii_ply, "element face 2", "element face 0"), "x.ply", "x.ply", "no triangles");
  expect_fault(broken(ascii_ply, "255 4 0", "255 400000000 0"), "x.ply", "line 21",
               "announces a list of 400000000");
  std::string huge = binary_ply(false);
  expect_fault(broken(huge, "element face 2", "element face 4000000000"), "x.ply", "byte", "truncated");
  std::string nan_ply = binary_ply(false);
  const float nan = std::numeric_limits<float>::quiet_NaN();
  std::memcpy(&nan_ply[nan_ply.find("end_header\r\n") + 12], &nan, 4);
  expect_fault(nan_ply, "x.ply", "byte", "point 0 is not a finite number");
  expect_fault(broken(off, "4 0 1 2 3", "4 0 1 2 5"), "x.off", "line 10", "names point 5 of 5");
  expect_fault(broken(off, "4 0 1 2 3", "4 0 1 2"), "x.off", "line 10", "a face of 4 corners names 3");
  expect_fault(broken(off, "5 2 0", "5000000000 2 0"), "x.off", "line 3", "announced");
  expect_fault(broken(off, "0 1 0", "0 inf 0"), "x.off", "line 8", "not a finite number");
  expect_fault(broken(obj, "f -5//1", "f -6//1"), "x.obj", "line 14", "not there");
  expect_fault(broken(obj, "f -5//1", "f 0//1"), "x.obj", "line 14", "not there");
  expect_fault(broken(obj, "f -5//1", "f 6//1"), "x.obj", "line 14", "names point 6 of 5");
  expect_fault(broken(obj, "v 1 0 0 1", "v 1 0"), "x.obj", "line 5", "three numbers");
  expect_fault("v 0 0 0\nv 1 0 0\nv 0 1 0\n", "x.obj", "x.obj", "no triangles");
  expect_fault(broken(ascii_stl, "vertex 1 0 0", "vertex 1 nan 0"), "x.stl", "line 5", "not a finite number");
  expect_fault(broken(ascii_stl, "vertex 1 0 0", "vertex 1 0"), "x.stl", "line 5", "three numbers");
  expect_fault(broken(ascii_stl, "   vertex 1 0 0\n", ""), "x.stl", "line 6", "fewer than three");
  expect_fault("solid nothing\nendsolid nothing\n", "x.stl", "x.stl", "no triangles");
  std::string bad_stl = binary_stl();
  std::memcpy(&bad_stl[84 + 50 + 12], &nan, 4);
  expect_fault(bad_stl, "x.stl", "byte 134", "triangle 1 is not a finite number");
  std::string more = binary_stl();
  more[80] = 100;
  expect_fault(more, "x.stl", "byte 234", "truncated: 3 of 100");
}

TEST(ReadMesh, SurvivesEveryTruncation) {
  const std::vector<std::pair<std::string, std::string>> files{
      {ascii_ply, "t.ply"}, {binary_ply(false), "t.ply"}, {binary_ply(true), "t.ply"}, {off, "t.off"},
      {obj, "t.obj"},       {ascii_stl, "t.stl"},         {binary_stl(), "t.stl"}};
  for (const auto& [text, name] : files) {
    int faults = 0;
    for (std::size_t n = 0; n < text.size(); ++n) {
      const auto mesh = parse(std::string_view(text).substr(0, n), name);
      if (!mesh) {
        ++faults;
        EXPECT_FALSE(mesh.error().what.empty());
      } else {
        EXPECT_TRUE(validate(*mesh));
      }
    }
    EXPECT_GT(faults, static_cast<int>(text.size() / 2)) << name;
  }
  // Formats that say how much there must be do not let any of it go missing.
  for (const auto& text : {binary_ply(false), binary_ply(true), binary_stl()}) {
    for (std::size_t n = 0; n < text.size(); ++n)
      EXPECT_FALSE(parse(std::string_view(text).substr(0, n), "t.stl")) << n;
  }
}

TEST(ReadMesh, SurvivesEveryChangedByte) {
  for (const auto& [text, name] : {std::pair{ascii_ply, "t.ply"},
                                   {binary_ply(false), "t.ply"},
                                   {off, "t.off"},
                                   {obj, "t.obj"},
                                   {ascii_stl, "t.stl"},
                                   {binary_stl(), "t.stl"}}) {
    for (std::size_t i = 0; i < text.size(); ++i) {
      for (const char c : {'\0', '\xff', '9', '-', '\n', ' '}) {
        std::string changed = text;
        changed[i] = c;
        const auto mesh = parse(changed, name);
        if (mesh) {
          EXPECT_TRUE(validate(*mesh));
        }
      }
    }
  }
}

TEST(ReadMesh, DropsTrianglesWithoutArea) {
  const auto mesh = parse("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 1 2\nf 1 2 3\nf 1 2 2 3\n", "x.obj");
  ASSERT_TRUE(mesh);
  EXPECT_EQ(mesh->triangles, (std::vector<Index3>{{0, 1, 2}, {0, 1, 2}}));
}

TEST(ReadMesh, AMissingFileAndAFolderAreNamed) {
  EXPECT_NE(read_mesh("/nowhere/at/all.ply").error().message().find("/nowhere/at/all.ply"),
            std::string::npos);
  EXPECT_NE(read_mesh("/tmp").error().what.find("folder"), std::string::npos);
}

/// The shared data folder beside the project, where it is there.
fs::path shared_data() {
  return fs::path(TURGOR_SOURCE_DIR).parent_path() / "shared" / "data";
}

TEST(ReadMesh, RealScansHaveTheirKnownFeatures) {
  struct Known {
    const char* file;
    std::size_t points, triangles;
    int boundary;
    bool manifold;
  };
  if (!fs::exists(shared_data() / "meshes")) GTEST_SKIP() << "no shared/data/meshes beside the project";
  for (const Known& known :
       {Known{"bunny.ply", 35947, 69451, 223, true}, Known{"gear.ply", 500, 1000, 0, true},
        Known{"happy_15535.ply", 7753, 15535, 6, false},
        Known{"dragon_vrip_res2.ply", 100250, 202520, 0, false}}) {
    const auto mesh = read_mesh(shared_data() / "meshes" / known.file);
    ASSERT_TRUE(mesh) << mesh.error().message();
    EXPECT_EQ(mesh->points.size(), known.points);
    EXPECT_EQ(mesh->triangles.size(), known.triangles);
    const Topology found = topology(*mesh);
    EXPECT_EQ(found.boundary_edges, known.boundary);
    EXPECT_EQ(found.non_manifold_edges == 0, known.manifold);
  }
}

TEST(ReadMesh, EverySurfaceInTheSharedDataIsRead) {
  if (!fs::exists(shared_data())) GTEST_SKIP() << "no shared/data beside the project";
  int count = 0;
  for (const auto& entry : fs::recursive_directory_iterator(shared_data())) {
    const std::string extension = entry.path().extension().string();
    if (extension != ".ply" && extension != ".obj") continue;
    const auto mesh = read_mesh(entry.path());
    ASSERT_TRUE(mesh) << mesh.error().message();
    EXPECT_TRUE(validate(*mesh)) << entry.path();
    ++count;
  }
  EXPECT_GE(count, 10);
}

}  // namespace
}  // namespace turgor
