// Which reader a file is for: told by its content, not by its name.
#include "turgor/imaging/scan.hpp"

#include <algorithm>
#include <cstring>
#include <exception>
#include <new>
#include <string_view>
#include <system_error>

#include "imaging/scan/inflate.hpp"
#include "imaging/scan/readers.hpp"
#include "turgor/core/file.hpp"

namespace turgor {
namespace {
namespace fs = std::filesystem;
using namespace scan_io;

enum class Format { dicom, nifti, nrrd, metaimage, inv3 };

bool has(std::span<const std::byte> bytes, std::size_t at, std::string_view text) {
  return bytes.size() >= at + text.size() && std::memcmp(bytes.data() + at, text.data(), text.size()) == 0;
}

bool is_nifti(std::span<const std::byte> bytes) {
  std::int32_t size = 0;
  if (bytes.size() < sizeof size) return false;
  std::memcpy(&size, bytes.data(), sizeof size);
  constexpr std::int32_t swapped348 = 0x5C010000, swapped540 = 0x1C020000;
  return size == 348 || size == 540 || size == swapped348 || size == swapped540;
}

/// MetaImage headers have no magic; they are lines of "Key = value" with the size of the voxel array among
/// them.
bool is_metaimage(std::span<const std::byte> bytes) {
  const std::string_view start(reinterpret_cast<const char*>(bytes.data()),
                               std::min<std::size_t>(bytes.size(), 4096));
  const std::size_t equals = start.find('=');
  return equals != std::string_view::npos && equals < 64 && start.find("DimSize") != std::string_view::npos;
}

std::string lower_extension(const fs::path& path) {
  std::string extension = path.extension().string();
  for (char& c : extension) c = c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
  return extension;
}

/// Damaged files are told by their name, so that the right reader says what is wrong.
Format recognise(std::span<const std::byte> bytes, const fs::path& path) {
  const std::string extension = lower_extension(path);
  if (has(bytes, 0, "\x1f\x8b")) {
    const Inflated start = inflate_bytes(bytes, 1024);
    if (has(start.bytes, 257, "ustar") || extension == ".inv3") return Format::inv3;
    return is_nifti(start.bytes) || extension == ".gz" ? Format::nifti : Format::dicom;
  }
  if (has(bytes, 128, "DICM")) return Format::dicom;
  if (has(bytes, 0, "NRRD") || extension == ".nrrd" || extension == ".nhdr") return Format::nrrd;
  if (is_nifti(bytes) || extension == ".nii" || extension == ".hdr") return Format::nifti;
  if (is_metaimage(bytes) || extension == ".mha" || extension == ".mhd") return Format::metaimage;
  return extension == ".inv3" ? Format::inv3 : Format::dicom;
}

/// Of an Analyze-style pair either file may be named; the header says what the other holds.
fs::path header_of_pair(const fs::path& path) {
  fs::path stem = path;
  if (lower_extension(stem) == ".gz") stem.replace_extension();
  if (lower_extension(stem) != ".img") return path;
  std::error_code code;
  for (const char* ending : {".hdr", ".hdr.gz", ".HDR"}) {
    fs::path header = fs::path(stem).replace_extension(ending);
    if (fs::is_regular_file(header, code)) return header;
  }
  return path;
}

Result<std::vector<std::byte>> read_whole(const fs::path& path) {
  TURGOR_TRY(auto bytes, read_file(path));
  if (bytes.empty()) return bad_file(path, "is empty", "Copy the file again");
  return bytes;
}

Result<StoredVolume> read_one_file(const fs::path& named, const ReadScanOptions& options, Context& context) {
  const Stage stage(context, "read scan");
  const fs::path path = header_of_pair(named);
  std::vector<std::byte> bytes;
  TURGOR_TRY(bytes, read_whole(path));
  switch (recognise(bytes, path)) {
    case Format::inv3:
      return read_inv3({path, bytes}, context);
    case Format::nifti:
      return read_nifti({path, bytes}, context);
    case Format::nrrd:
      return read_nrrd({path, bytes}, context);
    case Format::metaimage:
      return read_metaimage({path, bytes}, context);
    case Format::dicom:
      break;
  }
  bytes = {};
  return read_dicom(path, options.series, context);
}

/// A format that does not say what its numbers mean: they are taken at their word, and doubts are told.
void note_unknown_modality(const Scan& scan, const fs::path& path, Context& context) {
  if (!scan.info.modality.empty()) return;
  context.notice(path.string() + ": " + scan.info.format +
                 " does not state the modality; its values are taken as Hounsfield units.");
  const auto lowest = std::min_element(scan.hu.voxels.begin(), scan.hu.voxels.end());
  if (*lowest > -200) {
    context.warning(path.string() + ": its lowest value is " + std::to_string(*lowest) +
                    ", far above air: these may not be Hounsfield units.");
  }
}

Result<Scan> read_any(const fs::path& path, const ReadScanOptions& options, Context& context) {
  std::error_code code;
  const auto status = fs::status(path, code);
  if (status.type() == fs::file_type::not_found) {
    return bad_file(path, "no such file or folder", "Check the spelling of the path");
  }
  TURGOR_TRY(StoredVolume stored, fs::is_directory(status) ? read_dicom(path, options.series, context)
                                                           : read_one_file(path, options, context));
  TURGOR_TRY(Scan scan, to_canonical(std::move(stored), path, context, options.labels));
  if (!options.labels) note_unknown_modality(scan, path, context);
  return scan;
}

Result<std::vector<SeriesInfo>> list_any(const fs::path& path, Context& context) {
  std::error_code code;
  if (!fs::is_directory(path, code)) {
    std::vector<std::byte> bytes;
    TURGOR_TRY(bytes, read_whole(path));
    if (recognise(bytes, path) != Format::dicom) return std::vector<SeriesInfo>{};
  }
  return list_dicom_series(path, context);
}

/// Libraries and allocation may throw; our own interface does not.
template <class T, class Work>
Result<T> guarded(const fs::path& path, Work&& work) {
  try {
    return work();
  } catch (const std::bad_alloc&) {
    return Error{ErrorKind::system, "there is not enough memory to read it", path.string(),
                 "Close other programs, or crop the scan"};
  } catch (const std::exception& e) {
    return bad_file(path, std::string("cannot be read (") + e.what() + ")", "Export the scan again");
  }
}

}  // namespace

Result<Scan> read_scan(const fs::path& path, const ReadScanOptions& options, Context& context) {
  return guarded<Scan>(path, [&] { return read_any(path, options, context); });
}

Result<std::vector<SeriesInfo>> list_series(const fs::path& path, Context& context) {
  return guarded<std::vector<SeriesInfo>>(path, [&] { return list_any(path, context); });
}

}  // namespace turgor
