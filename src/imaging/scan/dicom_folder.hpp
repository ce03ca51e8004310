// The series that lie in a folder of DICOM files.
#pragma once

#include "imaging/scan/dicom_slice.hpp"

namespace turgor::scan_io {

struct DicomSeries {
  SeriesInfo info;
  std::string study_description, patient;
  bool localizer = false;
  std::vector<DicomSlice> slices;
};

struct SkippedFile {
  std::filesystem::path path;
  std::string fault;
};

struct DicomFolder {
  std::filesystem::path path;  ///< as the user named it: a folder, or one file of it
  std::vector<DicomSeries>
      series;  ///< largest CT first; localizers apart from the series that they belong to
  std::vector<SkippedFile> skipped;  ///< by path
};

/// Reads the headers of all files in and below the folder `path` (of a file: beside it, only its own series
/// stays). Errors: a file that is no CT image, no images at all, more than 100,000 files.
Result<DicomFolder> scan_dicom_folder(const std::filesystem::path& path, Context& context);

/// The series of that UID, or whose UID or description holds `wanted`; the largest CT if that is empty.
Result<DicomSeries> choose_series(const DicomFolder& folder, const std::string& wanted, Context& context);

}  // namespace turgor::scan_io
