#include <gtest/gtest.h>
#include <unistd.h>

#include <cstring>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "shapes.hpp"
#include "turgor/core/file.hpp"
#include "turgor/geometry/mesh_file.hpp"

namespace turgor {
namespace {

namespace fs = std::filesystem;

class WriteMesh : public ::testing::Test {
 protected:
  void SetUp() override {
    folder_ = fs::temp_directory_path() / ("turgor_write_mesh_" + std::to_string(::getpid()));
    fs::create_directories(folder_);
  }
  void TearDown() override { fs::remove_all(folder_); }
  fs::path folder_;
};

std::string content(const fs::path& path) {
  auto text = read_text_file(path);
  EXPECT_TRUE(text);
  return text ? *text : std::string{};
}

template <class T>
T number_at(const std::string& bytes, std::size_t at) {
  T value{};
  EXPECT_LE(at + sizeof(T), bytes.size());
  if (at + sizeof(T) <= bytes.size()) std::memcpy(&value, bytes.data() + at, sizeof(T));
  return value;
}

MeshField heights(const TriMesh& mesh) {
  MeshField field{"height over <base>", 1, {}};
  for (const Vec3& p : mesh.points) field.values.push_back(static_cast<float>(p.z));
  return field;
}

TEST_F(WriteMesh, PlyComesBackAsItWas) {
  const TriMesh mesh = testing::sphere(50, 3, {1, 2, 3});
  MeshField move{"move", 3, std::vector<float>(mesh.points.size() * 3, 0.5F)};
  ASSERT_TRUE(write_ply(folder_ / "a.ply", mesh, {heights(mesh), move}));
  const auto back = read_mesh(folder_ / "a.ply");
  ASSERT_TRUE(back) << back.error().message();
  EXPECT_EQ(back->triangles, mesh.triangles);
  for (std::size_t i = 0; i < mesh.points.size(); ++i)
    EXPECT_LT(distance(back->points[i], mesh.points[i]), 1e-5);
  const std::string text = content(folder_ / "a.ply");
  EXPECT_NE(text.find("property float height_over__base_\nproperty float move_0\nproperty float move_1\n"),
            std::string::npos);
  EXPECT_NE(text.find("LPS"), std::string::npos);
  // The fields lie behind the coordinates of each point.
  const std::size_t data = text.find("end_header\n") + 11;
  EXPECT_EQ(number_at<float>(text, data + 28 * 7 + 12), static_cast<float>(mesh.points[7].z));
  EXPECT_EQ(number_at<float>(text, data + 28 * 7 + 24), 0.5F);
}

/// The value of an attribute of the first element at or after `from`.
std::string attribute(const std::string& text, const std::string& name, std::size_t from) {
  const std::size_t start = text.find(name + "=\"", from) + name.size() + 2;
  return text.substr(start, text.find('"', start) - start);
}

/// An appended array found by its name, checked against its announced length.
template <class T>
std::vector<T> appended(const std::string& text, const std::string& name, const std::string& type) {
  const std::size_t element = text.find("Name=\"" + name + "\"");
  EXPECT_NE(element, std::string::npos) << name;
  if (element == std::string::npos) return {};
  const std::size_t tag = text.rfind("<DataArray", element);
  EXPECT_EQ(attribute(text, "type", tag), type);
  const std::size_t base = text.find("<AppendedData encoding=\"raw\">\n_") + 31;
  const std::size_t at = base + std::stoul(attribute(text, "offset", tag));
  const auto bytes = number_at<std::uint64_t>(text, at);
  EXPECT_EQ(bytes % sizeof(T), 0U);
  std::vector<T> values(bytes / sizeof(T));
  EXPECT_LE(at + 8 + bytes, text.size());
  std::memcpy(values.data(), text.data() + at + 8, bytes);
  return values;
}

TEST_F(WriteMesh, VtpHoldsPointsTrianglesAndFieldsAtItsOffsets) {
  const TriMesh mesh = testing::sphere(5, 2);
  ASSERT_TRUE(write_vtp(folder_ / "a.vtp", mesh, {heights(mesh)}));
  const std::string text = content(folder_ / "a.vtp");
  EXPECT_EQ(attribute(text, "NumberOfPoints", 0), std::to_string(mesh.points.size()));
  EXPECT_EQ(attribute(text, "NumberOfPolys", 0), std::to_string(mesh.triangles.size()));
  EXPECT_EQ(attribute(text, "header_type", 0), "UInt64");
  const auto points = appended<float>(text, "Points", "Float32");
  ASSERT_EQ(points.size(), 3 * mesh.points.size());
  EXPECT_EQ(points[10], static_cast<float>(mesh.points[3].y));
  const auto connectivity = appended<std::int32_t>(text, "connectivity", "Int32");
  ASSERT_EQ(connectivity.size(), 3 * mesh.triangles.size());
  EXPECT_EQ(connectivity[7], mesh.triangles[2][1]);
  const auto offsets = appended<std::int32_t>(text, "offsets", "Int32");
  EXPECT_EQ(offsets.back(), static_cast<std::int32_t>(connectivity.size()));
  EXPECT_EQ(appended<float>(text, "height_over__base_", "Float32"), heights(mesh).values);
  EXPECT_TRUE(text.ends_with("\n</AppendedData>\n</VTKFile>\n"));
}

TEST_F(WriteMesh, VtuHoldsMixedCells) {
  CellMesh mesh;
  mesh.points = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {1, 0, 1}, {0, 1, 1}};
  mesh.connectivity = {0, 1, 2, 3, 4, 5, 0, 3, 0, 1, 2};
  mesh.offsets = {6, 8, 11};
  mesh.types = {13, 3, 5};
  const MeshField stiffness{"stiffness", 1, {1, 2, 3}}, move{"move", 3, std::vector<float>(18, 2)};
  ASSERT_TRUE(write_vtu(folder_ / "a.vtu", mesh, {move}, {stiffness}));
  const std::string text = content(folder_ / "a.vtu");
  EXPECT_EQ(attribute(text, "NumberOfCells", 0), "3");
  EXPECT_EQ(appended<std::uint8_t>(text, "types", "UInt8"), mesh.types);
  EXPECT_EQ(appended<std::int32_t>(text, "offsets", "Int32"), mesh.offsets);
  EXPECT_EQ(appended<std::int32_t>(text, "connectivity", "Int32"), mesh.connectivity);
  EXPECT_EQ(appended<float>(text, "stiffness", "Float32"), stiffness.values);
  EXPECT_LT(text.find("<PointData>"), text.find("Name=\"move\""));
  EXPECT_LT(text.find("<CellData>"), text.find("Name=\"stiffness\""));
  mesh.connectivity[3] = 6;
  EXPECT_FALSE(write_vtu(folder_ / "b.vtu", mesh));
  EXPECT_FALSE(fs::exists(folder_ / "b.vtu"));
}

struct Glb {
  nlohmann::json json;
  std::string binary;
};
Glb read_glb(const std::string& bytes) {
  EXPECT_EQ(bytes.substr(0, 4), "glTF");
  EXPECT_EQ(number_at<std::uint32_t>(bytes, 4), 2U);
  EXPECT_EQ(number_at<std::uint32_t>(bytes, 8), bytes.size());
  const auto json = number_at<std::uint32_t>(bytes, 12);
  EXPECT_EQ(json % 4, 0U);
  EXPECT_EQ(bytes.substr(16, 4), "JSON");
  Glb glb;
  glb.json = nlohmann::json::parse(bytes.substr(20, json), nullptr, false);
  EXPECT_FALSE(glb.json.is_discarded());
  if (bytes.size() == 20 + json) return glb;
  const auto binary = number_at<std::uint32_t>(bytes, 20 + json);
  EXPECT_EQ(binary % 4, 0U);
  EXPECT_EQ(bytes.substr(24 + json, 4), std::string("BIN\0", 4));
  EXPECT_EQ(bytes.size(), 28 + json + binary);
  glb.binary = bytes.substr(28 + json);
  return glb;
}

/// Values of an accessor, its view checked against the buffer.
template <class T>
std::vector<T> accessed(const Glb& glb, std::size_t accessor, std::size_t components) {
  const auto& a = glb.json["accessors"][accessor];
  const auto& view = glb.json["bufferViews"][a["bufferView"].get<std::size_t>()];
  const auto start = view["byteOffset"].get<std::size_t>(), length = view["byteLength"].get<std::size_t>();
  EXPECT_EQ(start % 4, 0U);
  EXPECT_LE(start + length, glb.json["buffers"][0]["byteLength"].get<std::size_t>());
  EXPECT_LE(start + length, glb.binary.size());
  EXPECT_EQ(length, a["count"].get<std::size_t>() * components * sizeof(T));
  std::vector<T> values(length / sizeof(T));
  std::memcpy(values.data(), glb.binary.data() + start, length);
  return values;
}

TEST_F(WriteMesh, GlbIsInMetresWithYUpAndTheFaceTowardsZ) {
  // One leg to the patient's left, one up, and the nose to the front (-y).
  const TriMesh mesh{{{100, 0, 0}, {0, -200, 0}, {0, 0, 300}, {0, 0, 0}}, {{0, 1, 2}, {0, 2, 3}}};
  GltfBody body{"skin \"after\"\n", &mesh, {0.5F, 0.25F, 1.0F}, 0.7F, {}};
  GltfBody coloured{"map", &mesh, {0.5F, 0.25F, 1.0F}, 0.7F, {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {2, -1, 0}}};
  const TriMesh nothing;
  ASSERT_TRUE(write_glb(folder_ / "a.glb", {body, coloured, {"nothing", &nothing, {}, 0, {}}}));
  const Glb glb = read_glb(content(folder_ / "a.glb"));
  EXPECT_EQ(glb.json["asset"]["version"], "2.0");
  ASSERT_EQ(glb.json["nodes"].size(), 2U);
  ASSERT_EQ(glb.json["scenes"][0]["nodes"].size(), 2U);
  EXPECT_EQ(glb.json["nodes"][0]["name"], "skin \"after\"\n");
  const auto& primitive = glb.json["meshes"][0]["primitives"][0];
  const auto position = primitive["attributes"]["POSITION"].get<std::size_t>();
  const auto points = accessed<float>(glb, position, 3);
  // Left stays +x, front becomes +z, up becomes +y.
  EXPECT_EQ(points, (std::vector<float>{0.1F, 0, 0, 0, 0, 0.2F, 0, 0.3F, 0, 0, 0, 0}));
  EXPECT_EQ(glb.json["accessors"][position]["min"], (nlohmann::json{0, 0, 0}));
  EXPECT_FLOAT_EQ(glb.json["accessors"][position]["max"][1].get<float>(), 0.3F);
  EXPECT_FLOAT_EQ(glb.json["accessors"][position]["max"][2].get<float>(), 0.2F);
  const auto indices = accessed<std::uint32_t>(glb, primitive["indices"].get<std::size_t>(), 1);
  EXPECT_EQ(indices, (std::vector<std::uint32_t>{0, 1, 2, 0, 2, 3}));
  EXPECT_EQ(glb.json["accessors"][primitive["indices"].get<std::size_t>()]["componentType"], 5125);
  const auto normals = accessed<float>(glb, primitive["attributes"]["NORMAL"].get<std::size_t>(), 3);
  for (std::size_t i = 0; i < 4; ++i) {
    EXPECT_NEAR(std::hypot(normals[3 * i], normals[3 * i + 1], normals[3 * i + 2]), 1, 1e-6);
  }
  EXPECT_FALSE(primitive["attributes"].contains("COLOR_0"));
  const auto& second = glb.json["meshes"][1]["primitives"][0];
  const auto colours = accessed<float>(glb, second["attributes"]["COLOR_0"].get<std::size_t>(), 3);
  EXPECT_EQ(colours, (std::vector<float>{1, 0, 0, 0, 1, 0, 0, 0, 1, 1, 0, 0}));
  EXPECT_EQ(glb.json["materials"][1]["pbrMetallicRoughness"]["baseColorFactor"],
            (nlohmann::json{1, 1, 1, 1}));
  EXPECT_FLOAT_EQ(glb.json["materials"][0]["pbrMetallicRoughness"]["baseColorFactor"][1].get<float>(), 0.25F);
}

TEST_F(WriteMesh, GlbKeepsTheVolumeAndItsSign) {
  const TriMesh mesh = testing::torus(30, 8, 40, 20);
  ASSERT_TRUE(write_glb(folder_ / "a.glb", {{"ring", &mesh, {}, 0.5F, {}}}));
  const Glb glb = read_glb(content(folder_ / "a.glb"));
  const auto& primitive = glb.json["meshes"][0]["primitives"][0];
  const auto points = accessed<float>(glb, primitive["attributes"]["POSITION"].get<std::size_t>(), 3);
  const auto indices = accessed<std::uint32_t>(glb, primitive["indices"].get<std::size_t>(), 1);
  TriMesh back;
  for (std::size_t i = 0; i + 2 < points.size(); i += 3)
    back.points.push_back(Vec3{points[i], points[i + 1], points[i + 2]} * 1000.0);
  for (std::size_t i = 0; i + 2 < indices.size(); i += 3) {
    back.triangles.push_back(
        {static_cast<int>(indices[i]), static_cast<int>(indices[i + 1]), static_cast<int>(indices[i + 2])});
  }
  EXPECT_NEAR(enclosed_volume(back), enclosed_volume(mesh), 1e-4 * enclosed_volume(mesh));
}

TEST_F(WriteMesh, AnEmptySceneIsStillValid) {
  ASSERT_TRUE(write_glb(folder_ / "e.glb", {}));
  const Glb glb = read_glb(content(folder_ / "e.glb"));
  EXPECT_FALSE(glb.json.contains("meshes"));
  EXPECT_EQ(glb.json["scenes"].size(), 1U);
}

TEST_F(WriteMesh, FieldsThatDoNotFitAndBrokenSurfacesWriteNothing) {
  TriMesh mesh = testing::sphere(5, 2);
  const MeshField shorter{"short", 1, {1, 2, 3}};
  EXPECT_FALSE(write_ply(folder_ / "a.ply", mesh, {shorter}));
  EXPECT_FALSE(write_vtp(folder_ / "a.vtp", mesh, {shorter}));
  mesh.triangles[0][0] = 100000;
  EXPECT_FALSE(write_ply(folder_ / "a.ply", mesh));
  EXPECT_FALSE(write_vtp(folder_ / "a.vtp", mesh));
  EXPECT_FALSE(write_glb(folder_ / "a.glb", {{"a", &mesh, {}, 0, {}}}));
  EXPECT_TRUE(fs::is_empty(folder_));
  EXPECT_FALSE(write_ply(folder_ / "no" / "such" / "a.ply", testing::sphere(1, 1)));
}

}  // namespace
}  // namespace turgor
