// Surfaces from PLY: text or binary of either order of bytes, elements and properties in any order.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <limits>
#include <optional>

#include "geometry/mesh_readers.hpp"

namespace turgor::detail {
namespace {

enum class Scalar { int8, uint8, int16, uint16, int32, uint32, float32, float64 };

std::optional<Scalar> scalar_named(std::string_view name) {
  constexpr std::array<std::pair<std::string_view, Scalar>, 16> names{{{"char", Scalar::int8},
                                                                       {"int8", Scalar::int8},
                                                                       {"uchar", Scalar::uint8},
                                                                       {"uint8", Scalar::uint8},
                                                                       {"short", Scalar::int16},
                                                                       {"int16", Scalar::int16},
                                                                       {"ushort", Scalar::uint16},
                                                                       {"uint16", Scalar::uint16},
                                                                       {"int", Scalar::int32},
                                                                       {"int32", Scalar::int32},
                                                                       {"uint", Scalar::uint32},
                                                                       {"uint32", Scalar::uint32},
                                                                       {"float", Scalar::float32},
                                                                       {"float32", Scalar::float32},
                                                                       {"double", Scalar::float64},
                                                                       {"float64", Scalar::float64}}};
  for (const auto& [known, type] : names) {
    if (known == name) return type;
  }
  return std::nullopt;
}

std::size_t size_of(Scalar type) {
  constexpr std::array<std::size_t, 8> sizes{1, 1, 2, 2, 4, 4, 4, 8};
  return sizes[static_cast<std::size_t>(type)];
}

struct Property {
  std::string name;
  Scalar type{};
  std::optional<Scalar> count_type;  ///< set for lists
};
struct Element {
  std::string name;
  std::uint64_t count = 0;
  std::vector<Property> properties;
};
enum class Format { text, little_endian, big_endian };
struct Header {
  Format format{};
  std::vector<Element> elements;
  std::size_t lines = 0, bytes = 0;
};

/// One "property" line into the element it belongs to; false where it is not understood.
bool add_property(std::string_view rest, Element& element) {
  Property property;
  std::string_view type = take_word(rest);
  if (type == "list") {
    property.count_type = scalar_named(take_word(rest));
    type = take_word(rest);
    if (!property.count_type || *property.count_type >= Scalar::float32) return false;
  }
  const std::optional<Scalar> scalar = scalar_named(type);
  property.name = take_word(rest);
  if (!scalar || property.name.empty()) return false;
  property.type = *scalar;
  element.properties.push_back(std::move(property));
  return true;
}

Result<Header> read_header(const MeshSource& source) {
  Header header;
  TextScanner scanner(source.text());
  std::string_view line;
  std::optional<Format> format;
  while (scanner.next_line(line)) {
    std::string_view rest = line;
    const std::string_view word = take_word(rest);
    const auto fail = [&](const char* what) {
      return source.at_line(scanner.line(), fmt::format("{}: \"{:.60}\"", what, line));
    };
    if (word == "end_header") {
      if (!format) return source.at_line(scanner.line(), "the PLY header names no format");
      header.format = *format;
      header.lines = scanner.line(), header.bytes = scanner.position();
      return header;
    }
    if (word == "format") {
      const std::string_view name = take_word(rest);
      if (name == "ascii") format = Format::text;
      if (name == "binary_little_endian") format = Format::little_endian;
      if (name == "binary_big_endian") format = Format::big_endian;
      if (!format) return fail("unknown PLY format");
    } else if (word == "element") {
      Element element;
      element.name = take_word(rest);
      long long count = -1;
      if (!to_integer(take_word(rest), count) || count < 0) return fail("element without a number");
      element.count = static_cast<std::uint64_t>(count);
      header.elements.push_back(std::move(element));
    } else if (word == "property") {
      if (header.elements.empty() || !add_property(rest, header.elements.back()))
        return fail("property not understood");
    } else if (!word.empty() && word != "ply" && word != "comment" && word != "obj_info") {
      return fail("unknown word in the PLY header");
    }
  }
  return source.at_line(scanner.line(), "the PLY header does not end");
}

/// Where the values come from: words of a text, or bytes. Both bound what a header may claim by what is
/// there.
class TextValues {
 public:
  TextValues(const MeshSource& source, const Header& header)
      : source_(source), scanner_(source.text().substr(header.bytes)), lines_before_(header.lines) {}
  bool value(Scalar, double& out) {
    std::string_view word;
    return scanner_.next_word(word) && to_number(word, out);
  }
  /// Least bytes that `count` values take.
  [[nodiscard]] bool can_hold(std::uint64_t count, std::size_t) const {
    return count <= scanner_.left() / 2 + 1;
  }
  [[nodiscard]] bool at_end() const { return scanner_.left() == 0; }
  [[nodiscard]] Error fault(std::string what) const {
    return source_.at_line(lines_before_ + std::max<std::size_t>(scanner_.line(), 1), std::move(what));
  }

