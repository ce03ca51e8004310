// Surfaces from glTF 2.0, binary or JSON (Khronos, glTF 2.0 specification, sections 3 and 4.4).
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <nlohmann/json.hpp>
#include <optional>

#include "geometry/byte_stream.hpp"
#include "geometry/mesh_readers.hpp"
#include "geometry/welder.hpp"
#include "turgor/core/file.hpp"
#include "turgor/core/index.hpp"

namespace turgor::detail {
namespace {

using nlohmann::json;

constexpr std::uint32_t kJsonChunk = 0x4E4F534A, kBinaryChunk = 0x004E4942;
/// How many times over a file's nodes may show what it holds: no more than bytes it has, a thousandfold.
constexpr std::size_t kMostCorners = 1000;

struct Transform {
  Mat3 linear{};
  Vec3 shift{};
  friend Transform operator*(const Transform& a, const Transform& b) {
    return {a.linear * b.linear, a.linear * b.shift + a.shift};
  }
};

/// A member that is a whole number from 0; nothing where it is absent or anything else.
std::optional<std::size_t> whole(const json& object, const char* key) {
  const auto found = object.find(key);
  if (found == object.end() || !found->is_number_unsigned()) return std::nullopt;
  return found->get<std::size_t>();
}
/// An entry of one of the document's lists; null where there is none.
const json* entry(const json& document, const char* list, std::optional<std::size_t> index) {
  const auto found = document.find(list);
  if (!index || found == document.end() || !found->is_array() || *index >= found->size()) return nullptr;
  const json& item = (*found)[*index];
  return item.is_object() ? &item : nullptr;
}
/// `n` numbers; nothing where the member is no such list.
std::optional<std::vector<double>> numbers(const json& object, const char* key, std::size_t n) {
  const auto found = object.find(key);
  if (found == object.end() || !found->is_array() || found->size() != n) return std::nullopt;
  std::vector<double> out;
  for (const json& v : *found) {
    if (!v.is_number()) return std::nullopt;
    out.push_back(v.get<double>());
  }
  return out;
}

Mat3 turn_of(const std::vector<double>& q) {
  const double x = q[0], y = q[1], z = q[2], w = q[3];
  return {{Vec3{1 - 2 * (y * y + z * z), 2 * (x * y + z * w), 2 * (x * z - y * w)},
           Vec3{2 * (x * y - z * w), 1 - 2 * (x * x + z * z), 2 * (y * z + x * w)},
           Vec3{2 * (x * z + y * w), 2 * (y * z - x * w), 1 - 2 * (x * x + y * y)}}};
}

Transform transform_of(const json& node) {
  if (const auto m = numbers(node, "matrix", 16)) {
    const auto column = [&](std::size_t c) { return Vec3{(*m)[4 * c], (*m)[4 * c + 1], (*m)[4 * c + 2]}; };
    return {Mat3{{column(0), column(1), column(2)}}, column(3)};
  }
  Transform t;
  if (const auto q = numbers(node, "rotation", 4)) t.linear = turn_of(*q);
  if (const auto s = numbers(node, "scale", 3)) {
    for (std::size_t c = 0; c < 3; ++c) t.linear.c[c] *= (*s)[c];
  }
  if (const auto v = numbers(node, "translation", 3)) t.shift = {(*v)[0], (*v)[1], (*v)[2]};
  return t;
}

/// glTF's metres, y up, to LPS millimetres: the inverse of what write_glb does.
Vec3 to_lps(const Vec3& p) {
  return Vec3{p.x, -p.z, p.y} * 1000.0;
}

class GltfReader {
 public:
  explicit GltfReader(const MeshSource& source) : source_(source), welder_(mesh_) {}

  Result<TriMesh> read() {
    TURGOR_CHECK(split());
    document_ = json::parse(json_text_, nullptr, false);
    if (!document_.is_object()) return source_.whole("holds no JSON document that can be read");
    TURGOR_CHECK(check_extensions());
    TURGOR_CHECK(read_scene());
    return finished(source_, std::move(mesh_));
  }

 private:
  using Bytes = std::vector<std::byte>;
  struct Accessor {
    const std::byte* first = nullptr;
    std::size_t count = 0, stride = 0;
    int component = 0;
  };

