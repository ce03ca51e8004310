// Scan files in and out. Whatever is stored, the volume that comes out is right-handed LPS.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "turgor/core/context.hpp"
#include "turgor/imaging/volume.hpp"

namespace turgor {

struct ScanInfo {
  std::string format;              ///< "DICOM", "NIfTI", "NRRD", "MetaImage", "InVesalius"
  std::string patient;             ///< as stored; may be empty
  std::string study;               ///< description; may be empty
  std::string series;              ///< DICOM series instance UID; may be empty
  std::string series_description;  ///< may be empty
  std::string modality;            ///< "CT" where known; empty where the format states none
  double gantry_tilt_deg = 0;
  bool stored_left_handed = false;  ///< the array was mirrored or flipped in the file, and has been put right
  std::vector<std::string> skipped_files;
};

struct Scan {
  CtVolume hu;  ///< Hounsfield units; axes permuted and flipped so that i ≈ +L, j ≈ +P, k ≈ +S
  ScanInfo info;
};

/// One series of a DICOM folder.
struct SeriesInfo {
  std::string uid, description, modality;
  int slices = 0;
};

struct ReadScanOptions {
  std::string
      series;  ///< DICOM series UID (or a unique part of it, or of its description); empty: the largest CT
  /// Numbers of labels instead of Hounsfield units: sheared stacks are resampled by the nearest voxel, with 0
  /// outside, and a number beyond 16 bits is an error.
  bool labels = false;
};

/// Reads a DICOM folder (or one file of it), .nii/.nii.gz/.hdr+.img, .nrrd/.nhdr, .mha/.mhd (+raw/zraw),
/// .inv3. Errors name the file and the remedy; files that are not images are skipped with a warning when the
/// rest is whole.
Result<Scan> read_scan(const std::filesystem::path& path, const ReadScanOptions& options, Context& context);
/// The series of a DICOM folder, largest CT first. Empty for other formats.
Result<std::vector<SeriesInfo>> list_series(const std::filesystem::path& path, Context& context);

struct DicomWriteOptions {
  std::string patient_name = "Phantom^Turgor";
  std::string series_description = "Turgor head phantom";
  std::uint64_t seed = 0;  ///< UIDs are a pure function of this and of the content: a repeated run gives the
                           ///< same bytes, and two different phantoms never share a UID
};
/// A CT Image Storage series, one file a slice (IM0001.dcm …), explicit little endian, rescale intercept
/// -1024.
Result<void> write_dicom_series(const std::filesystem::path& folder, const CtVolume& hu,
                                const DicomWriteOptions& options, Context& context);
/// NRRD with space "left-posterior-superior", gzip.
Result<void> write_nrrd(const std::filesystem::path& path, const LabelVolume& labels);
Result<void> write_nrrd(const std::filesystem::path& path, const CtVolume& hu);
Result<void> write_nrrd(const std::filesystem::path& path, const Volume<float>& values);

}  // namespace turgor
