// Surfaces to glTF 2.0 binary (Khronos, glTF 2.0 specification, sections 3 and 4.4).
#include <fmt/format.h>

#include <algorithm>
#include <limits>

#include "geometry/bytes.hpp"
#include "geometry/field_check.hpp"
#include "turgor/core/file.hpp"
#include "turgor/geometry/mesh_file.hpp"

namespace turgor {
namespace {

constexpr int array_buffer = 34962, element_array_buffer = 34963;
constexpr int type_float = 5126, type_unsigned_int = 5125;

/// LPS millimetres to glTF metres: +x is left of who faces +z in both, so a rotation, not a mirror image.
Vec3f turned(const Vec3& v) {
  return to_float(Vec3{v.x, v.z, -v.y});
}
Vec3f position(const Vec3& p) {
  return turned(p * 1e-3);
}

/// Into [0, 1], whatever it was.
float unit(float x) {
  return x > 0 ? std::min(x, 1.0F) : 0.0F;
}

std::string json_string(const std::string& text) {
  std::string out = "\"";
  for (const char c : text) {
    const auto code = static_cast<unsigned char>(c);
    if (c == '"' || c == '\\') {
      out += '\\', out += c;
    } else if (code < 0x20) {
      out += fmt::format("\\u{:04x}", code);
    } else {
      out += c;
    }
  }
  return out + "\"";
}

/// The parts of the JSON document that list what lies in the binary chunk.
struct Document {
  std::vector<std::string> views, accessors, meshes, materials, nodes;
  detail::ByteWriter binary;

  int add_view(std::size_t start, int target) {
    views.push_back(fmt::format(R"({{"buffer":0,"byteOffset":{},"byteLength":{},"target":{}}})", start,
                                binary.size() - start, target));
    binary.pad(4, '\0');
    return static_cast<int>(views.size()) - 1;
  }
  int add_vectors(const std::vector<Vec3f>& values, bool with_range) {
    const std::size_t start = binary.size();
    binary.put_all(values);
    const int view = add_view(start, array_buffer);
    std::string range;
    if (with_range) {
      Vec3f low = values[0], high = values[0];
      for (const Vec3f& v : values) {
        for (int i = 0; i < 3; ++i) low[i] = std::min(low[i], v[i]), high[i] = std::max(high[i], v[i]);
      }
      range =
          fmt::format(R"(,"min":[{},{},{}],"max":[{},{},{}])", low.x, low.y, low.z, high.x, high.y, high.z);
    }
    accessors.push_back(fmt::format(R"({{"bufferView":{},"componentType":{},"count":{},"type":"VEC3"{}}})",
                                    view, type_float, values.size(), range));
    return static_cast<int>(accessors.size()) - 1;
  }
  int add_indices(const std::vector<Index3>& triangles) {
    const std::size_t start = binary.size();
    binary.put_all(triangles);
    const int view = add_view(start, element_array_buffer);
    accessors.push_back(fmt::format(R"({{"bufferView":{},"componentType":{},"count":{},"type":"SCALAR"}})",
                                    view, type_unsigned_int, triangles.size() * 3));
    return static_cast<int>(accessors.size()) - 1;
  }
  [[nodiscard]] std::string json() const {
    // A scene without anything in it has no lists at all: the standard forbids empty ones.
    std::string text = R"({"asset":{"version":"2.0","generator":"Turgor"},"scene":0,"scenes":[{)";
    if (!nodes.empty()) {
      text += R"("nodes":[)";
      for (std::size_t i = 0; i < nodes.size(); ++i) text += fmt::format("{}{}", i ? "," : "", i);
      text += "]";
    }
    text += "}]";
    const auto list = [&](const char* name, const std::vector<std::string>& items) {
      if (!items.empty()) text += fmt::format(",\"{}\":[{}]", name, fmt::join(items, ","));
    };
    list("nodes", nodes), list("meshes", meshes), list("materials", materials), list("accessors", accessors);
    list("bufferViews", views);
    if (binary.size() > 0) text += fmt::format(R"(,"buffers":[{{"byteLength":{}}}])", binary.size());
    return text + "}";
  }
};

void add_body(Document& document, const GltfBody& body) {
  const TriMesh& mesh = *body.mesh;
  std::vector<Vec3f> points(mesh.points.size()), normals(mesh.points.size());
  const std::vector<Vec3> point_normals_lps = point_normals(mesh);
  for (std::size_t i = 0; i < points.size(); ++i) {
    points[i] = position(mesh.points[i]);
    // Normals must have unit length, also where no triangle uses the point.
    const Vec3 n = point_normals_lps[i];
    normals[i] = squared_length(n) > 0 ? turned(n) : Vec3f{0, 1, 0};
  }
  std::string attributes = fmt::format(R"("POSITION":{})", document.add_vectors(points, true));
  attributes += fmt::format(R"(,"NORMAL":{})", document.add_vectors(normals, false));
  const bool coloured = body.point_colours.size() == mesh.points.size();
  if (coloured) {
    std::vector<Vec3f> colours = body.point_colours;
    for (Vec3f& c : colours) {
      for (int i = 0; i < 3; ++i) c[i] = unit(c[i]);
    }
    attributes += fmt::format(R"(,"COLOR_0":{})", document.add_vectors(colours, false));
  }
  const int indices = document.add_indices(mesh.triangles);
  // Point colours are multiplied by the base colour.
  const Vec3f base = coloured ? Vec3f{1, 1, 1} : body.base_colour;
  const std::size_t number = document.meshes.size();
  document.materials.push_back(fmt::format(
      R"({{"name":{},"doubleSided":true,"pbrMetallicRoughness":{{"baseColorFactor":[{},{},{},1],"metallicFactor":0,"roughnessFactor":{}}}}})",
      json_string(body.name), unit(base.x), unit(base.y), unit(base.z), unit(body.roughness)));
  document.meshes.push_back(
      fmt::format(R"({{"name":{},"primitives":[{{"attributes":{{{}}},"indices":{},"material":{}}}]}})",
                  json_string(body.name), attributes, indices, number));
  document.nodes.push_back(fmt::format(R"({{"name":{},"mesh":{}}})", json_string(body.name), number));
}

}  // namespace

Result<void> write_glb(const std::filesystem::path& path, const std::vector<GltfBody>& bodies) {
  Document document;
  for (const GltfBody& body : bodies) {
    // The standard has no empty meshes.
    if (!body.mesh || body.mesh->triangles.empty()) continue;
    TURGOR_CHECK(detail::check_surface(*body.mesh, path));
    add_body(document, body);
  }
  std::string json = document.json();
  json.resize((json.size() + 3) / 4 * 4, ' ');
  const std::size_t binary = document.binary.size();
  const std::size_t total = 12 + 8 + json.size() + (binary > 0 ? 8 + binary : 0);
  if (total > std::numeric_limits<std::uint32_t>::max()) {
    return Error{ErrorKind::bad_input, "the surfaces are larger than a glTF file can hold (4 GiB)",
                 path.string(), "Write fewer or reduced surfaces"};
  }
  detail::ByteWriter out(total);
  for (const std::size_t word :
       {std::size_t{0x46546C67}, std::size_t{2}, total, json.size(), std::size_t{0x4E4F534A}}) {
    out.put(static_cast<std::uint32_t>(word));
  }
  out.text(json);
  if (binary > 0) {
    out.put(static_cast<std::uint32_t>(binary));
    out.put(std::uint32_t{0x004E4942});
    out.put_all(document.binary.bytes());
  }
  return write_file(path, out.bytes());
}

}  // namespace turgor
