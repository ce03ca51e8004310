// MetaImage (https://itk.org/Wiki/MetaIO/Documentation), with the meaning that ITK gives to its fields: the
// space is LPS, and each three numbers of TransformMatrix are the direction of one array axis.
#include <fmt/format.h>

#include <map>

#include "imaging/scan/header_text.hpp"
#include "imaging/scan/readers.hpp"
#include "turgor/core/file.hpp"

namespace turgor::scan_io {
namespace {

constexpr const char* kExportAgain = "Export the scan again, as one MetaImage volume with scalar voxels";

std::optional<ScalarType> meta_type(std::string_view name) {
  static const std::map<std::string_view, ScalarType> types{
      {"MET_CHAR", ScalarType::int8},       {"MET_UCHAR", ScalarType::uint8},
      {"MET_SHORT", ScalarType::int16},     {"MET_USHORT", ScalarType::uint16},
      {"MET_INT", ScalarType::int32},       {"MET_UINT", ScalarType::uint32},
      {"MET_LONG", ScalarType::int32},      {"MET_ULONG", ScalarType::uint32},
      {"MET_LONG_LONG", ScalarType::int64}, {"MET_ULONG_LONG", ScalarType::uint64},
      {"MET_FLOAT", ScalarType::float32},   {"MET_DOUBLE", ScalarType::float64}};
  const auto found = types.find(name);
  return found == types.end() ? std::nullopt : std::optional(found->second);
}

/// Axes from letters such as RAI, which name the side where each axis starts; nullopt where they are not
/// three different directions.
std::optional<std::array<Vec3, 3>> anatomical_axes(std::string_view letters) {
  if (letters.size() != 3) return std::nullopt;
  std::array<Vec3, 3> axes{};
  int seen = 0;
  for (std::size_t a = 0; a < 3; ++a) {
    static constexpr std::string_view starts = "RLAPIS";
    const std::size_t at = starts.find(letters[a]);
    if (at == std::string_view::npos) return std::nullopt;
    axes[a][static_cast<int>(at / 2)] = at % 2 == 0 ? 1 : -1;
    seen |= 1 << (at / 2);
  }
  return seen == 7 ? std::optional(axes) : std::nullopt;
}

class MetaImageReader {
 public:
  MetaImageReader(const SourceFile& file, Context& context) : file_(file), context_(context) {}

  Result<StoredVolume> read() {
    TURGOR_CHECK(parse_header());
    StoredVolume stored;
    stored.info.format = "MetaImage";
    stored.info.modality = field({"Modality"}) == "MET_MOD_CT" ? "CT" : "";
    TURGOR_CHECK(read_size(stored));
    TURGOR_CHECK(read_place(stored));
    TURGOR_CHECK(read_data(stored));
    return stored;
  }

 private:
  [[nodiscard]] Error fault(std::string what) const {
    return bad_file(file_.path, std::move(what), kExportAgain);
  }

  /// The first of several names of one field.
  [[nodiscard]] std::string field(std::initializer_list<const char*> names) const {
    for (const char* name : names) {
      const auto found = fields_.find(name);
      if (found != fields_.end()) return found->second;
    }
    return {};
  }
  [[nodiscard]] bool flag(std::initializer_list<const char*> names) const {
    const std::string value = lower_case(field(names));
    return value == "true" || value == "1" || value == "t";
  }

  /// ElementDataFile ends the header.
  Result<void> parse_header() {
    LineReader lines(file_.bytes.subspan(0, std::min<std::size_t>(file_.bytes.size(), 1 << 20)));
    for (int n = 1;; ++n) {
      const auto line = lines.next();
      if (!line) return fault("is cut short within its header");
      if (trimmed(*line).empty()) continue;
      const std::size_t equals = line->find('=');
      if (equals == std::string_view::npos)
        return fault(fmt::format("line {} of its header has no \"=\"", n));
      const std::string name(trimmed(line->substr(0, equals)));
      fields_[name] = std::string(trimmed(line->substr(equals + 1)));
      if (name == "ElementDataFile") {
        header_end_ = lines.position();
        return {};
      }
    }
  }

  Result<void> read_size(StoredVolume& stored) {
    const auto sizes = whole_numbers(field({"DimSize"}));
    if (!sizes || sizes->size() < 3 || sizes->size() > 8)
      return fault("its header states no three sizes (DimSize)");
    for (std::size_t n = 3; n < sizes->size(); ++n) {
      if ((*sizes)[n] != 1) return fault(fmt::format("holds {} volumes", (*sizes)[n]));
    }
    dimension_ = sizes->size();
    const std::string channels = field({"ElementNumberOfChannels"});
    if (!channels.empty() && channels != "1")
      return fault(fmt::format("holds {} values for each voxel", channels));
    TURGOR_TRY(stored.size, checked_size({(*sizes)[0], (*sizes)[1], (*sizes)[2]}, file_.path));
    return {};
  }

