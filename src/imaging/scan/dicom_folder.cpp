#include "imaging/scan/dicom_folder.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <set>
#include <system_error>
#include <tuple>

#include "turgor/core/parallel.hpp"

namespace turgor::scan_io {
namespace {
namespace fs = std::filesystem;

constexpr std::size_t kMaxFiles = 100'000;
constexpr int kMaxDepth = 8;

/// Files that accompany DICOM images and are passed over without a word.
bool is_companion(const fs::path& path) {
  const std::string name = path.filename().string();
  return name.starts_with('.') || name == "DICOMDIR";
}

Result<std::vector<fs::path>> list_files(const fs::path& folder, int max_depth, Context& context) {
  std::vector<fs::path> files;
  std::error_code code;
  fs::recursive_directory_iterator at(folder, fs::directory_options::skip_permission_denied, code), end;
  for (; !code && at != end; at.increment(code)) {
    TURGOR_CHECK(context.check());
    if (at.depth() >= max_depth) at.disable_recursion_pending();
    std::error_code ignored;
    // Links to nothing, pipes and devices stay in the list: whoever reads them says that they cannot be read.
    if (at->is_directory(ignored) || is_companion(at->path())) continue;
    files.push_back(at->path());
    if (files.size() > kMaxFiles) {
      return bad_file(folder, fmt::format("holds more than {} files", kMaxFiles),
                      "Name the folder of one patient");
    }
  }
  if (code)
    return Error{ErrorKind::system, "cannot be listed (" + code.message() + ")", folder.string(),
                 "Check its permissions"};
  std::sort(files.begin(), files.end());
  return files;
}

Result<std::vector<DicomFileOutcome>> read_headers(const std::vector<fs::path>& files, Context& context) {
  std::vector<DicomFileOutcome> outcomes(files.size());
  parallel_for(files.size(), 8, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end && !context.cancelled(); ++i) outcomes[i] = read_dicom_info(files[i]);
  });
  TURGOR_CHECK(context.check());
  return outcomes;
}

std::vector<DicomSeries> group(std::vector<DicomFileOutcome>& outcomes) {
  std::map<std::pair<std::string, bool>, DicomSeries> groups;
  for (DicomFileOutcome& outcome : outcomes) {
    if (!outcome.info) continue;
    DicomFileInfo& file = *outcome.info;
    DicomSeries& series = groups[{file.series_uid, file.localizer}];
    if (series.slices.empty()) {
      series.info = {file.series_uid, file.series_description, file.modality, 0};
      series.study_description = file.study_description;
      series.patient = file.patient;
      series.localizer = file.localizer;
    }
    series.slices.insert(series.slices.end(), file.slices.begin(), file.slices.end());
    series.info.slices = static_cast<int>(series.slices.size());
  }
  std::vector<DicomSeries> all;
  all.reserve(groups.size());
  for (auto& [key, series] : groups) all.push_back(std::move(series));
  const auto rank = [](const DicomSeries& s) {
    return std::tuple(s.info.modality != "CT", s.localizer, -s.info.slices, s.info.uid);
  };
  std::sort(all.begin(), all.end(), [&](const auto& a, const auto& b) { return rank(a) < rank(b); });
  return all;
}

/// Nothing readable: says the likeliest reason.
Error no_images(const fs::path& folder, const std::vector<fs::path>& files,
                const std::vector<SkippedFile>& skipped) {
  for (const fs::path& file : files) {
    const std::string name = file.filename().string();
    for (const char* ending : {".nii", ".nii.gz", ".nrrd", ".nhdr", ".mha", ".mhd", ".inv3"}) {
      if (name.ends_with(ending)) {
        return bad_file(folder, "holds no DICOM images",
                        fmt::format("Name the file itself: {}", file.string()));
      }
    }
  }
  for (const SkippedFile& file : skipped) {
    if (file.fault != "is not a DICOM file") {
      return bad_file(folder,
                      fmt::format("holds no readable CT image; {}, for one, {}",
                                  file.path.filename().string(), file.fault),
                      "Copy the series again from its source");
    }
  }
  return bad_file(folder, "holds no DICOM images", "Name a folder with a CT series, or a scan file");
}

