#include "imaging/scan/dicom_stack.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace turgor::scan_io {
namespace {

std::string slice_name(const DicomSlice& slice) {
  const std::string file = slice.path.filename().string();
  return slice.frames_in_file > 1 ? fmt::format("{} frame {}", file, slice.frame + 1) : file;
}

/// Two slices that the user has to tell apart: of one name they lie in different folders.
std::string both_names(const DicomSlice& a, const DicomSlice& b) {
  const bool same = slice_name(a) == slice_name(b) && a.path != b.path;
  return same ? fmt::format("{} and {}", a.path.string(), b.path.string())
              : fmt::format("{} and {}", slice_name(a), slice_name(b));
}

Result<void> check_alike(const std::vector<DicomSlice>& slices, const std::filesystem::path& where) {
  const DicomSlice& first = slices.front();
  for (const DicomSlice& slice : slices) {
    const PixelLayout &a = first.layout, &b = slice.layout;
    if (a.rows != b.rows || a.columns != b.columns) {
      return bad_file(where,
                      fmt::format("mixes slices of {} × {} voxels ({}) and {} × {} ({})", a.columns, a.rows,
                                  slice_name(first), b.columns, b.rows, slice_name(slice)),
                      "Keep slices of one size in the folder");
    }
    if (distance(normalized(first.row_step), normalized(slice.row_step)) > 1e-3 ||
        distance(normalized(first.column_step), normalized(slice.column_step)) > 1e-3) {
      return bad_file(where,
                      fmt::format("mixes slices of different orientation ({} and {})", slice_name(first),
                                  slice_name(slice)),
                      "Keep slices of one orientation in the folder");
    }
    if (std::abs(length(first.row_step) / length(slice.row_step) - 1) > 1e-3 ||
        std::abs(length(first.column_step) / length(slice.column_step) - 1) > 1e-3) {
      return bad_file(where,
                      fmt::format("mixes slices of different pixel spacing ({} and {})", slice_name(first),
                                  slice_name(slice)),
                      "Keep slices of one pixel spacing in the folder");
    }
  }
  return {};
}

Result<void> check_gaps(const std::vector<DicomSlice>& slices, const Vec3& normal,
                        const std::filesystem::path& where) {
  std::vector<double> gaps;
  for (std::size_t i = 1; i < slices.size(); ++i) {
    gaps.push_back(dot(normal, slices[i].position - slices[i - 1].position));
    if (gaps.back() < 1e-3) {
      return bad_file(where,
                      fmt::format("has two slices at one place ({})", both_names(slices[i - 1], slices[i])),
                      "Remove the one that does not belong to the series");
    }
  }
  std::vector<double> sorted = gaps;
  const auto middle = sorted.begin() + static_cast<std::ptrdiff_t>(sorted.size() / 2);
  std::nth_element(sorted.begin(), middle, sorted.end());
  const double usual = *middle;
  for (std::size_t i = 0; i < gaps.size(); ++i) {
    const std::string between =
        fmt::format("between {} and {}", slice_name(slices[i]), slice_name(slices[i + 1]));
    if (gaps[i] > 1.5 * usual) {
      return bad_file(where,
                      fmt::format("lacks {} slice(s) {}: a gap of {:.2f} mm where {:.2f} mm is usual",
                                  std::max(1.0, std::round(gaps[i] / usual) - 1), between, gaps[i], usual),
                      "Copy the whole series again");
    }
    // Scanners round positions to a tenth of a millimetre, so thin slices may seem a little uneven.
    if (std::abs(gaps[i] - usual) > std::max(0.25 * usual, 0.05)) {
      return bad_file(where,
                      fmt::format("has unevenly spaced slices: {:.2f} mm {} where {:.2f} mm is usual",
                                  gaps[i], between, usual),
                      "Export the series with even spacing, or name one of its even parts");
    }
  }
  return {};
}

}  // namespace

Result<SliceStack> stack_slices(std::vector<DicomSlice> slices, const std::filesystem::path& where) {
  if (slices.size() < 2) {
    return bad_file(where, "holds one slice only, which is not a volume",
                    "Name the folder of a whole series");
  }
  TURGOR_CHECK(check_alike(slices, where));
  const Vec3 normal = normalized(cross(slices.front().row_step, slices.front().column_step));
  std::stable_sort(slices.begin(), slices.end(), [&](const DicomSlice& a, const DicomSlice& b) {
    return dot(normal, a.position) < dot(normal, b.position);
  });
  TURGOR_CHECK(check_gaps(slices, normal, where));
  SliceStack stack;
  const Vec3 first = slices.front().position;
  stack.slice_step = (slices.back().position - first) / static_cast<double>(slices.size() - 1);
  const double tolerance =
      0.5 * std::min(length(slices.front().row_step), length(slices.front().column_step));
  for (std::size_t i = 0; i < slices.size(); ++i) {
    Vec3 apart = slices[i].position - first - stack.slice_step * static_cast<double>(i);
    apart -= normal * dot(normal, apart);
    if (length(apart) > tolerance) {
      return bad_file(where,
                      fmt::format("has slices shifted against each other at {} by {:.2f} mm",
                                  slice_name(slices[i]), length(apart)),
                      "Export the series again without changed table positions");
    }
  }
  const double along = std::min(1.0, dot(normal, normalized(stack.slice_step)));
  stack.tilt_deg = degrees(std::acos(along));
  if (stack.tilt_deg < 0.05) stack.tilt_deg = 0;
  stack.slices = std::move(slices);
  return stack;
}

}  // namespace turgor::scan_io
