#include "imaging/bit_volume.hpp"

#include <limits>

namespace turgor::detail {

BitVolume pack_at_least(const CtVolume& volume, double level, int pad) {
  using Limits = std::numeric_limits<std::int16_t>;
  if (!(level <= Limits::max())) return pack(volume, pad, [](std::int16_t) { return false; });
  const auto lowest = static_cast<std::int16_t>(std::ceil(std::max<double>(level, Limits::min())));
  return pack(volume, pad, [lowest](std::int16_t value) { return value >= lowest; });
}

BitVolume pack_nonzero(const LabelVolume& mask, int pad) {
  return pack(mask, pad, [](std::uint8_t value) { return value != 0; });
}

BitVolume pack_equal(const LabelVolume& mask, std::uint8_t label, int pad) {
  return pack(mask, pad, [label](std::uint8_t value) { return value == label; });
}

namespace {

/// Eight bits to eight bytes of 0 or 1, bit 0 first in memory.
std::uint64_t spread(std::uint64_t byte) {
  const std::uint64_t low = (byte & 0x7F) * 0x0002040810204081ULL & 0x0101010101010101ULL;
  return low | (byte >> 7) << 56;
}

}  // namespace

LabelVolume unpack(const BitVolume& bits, const Grid& grid) {
  LabelVolume mask(grid);
  const int n = grid.size[0];
  parallel_for(bits.rows(), row_grain(n), [&](std::size_t begin, std::size_t end) {
    for (std::size_t r = begin; r < end; ++r) {
      const std::uint64_t* row = bits.row(r);
      std::uint8_t* out = mask.voxels.data() + r * static_cast<std::size_t>(n);
      for (int i = 0; i < n; i += 8) {
        const std::uint64_t eight = spread((row[i / 64] >> (i % 64)) & 0xFF);
        std::memcpy(out + i, &eight, static_cast<std::size_t>(std::min(8, n - i)));
      }
    }
  });
  return mask;
}

BitVolume complement(const BitVolume& bits) {
  BitVolume result(bits.size);
  const int full = bits.size[0] / 64, rest = bits.size[0] % 64;
  for (std::size_t r = 0; r < bits.rows(); ++r) {
    const std::uint64_t* from = bits.row(r);
    std::uint64_t* to = result.row(r);
    for (int w = 0; w < full; ++w) to[w] = ~from[w];
    if (rest) to[full] = ~from[full] & low_bits(rest);
  }
  return result;
}

}  // namespace turgor::detail
