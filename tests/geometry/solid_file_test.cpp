// Solids to files and back.
#include "turgor/geometry/solid_file.hpp"

#include <gtest/gtest.h>
#include <unistd.h>

#include <cstring>
#include <filesystem>
#include <fstream>
#include <map>
#include <sstream>
#include <string>

#include "geometry/shapes.hpp"
#include "turgor/core/file.hpp"
#include "turgor/core/index.hpp"

namespace turgor {
namespace {

namespace fs = std::filesystem;

class SolidFiles : public ::testing::Test {
 protected:
  void SetUp() override {
    folder_ = fs::temp_directory_path() / ("turgor_solid_" + std::to_string(::getpid()));
    fs::create_directories(folder_);
    VoxelOptions options;
    options.resolution = 7;
    const auto voxels = voxelise(testing::torus(10, 3, 30, 15), options);
    ASSERT_TRUE(voxels);
    auto solid = solid_of(*voxels);
    ASSERT_TRUE(solid);
    solid_ = *std::move(solid);
    cubes_ = hexahedra(solid_);
  }
  void TearDown() override { fs::remove_all(folder_); }

  fs::path write(const std::string& name, SolidCells cells = SolidCells::tetrahedra) {
    const auto done = write_solid(folder_ / name, solid_, cells);
    EXPECT_TRUE(done) << (done ? "" : done.error().message());
    return folder_ / name;
  }
  /// The lines of a text file that are not comments, commas as blanks.
  static std::istringstream text_of(const fs::path& path) {
    std::ifstream in(path);
    std::string line, all;
    while (std::getline(in, line)) {
      if (line.empty() || line[0] == '#') continue;
      for (char& c : line)
        if (c == ',') c = ' ';
      all += line + '\n';
    }
    return std::istringstream(all);
  }
  /// The next `count` numbers are these.
  template <class Values>
  static void expect_numbers(std::istream& in, const Values& values, int add = 0) {
    for (const int wanted : values) {
      int found = -1;
      in >> found;
      ASSERT_EQ(found, wanted + add);
    }
  }
  static void expect_point(std::istream& in, const Vec3& wanted) {
    Vec3 found;
    in >> found.x >> found.y >> found.z;
    ASSERT_EQ(found, wanted);
  }
  template <class T>
  static T next(std::istream& in) {
    T value{};
    in >> value;
    return value;
  }
  static void skip_to(std::istream& in, const std::string& word) {
    for (std::string w; in >> w && w != word;) continue;
    ASSERT_TRUE(in) << word;
  }