  std::uint32_t word(std::size_t at) const {
    std::uint32_t value = 0;
    std::memcpy(&value, source_.bytes.data() + at, sizeof value);
    return value;
  }
  /// Into JSON and binary chunk; a JSON file is all the first.
  Result<void> split() {
    const std::string_view text = source_.text();
    if (!text.starts_with("glTF")) {
      json_text_ = text;
      return {};
    }
    if (text.size() < 20) return source_.at_byte(text.size(), "truncated: no glTF header");
    if (word(4) != 2) return source_.at_byte(4, fmt::format("is glTF version {}, not 2", word(4)));
    if (word(8) != text.size())
      return source_.at_byte(text.size(), fmt::format("truncated or longer than its {} bytes", word(8)));
    for (std::size_t at = 12; at < text.size();) {
      if (text.size() - at < 8 || word(at) > text.size() - at - 8)
        return source_.at_byte(at, "truncated: a chunk reaches beyond the file");
      const std::string_view chunk = text.substr(at + 8, word(at));
      if (word(at + 4) == kJsonChunk && json_text_.empty()) json_text_ = chunk;
      if (word(at + 4) == kBinaryChunk && binary_.empty()) binary_ = source_.bytes.subspan(at + 8, word(at));
      at += 8 + chunk.size();
    }
    return {};
  }
  Result<void> check_extensions() const {
    const auto required = document_.find("extensionsRequired");
    if (required == document_.end() || !required->is_array()) return {};
    for (const json& name : *required) {
      if (!name.is_string()) continue;
      const auto& text = name.get_ref<const std::string&>();
      // Looks and lights do not move points.
      if (text.starts_with("KHR_materials") || text.starts_with("KHR_lights") ||
          text == "KHR_texture_transform")
        continue;
      Error error = source_.whole(fmt::format("needs the extension \"{:.60}\", which is not read", text));
      error.remedy = "Export it without compression or quantisation";
      return error;
    }
    return {};
  }

  /// The nodes of the default scene, else the first, else all that are no one's children.
  std::vector<std::size_t> roots() const {
    const json* scene = entry(document_, "scenes", whole(document_, "scene").value_or(0));
    if (scene != nullptr) return children(*scene, "nodes");
    std::vector<std::size_t> all;
    const auto nodes = document_.find("nodes");
    if (nodes == document_.end() || !nodes->is_array()) return all;
    std::vector<bool> child(nodes->size());
    for (const json& node : *nodes) {
      if (!node.is_object()) continue;
      for (const std::size_t c : children(node, "children"))
        if (c < child.size()) child[c] = true;
    }
    for (std::size_t n = 0; n < child.size(); ++n)
      if (!child[n]) all.push_back(n);
    return all;
  }
  static std::vector<std::size_t> children(const json& object, const char* key) {
    std::vector<std::size_t> out;
    const auto list = object.find(key);
    if (list == object.end() || !list->is_array()) return out;
    for (const json& v : *list)
      out.push_back(v.is_number_unsigned() ? v.get<std::size_t>() : ~std::size_t{0});
    return out;
  }
  Result<void> read_scene() {
    struct Visit {
      std::size_t node;
      Transform transform;
    };
    std::vector<Visit> waiting;
    std::vector<bool> seen(document_.contains("nodes") ? document_["nodes"].size() : 0);
    const auto add = [&](std::vector<std::size_t> nodes, const Transform& transform) {
      for (auto n = nodes.rbegin(); n != nodes.rend(); ++n) waiting.push_back({*n, transform});
    };
    add(roots(), {});
    while (!waiting.empty()) {
      const Visit visit = waiting.back();
      waiting.pop_back();
      const json* node = entry(document_, "nodes", visit.node);
      if (node == nullptr) return source_.whole("names a node that is not there");
      if (seen[visit.node]) return source_.whole(fmt::format("node {} hangs in two places", visit.node));
      seen[visit.node] = true;
      const Transform transform = visit.transform * transform_of(*node);
      if (node->contains("mesh")) TURGOR_CHECK(add_mesh(whole(*node, "mesh"), transform));
      add(children(*node, "children"), transform);
    }
    return {};
  }

