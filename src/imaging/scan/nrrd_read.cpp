// NRRD as teem defines it (http://teem.sourceforge.net/nrrd/format.html): attached and detached headers, one
// data file.
#include <fmt/format.h>

#include <map>

#include "imaging/scan/header_text.hpp"
#include "imaging/scan/readers.hpp"
#include "turgor/core/file.hpp"

namespace turgor::scan_io {
namespace {

constexpr const char* kExportAgain = "Export the scan again, as one NRRD volume with scalar voxels";

struct NrrdHeader {
  std::map<std::string, std::string> fields;  // by their name without spaces: "spacedirections"
  std::size_t end = 0;                        // offset of the byte behind the blank line
  bool closed = false;                        // whether there was a blank line
};

/// Stops at the blank line, or at the end of the file, or where a line is nothing that a header can hold.
Result<NrrdHeader> parse_header(const SourceFile& file) {
  LineReader lines(file.bytes.subspan(0, std::min<std::size_t>(file.bytes.size(), 1 << 20)));
  NrrdHeader header;
  lines.next();  // the magic, already seen
  for (int n = 2;; ++n) {
    const auto line = lines.next();
    header.end = lines.position();
    if (!line) return header;
    if (line->empty()) {
      header.closed = true;
      return header;
    }
    if (line->starts_with('#') || line->find(":=") != std::string_view::npos) continue;
    const std::size_t colon = line->find(": ");
    const std::size_t plain = colon == std::string_view::npos ? line->find(':') : colon;
    if (plain == std::string_view::npos) {
      return bad_file(file.path, fmt::format("line {} of its header is not \"field: value\"", n),
                      kExportAgain);
    }
    std::string name = lower_case(line->substr(0, plain));
    std::erase(name, ' ');
    header.fields[name] = std::string(trimmed(line->substr(plain + 1)));
  }
}

std::optional<ScalarType> nrrd_type(std::string name) {
  std::erase(name, ' ');
  name = lower_case(name);
  if (name.ends_with("_t")) name.resize(name.size() - 2);
  static const std::map<std::string_view, ScalarType> types{{"signedchar", ScalarType::int8},
                                                            {"int8", ScalarType::int8},
                                                            {"uchar", ScalarType::uint8},
                                                            {"unsignedchar", ScalarType::uint8},
                                                            {"uint8", ScalarType::uint8},
                                                            {"short", ScalarType::int16},
                                                            {"shortint", ScalarType::int16},
                                                            {"signedshort", ScalarType::int16},
                                                            {"signedshortint", ScalarType::int16},
                                                            {"int16", ScalarType::int16},
                                                            {"ushort", ScalarType::uint16},
                                                            {"unsignedshort", ScalarType::uint16},
                                                            {"unsignedshortint", ScalarType::uint16},
                                                            {"uint16", ScalarType::uint16},
                                                            {"int", ScalarType::int32},
                                                            {"signedint", ScalarType::int32},
                                                            {"int32", ScalarType::int32},
                                                            {"uint", ScalarType::uint32},
                                                            {"unsignedint", ScalarType::uint32},
                                                            {"uint32", ScalarType::uint32},
                                                            {"longlong", ScalarType::int64},
                                                            {"longlongint", ScalarType::int64},
                                                            {"signedlonglong", ScalarType::int64},
                                                            {"signedlonglongint", ScalarType::int64},
                                                            {"int64", ScalarType::int64},
                                                            {"ulonglong", ScalarType::uint64},
                                                            {"unsignedlonglong", ScalarType::uint64},
                                                            {"unsignedlonglongint", ScalarType::uint64},
                                                            {"uint64", ScalarType::uint64},
                                                            {"float", ScalarType::float32},
                                                            {"double", ScalarType::float64}};
  const auto found = types.find(name);
  return found == types.end() ? std::nullopt : std::optional(found->second);
}

std::optional<DataEncoding> nrrd_encoding(const std::string& name) {
  const std::string lower = lower_case(name);
  if (lower == "raw") return DataEncoding::raw;
  if (lower == "gzip" || lower == "gz") return DataEncoding::gzip;
  if (lower == "ascii" || lower == "text" || lower == "txt") return DataEncoding::ascii;
  return std::nullopt;
}

/// Factors from the header's space to LPS; nullopt where the space has no anatomical meaning.
std::optional<Vec3> to_lps(std::string space) {
  space = lower_case(space);
  if (space == "left-posterior-superior" || space == "lps") return Vec3{1, 1, 1};
  if (space == "right-anterior-superior" || space == "ras") return Vec3{-1, -1, 1};
  if (space == "left-anterior-superior" || space == "las") return Vec3{1, -1, 1};
  return std::nullopt;
}

/// "(1,0,0) none (0,1,0) …": a vector for each axis, nullopt for "none".
std::optional<std::vector<std::optional<Vec3>>> parse_vectors(std::string_view text) {
  std::vector<std::optional<Vec3>> vectors;
  std::size_t at = 0;
  while (at < text.size()) {
    if (text[at] == ' ' || text[at] == '\t') {
      ++at;
    } else if (text[at] == '(') {
      const std::size_t end = text.find(')', at);
      if (end == std::string_view::npos) return std::nullopt;
      std::string inside(text.substr(at + 1, end - at - 1));
      for (char& c : inside) c = c == ',' ? ' ' : c;
      const auto values = numbers(inside);
      if (!values || values->size() != 3) return std::nullopt;
      vectors.push_back(Vec3{(*values)[0], (*values)[1], (*values)[2]});
      at = end + 1;
    } else if (text.substr(at).starts_with("none")) {
      vectors.push_back(std::nullopt);
      at += 4;
    } else {
      return std::nullopt;
    }
  }
  return vectors;
}

/// Millimetres per unit of the header's space.
double unit_in_mm(const std::string& units) {
  if (units.find("\"m\"") != std::string::npos) return 1000;
  if (units.find("\"cm\"") != std::string::npos) return 10;
  if (units.find("\"um\"") != std::string::npos || units.find("\"µm\"") != std::string::npos) return 1e-3;
  return 1;
}

class NrrdReader {
 public:
  NrrdReader(const SourceFile& file, NrrdHeader header, Context& context)
      : file_(file), header_(std::move(header)), context_(context) {}

