#include "imaging/scan/scalars.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <functional>

#include "turgor/core/parallel.hpp"

namespace turgor::scan_io {
namespace {

template <class T>
T load(const std::byte* p, bool swap) {
  std::byte raw[sizeof(T)];
  std::memcpy(raw, p, sizeof(T));
  if (swap) std::reverse(raw, raw + sizeof(T));
  T value;
  std::memcpy(&value, raw, sizeof(T));
  return value;
}

template <class T>
ValueLosses convert(const std::byte* in, const ScalarFormat& format, std::span<std::int16_t> out) {
  static_assert(std::endian::native == std::endian::little);
  ValueLosses losses;
  for (std::size_t n = 0; n < out.size(); ++n) {
    const double stored = static_cast<double>(load<T>(in + n * sizeof(T), format.big_endian));
    const double hu = std::floor(stored * format.slope + format.intercept + 0.5);
    if (hu >= -32768.0 && hu <= 32767.0) {
      out[n] = static_cast<std::int16_t>(hu);
    } else if (std::isfinite(hu)) {
      out[n] = hu < 0 ? std::int16_t{-32768} : std::int16_t{32767};
      ++losses.clamped;
    } else {
      out[n] = kAirHu;
      ++losses.not_finite;
    }
  }
  return losses;
}

ValueLosses convert_range(const std::byte* in, const ScalarFormat& format, std::span<std::int16_t> out) {
  switch (format.type) {
    case ScalarType::uint8:
      return convert<std::uint8_t>(in, format, out);
    case ScalarType::int8:
      return convert<std::int8_t>(in, format, out);
    case ScalarType::uint16:
      return convert<std::uint16_t>(in, format, out);
    case ScalarType::int16:
      return convert<std::int16_t>(in, format, out);
    case ScalarType::uint32:
      return convert<std::uint32_t>(in, format, out);
    case ScalarType::int32:
      return convert<std::int32_t>(in, format, out);
    case ScalarType::uint64:
      return convert<std::uint64_t>(in, format, out);
    case ScalarType::int64:
      return convert<std::int64_t>(in, format, out);
    case ScalarType::float32:
      return convert<float>(in, format, out);
    case ScalarType::float64:
      return convert<double>(in, format, out);
  }
  return {};
}

}  // namespace

std::size_t scalar_bytes(ScalarType type) {
  switch (type) {
    case ScalarType::uint8:
    case ScalarType::int8:
      return 1;
    case ScalarType::uint16:
    case ScalarType::int16:
      return 2;
    case ScalarType::uint32:
    case ScalarType::int32:
    case ScalarType::float32:
      return 4;
    case ScalarType::uint64:
    case ScalarType::int64:
    case ScalarType::float64:
      return 8;
  }
  return 1;
}

ValueLosses to_hounsfield(std::span<const std::byte> bytes, const ScalarFormat& format,
                          std::span<std::int16_t> out) {
  const std::size_t width = scalar_bytes(format.type);
  if (format.type == ScalarType::int16 && !format.big_endian && format.slope == 1 && format.intercept == 0) {
    std::memcpy(out.data(), bytes.data(), out.size() * width);
    return {};
  }
  return parallel_reduce<ValueLosses>(
      out.size(), 1 << 16, {},
      [&](std::size_t begin, std::size_t end) {
        return convert_range(bytes.data() + begin * width, format, out.subspan(begin, end - begin));
      },
      [](ValueLosses a, const ValueLosses& b) { return a += b; });
}

}  // namespace turgor::scan_io