  Result<void> add_mesh(std::optional<std::size_t> number, const Transform& transform) {
    const json* mesh = entry(document_, "meshes", number);
    if (mesh == nullptr) return source_.whole("names a mesh that is not there");
    const auto primitives = mesh->find("primitives");
    if (primitives == mesh->end() || !primitives->is_array()) return {};
    for (const json& primitive : *primitives) {
      if (!primitive.is_object()) return source_.whole("has a primitive that is no object");
      const std::size_t mode = primitive.contains("mode") ? whole(primitive, "mode").value_or(99) : 4;
      if (mode >= 4 && mode <= 6) TURGOR_CHECK(add_primitive(primitive, mode, transform));
    }
    return {};
  }
  Result<void> add_primitive(const json& primitive, std::size_t mode, const Transform& transform) {
    const auto attributes = primitive.find("attributes");
    if (attributes == primitive.end() || !attributes->is_object() || !attributes->contains("POSITION"))
      return {};
    TURGOR_TRY(const Accessor positions, accessor(whole(*attributes, "POSITION"), "VEC3", 12));
    if (positions.component != 5126) return source_.whole("has positions that are not floats");
    std::optional<Accessor> indices;
    if (primitive.contains("indices")) {
      TURGOR_TRY(indices, accessor(whole(primitive, "indices"), "SCALAR", 1));
    }
    const std::size_t corners = indices ? indices->count : positions.count;
    corners_ += corners;
    if (corners_ > kMostCorners * source_.bytes.size() ||
        corners_ > static_cast<std::size_t>(std::numeric_limits<int>::max()))
      return source_.whole("shows its meshes more often than can be held");
    std::vector<int> numbers;
    numbers.reserve(corners);
    for (std::size_t c = 0; c < corners; ++c) {
      const std::size_t p = indices ? index_at(*indices, c) : c;
      if (p >= positions.count)
        return source_.whole(fmt::format("corner {} names point {} of {}", c, p, positions.count));
      std::array<float, 3> v;
      std::memcpy(v.data(), positions.first + p * positions.stride, sizeof v);
      const Vec3 point = to_lps(transform.linear * Vec3{v[0], v[1], v[2]} + transform.shift);
      if (!is_finite(point)) return source_.whole(fmt::format("point {} is not finite", p));
      numbers.push_back(welder_.number(point));
    }
    add_triangles(numbers, mode, transform.linear.determinant() < 0);
    return {};
  }
  void add_triangles(const std::vector<int>& c, std::size_t mode, bool mirrored) {
    const auto add = [&](int a, int b, int d) {
      add_polygon(mesh_, mirrored ? std::array{a, d, b} : std::array{a, b, d});
    };
    if (mode == 4) {
      for (std::size_t i = 2; i < c.size(); i += 3) add(c[i - 2], c[i - 1], c[i]);
    } else if (mode == 5) {
      for (std::size_t i = 2; i < c.size(); ++i) add(c[i - 2], c[i - 1 + i % 2], c[i - i % 2]);
    } else {
      for (std::size_t i = 2; i < c.size(); ++i) add(c[0], c[i - 1], c[i]);
    }
  }

