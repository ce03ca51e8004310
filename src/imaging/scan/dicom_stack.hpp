// Slices of one series to a stack: order, spacing and tilt from their positions alone.
#pragma once

#include "imaging/scan/dicom_slice.hpp"

namespace turgor::scan_io {

struct SliceStack {
  std::vector<DicomSlice> slices;  ///< by rising position along the slice normal
  Vec3 slice_step{};    ///< from a slice to the next, LPS mm; oblique to the slices under gantry tilt
  double tilt_deg = 0;  ///< between slice_step and the slice normal
};

/// Sorts by the position projected on the slice normal. Errors: one slice only, mixed sizes, orientations or
/// pixel spacings, two slices at one place, a missing slice, uneven gaps or shifts.
Result<SliceStack> stack_slices(std::vector<DicomSlice> slices, const std::filesystem::path& where);

}  // namespace turgor::scan_io
