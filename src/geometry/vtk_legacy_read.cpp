// Surfaces from VTK's legacy files, text or binary: VTK file formats, "Simple legacy formats", to
// version 5.1.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cctype>
#include <cstring>
#include <optional>

#include "geometry/mesh_readers.hpp"
#include "geometry/vtk_cells.hpp"
#include "turgor/core/index.hpp"
#include "turgor/core/lower_case.hpp"

namespace turgor::detail {
namespace {

/// Keywords are short.
std::string lower(std::string_view word) {
  return lower_case(word.substr(0, 64));
}

template <class T>
double big_endian(const std::byte* from) {
  std::array<std::byte, sizeof(T)> raw;
  std::memcpy(raw.data(), from, sizeof(T));
  std::reverse(raw.begin(), raw.end());
  return static_cast<double>(std::bit_cast<T>(raw));
}

struct Number {
  std::string_view name;
  std::size_t bytes;
  double (*value)(const std::byte*);
};
constexpr std::array<Number, 13> kNumbers{{{"unsigned_char", 1, big_endian<std::uint8_t>},
                                           {"char", 1, big_endian<std::int8_t>},
                                           {"unsigned_short", 2, big_endian<std::uint16_t>},
                                           {"short", 2, big_endian<std::int16_t>},
                                           {"unsigned_int", 4, big_endian<std::uint32_t>},
                                           {"int", 4, big_endian<std::int32_t>},
                                           {"unsigned_long", 8, big_endian<std::uint64_t>},
                                           {"long", 8, big_endian<std::int64_t>},
                                           {"vtktypeint64", 8, big_endian<std::int64_t>},
                                           {"vtktypeint32", 4, big_endian<std::int32_t>},
                                           {"vtkidtype", 4, big_endian<std::int32_t>},
                                           {"float", 4, big_endian<float>},
                                           {"double", 8, big_endian<double>}}};

const Number* number_named(std::string_view name) {
  const std::string wanted = lower(name);
  const auto* const found =
      std::find_if(kNumbers.begin(), kNumbers.end(), [&](const Number& n) { return n.name == wanted; });
  return found == kNumbers.end() ? nullptr : found;
}

class LegacyReader {
 public:
  explicit LegacyReader(const MeshSource& source) : source_(source), text_(source.text()), surface_(source) {}

  Result<TriMesh> read() {
    TURGOR_CHECK(read_head());
    while (true) {
      const std::string word = lower(next_word());
      // What follows are values of points and cells.
      if (word.empty() || word == "point_data" || word == "cell_data") break;
      TURGOR_CHECK(read_section(word));
    }
    if (!types_.empty() || !grid_ends_.empty()) TURGOR_CHECK(add_grid());
    return surface_.finish();
  }

 private:
  using Values = std::vector<double>;

  Error fault(std::string what) const {
    if (binary_) return source_.at_byte(at_, std::move(what));
    const auto lines = std::count(text_.begin(), text_.begin() + static_cast<std::ptrdiff_t>(at_), '\n');
    return source_.at_line(static_cast<std::size_t>(lines) + 1, std::move(what));
  }
  std::string_view next_line() {
    const std::size_t end = std::min(text_.find('\n', at_), text_.size());
    std::string_view line = text_.substr(at_, end - at_);
    at_ = std::min(end + 1, text_.size());
    if (!line.empty() && line.back() == '\r') line.remove_suffix(1);
    return line;
  }
  std::string_view next_word() {
    const auto blank = [&] { return std::isspace(static_cast<unsigned char>(text_[at_])) != 0; };
    while (at_ < text_.size() && blank()) ++at_;
    const std::size_t start = at_;
    while (at_ < text_.size() && !blank()) ++at_;
    return text_.substr(start, at_ - start);
  }

  Result<void> read_head() {
    next_line(), next_line();  // version and title
    const std::string format = lower(next_word());
    binary_ = format == "binary";
    if (!binary_ && format != "ascii") return fault("is neither ASCII nor BINARY");
    if (lower(next_word()) != "dataset") return fault("names no DATASET");
    const std::string kind = lower(next_word());
    if (kind == "polydata" || kind == "unstructured_grid") return {};
    Error error = fault(fmt::format("holds {}, not a surface", kind));
    error.remedy = "Export polygonal data (ParaView: Extract Surface)";
    return error;
  }

  /// A count, after the name of a section.
  Result<std::size_t> count(std::string_view section) {
    long long value = -1;
    if (!to_integer(next_word(), value) || value < 0)
      return fault(fmt::format("{} without a number", section));
    return static_cast<std::size_t>(value);
  }
  Result<const Number*> type(std::string_view section) {
    const std::string_view name = next_word();
    const Number* number = number_named(name);
    if (number == nullptr) return fault(fmt::format("{} of unknown type \"{:.40}\"", section, name));
    return number;
  }
  Result<Values> values(std::size_t n, const Number& number, std::string_view section) {
    if (binary_) next_line();
    const std::size_t left = text_.size() - at_;
    if (n > (binary_ ? left / number.bytes : left / 2 + 1))
      return fault(fmt::format("truncated: {} numbers of {} are announced", n, section));
    Values out(n);
    for (double& value : out) {
      if (binary_) {
        value = number.value(source_.bytes.data() + at_);
        at_ += number.bytes;
      } else if (const std::string_view word = next_word(); !to_number(word, value)) {
        return fault(word.empty() ? fmt::format("truncated within {}", section)
                                  : fmt::format("\"{:.40}\" is not a number of {}", word, section));
      }
    }
    return out;
  }