 private:
  const MeshSource& source_;
  TextScanner scanner_;
  std::size_t lines_before_;
};

class BinaryValues {
 public:
  BinaryValues(const MeshSource& source, const Header& header)
      : source_(source), at_(header.bytes), swap_(header.format == Format::big_endian) {}
  bool value(Scalar type, double& out) {
    switch (type) {
      case Scalar::int8:
        return take<std::int8_t>(out);
      case Scalar::uint8:
        return take<std::uint8_t>(out);
      case Scalar::int16:
        return take<std::int16_t>(out);
      case Scalar::uint16:
        return take<std::uint16_t>(out);
      case Scalar::int32:
        return take<std::int32_t>(out);
      case Scalar::uint32:
        return take<std::uint32_t>(out);
      case Scalar::float32:
        return take<float>(out);
      case Scalar::float64:
        return take<double>(out);
    }
    return false;
  }
  [[nodiscard]] bool can_hold(std::uint64_t count, std::size_t size) const {
    return count <= (source_.bytes.size() - at_) / std::max<std::size_t>(size, 1);
  }
  [[nodiscard]] bool at_end() const { return at_ == source_.bytes.size(); }
  [[nodiscard]] Error fault(std::string what) const { return source_.at_byte(at_, std::move(what)); }

 private:
  template <class T>
  bool take(double& out) {
    if (source_.bytes.size() - at_ < sizeof(T)) {
      at_ = source_.bytes.size();
      return false;
    }
    std::array<std::byte, sizeof(T)> raw;
    std::memcpy(raw.data(), source_.bytes.data() + at_, sizeof(T));
    at_ += sizeof(T);
    if (swap_) std::reverse(raw.begin(), raw.end());
    out = static_cast<double>(std::bit_cast<T>(raw));
    return true;
  }
  const MeshSource& source_;
  std::size_t at_;
  bool swap_;
};

template <class Values>
class PlyBody {
 public:
  PlyBody(const MeshSource& source, const Header& header, Values values)
      : source_(source), header_(header), values_(std::move(values)) {
    for (const Element& e : header.elements) {
      if (e.name == "vertex") vertices_ = e.count;
    }
  }

  Result<TriMesh> read() {
    if (vertices_ > static_cast<std::uint64_t>(std::numeric_limits<int>::max())) {
      return source_.whole("has more points than can be numbered");
    }
    for (const Element& element : header_.elements) {
      if (element.properties.empty()) continue;
      TURGOR_CHECK(read_element(element));
    }
    return finished(source_, std::move(mesh_));
  }