  Result<StoredVolume> read() {
    StoredVolume stored;
    stored.info.format = "NRRD";
    TURGOR_CHECK(read_axes(stored));
    TURGOR_CHECK(read_data(stored));
    return stored;
  }

 private:
  [[nodiscard]] std::string field(const std::string& name) const {
    const auto found = header_.fields.find(name);
    return found == header_.fields.end() ? std::string{} : found->second;
  }
  [[nodiscard]] Error fault(std::string what) const {
    return bad_file(file_.path, std::move(what), kExportAgain);
  }

  /// Sizes and directions of the three spatial axes; further axes must have one sample.
  Result<void> read_axes(StoredVolume& stored) {
    const auto sizes = whole_numbers(field("sizes"));
    if (!sizes || sizes->size() < 3 || sizes->size() > 16) return fault("its header states no three sizes");
    auto directions = parse_vectors(field("spacedirections"));
    if (!directions) return fault("the space directions in its header are not vectors of three numbers");
    const bool placed = !directions->empty();
    if (!placed) {
      TURGOR_TRY(*directions, directions_from_spacings(sizes->size()));
    }
    if (directions->size() != sizes->size()) return fault("its header states a direction for some axes only");
    std::array<std::int64_t, 3> size{};
    std::size_t found = 0;
    for (std::size_t a = 0; a < sizes->size(); ++a) {
      if (!(*directions)[a] || (found == 3 && (*sizes)[a] == 1)) {
        if ((*sizes)[a] != 1) return fault(fmt::format("holds {} values for each voxel", (*sizes)[a]));
        continue;
      }
      if (found == 3) return fault("has more than three axes");
      size[found] = (*sizes)[a];
      stored.axes[found++] = *(*directions)[a];
    }
    if (found != 3) return fault("has fewer than three spatial axes");
    TURGOR_TRY(stored.size, checked_size(size, file_.path));
    return place(stored);
  }

