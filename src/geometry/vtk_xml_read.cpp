// Surfaces from VTK's XML files, .vtp and the surface cells of .vtu, and all cells of .vtu: text, base64 or
// appended data, plain or with zlib: VTK file formats, "XML file formats".
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cstring>
#include <pugixml.hpp>

#include "geometry/byte_stream.hpp"
#include "geometry/mesh_readers.hpp"
#include "geometry/vtk_cells.hpp"
#include "turgor/core/index.hpp"

namespace turgor::detail {
namespace {

using Values = std::vector<double>;

struct Number {
  std::string_view name;
  std::size_t bytes;
  double (*value)(const std::byte*, bool swap);
};
template <class T>
double load(const std::byte* from, bool swap) {
  std::array<std::byte, sizeof(T)> raw;
  std::memcpy(raw.data(), from, sizeof(T));
  if (swap) std::reverse(raw.begin(), raw.end());
  return static_cast<double>(std::bit_cast<T>(raw));
}
constexpr std::array<Number, 10> kNumbers{{{"Int8", 1, load<std::int8_t>},
                                           {"UInt8", 1, load<std::uint8_t>},
                                           {"Int16", 2, load<std::int16_t>},
                                           {"UInt16", 2, load<std::uint16_t>},
                                           {"Int32", 4, load<std::int32_t>},
                                           {"UInt32", 4, load<std::uint32_t>},
                                           {"Int64", 8, load<std::int64_t>},
                                           {"UInt64", 8, load<std::uint64_t>},
                                           {"Float32", 4, load<float>},
                                           {"Float64", 8, load<double>}}};
const Number* number_named(std::string_view name) {
  const auto* const found =
      std::find_if(kNumbers.begin(), kNumbers.end(), [&](const Number& n) { return n.name == name; });
  return found == kNumbers.end() ? nullptr : found;
}

/// The XML part, and the appended data between "_" and the end, which need not be XML.
struct Parts {
  std::string head;
  std::string_view appended;
};
Parts parted(std::string_view text) {
  const std::size_t tag = text.find("<AppendedData");
  if (tag == std::string_view::npos) return {std::string(text), {}};
  const std::size_t open = text.find('>', tag);
  const std::size_t mark = open == std::string_view::npos ? open : text.find('_', open);
  const std::size_t end = text.rfind("</AppendedData");
  std::string_view data;
  if (mark != std::string_view::npos)
    data = text.substr(mark + 1, end == std::string_view::npos || end <= mark ? end : end - mark - 1);
  // The tag stays, for its encoding, as an empty element.
  const std::string_view attributes =
      open == std::string_view::npos ? std::string_view{} : text.substr(tag, open - tag);
  return {std::string(text.substr(0, tag)) + std::string(attributes) + "/></VTKFile>", data};
}

class XmlReader {
 public:
  explicit XmlReader(const MeshSource& source)
      : source_(source), parts_(parted(source.text())), surface_(source) {
    budget_ = kMostInflated * source.bytes.size();
  }

  Result<TriMesh> read() {
    TURGOR_TRY(const pugi::xml_node file, open());
    const std::string kind = file.attribute("type").value();
    for (const pugi::xml_node piece : file.child(kind.c_str()).children("Piece")) {
      if (kind == "PolyData") TURGOR_CHECK(read_surface(piece));
      if (kind == "UnstructuredGrid") TURGOR_CHECK(read_grid(piece));
    }
    if (kind != "PolyData" && kind != "UnstructuredGrid") {
      Error error = source_.whole(fmt::format("holds VTK data of type \"{:.40}\", not a surface", kind));
      error.remedy = "Export polygonal data (ParaView: Extract Surface)";
      return error;
    }
    return surface_.finish();
  }

  Result<CellFile> read_cells() {
    TURGOR_TRY(const pugi::xml_node file, open());
    const pugi::xml_node piece = file.child("UnstructuredGrid").child("Piece");
    if (!piece || piece.next_sibling("Piece")) {
      Error error = source_.whole(piece ? "holds more than one piece" : "holds no unstructured grid");
      error.remedy = "Give a .vtu file of one piece";
      return error;
    }
    TURGOR_TRY(const Cells cells, read_grid(piece));
    CellFile out;
    out.mesh.points = surface_.points();
    for (const double p : cells.corners) out.mesh.connectivity.push_back(whole_number(p));
    for (const double end : cells.ends) out.mesh.offsets.push_back(whole_number(end));
    for (const double type : cells.types) {
      if (!(type >= 0 && type <= 255)) return source_.whole(fmt::format("has a cell of type {:g}", type));
      out.mesh.types.push_back(static_cast<std::uint8_t>(type));
    }
    for (const pugi::xml_node array : piece.child("CellData").children("DataArray")) {
      TURGOR_TRY(CellField field, read_field(array, cells.types.size()));
      out.cell_fields.push_back(std::move(field));
    }
    return out;
  }