 private:
  Result<void> read_element(const Element& element) {
    std::size_t least = 0;
    for (const Property& p : element.properties) least += size_of(p.count_type ? *p.count_type : p.type);
    if (!values_.can_hold(element.count, least)) {
      return values_.fault(
          fmt::format("truncated: {} {} elements are announced", element.count, element.name));
    }
    const bool vertex = element.name == "vertex", face = element.name == "face";
    std::array<std::size_t, 3> axes{};
    if (vertex) TURGOR_CHECK(find_axes(element, axes));
    const std::size_t corners = face ? find_corners(element) : none;
    if (face && corners == none) return source_.whole("the faces have no list \"vertex_indices\"");
    if (vertex) mesh_.points.reserve(static_cast<std::size_t>(element.count));
    std::vector<double> row(element.properties.size());
    for (std::uint64_t i = 0; i < element.count; ++i) {
      for (std::size_t k = 0; k < element.properties.size(); ++k) {
        TURGOR_CHECK(read_property(element, k, k == corners, i, row[k]));
      }
      if (!vertex) continue;
      const Vec3 p{row[axes[0]], row[axes[1]], row[axes[2]]};
      if (!is_finite(p)) return values_.fault(fmt::format("point {} is not a finite number", i));
      mesh_.points.push_back(p);
    }
    return {};
  }

  /// A scalar into `value`; a list is skipped, or taken as a polygon where it holds the corners.
  Result<void> read_property(const Element& element, std::size_t k, bool corners, std::uint64_t number,
                             double& value) {
    const Property& property = element.properties[k];
    const auto fault = [&] {
      return values_.fault(
          fmt::format("{}: {} {}", values_.at_end() ? "truncated" : "not a number", element.name, number));
    };
    if (!property.count_type) {
      if (!values_.value(property.type, value)) return fault();
      return {};
    }
    double announced = 0;
    if (!values_.value(*property.count_type, announced)) return fault();
    if (!(announced >= 0) || announced != std::floor(announced)) return fault();
    // Compared as a number first: casting a larger one would be undefined.
    if (announced > 1e15 ||
        !values_.can_hold(static_cast<std::uint64_t>(announced), size_of(property.type))) {
      return values_.fault(
          fmt::format("truncated: {} {} announces a list of {}", element.name, number, announced));
    }
    const auto count = static_cast<std::size_t>(announced);
    polygon_.clear();
    for (std::size_t i = 0; i < count; ++i) {
      double item = 0;
      if (!values_.value(property.type, item)) return fault();
      if (!corners) continue;
      if (!(item >= 0) || item >= static_cast<double>(vertices_) || item != std::floor(item)) {
        return values_.fault(fmt::format("face {} names point {} of {}", number, item, vertices_));
      }
      polygon_.push_back(static_cast<int>(item));
    }
    if (corners) add_polygon(mesh_, polygon_);
    return {};
  }

  Result<void> find_axes(const Element& element, std::array<std::size_t, 3>& axes) const {
    constexpr std::array<std::string_view, 3> names{"x", "y", "z"};
    for (std::size_t a = 0; a < 3; ++a) {
      const auto found = std::find_if(element.properties.begin(), element.properties.end(),
                                      [&](const Property& p) { return p.name == names[a] && !p.count_type; });
      if (found == element.properties.end())
        return source_.whole(fmt::format("the points have no property \"{}\"", names[a]));
      axes[a] = static_cast<std::size_t>(found - element.properties.begin());
    }
    return {};
  }
  static std::size_t find_corners(const Element& element) {
    for (std::size_t k = 0; k < element.properties.size(); ++k) {
      const Property& p = element.properties[k];
      if (p.count_type && (p.name == "vertex_indices" || p.name == "vertex_index")) return k;
    }
    return none;
  }

  static constexpr std::size_t none = std::numeric_limits<std::size_t>::max();
  const MeshSource& source_;
  const Header& header_;
  Values values_;
  std::uint64_t vertices_ = 0;
  TriMesh mesh_;
  std::vector<int> polygon_;
};

}  // namespace

Result<TriMesh> parse_ply(const MeshSource& source) {
  TURGOR_TRY(const Header header, read_header(source));
  if (header.format == Format::text) return PlyBody(source, header, TextValues(source, header)).read();
  return PlyBody(source, header, BinaryValues(source, header)).read();
}

}  // namespace turgor::detail