  fs::path folder_;
  SolidMesh solid_;
  std::vector<std::array<int, 8>> cubes_;
};

TEST_F(SolidFiles, TetGensThree) {
  write("ring.ele");
  std::istringstream node = text_of(folder_ / "ring.node"), ele = text_of(folder_ / "ring.ele"),
                     face = text_of(folder_ / "ring.face");
  expect_numbers(node, std::array{static_cast<int>(solid_.points.size()), 3, 0, 1});
  for (std::size_t p = 0; p < solid_.points.size(); ++p) {
    ASSERT_EQ(next<std::size_t>(node), p);
    expect_point(node, solid_.points[p]);
    ASSERT_EQ(next<int>(node), solid_.on_surface[p]);
  }
  expect_numbers(ele, std::array{static_cast<int>(solid_.tetrahedra.size()), 4, 0});
  for (std::size_t t = 0; t < solid_.tetrahedra.size(); ++t) {
    ASSERT_EQ(next<std::size_t>(ele), t);
    expect_numbers(ele, solid_.tetrahedra[t]);
  }
  expect_numbers(face, std::array{static_cast<int>(solid_.surface_triangles.size()), 1});
  for (std::size_t t = 0; t < solid_.surface_triangles.size(); ++t) {
    ASSERT_EQ(next<std::size_t>(face), t);
    expect_numbers(face, solid_.surface_triangles[t]);
    ASSERT_EQ(next<int>(face), 1);
  }
}

TEST_F(SolidFiles, Gmsh) {
  for (const bool cubes : {false, true}) {
    std::istringstream in =
        text_of(write("ring.msh", cubes ? SolidCells::hexahedra : SolidCells::tetrahedra));
    skip_to(in, "$Nodes");
    const int points = static_cast<int>(solid_.points.size());
    expect_numbers(in, std::array{1, points, 1, points, 3, 1, 0, points});
    for (int p = 1; p <= points; ++p) ASSERT_EQ(next<int>(in), p);
    for (const Vec3& p : solid_.points) expect_point(in, p);
    skip_to(in, "$Elements");
    const int cells = static_cast<int>(cubes ? cubes_.size() : solid_.tetrahedra.size());
    const int faces = static_cast<int>(solid_.surface_triangles.size()) / (cubes ? 2 : 1);
    expect_numbers(in, std::array{2, cells + faces, 1, cells + faces, 3, 1, cubes ? 5 : 4, cells});
    for (int c = 0; c < cells; ++c) {
      ASSERT_EQ(next<int>(in), c + 1);
      if (cubes) expect_numbers(in, cubes_[at(c)], 1);
      if (!cubes) expect_numbers(in, solid_.tetrahedra[at(c)], 1);
    }
    expect_numbers(in, std::array{2, 1, cubes ? 3 : 2, faces});
    double area = 0;
    for (int f = 0; f < faces; ++f) {
      ASSERT_EQ(next<int>(in), cells + f + 1);
      std::vector<Vec3> corners;
      for (int n = 0; n < (cubes ? 4 : 3); ++n) corners.push_back(solid_.points[at(next<int>(in) - 1)]);
      area += 0.5 * length(cross(corners[1] - corners[0], corners[2] - corners[0]));
      if (cubes) area += 0.5 * length(cross(corners[2] - corners[0], corners[3] - corners[0]));
    }
    EXPECT_NEAR(
        area / (0.5 * static_cast<double>(solid_.surface_triangles.size()) * solid_.spacing * solid_.spacing),
        1, 1e-12);
    ASSERT_EQ(next<std::string>(in), "$EndElements");
  }
}

TEST_F(SolidFiles, AbaqusAndCalculix) {
  // Corners of S1, S2 ... as the manual of CalculiX numbers them.
  constexpr int tetrahedron[4][3] = {{1, 2, 3}, {1, 4, 2}, {2, 4, 3}, {3, 4, 1}};
  constexpr int cube[6][4] = {{1, 2, 3, 4}, {5, 8, 7, 6}, {1, 5, 6, 2},
                              {2, 6, 7, 3}, {3, 7, 8, 4}, {4, 8, 5, 1}};
  for (const bool cubes : {false, true}) {
    std::istringstream in =
        text_of(write("ring.inp", cubes ? SolidCells::hexahedra : SolidCells::tetrahedra));
    skip_to(in, "NSET=POINTS");
    for (std::size_t p = 0; p < solid_.points.size(); ++p) {
      ASSERT_EQ(next<std::size_t>(in), p + 1);
      expect_point(in, solid_.points[p]);
    }
    skip_to(in, cubes ? "TYPE=C3D8" : "TYPE=C3D4");
    skip_to(in, "ELSET=SOLID");
    const std::size_t cells = cubes ? cubes_.size() : solid_.tetrahedra.size();
    for (std::size_t c = 0; c < cells; ++c) {
      ASSERT_EQ(next<std::size_t>(in), c + 1);
      if (cubes) expect_numbers(in, cubes_[c], 1);
      if (!cubes) expect_numbers(in, solid_.tetrahedra[c], 1);
    }
    skip_to(in, "NSET=SURFACE_POINTS");
    for (std::size_t p = 0; p < solid_.points.size(); ++p)
      if (solid_.on_surface[p] != 0) ASSERT_EQ(next<std::size_t>(in), p + 1);
    skip_to(in, "TYPE=ELEMENT");
    // Each face named is made of points of the surface, and no face is named twice.
    std::map<std::string, int> seen;
    int cell = 0;
    for (std::string face; in >> cell >> face;) {
      EXPECT_EQ(seen[std::to_string(cell) + face]++, 0);
      const int s = face[1] - '1';
      for (int n = 0; n < (cubes ? 4 : 3); ++n) {
        const int p = cubes ? cubes_[at(cell - 1)][at(cube[s][n] - 1)]
                            : solid_.tetrahedra[at(cell - 1)][at(tetrahedron[s][n] - 1)];
        ASSERT_EQ(solid_.on_surface[at(p)], 1);
      }
    }
    EXPECT_EQ(seen.size(), solid_.surface_triangles.size() / (cubes ? 2 : 1));
  }
}

/// The appended array of this name: its values, and where its bytes end.
template <class T>
std::vector<T> vtu_array(const std::string& file, const std::string& name, std::size_t from = 0) {
  const std::size_t element = file.find("Name=\"" + name + "\"", from);
  const std::size_t offset = file.find("offset=\"", element) + 8;
  const char* data =
      file.data() + file.find("<AppendedData encoding=\"raw\">\n_") + 31 + std::stoul(file.substr(offset));
  std::uint64_t bytes = 0;
  std::memcpy(&bytes, data, 8);
  std::vector<T> values(bytes / sizeof(T));
  std::memcpy(values.data(), data + 8, bytes);
  return values;
}

TEST_F(SolidFiles, Vtu) {
  for (const bool cubes : {false, true}) {
    std::ifstream in(write("ring.vtu", cubes ? SolidCells::hexahedra : SolidCells::tetrahedra),
                     std::ios::binary);
    const std::string file{std::istreambuf_iterator<char>(in), {}};
    const auto points = vtu_array<Vec3f>(file, "Points");
    ASSERT_EQ(points.size(), solid_.points.size());
    for (std::size_t p = 0; p < points.size(); ++p) ASSERT_EQ(points[p], to_float(solid_.points[p]));
    const auto connectivity = vtu_array<int>(file, "connectivity");
    const auto types = vtu_array<std::uint8_t>(file, "types");
    const auto tags = vtu_array<float>(file, "surface", file.find("<CellData>"));
    const auto point_tags = vtu_array<float>(file, "surface", file.find("<PointData>"));
    const std::size_t cells = cubes ? cubes_.size() : solid_.tetrahedra.size(), corners = cubes ? 8 : 4;
    ASSERT_EQ(types.size(), cells + solid_.surface_triangles.size() / (cubes ? 2 : 1));
    ASSERT_EQ(tags.size(), types.size());
    for (std::size_t c = 0; c < types.size(); ++c) {
      ASSERT_EQ(tags[c], c < cells ? 0 : 1);
      ASSERT_EQ(int{types[c]}, c < cells ? (cubes ? 12 : 10) : (cubes ? 9 : 5));
    }
    for (std::size_t n = 0; n < corners * cells; ++n)
      ASSERT_EQ(connectivity[n], cubes ? cubes_[n / 8][n % 8] : solid_.tetrahedra[n / 4][n % 4]);
    for (std::size_t p = 0; p < points.size(); ++p) ASSERT_EQ(point_tags[p], solid_.on_surface[p]);
  }
}

TEST_F(SolidFiles, PlainBinaryReadsBackWhole) {
  const auto four = read_solid(write("ring.solid"));
  ASSERT_TRUE(four) << four.error().message();
  EXPECT_EQ(four->corners, 4);
  EXPECT_EQ(four->spacing, solid_.spacing);
  EXPECT_TRUE(
      std::equal(four->points.begin(), four->points.end(), solid_.points.begin(), solid_.points.end()));
  ASSERT_EQ(four->cells.size(), 4 * solid_.tetrahedra.size());
  for (std::size_t n = 0; n < four->cells.size(); ++n)
    ASSERT_EQ(four->cells[n], solid_.tetrahedra[n / 4][n % 4]);
  EXPECT_TRUE(std::equal(four->surface_triangles.begin(), four->surface_triangles.end(),
                         solid_.surface_triangles.begin(), solid_.surface_triangles.end()));
  EXPECT_TRUE(std::equal(four->surface_cells.begin(), four->surface_cells.end(), solid_.surface_cells.begin(),
                         solid_.surface_cells.end()));
  EXPECT_EQ(four->on_surface, solid_.on_surface);
  const auto eight = read_solid(write("ring.solid", SolidCells::hexahedra));
  ASSERT_TRUE(eight) << eight.error().message();
  EXPECT_EQ(eight->corners, 8);
  ASSERT_EQ(eight->cells.size(), 8 * cubes_.size());
  for (std::size_t n = 0; n < eight->cells.size(); ++n) ASSERT_EQ(eight->cells[n], cubes_[n / 8][n % 8]);
}

TEST_F(SolidFiles, DamagedPlainFilesAreRefused) {
  const auto bytes = read_file(write("ring.solid"));
  ASSERT_TRUE(bytes);
  const fs::path bad = folder_ / "bad.solid";
  const auto refused = [&](const std::vector<std::byte>& content) {
    EXPECT_TRUE(write_file(bad, std::span<const std::byte>(content)));
    const auto solid = read_solid(bad);
    return !solid && solid.error().kind == ErrorKind::bad_input;
  };
  for (const std::size_t length : {std::size_t{0}, std::size_t{7}, std::size_t{40}, bytes->size() - 1})
    EXPECT_TRUE(refused({bytes->begin(), bytes->begin() + static_cast<std::ptrdiff_t>(length)}));
  for (const std::size_t place : {0, 15, 23, 24, 31, 39}) {  // magic, counts and spacing
    auto changed = *bytes;
    changed[place] = std::byte{0xff};
    if (place == 39) changed[38] = std::byte{0xff};
    EXPECT_TRUE(refused(changed)) << place;
  }
  auto changed = *bytes;
  changed[48 + 24 * solid_.points.size() + 3] = std::byte{0x7f};  // the first corner of the first cell
  EXPECT_TRUE(refused(changed));
}

TEST_F(SolidFiles, OtherNamesAndImpossibleCellsAreErrors) {
  EXPECT_FALSE(write_solid(folder_ / "ring.stl", solid_, SolidCells::tetrahedra));
  EXPECT_FALSE(write_solid(folder_ / "ring", solid_, SolidCells::tetrahedra));
  EXPECT_FALSE(write_solid(folder_ / "ring.node", solid_, SolidCells::hexahedra));
  EXPECT_FALSE(write_solid(folder_ / "nowhere" / "ring.node", solid_, SolidCells::tetrahedra));
  EXPECT_TRUE(fs::is_empty(folder_));
}

}  // namespace
}  // namespace turgor
