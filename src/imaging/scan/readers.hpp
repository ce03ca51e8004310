// The readers of the single formats. Each takes the bytes of a file (so that tests and fuzzers need no disk).
#pragma once

#include "imaging/scan/stored_volume.hpp"

namespace turgor::scan_io {

/// InVesalius 3 project: a gzip-compressed tar archive with a property list and the raw array. The program
/// stores rows from back to front, so the array is left-handed: patient y = -sy j.
Result<StoredVolume> read_inv3(const SourceFile& file, Context& context);

/// NRRD, attached or detached (the data file is then read from beside the header).
Result<StoredVolume> read_nrrd(const SourceFile& file, Context& context);

/// NIfTI-1 and -2, single or as a pair (.hdr with .img), plain or gzip. The sform places it, else the qform.
Result<StoredVolume> read_nifti(const SourceFile& file, Context& context);

/// MetaImage, with the voxels inside (.mha) or in one file beside (.mhd).
Result<StoredVolume> read_metaimage(const SourceFile& file, Context& context);

/// A DICOM folder, or the series of one file in its folder. `wanted` as in ReadScanOptions::series.
Result<StoredVolume> read_dicom(const std::filesystem::path& path, const std::string& wanted,
                                Context& context);
Result<std::vector<SeriesInfo>> list_dicom_series(const std::filesystem::path& path, Context& context);

}  // namespace turgor::scan_io