  Result<std::vector<std::optional<Vec3>>> directions_from_spacings(std::size_t dimension) {
    std::vector<std::optional<Vec3>> directions(dimension);
    std::vector<std::string_view> spacings = words(field("spacings"));
    if (!spacings.empty() && spacings.size() != dimension)
      return fault("its header states a spacing for some axes only");
    const std::string text = field("spacings");
    spacings = words(text);
    int next = 0;
    for (std::size_t a = 0; a < dimension; ++a) {
      double spacing = 1;
      if (!spacings.empty()) {
        const auto value = numbers(spacings[a]);
        if (!value) {
          if (dimension > 3) continue;  // "nan" marks an axis that is not spatial
          return fault("its header states a spacing that is not a number");
        }
        spacing = value->front();
      }
      if (next == 3) break;
      Vec3 axis{};
      axis[next++] = spacing;
      directions[a] = axis;
    }
    return directions;
  }

  Result<void> place(StoredVolume& stored) {
    const std::string space = field("space");
    auto factor = to_lps(space);
    if (!factor) {
      context_.warning(fmt::format(
          "{}: its header states no anatomical space, so left and right are not certain; LPS is assumed.",
          file_.path.string()));
      factor = Vec3{1, 1, 1};
    }
    if (const std::string text = field("spaceorigin"); !text.empty()) {
      const auto origin = parse_vectors(text);
      if (!origin || origin->size() != 1 || !origin->front())
        return fault("its space origin is not a vector");
      stored.origin = *origin->front();
    }
    const double mm = unit_in_mm(field("spaceunits"));
    const auto convert = [&](Vec3& v) { v = Vec3{v.x * factor->x, v.y * factor->y, v.z * factor->z} * mm; };
    convert(stored.origin);
    for (Vec3& axis : stored.axes) convert(axis);
    return {};
  }

  Result<void> read_data(StoredVolume& stored) {
    const auto type = nrrd_type(field("type"));
    if (!type) return fault(fmt::format("has voxels of type \"{}\"", field("type")));
    const auto encoding = nrrd_encoding(field("encoding"));
    if (!encoding)
      return fault(fmt::format("uses the encoding \"{}\", not raw, gzip or ascii", field("encoding")));
    DataBlock block{file_.path, *encoding, {*type}, 0};
    const std::string endian = lower_case(field("endian"));
    if (endian.empty() && scalar_bytes(*type) > 1 && *encoding != DataEncoding::ascii) {
      return fault("its header states no byte order (endian)");
    }
    block.format.big_endian = endian == "big";
    const auto skip = whole_numbers(field("byteskip")), lines = whole_numbers(field("lineskip"));
    if (!skip || !lines || skip->size() > 1 || lines->size() > 1)
      return fault("its skips are not whole numbers");
    block.skip = skip->empty() ? 0 : skip->front();
    if (block.skip < -1) return fault("its byte skip is negative");
    std::span<const std::byte> data = file_.bytes.subspan(header_.end);
    std::vector<std::byte> detached;
    std::string name = field("datafile");
    if (!name.empty()) {
      if (name.starts_with("LIST") || words(name).size() >= 4)
        return fault("spreads its voxels over several files");
      block.path = beside(file_.path, name);
      TURGOR_TRY(detached, read_file(block.path));
      data = detached;
    } else if (!header_.closed) {
      return fault("is cut short within its header");
    }
    LineReader skipped(data);
    for (std::int64_t n = lines->empty() ? 0 : lines->front(); n > 0; --n) {
      if (!skipped.next()) return fault("is cut short within the lines to be skipped");
    }
    return read_voxels(data.subspan(skipped.position()), block, stored, context_);
  }

  const SourceFile& file_;
  NrrdHeader header_;
  Context& context_;
};

}  // namespace

Result<StoredVolume> read_nrrd(const SourceFile& file, Context& context) {
  TURGOR_TRY(NrrdHeader header, parse_header(file));
  return NrrdReader(file, std::move(header), context).read();
}

}  // namespace turgor::scan_io