 private:
  struct Cells {
    Values types, ends, corners;
  };

  Result<pugi::xml_node> open() {
    const pugi::xml_parse_result parsed = document_.load_buffer(parts_.head.data(), parts_.head.size());
    if (!parsed) {
      return source_.at_byte(static_cast<std::size_t>(std::max<std::ptrdiff_t>(parsed.offset, 0)),
                             fmt::format("is damaged XML ({})", parsed.description()));
    }
    const pugi::xml_node file = document_.child("VTKFile");
    TURGOR_CHECK(read_attributes(file));
    return file;
  }

  Result<void> read_attributes(const pugi::xml_node& file) {
    if (!file) return source_.whole("has no element VTKFile");
    swap_ = std::string_view(file.attribute("byte_order").value()) == "BigEndian";
    header_bytes_ = std::string_view(file.attribute("header_type").value()) == "UInt64" ? 8 : 4;
    const std::string_view compressor = file.attribute("compressor").value();
    compressed_ = !compressor.empty();
    if (compressed_ && compressor != "vtkZLibDataCompressor") {
      Error error = source_.whole(fmt::format("is compressed by {:.60}", compressor));
      error.remedy = "Save it with zlib, or without compression";
      return error;
    }
    const std::string_view encoding = file.child("AppendedData").attribute("encoding").value();
    appended_base64_ = encoding == "base64";
    return {};
  }

  Result<void> read_surface(const pugi::xml_node& piece) {
    TURGOR_CHECK(read_points(piece));
    TURGOR_CHECK(read_list(piece.child("Polys"), vtk::polygon, piece.attribute("NumberOfPolys")));
    return read_list(piece.child("Strips"), vtk::strip, piece.attribute("NumberOfStrips"));
  }
  /// Ends and corners are those of points there are.
  Result<Cells> read_grid(const pugi::xml_node& piece) {
    TURGOR_CHECK(read_points(piece));
    const pugi::xml_node list = piece.child("Cells");
    Cells cells;
    TURGOR_TRY(cells.types, named_array(list, "types"));
    TURGOR_TRY(cells.ends, named_array(list, "offsets"));
    TURGOR_TRY(cells.corners, named_array(list, "connectivity"));
    if (cells.types.size() != cells.ends.size())
      return source_.whole(fmt::format("has {} types for {} cells", cells.types.size(), cells.ends.size()));
    TURGOR_CHECK(surface_.add_cells(cells.types, cells.ends, cells.corners));
    return cells;
  }
  Result<CellField> read_field(const pugi::xml_node& array, std::size_t cells) {
    CellField field{array.attribute("Name").value(), array.attribute("NumberOfComponents").as_int(1), {}};
    TURGOR_TRY(field.values, values_of(array));
    if (field.components < 1 || field.values.size() != at(field.components) * cells) {
      return source_.whole(fmt::format("field \"{:.40}\" holds {} numbers for {} cells", field.name,
                                       field.values.size(), cells));
    }
    return field;
  }
  Result<void> read_points(const pugi::xml_node& piece) {
    const pugi::xml_node array = piece.child("Points").child("DataArray");
    Values coordinates;
    if (array) {
      TURGOR_TRY(coordinates, values_of(array));
    }
    const double announced = piece.attribute("NumberOfPoints").as_double(-1);
    if (static_cast<double>(coordinates.size()) != 3 * announced)
      return source_.whole(fmt::format("holds {} coordinates of {:g} points", coordinates.size(), announced));
    return surface_.add_points(coordinates);
  }
  Result<void> read_list(const pugi::xml_node& list, int type, const pugi::xml_attribute& announced) {
    if (!list || announced.as_double(1) == 0) return {};
    TURGOR_TRY(const Values ends, named_array(list, "offsets"));
    TURGOR_TRY(const Values corners, named_array(list, "connectivity"));
    if (announced && announced.as_double() != static_cast<double>(ends.size()))
      return source_.whole(fmt::format("holds {} of {:g} cells", ends.size(), announced.as_double()));
    return surface_.add_cells(std::array{static_cast<double>(type)}, ends, corners);
  }
  Result<Values> named_array(const pugi::xml_node& list, const char* name) {
    const pugi::xml_node array = list.find_child_by_attribute("DataArray", "Name", name);
    if (!array) return source_.whole(fmt::format("has cells without their {}", name));
    return values_of(array);
  }

