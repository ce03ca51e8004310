// NIfTI-1 and NIfTI-2 (https://nifti.nimh.nih.gov). Their space is RAS; x and y change sign on the way to
// LPS.
#include <fmt/format.h>

#include <bit>
#include <cmath>
#include <cstring>

#include "imaging/scan/header_text.hpp"
#include "imaging/scan/inflate.hpp"
#include "imaging/scan/readers.hpp"
#include "turgor/core/file.hpp"

namespace turgor::scan_io {
namespace {

constexpr const char* kExportAgain = "Export the scan again, as one NIfTI volume with scalar voxels";

/// The fields that matter, of either version.
struct NiftiHeader {
  bool big_endian = false, pair = false;
  std::array<std::int64_t, 8> dim{};
  std::array<double, 8> pixdim{};
  int datatype = 0, units = 0, qform_code = 0, sform_code = 0;
  double vox_offset = 0, slope = 0, intercept = 0;
  std::array<double, 3> quaternion{}, qoffset{};
  std::array<std::array<double, 4>, 3> srow{};
};

/// Reads numbers of either byte order from fixed places.
class FieldReader {
 public:
  FieldReader(std::span<const std::byte> bytes, bool big_endian) : bytes_(bytes), big_(big_endian) {}
  template <class T>
  [[nodiscard]] T at(std::size_t offset) const {
    std::byte raw[sizeof(T)];
    std::memcpy(raw, bytes_.data() + offset, sizeof(T));
    if (big_) std::reverse(raw, raw + sizeof(T));
    T value;
    std::memcpy(&value, raw, sizeof(T));
    return value;
  }