  /// `count` numbers of a field, or nothing where the field is absent.
  Result<std::vector<double>> read_numbers(std::initializer_list<const char*> names, std::size_t count) {
    const auto values = numbers(field(names));
    if (!values || (!values->empty() && values->size() != count)) {
      return fault(fmt::format("its {} is not {} numbers", *names.begin(), count));
    }
    return *values;
  }

  Result<void> read_place(StoredVolume& stored) {
    TURGOR_TRY(const auto matrix,
               read_numbers({"TransformMatrix", "Rotation", "Orientation"}, dimension_ * dimension_));
    TURGOR_TRY(const auto offset, read_numbers({"Offset", "Position", "Origin"}, dimension_));
    TURGOR_TRY(const auto spacing, read_numbers({"ElementSpacing", "ElementSize"}, dimension_));
    const auto letters = anatomical_axes(field({"AnatomicalOrientation"}));
    if (!matrix.empty()) {
      for (std::size_t a = 0; a < 3; ++a) {
        const std::size_t at = a * dimension_;
        stored.axes[a] = {matrix[at], matrix[at + 1], matrix[at + 2]};
      }
      compare_orientations(stored.axes, letters);
    } else {
      // Readers built on ITK take array axes for patient axes here, whatever the letters say.
      stored.axes = {Vec3{1, 0, 0}, Vec3{0, 1, 0}, Vec3{0, 0, 1}};
      if (!letters || *letters != stored.axes) {
        context_.warning(fmt::format(
            "{}: its header states no TransformMatrix, so left and right are not certain; LPS is assumed.",
            file_.path.string()));
      }
    }
    if (!offset.empty()) stored.origin = {offset[0], offset[1], offset[2]};
    for (std::size_t a = 0; a < 3; ++a) {
      stored.axes[a] = normalized(stored.axes[a]) * (spacing.empty() ? 1.0 : spacing[a]);
    }
    return {};
  }

  void compare_orientations(const std::array<Vec3, 3>& axes,
                            const std::optional<std::array<Vec3, 3>>& letters) {
    if (!letters) return;
    const auto handedness = [](const std::array<Vec3, 3>& m) { return dot(m[0], cross(m[1], m[2])) < 0; };
    if (handedness(axes) != handedness(*letters)) {
      context_.warning(
          fmt::format("{}: its TransformMatrix and AnatomicalOrientation disagree on left and right; the "
                      "matrix is taken.",
                      file_.path.string()));
    }
  }

  Result<void> read_data(StoredVolume& stored) {
    const auto type = meta_type(field({"ElementType"}));
    if (!type) return fault(fmt::format("has voxels of type \"{}\"", field({"ElementType"})));
    DataBlock block{file_.path, DataEncoding::raw, {*type}, 0};
    block.format.big_endian = flag({"BinaryDataByteOrderMSB", "ElementByteOrderMSB"});
    const std::string binary = field({"BinaryData"});
    if (!binary.empty() && !flag({"BinaryData"})) block.encoding = DataEncoding::ascii;
    if (flag({"CompressedData"})) block.encoding = DataEncoding::gzip;
    if (const std::string text = field({"HeaderSize"}); !text.empty()) {
      const auto size = whole_numbers(text);
      if (!size || size->size() != 1 || size->front() < -1)
        return fault("its HeaderSize is not a number of bytes");
      block.skip = size->front();
    }
    const std::string name = field({"ElementDataFile"});
    std::span<const std::byte> data = file_.bytes.subspan(header_end_);
    std::vector<std::byte> detached;
    const std::string upper = lower_case(name);
    if (upper == "list" || name.find('%') != std::string::npos)
      return fault("spreads its voxels over several files");
    if (upper != "local") {
      if (name.empty()) return fault("names no data file (ElementDataFile)");
      block.path = beside(file_.path, name);
      TURGOR_TRY(detached, read_file(block.path));
      data = detached;
    }
    return read_voxels(data, block, stored, context_);
  }

  const SourceFile& file_;
  Context& context_;
  std::map<std::string, std::string, std::less<>> fields_;
  std::size_t header_end_ = 0, dimension_ = 3;
};

}  // namespace

Result<StoredVolume> read_metaimage(const SourceFile& file, Context& context) {
  return MetaImageReader(file, context).read();
}

}  // namespace turgor::scan_io