std::string describe(const SeriesInfo& info) {
  return fmt::format("\"{}\" ({}, {} slices, {})", info.description,
                     info.modality.empty() ? "no modality" : info.modality, info.slices, info.uid);
}

std::string describe_all(const std::vector<const DicomSeries*>& series) {
  std::string text;
  for (std::size_t i = 0; i < series.size() && i < 8; ++i) {
    text += (i > 0 ? "; " : "") + describe(series[i]->info);
  }
  return series.size() > 8 ? text + fmt::format("; and {} more", series.size() - 8) : text;
}

}  // namespace

Result<DicomFolder> scan_dicom_folder(const fs::path& path, Context& context) {
  const Stage stage(context, "scan headers");
  std::error_code code;
  const bool one_file = !fs::is_directory(path, code);
  const fs::path folder = !one_file ? path : path.has_parent_path() ? path.parent_path() : fs::path(".");
  TURGOR_TRY(std::vector<fs::path> files, list_files(folder, one_file ? 0 : kMaxDepth, context));
  std::string own_series;
  if (one_file) {
    const DicomFileOutcome own = read_dicom_info(path);
    if (!own.info) {
      return bad_file(path, own.not_dicom ? "is not a scan in a format known here" : own.fault,
                      "Name a DICOM folder or file, NIfTI, NRRD, MetaImage or InVesalius project");
    }
    own_series = own.info->series_uid;
  }
  TURGOR_TRY(auto outcomes, read_headers(files, context));
  DicomFolder result;
  result.path = path;
  for (std::size_t i = 0; i < files.size(); ++i) {
    if (outcomes[i].info || (one_file && outcomes[i].not_dicom)) continue;
    result.skipped.push_back({files[i], outcomes[i].fault});
  }
  result.series = group(outcomes);
  if (one_file) {
    std::erase_if(result.series, [&](const DicomSeries& s) { return s.info.uid != own_series; });
  }
  if (result.series.empty()) return no_images(path, files, result.skipped);
  return result;
}

Result<DicomSeries> choose_series(const DicomFolder& folder, const std::string& wanted, Context& context) {
  std::vector<const DicomSeries*> all, matches;
  for (const DicomSeries& series : folder.series) all.push_back(&series);
  if (wanted.empty()) {
    const DicomSeries& best = *all.front();
    if (best.info.modality != "CT") {
      return bad_file(
          folder.path, "holds no CT series, only " + describe_all(all),
          "Name a CT scan; to read another series as Hounsfield units all the same, name its UID");
    }
    if (all.size() > 1) {
      context.notice(fmt::format("{}: {} series; the largest CT is taken: {}.", folder.path.string(),
                                 all.size(), describe(best.info)));
    }
    return best;
  }
  for (const DicomSeries* s : all) {
    if (s->info.uid == wanted) matches.push_back(s);
  }
  if (matches.empty()) {
    for (const DicomSeries* s : all) {
      if (s->info.uid.find(wanted) != std::string::npos ||
          s->info.description.find(wanted) != std::string::npos) {
        matches.push_back(s);
      }
    }
  }
  if (matches.empty()) {
    return bad_file(folder.path, fmt::format("holds no series \"{}\"", wanted),
                    "It holds " + describe_all(all));
  }
  std::set<std::string> uids;
  for (const DicomSeries* s : matches) uids.insert(s->info.uid);
  if (uids.size() > 1) {
    return bad_file(folder.path, fmt::format("holds several series that match \"{}\"", wanted),
                    "Name one of " + describe_all(matches));
  }
  if (matches.front()->info.modality != "CT") {
    context.warning(fmt::format("{}: the series {} is not CT; its values are taken as Hounsfield units.",
                                folder.path.string(), describe(matches.front()->info)));
  }
  return *matches.front();
}

}  // namespace turgor::scan_io