 private:
  std::span<const std::byte> bytes_;
  bool big_;
};

/// Places of the fields of one version; Real and Whole are its number types.
struct Places {
  std::size_t dim, datatype, pixdim, vox_offset, slope, intercept, units, qform, sform, quaternion, srow;
};
constexpr Places kVersion1{40, 70, 76, 108, 112, 116, 123, 252, 254, 256, 280};
constexpr Places kVersion2{16, 12, 104, 168, 176, 184, 500, 344, 348, 352, 400};

template <class Whole, class Real, class Code>
NiftiHeader read_fields(const FieldReader& in, const Places& at) {
  NiftiHeader header;
  for (std::size_t n = 0; n < 8; ++n) {
    header.dim[n] = in.at<Whole>(at.dim + n * sizeof(Whole));
    header.pixdim[n] = static_cast<double>(in.at<Real>(at.pixdim + n * sizeof(Real)));
  }
  header.datatype = in.at<std::int16_t>(at.datatype);
  header.slope = static_cast<double>(in.at<Real>(at.slope));
  header.intercept = static_cast<double>(in.at<Real>(at.intercept));
  header.qform_code = in.at<Code>(at.qform);
  header.sform_code = in.at<Code>(at.sform);
  for (std::size_t n = 0; n < 3; ++n) {
    header.quaternion[n] = static_cast<double>(in.at<Real>(at.quaternion + n * sizeof(Real)));
    header.qoffset[n] = static_cast<double>(in.at<Real>(at.quaternion + (3 + n) * sizeof(Real)));
    for (std::size_t m = 0; m < 4; ++m) {
      header.srow[n][m] = static_cast<double>(in.at<Real>(at.srow + (4 * n + m) * sizeof(Real)));
    }
  }
  return header;
}

Result<NiftiHeader> parse_header(std::span<const std::byte> bytes, const std::filesystem::path& path) {
  const Error cut = bad_file(path, "is cut short within its NIfTI header", "Copy the file again");
  if (bytes.size() < 348) return cut;
  const auto size = FieldReader(bytes, false).at<std::int32_t>(0);
  const auto swapped = FieldReader(bytes, true).at<std::int32_t>(0);
  const bool big = swapped == 348 || swapped == 540;
  const FieldReader in(bytes, big);
  if (size != 348 && size != 540 && !big) {
    return bad_file(path, "is not a NIfTI file: its header does not start with its own size",
                    "Copy the file again, or name a scan");
  }
  NiftiHeader header;
  if (size == 540 || swapped == 540) {
    if (bytes.size() < 540) return cut;
    header = read_fields<std::int64_t, double, std::int32_t>(in, kVersion2);
    header.vox_offset = static_cast<double>(in.at<std::int64_t>(kVersion2.vox_offset));
    header.units = in.at<std::int32_t>(kVersion2.units);
    header.pair = std::memcmp(bytes.data() + 4, "ni2", 3) == 0;
  } else {
    const auto* magic = reinterpret_cast<const char*>(bytes.data() + 344);
    header = read_fields<std::int16_t, float, std::int16_t>(in, kVersion1);
    header.vox_offset = static_cast<double>(in.at<float>(kVersion1.vox_offset));
    header.units = static_cast<unsigned char>(bytes[kVersion1.units]);
    header.pair = std::memcmp(magic, "ni1", 3) == 0;
    if (!header.pair && std::memcmp(magic, "n+1", 3) != 0) {
      return bad_file(path, "is an Analyze 7.5 file, which does not say where left and right are",
                      "Export the scan as NIfTI or NRRD");
    }
  }
  header.big_endian = big;
  return header;
}

std::optional<ScalarType> nifti_type(int code) {
  switch (code) {
    case 2:
      return ScalarType::uint8;
    case 4:
      return ScalarType::int16;
    case 8:
      return ScalarType::int32;
    case 16:
      return ScalarType::float32;
    case 64:
      return ScalarType::float64;
    case 256:
      return ScalarType::int8;
    case 512:
      return ScalarType::uint16;
    case 768:
      return ScalarType::uint32;
    case 1024:
      return ScalarType::int64;
    case 1280:
      return ScalarType::uint64;
    default:
      return std::nullopt;
  }
}

struct Placement {
  std::array<Vec3, 3> axes{};
  Vec3 origin{};
  [[nodiscard]] double determinant() const { return dot(axes[0], cross(axes[1], axes[2])); }
};

Placement sform(const NiftiHeader& h) {
  Placement p;
  for (int n = 0; n < 3; ++n) {
    const auto& row = h.srow[static_cast<std::size_t>(n)];
    for (std::size_t a = 0; a < 3; ++a) p.axes[a][n] = row[a];
    p.origin[n] = row[3];
  }
  return p;
}

/// Rotation from the stored quaternion, pixdim as spacing, pixdim[0] as the handedness of the third axis.
Placement qform(const NiftiHeader& h) {
  double b = h.quaternion[0], c = h.quaternion[1], d = h.quaternion[2];
  const double square = b * b + c * c + d * d;
  double a = 0;
  if (square > 1) {  // rounding in the file
    const double scale = 1 / std::sqrt(square);
    b *= scale, c *= scale, d *= scale;
  } else {
    a = std::sqrt(1 - square);
  }
  const Mat3 turn{{Vec3{a * a + b * b - c * c - d * d, 2 * (b * c + a * d), 2 * (b * d - a * c)},
                   Vec3{2 * (b * c - a * d), a * a + c * c - b * b - d * d, 2 * (c * d + a * b)},
                   Vec3{2 * (b * d + a * c), 2 * (c * d - a * b), a * a + d * d - b * b - c * c}}};
  const double handedness = h.pixdim[0] < 0 ? -1 : 1;
  Placement p;
  p.axes = {turn.c[0] * h.pixdim[1], turn.c[1] * h.pixdim[2], turn.c[2] * (h.pixdim[3] * handedness)};
  p.origin = {h.qoffset[0], h.qoffset[1], h.qoffset[2]};
  return p;
}

Placement place(const NiftiHeader& h, const std::filesystem::path& path, Context& context) {
  Placement p;
  if (h.sform_code > 0) {
    p = sform(h);
    if (h.qform_code > 0 && p.determinant() * qform(h).determinant() < 0) {
      context.warning(fmt::format("{}: its sform and qform disagree on left and right; the sform is taken.",
                                  path.string()));
    }
  } else if (h.qform_code > 0) {
    p = qform(h);
  } else {
    context.warning(
        fmt::format("{}: it states no orientation, so left and right are not certain; axes to right, front "
                    "and top are assumed.",
                    path.string()));
    p.axes = {Vec3{h.pixdim[1], 0, 0}, Vec3{0, h.pixdim[2], 0}, Vec3{0, 0, h.pixdim[3]}};
  }
  const int unit = h.units & 7;
  const double mm = unit == 1 ? 1000 : unit == 3 ? 1e-3 : 1;
  const auto to_lps = [&](Vec3& v) { v = Vec3{-v.x, -v.y, v.z} * mm; };
  to_lps(p.origin);
  for (Vec3& axis : p.axes) to_lps(axis);
  return p;
}

/// The voxels' file of a pair: the header's name with .img, plain or compressed.
Result<std::filesystem::path> image_of_pair(const std::filesystem::path& header) {
  std::filesystem::path stem = header;
  if (stem.extension() == ".gz") stem.replace_extension();
  for (const char* ending : {".img", ".img.gz", ".IMG"}) {
    std::filesystem::path image = stem;
    image.replace_extension(ending);
    std::error_code code;
    if (std::filesystem::is_regular_file(image, code)) return image;
  }
  return bad_file(header, "has no .img file beside it", "Put the .img file of the pair into the same folder");
}

bool is_gzip(std::span<const std::byte> bytes) {
  return bytes.size() > 2 && bytes[0] == std::byte{0x1F} && bytes[1] == std::byte{0x8B};
}

}  // namespace

Result<StoredVolume> read_nifti(const SourceFile& file, Context& context) {
  std::vector<std::byte> start;
  if (is_gzip(file.bytes)) start = inflate_bytes(file.bytes, 540).bytes;
  TURGOR_TRY(const NiftiHeader header, parse_header(start.empty() ? file.bytes : start, file.path));
  const auto fault = [&](std::string what) { return bad_file(file.path, std::move(what), kExportAgain); };
  const auto type = nifti_type(header.datatype);
  if (!type) return fault(fmt::format("has voxels of NIfTI type {}, which are not scalars", header.datatype));
  if (header.dim[0] < 3 || header.dim[0] > 7) return fault(fmt::format("has {} dimensions", header.dim[0]));
  for (std::size_t n = 4; n <= static_cast<std::size_t>(header.dim[0]); ++n) {
    if (header.dim[n] > 1) return fault(fmt::format("holds {} volumes", header.dim[n]));
  }
  StoredVolume stored;
  stored.info.format = "NIfTI";
  TURGOR_TRY(stored.size, checked_size({header.dim[1], header.dim[2], header.dim[3]}, file.path));
  const Placement placement = place(header, file.path, context);
  stored.axes = placement.axes;
  stored.origin = placement.origin;
  DataBlock block{file.path, DataEncoding::raw, {*type, header.big_endian}, 0};
  const bool scaled = std::isfinite(header.slope) && header.slope != 0;
  if (scaled) block.format.slope = header.slope;
  if (scaled && std::isfinite(header.intercept)) block.format.intercept = header.intercept;
  const double least = header.pair ? 0 : 348;
  if (!(header.vox_offset >= 0 && header.vox_offset < 1e9)) return fault("states an impossible voxel offset");
  block.skip = static_cast<std::int64_t>(header.vox_offset >= least ? header.vox_offset : 352);
  std::vector<std::byte> image;
  std::span<const std::byte> data = file.bytes;
  if (header.pair) {
    TURGOR_TRY(block.path, image_of_pair(file.path));
    TURGOR_TRY(image, read_file(block.path));
    data = image;
  }
  if (is_gzip(data)) block.encoding = DataEncoding::gzip;
  TURGOR_CHECK(read_voxels(data, block, stored, context));
  return stored;
}

}  // namespace turgor::scan_io
