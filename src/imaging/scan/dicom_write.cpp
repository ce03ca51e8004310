#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <optional>
#include <system_error>

#include "imaging/scan/stored_volume.hpp"
#include "turgor/core/file.hpp"
#include "turgor/core/parallel.hpp"
#include "turgor/core/random.hpp"

namespace turgor {
namespace {
namespace fs = std::filesystem;
using scan_io::bad_file;

constexpr const char* kCtImageStorage = "1.2.840.10008.5.1.4.1.1.2";
constexpr const char* kExplicitLittleEndian = "1.2.840.10008.1.2.1";
constexpr const char* kImplementation = "2.25.260318425170731029514238465117";

/// Appends elements in explicit little endian (PS3.5 7.1.2); callers keep the tags rising.
class ElementWriter {
 public:
  void text(std::uint32_t tag, const char* vr, std::string value) {
    const char padding = std::strcmp(vr, "UI") == 0 ? '\0' : ' ';
    if (value.size() % 2 != 0) value += padding;
    head(tag, vr, value.size());
    bytes_.insert(bytes_.end(), value.begin(), value.end());
  }
  void u16(std::uint32_t tag, std::uint16_t value) {
    head(tag, "US", 2);
    put16(value);
  }
  void u32(std::uint32_t tag, std::uint32_t value) {
    head(tag, "UL", 4);
    put32(value);
  }
  void version(std::uint32_t tag) {
    head(tag, "OB", 2);
    put16(0x0100);  // bytes 00 01
  }
  void pixels(const std::vector<std::uint16_t>& values) {
    head(0x7FE00010, "OW", values.size() * 2);
    bytes_.append(reinterpret_cast<const char*>(values.data()), values.size() * 2);
  }
  void append(const ElementWriter& other) { bytes_ += other.bytes_; }
  void raw(std::string_view text) { bytes_ += text; }
  [[nodiscard]] const std::string& bytes() const { return bytes_; }
  void reserve(std::size_t size) { bytes_.reserve(size); }