  Result<Values> values_of(const pugi::xml_node& array) {
    const std::string name = array.attribute("Name").value();
    const Number* number = number_named(array.attribute("type").value());
    if (number == nullptr) return source_.whole(fmt::format("array \"{:.40}\" has no known type", name));
    const std::string_view format = array.attribute("format").value();
    if (format == "ascii") return text_values(array, name);
    std::optional<std::vector<std::byte>> bytes;
    if (format == "binary") {
      bytes = unpacked(ByteStream::base64(array.text().get()));
    } else if (format == "appended") {
      const std::size_t from = static_cast<std::size_t>(array.attribute("offset").as_ullong(~0ULL));
      if (from < parts_.appended.size()) {
        const std::string_view data = parts_.appended.substr(from);
        bytes = unpacked(appended_base64_ ? ByteStream::base64(data) : ByteStream::raw(data));
      }
    }
    if (!bytes || bytes->size() % number->bytes != 0)
      return source_.whole(fmt::format("array \"{:.40}\" is truncated or damaged", name));
    Values values(bytes->size() / number->bytes);
    for (std::size_t i = 0; i < values.size(); ++i)
      values[i] = number->value(bytes->data() + i * number->bytes, swap_);
    return values;
  }
  Result<Values> text_values(const pugi::xml_node& array, const std::string& name) {
    TextScanner scanner(array.text().get());
    Values values;
    for (std::string_view word; scanner.next_word(word);) {
      if (!to_number(word, values.emplace_back()))
        return source_.whole(fmt::format("\"{:.40}\" is not a number of array \"{:.40}\"", word, name));
    }
    return values;
  }

  using Bytes = std::optional<std::vector<std::byte>>;
  std::optional<std::uint64_t> header_word(ByteStream& stream) const {
    const Bytes raw = stream.take(header_bytes_);
    if (!raw) return std::nullopt;
    const std::array<std::byte, 8> whole = [&] {
      std::array<std::byte, 8> out{};
      std::copy(raw->begin(), raw->end(), out.begin());
      if (swap_) std::reverse(out.begin(), out.begin() + static_cast<std::ptrdiff_t>(header_bytes_));
      return out;
    }();
    return std::bit_cast<std::uint64_t>(whole);
  }
  /// Pieces may share arrays, so what is unpacked in all is bounded by what the file can hold.
  bool spend(std::uint64_t bytes) {
    if (bytes > budget_) return false;
    budget_ -= static_cast<std::size_t>(bytes);
    return true;
  }
  /// The bytes of an array: after their number, or in blocks after the numbers of each.
  Bytes unpacked(ByteStream stream) {
    const auto count = header_word(stream);
    if (!count) return std::nullopt;
    if (!compressed_) return spend(*count) ? stream.take(static_cast<std::size_t>(*count)) : std::nullopt;
    const auto block = header_word(stream), last = header_word(stream);
    if (!block || !last || *count > stream.left()) return std::nullopt;
    std::vector<std::uint64_t> sizes;
    for (std::uint64_t b = 0; b < *count; ++b) {
      const auto size = header_word(stream);
      if (!size) return std::nullopt;
      sizes.push_back(*size);
    }
    std::vector<std::byte> out;
    for (std::size_t b = 0; b < sizes.size(); ++b) {
      const std::uint64_t whole = b + 1 == sizes.size() && *last > 0 ? *last : *block;
      const Bytes packed =
          sizes[b] <= stream.left() ? stream.take(static_cast<std::size_t>(sizes[b])) : std::nullopt;
      if (!packed || !spend(whole)) return std::nullopt;
      const Bytes inflated = inflate_exactly(*packed, static_cast<std::size_t>(whole));
      if (!inflated) return std::nullopt;
      out.insert(out.end(), inflated->begin(), inflated->end());
    }
    return out;
  }

  const MeshSource& source_;
  Parts parts_;
  pugi::xml_document document_;
  VtkSurface surface_;
  std::size_t header_bytes_ = 4, budget_ = 0;
  bool swap_ = false, compressed_ = false, appended_base64_ = false;
};

}  // namespace

Result<TriMesh> parse_vtk_xml(const MeshSource& source) {
  return XmlReader(source).read();
}

Result<CellFile> parse_vtk_cells(const MeshSource& source) {
  return XmlReader(source).read_cells();
}

}  // namespace turgor::detail