  Result<void> read_section(const std::string& word) {
    if (word == "points") return read_points();
    if (word == "polygons") return read_cells(word, vtk::polygon);
    if (word == "triangle_strips") return read_cells(word, vtk::strip);
    if (word == "vertices" || word == "lines") return read_cells(word, 0);
    if (word == "cells") return read_cells(word, -1);
    if (word == "cell_types") return read_types();
    if (word == "field") return skip_field();
    if (word == "metadata") {
      next_line();
      while (at_ < text_.size() && !next_line().empty()) {
      }
      return {};
    }
    return fault(fmt::format("unknown section \"{:.40}\"", word));
  }
  Result<void> read_points() {
    TURGOR_TRY(const std::size_t n, count("POINTS"));
    TURGOR_TRY(const Number* number, type("POINTS"));
    if (n > text_.size()) return fault(fmt::format("truncated: {} points are announced", n));
    TURGOR_TRY(const Values coordinates, values(3 * n, *number, "POINTS"));
    return surface_.add_points(coordinates);
  }
  /// Cells of one type, or of the types listed further on (-1).
  Result<void> read_cells(const std::string& section, int type) {
    TURGOR_TRY(const std::size_t cells, count(section));
    TURGOR_TRY(const std::size_t size, count(section));
    Values ends, corners;
    const std::size_t before = at_;
    if (lower(next_word()) == "offsets") {
      TURGOR_CHECK(read_offsets(section, cells, size, ends, corners));
    } else {
      at_ = before;
      TURGOR_CHECK(read_counted(section, cells, size, ends, corners));
    }
    if (type >= 0) return surface_.add_cells(std::array{static_cast<double>(type)}, ends, corners);
    grid_ends_ = std::move(ends), grid_corners_ = std::move(corners);
    return {};
  }
  /// Version 5.1: where each cell begins, and where the last ends; then all corners.
  Result<void> read_offsets(const std::string& section, std::size_t offsets, std::size_t size, Values& ends,
                            Values& corners) {
    TURGOR_TRY(const Number* offset_type, this->type(section));
    TURGOR_TRY(ends, values(offsets, *offset_type, section));
    if (!ends.empty()) ends.erase(ends.begin());
    if (lower(next_word()) != "connectivity") return fault(fmt::format("{} without CONNECTIVITY", section));
    TURGOR_TRY(const Number* corner_type, this->type(section));
    TURGOR_TRY(corners, values(size, *corner_type, section));
    return {};
  }
  /// Before: each cell's number of corners, then the corners.
  Result<void> read_counted(const std::string& section, std::size_t cells, std::size_t size, Values& ends,
                            Values& corners) {
    TURGOR_TRY(const Values all, values(size, *number_named("int"), section));
    std::size_t next = 0;
    for (std::size_t c = 0; c < cells; ++c) {
      const int n = next < all.size() ? whole_number(all[next]) : -1;
      if (n < 0 || at(n) >= all.size() - next)
        return fault(fmt::format("cell {} of {} does not end within the section", c, section));
      const auto first = all.begin() + static_cast<std::ptrdiff_t>(next) + 1;
      corners.insert(corners.end(), first, first + n);
      ends.push_back(static_cast<double>(corners.size()));
      next += at(n) + 1;
    }
    return {};
  }
  Result<void> read_types() {
    TURGOR_TRY(const std::size_t n, count("CELL_TYPES"));
    TURGOR_TRY(types_, values(n, *number_named("int"), "CELL_TYPES"));
    return {};
  }
  Result<void> add_grid() {
    if (types_.size() != grid_ends_.size())
      return fault(fmt::format("has {} types for {} cells", types_.size(), grid_ends_.size()));
    // One type stands for all cells: a single cell's too.
    return surface_.add_cells(types_, grid_ends_, grid_corners_);
  }
  Result<void> skip_field() {
    next_word();  // its name
    TURGOR_TRY(const std::size_t arrays, count("FIELD"));
    for (std::size_t a = 0; a < arrays; ++a) {
      if (lower(next_word()) == "metadata") {
        TURGOR_CHECK(read_section("metadata"));
        next_word();
      }
      TURGOR_TRY(const std::size_t components, count("FIELD"));
      TURGOR_TRY(const std::size_t tuples, count("FIELD"));
      const std::string_view name = next_word();
      const Number* number = number_named(name);
      if (number == nullptr)
        return fault(fmt::format("FIELD of type \"{:.40}\" cannot be passed over", name));
      if (tuples > text_.size() || components > text_.size() / std::max<std::size_t>(tuples, 1))
        return fault("truncated within FIELD");
      TURGOR_CHECK(values(components * tuples, *number, "FIELD"));
    }
    return {};
  }

  const MeshSource& source_;
  std::string_view text_;
  std::size_t at_ = 0;
  bool binary_ = false;
  VtkSurface surface_;
  Values types_, grid_ends_, grid_corners_;
};

}  // namespace

Result<TriMesh> parse_vtk_legacy(const MeshSource& source) {
  return LegacyReader(source).read();
}

}  // namespace turgor::detail