  static std::size_t index_at(const Accessor& a, std::size_t i) {
    std::uint32_t value = 0;
    std::memcpy(&value, a.first + i * a.stride, a.component == 5121 ? 1 : a.component == 5123 ? 2 : 4);
    return value;
  }
  Result<Accessor> accessor(std::optional<std::size_t> number, std::string_view type, std::size_t least) {
    const json* a = entry(document_, "accessors", number);
    if (a == nullptr) return source_.whole("names an accessor that is not there");
    if (a->contains("sparse")) return source_.whole("has a sparse accessor, which is not read");
    const auto kind = a->find("type");
    if (kind == a->end() || !kind->is_string() || kind->get_ref<const std::string&>() != type)
      return source_.whole(fmt::format("accessor {} is not of type {}", *number, type));
    Accessor out;
    out.component = static_cast<int>(std::min<std::size_t>(whole(*a, "componentType").value_or(0), 9999));
    const std::size_t bytes = out.component == 5121                            ? 1
                              : out.component == 5123                          ? 2
                              : out.component == 5125 || out.component == 5126 ? 4
                                                                               : 0;
    const bool index = type == "SCALAR";
    if (bytes == 0 || (index && out.component == 5126))
      return source_.whole(fmt::format("accessor {} has components of type {}", *number, out.component));
    const std::size_t item = index ? bytes : std::max(bytes * 3, least);
    const json* view = entry(document_, "bufferViews", whole(*a, "bufferView"));
    if (view == nullptr) return source_.whole(fmt::format("accessor {} has no buffer view", *number));
    TURGOR_TRY(const std::span<const std::byte> data, view_bytes(*view));
    out.count = whole(*a, "count").value_or(0);
    out.stride = whole(*view, "byteStride").value_or(item);
    const std::size_t start = whole(*a, "byteOffset").value_or(0);
    const bool fits =
        out.count == 0 || (start <= data.size() && item <= data.size() - start && out.stride >= item &&
                           (out.count - 1) <= (data.size() - start - item) / out.stride);
    if (!fits) return source_.whole(fmt::format("truncated: accessor {} reaches beyond its buffer", *number));
    out.first = data.data() + start;
    return out;
  }
  Result<std::span<const std::byte>> view_bytes(const json& view) {
    TURGOR_TRY(const std::span<const std::byte> data,
               buffer(whole(view, "buffer").value_or(~std::size_t{0})));
    const std::size_t start = whole(view, "byteOffset").value_or(0),
                      length = whole(view, "byteLength").value_or(0);
    if (start > data.size() || length > data.size() - start)
      return source_.whole("truncated: a buffer view reaches beyond its buffer");
    return data.subspan(start, length);
  }
  Result<std::span<const std::byte>> buffer(std::size_t number) {
    const json* b = entry(document_, "buffers", number);
    if (b == nullptr) return source_.whole("names a buffer that is not there");
    if (!b->contains("uri")) return binary_;
    buffers_.resize(document_["buffers"].size());
    if (!buffers_[number]) {
      TURGOR_TRY(buffers_[number], load((*b)["uri"], whole(*b, "byteLength").value_or(0)));
    }
    return std::span<const std::byte>(*buffers_[number]);
  }
  /// A buffer out of a data URI, or a file beside this one.
  Result<Bytes> load(const json& uri, std::size_t length) const {
    if (!uri.is_string()) return source_.whole("has a buffer whose URI is no text");
    const std::string_view text = uri.get_ref<const std::string&>();
    if (text.starts_with("data:")) {
      const std::size_t comma = text.find(";base64,");
      std::optional<Bytes> bytes;
      if (comma != std::string_view::npos) bytes = ByteStream::base64(text.substr(comma + 8)).take(length);
      if (!bytes) return source_.whole("has a data URI that is truncated or not base64");
      return *std::move(bytes);
    }
    const std::filesystem::path file(plain(text));
    const bool beside = !file.empty() && file.is_relative() && text.find(':') == std::string_view::npos &&
                        std::find(file.begin(), file.end(), "..") == file.end();
    if (!beside) {
      Error error = source_.whole(fmt::format("keeps a buffer at \"{:.80}\", not beside it", text));
      error.remedy = "Export it as .glb";
      return error;
    }
    return read_file(std::filesystem::path(source_.name).parent_path() / file);
  }
  /// Percent signs resolved.
  static std::string plain(std::string_view text) {
    const auto digit = [](char c) {
      return c >= '0' && c <= '9'   ? c - '0'
             : c >= 'a' && c <= 'f' ? c - 'a' + 10
             : c >= 'A' && c <= 'F' ? c - 'A' + 10
                                    : -1;
    };
    std::string out;
    for (std::size_t i = 0; i < text.size(); ++i) {
      const bool coded =
          text[i] == '%' && i + 2 < text.size() && digit(text[i + 1]) >= 0 && digit(text[i + 2]) >= 0;
      out += coded ? static_cast<char>(16 * digit(text[i + 1]) + digit(text[i + 2])) : text[i];
      if (coded) i += 2;
    }
    return out;
  }

  const MeshSource& source_;
  std::string_view json_text_;
  std::span<const std::byte> binary_;
  json document_;
  std::vector<std::optional<Bytes>> buffers_;
  TriMesh mesh_;
  Welder welder_;
  std::size_t corners_ = 0;
};

}  // namespace

Result<TriMesh> parse_gltf(const MeshSource& source) {
  return GltfReader(source).read();
}

}  // namespace turgor::detail
