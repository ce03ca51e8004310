#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <map>

#include "imaging/scan/dicom_folder.hpp"
#include "imaging/scan/dicom_stack.hpp"
#include "imaging/scan/readers.hpp"
#include "turgor/core/file.hpp"
#include "turgor/core/parallel.hpp"

namespace turgor::scan_io {
namespace {
namespace fs = std::filesystem;

struct DecodedStack {
  std::vector<std::int16_t> voxels;
  ValueLosses losses;
  std::vector<std::string> faults;  // per slice, empty where whole
};

using FileBytes = std::map<fs::path, std::vector<std::byte>>;

/// Files with many frames are read once; single slices are read where they are decoded.
Result<FileBytes> read_multi_frame_files(const SliceStack& stack) {
  FileBytes files;
  for (const DicomSlice& slice : stack.slices) {
    if (slice.frames_in_file < 2 || files.contains(slice.path)) continue;
    TURGOR_TRY(files[slice.path], read_file(slice.path));
  }
  return files;
}

Result<DecodedStack> decode_stack(const SliceStack& stack, const Index3& size, Context& context) {
  const Stage stage(context, "scan slices");
  TURGOR_TRY(const FileBytes shared, read_multi_frame_files(stack));
  DecodedStack decoded;
  decoded.voxels.resize(voxel_count(size));
  decoded.faults.resize(stack.slices.size());
  const std::size_t plane = static_cast<std::size_t>(size[0]) * static_cast<std::size_t>(size[1]);
  std::atomic<std::size_t> done{0};
  const auto decode_one = [&](std::size_t k) -> Result<ValueLosses> {
    const DicomSlice& slice = stack.slices[k];
    const std::span<std::int16_t> out(decoded.voxels.data() + k * plane, plane);
    const auto kept = shared.find(slice.path);
    if (kept != shared.end()) return read_dicom_pixels(slice, kept->second, out);
    TURGOR_TRY(const auto bytes, read_file(slice.path));
    return read_dicom_pixels(slice, bytes, out);
  };
  decoded.losses = parallel_reduce<ValueLosses>(
      stack.slices.size(), 1, {},
      [&](std::size_t k, std::size_t) -> ValueLosses {
        if (context.cancelled()) return {};
        const auto losses = decode_one(k);
        if (!losses) decoded.faults[k] = losses.error().what;
        context.progress(static_cast<double>(++done) / static_cast<double>(stack.slices.size()));
        return losses ? *losses : ValueLosses{};
      },
      [](ValueLosses a, const ValueLosses& b) { return a += b; });
  TURGOR_CHECK(context.check());
  return decoded;
}

/// A gap may be the place of a file that had to be skipped: the error then names it. What is named like a
/// slice may be one, destroyed; notes beside the slices are not.
Error blame_skipped(Error error, const std::vector<SkippedFile>& skipped, const DicomSeries& series) {
  const auto was_image = [](const SkippedFile& file) {
    return file.fault != "is not a DICOM file" && file.fault != "holds no image" &&
           file.fault != "cannot be read";
  };
  const auto named_alike = [&](const SkippedFile& file) {
    return file.path.extension() == series.slices.front().path.extension();
  };
  auto blamed = std::find_if(skipped.begin(), skipped.end(), was_image);
  if (blamed == skipped.end()) blamed = std::find_if(skipped.begin(), skipped.end(), named_alike);
  if (blamed != skipped.end()) {
    error.what += fmt::format("; the file {} was skipped because it {}", blamed->path.filename().string(),
                              blamed->fault);
  }
  return error;
}

void report_skipped(const DicomFolder& folder, ScanInfo& info, Context& context) {
  if (folder.skipped.empty()) return;
  std::string names;
  for (std::size_t i = 0; i < folder.skipped.size(); ++i) {
    const SkippedFile& file = folder.skipped[i];
    info.skipped_files.push_back(file.path.string());
    if (i < 5)
      names += fmt::format("{}{} ({})", i > 0 ? ", " : "", file.path.filename().string(), file.fault);
  }
  if (folder.skipped.size() > 5) names += fmt::format(" and {} more", folder.skipped.size() - 5);
  context.warning(
      fmt::format("{}: {} file(s) skipped: {}.", folder.path.string(), folder.skipped.size(), names));
}

/// Takes slices whose pixels cannot be decoded out of the series. False if all were whole.
bool drop_faulty(const SliceStack& stack, const DecodedStack& decoded, DicomSeries& series,
                 DicomFolder& folder) {
  std::vector<DicomSlice> whole;
  for (std::size_t k = 0; k < stack.slices.size(); ++k) {
    if (decoded.faults[k].empty()) {
      whole.push_back(stack.slices[k]);
    } else if (folder.skipped.empty() || folder.skipped.back().path != stack.slices[k].path) {
      folder.skipped.push_back({stack.slices[k].path, decoded.faults[k]});  // once for all frames of a file
    }
  }
  const bool dropped = whole.size() < series.slices.size();
  series.slices = std::move(whole);
  return dropped;
}

}  // namespace

Result<StoredVolume> read_dicom(const fs::path& path, const std::string& wanted, Context& context) {
  TURGOR_TRY(DicomFolder folder, scan_dicom_folder(path, context));
  TURGOR_TRY(DicomSeries series, choose_series(folder, wanted, context));
  SliceStack stack;
  DecodedStack decoded;
  Index3 size{};
  do {
    if (series.slices.empty()) {
      return bad_file(folder.skipped.back().path, folder.skipped.back().fault, "Copy the series again");
    }
    auto stacked = stack_slices(series.slices, path);
    if (!stacked) return blame_skipped(stacked.error(), folder.skipped, series);
    stack = *std::move(stacked);
    const PixelLayout& layout = stack.slices.front().layout;
    TURGOR_TRY(
        size,
        checked_size({layout.columns, layout.rows, static_cast<std::int64_t>(stack.slices.size())}, path));
    decoded = {};
    TURGOR_TRY(decoded, decode_stack(stack, size, context));
  } while (drop_faulty(stack, decoded, series, folder));
  StoredVolume stored;
  const DicomSlice& first = stack.slices.front();
  stored.size = size;
  stored.origin = first.position;
  stored.axes = {first.row_step, first.column_step, stack.slice_step};
  stored.voxels = std::move(decoded.voxels);
  stored.losses = decoded.losses;
  stored.info.format = "DICOM";
  stored.info.patient = series.patient;
  stored.info.study = series.study_description;
  stored.info.series = series.info.uid;
  stored.info.series_description = series.info.description;
  stored.info.modality = series.info.modality;
  stored.info.gantry_tilt_deg = stack.tilt_deg;
  report_skipped(folder, stored.info, context);
  return stored;
}

Result<std::vector<SeriesInfo>> list_dicom_series(const fs::path& path, Context& context) {
  TURGOR_TRY(const DicomFolder folder, scan_dicom_folder(path, context));
  std::vector<SeriesInfo> list;
  for (const DicomSeries& series : folder.series) {
    list.push_back(series.info);
    if (series.localizer) list.back().description += " (localizer)";
  }
  return list;
}

}  // namespace turgor::scan_io