 private:
  void put16(std::uint32_t v) {
    bytes_ += static_cast<char>(v & 0xFF);
    bytes_ += static_cast<char>(v >> 8 & 0xFF);
  }
  void put32(std::uint32_t v) { put16(v & 0xFFFF), put16(v >> 16); }
  void head(std::uint32_t tag, const char* vr, std::size_t length) {
    put16(tag >> 16), put16(tag & 0xFFFF);
    bytes_ += vr[0], bytes_ += vr[1];
    if (vr[0] == 'O') {
      put16(0), put32(static_cast<std::uint32_t>(length));
    } else {
      put16(static_cast<std::uint32_t>(length));
    }
  }
  std::string bytes_;
};

/// A decimal string of at most 16 bytes (PS3.5 6.2) that is as near to the value as that allows.
std::string decimal(double value) {
  for (int digits = 17; digits > 1; --digits) {
    std::string text = fmt::format("{:.{}g}", value == 0 ? 0.0 : value, digits);
    if (text.size() <= 16) return text;
  }
  return "0";
}
template <class... T>
std::string decimals(T... values) {
  std::string text;
  ((text += (text.empty() ? "" : "\\") + decimal(values)), ...);
  return text;
}

/// What all slices of a series share.
struct SeriesPlan {
  std::string study_uid, series_uid, frame_uid;
  std::uint64_t key = 0;
  bool is_signed = false;  // only where values below -1024 need it; the intercept is then zero
};

std::string uid(const RandomStream& random, std::uint64_t index) {
  return fmt::format("2.25.{}", random.bits(index) | 1);  // PS3.5 annex B.2
}

/// One number of all that makes this series differ from another.
std::uint64_t content_key(const CtVolume& hu, const DicomWriteOptions& options) {
  std::uint64_t key = RandomStream(options.seed).bits(0);
  const auto mix = [&](std::uint64_t value) { key = RandomStream(key ^ value).bits(1); };
  const auto mix_bytes = [&](const void* data, std::size_t size) {
    const char* p = static_cast<const char*>(data);
    std::uint64_t block = 0;
    for (std::size_t at = 0; at < size; at += sizeof block) {
      block = 0;
      std::memcpy(&block, p + at, std::min(sizeof block, size - at));
      key = (key ^ block) * 0x9E3779B97F4A7C15ULL;
      key ^= key >> 29;
    }
    mix(size);
  };
  mix_bytes(options.patient_name.data(), options.patient_name.size());
  mix_bytes(options.series_description.data(), options.series_description.size());
  for (const int n : hu.grid.size) mix(static_cast<std::uint64_t>(n));
  const Grid& g = hu.grid;
  const std::array<Vec3, 5> place{g.spacing, g.origin, g.direction.c[0], g.direction.c[1], g.direction.c[2]};
  for (const Vec3& v : place) {
    const std::array<double, 3> numbers{v.x, v.y, v.z};
    mix_bytes(numbers.data(), sizeof numbers);
  }
  mix_bytes(hu.voxels.data(), hu.voxels.size() * sizeof hu.voxels[0]);
  return key;
}

void write_identity(ElementWriter& out, const SeriesPlan& plan, const DicomWriteOptions& options,
                    const std::string& instance_uid) {
  out.text(0x00080005, "CS", "ISO_IR 192");
  out.text(0x00080008, "CS", "DERIVED\\PRIMARY\\AXIAL");
  out.text(0x00080016, "UI", kCtImageStorage);
  out.text(0x00080018, "UI", instance_uid);
  out.text(0x00080020, "DA", "20000101");  // fixed, so that a repeated run gives the same bytes
  out.text(0x00080023, "DA", "20000101");
  out.text(0x00080030, "TM", "120000");
  out.text(0x00080033, "TM", "120000");
  out.text(0x00080050, "SH", "");
  out.text(0x00080060, "CS", "CT");
  out.text(0x00080070, "LO", "Turgor");
  out.text(0x00080090, "PN", "");
  out.text(0x00081030, "LO", options.series_description);
  out.text(0x0008103E, "LO", options.series_description);
  out.text(0x00100010, "PN", options.patient_name);
  out.text(0x00100020, "LO", fmt::format("{:016x}", plan.key));
  out.text(0x00100030, "DA", "");
  out.text(0x00100040, "CS", "O");
}

std::string slice_bytes(const CtVolume& hu, int k, const SeriesPlan& plan, const DicomWriteOptions& options) {
  const Grid& grid = hu.grid;
  const std::string instance_uid = uid(RandomStream(plan.key), 16 + static_cast<std::uint64_t>(k));
  ElementWriter meta;
  meta.version(0x00020001);
  meta.text(0x00020002, "UI", kCtImageStorage);
  meta.text(0x00020003, "UI", instance_uid);
  meta.text(0x00020010, "UI", kExplicitLittleEndian);
  meta.text(0x00020012, "UI", kImplementation);
  meta.text(0x00020013, "SH", "TURGOR");
  const std::size_t plane = static_cast<std::size_t>(grid.size[0]) * static_cast<std::size_t>(grid.size[1]);
  ElementWriter out;
  out.reserve(plane * 2 + 2048);
  out.raw(std::string(128, '\0') + "DICM");
  out.u32(0x00020000, static_cast<std::uint32_t>(meta.bytes().size()));
  out.append(meta);
  write_identity(out, plan, options, instance_uid);
  const Vec3 &row = grid.direction.c[0], &column = grid.direction.c[1];
  const Vec3 position = grid.to_patient({0, 0, static_cast<double>(k)});
  out.text(0x00180050, "DS", decimal(grid.spacing.z));
  out.text(0x00180060, "DS", "120");
  out.text(0x00185100, "CS", "HFS");
  out.text(0x0020000D, "UI", plan.study_uid);
  out.text(0x0020000E, "UI", plan.series_uid);
  out.text(0x00200010, "SH", "1");
  out.text(0x00200011, "IS", "1");
  out.text(0x00200012, "IS", "1");
  out.text(0x00200013, "IS", fmt::format("{}", k + 1));
  out.text(0x00200032, "DS", decimals(position.x, position.y, position.z));
  out.text(0x00200037, "DS", decimals(row.x, row.y, row.z, column.x, column.y, column.z));
  out.text(0x00200052, "UI", plan.frame_uid);
  out.text(0x00201040, "LO", "");
  out.u16(0x00280002, 1);
  out.text(0x00280004, "CS", "MONOCHROME2");
  out.u16(0x00280010, static_cast<std::uint16_t>(grid.size[1]));
  out.u16(0x00280011, static_cast<std::uint16_t>(grid.size[0]));
  out.text(0x00280030, "DS", decimals(grid.spacing.y, grid.spacing.x));
  out.u16(0x00280100, 16);
  out.u16(0x00280101, 16);
  out.u16(0x00280102, 15);
  out.u16(0x00280103, plan.is_signed ? 1 : 0);
  out.text(0x00281050, "DS", "40");
  out.text(0x00281051, "DS", "400");
  out.text(0x00281052, "DS", plan.is_signed ? "0" : "-1024");
  out.text(0x00281053, "DS", "1");
  out.text(0x00281054, "LO", "HU");
  std::vector<std::uint16_t> stored(plane);
  const std::int16_t* from = hu.voxels.data() + static_cast<std::size_t>(k) * plane;
  const int offset = plan.is_signed ? 0 : 1024;
  for (std::size_t n = 0; n < plane; ++n) stored[n] = static_cast<std::uint16_t>(from[n] + offset);
  out.pixels(stored);
  return out.bytes();
}

Result<void> check_writable(const fs::path& folder, const CtVolume& hu) {
  const Grid& grid = hu.grid;
  if (hu.voxels.size() != grid.voxel_count() || grid.size[0] > 65535 || grid.size[1] > 65535) {
    return Error{ErrorKind::internal, "a volume without a proper size was to be written", folder.string()};
  }
  std::error_code code;
  fs::create_directories(folder, code);
  if (code) {
    return Error{ErrorKind::system, "the folder cannot be made (" + code.message() + ")", folder.string(),
                 "Choose another output folder"};
  }
  return {};
}

}  // namespace

Result<void> write_dicom_series(const fs::path& folder, const CtVolume& hu, const DicomWriteOptions& options,
                                Context& context) {
  const Stage stage(context, "write DICOM");
  TURGOR_CHECK(check_writable(folder, hu));
  SeriesPlan plan;
  plan.key = content_key(hu, options);
  const RandomStream random(plan.key);
  plan.study_uid = uid(random, 0), plan.series_uid = uid(random, 1), plan.frame_uid = uid(random, 2);
  plan.is_signed = std::any_of(hu.voxels.begin(), hu.voxels.end(), [](std::int16_t v) { return v < -1024; });
  const auto count = static_cast<std::size_t>(hu.grid.size[2]);
  std::vector<std::optional<Error>> errors(count);
  parallel_for(count, 4, [&](std::size_t begin, std::size_t end) {
    for (std::size_t k = begin; k < end && !context.cancelled(); ++k) {
      const fs::path path = folder / fmt::format("IM{:04}.dcm", k + 1);
      const auto written = write_file(path, slice_bytes(hu, static_cast<int>(k), plan, options));
      if (!written) errors[k] = written.error();
    }
    context.progress(static_cast<double>(end) / static_cast<double>(count));
  });
  for (const auto& error : errors) {
    if (error) return *error;
  }
  return context.check();
}

}  // namespace turgor
