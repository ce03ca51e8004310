// One CT slice: what its header says, and its pixels.
#pragma once

#include <string>
#include <vector>

#include "imaging/scan/dicom_data_set.hpp"
#include "imaging/scan/stored_volume.hpp"

namespace turgor::scan_io {

/// Pixel description module (PS3.3 C.7.6.3).
struct PixelLayout {
  int rows = 0, columns = 0;
  int bits_allocated = 16, bits_stored = 16, high_bit = 15;
  bool is_signed = false;
  bool operator==(const PixelLayout&) const = default;
};

struct DicomSlice {
  std::filesystem::path path;
  int frame = 0;  ///< of a multi-frame file, from 0
  int frames_in_file = 1;
  PixelLayout layout;
  double slope = 1, intercept = 0;
  bool has_padding = false;
  int padding_low = 0, padding_high = 0;  ///< stored values that mean "nothing was measured here"
  Vec3 position{};                        ///< centre of the first pixel, LPS mm
  Vec3 row_step{}, column_step{};         ///< LPS mm from a pixel to the next along a row, and down a column
};

/// What all slices of a file share and series are told apart by.
struct DicomFileInfo {
  std::string series_uid, series_description, study_description, patient, modality;
  bool localizer = false;
  std::vector<DicomSlice> slices;
};

/// Error kinds of one file, of which the folder reader makes warnings.
struct DicomFileOutcome {
  std::optional<DicomFileInfo> info;
  std::string fault;       ///< why there is none
  bool not_dicom = false;  ///< some other file
};

/// Reads the header of a file (its first 256 KiB where that is enough).
DicomFileOutcome read_dicom_info(const std::filesystem::path& path);
/// The same from memory. `file_size` may exceed `bytes`, which then hold the beginning of the file.
DicomFileOutcome parse_dicom_info(Bytes bytes, std::uint64_t file_size, const std::filesystem::path& path,
                                  bool* needs_more = nullptr);

/// Hounsfield units of one slice into `out` (rows × columns values). `bytes`: the whole file.
Result<ValueLosses> read_dicom_pixels(const DicomSlice& slice, Bytes bytes, std::span<std::int16_t> out);

}  // namespace turgor::scan_io
