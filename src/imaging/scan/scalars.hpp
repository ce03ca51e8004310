// Stored numbers to Hounsfield units.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "imaging/scan/stored_volume.hpp"

namespace turgor::scan_io {

enum class ScalarType { uint8, int8, uint16, int16, uint32, int32, uint64, int64, float32, float64 };

std::size_t scalar_bytes(ScalarType type);

struct ScalarFormat {
  ScalarType type = ScalarType::int16;
  bool big_endian = false;
  double slope = 1, intercept = 0;  ///< HU = slope * stored + intercept, rounded to the nearest
};

/// Converts as many values as `out` has room for from `bytes`, which must hold them. Parallel.
ValueLosses to_hounsfield(std::span<const std::byte> bytes, const ScalarFormat& format,
                          std::span<std::int16_t> out);

}  // namespace turgor::scan_io
