// Masks as rows of bits, 64 voxels a word: what surfaces, components and morphology work on inside.
#pragma once

#include <bit>
#include <cstdint>
#include <cstring>
#include <vector>

#include "turgor/core/parallel.hpp"
#include "turgor/imaging/volume.hpp"

namespace turgor::detail {

/// Bit i of row (j, k) is bit i % 64 of word i / 64. Every row ends with at least one zero word, so that the
/// bits after the last voxel can be read without a test. Rows lie one after another, j fastest.
struct BitVolume {
  Index3 size{0, 0, 0};
  int words = 0;  ///< a row, with the closing zero word
  std::vector<std::uint64_t> bits;

  BitVolume() = default;
  explicit BitVolume(const Index3& n)
      : size(n), words((n[0] + 63) / 64 + 1), bits(rows() * static_cast<std::size_t>(words)) {}

  [[nodiscard]] std::size_t rows() const {
    return static_cast<std::size_t>(size[1]) * static_cast<std::size_t>(size[2]);
  }
  [[nodiscard]] std::uint64_t* row(std::size_t r) {
    return bits.data() + r * static_cast<std::size_t>(words);
  }
  [[nodiscard]] const std::uint64_t* row(std::size_t r) const {
    return bits.data() + r * static_cast<std::size_t>(words);
  }
  [[nodiscard]] std::size_t row_index(int j, int k) const {
    return static_cast<std::size_t>(k) * static_cast<std::size_t>(size[1]) + static_cast<std::size_t>(j);
  }
  [[nodiscard]] bool test(int i, int j, int k) const {
    return (row(row_index(j, k))[i / 64] >> (i % 64)) & 1;
  }
};

/// Rows that one parallel range takes: a few thousand voxels.
inline std::size_t row_grain(int row_length) {
  return static_cast<std::size_t>(std::max(1, 16384 / std::max(1, row_length)));
}

/// The bits below `n` (0 to 64) of a word.
inline std::uint64_t low_bits(int n) {
  return n >= 64 ? ~std::uint64_t{0} : (std::uint64_t{1} << n) - 1;
}

/// Whether the array has the length that its grid says (a default-constructed volume has not).
template <class T>
bool is_whole(const Volume<T>& volume) {
  return volume.voxels.size() == volume.grid.voxel_count();
}

/// Writes inside(values[i]) for i < n into the words of one row, from bit `first` (0 or 1) on.
template <class T, class Inside>
void pack_row(const T* values, int n, int first, std::uint64_t* words, Inside inside) {
  std::uint64_t carry = 0;
  int w = 0;
  for (int begin = 0; begin < n; begin += 64, ++w) {
    std::uint8_t flags[64];
    const int count = std::min(64, n - begin);
    if (count < 64) std::memset(flags, 0, sizeof flags);
    for (int i = 0; i < count; ++i) flags[i] = inside(values[begin + i]) ? 1 : 0;
    std::uint64_t word = 0;
    for (int b = 0; b < 8; ++b) {
      // Eight bytes of 0 or 1 become one byte: the product moves byte m's bit to bit 56 + m.
      std::uint64_t eight;
      std::memcpy(&eight, flags + 8 * b, 8);
      word |= ((eight * 0x0102040810204080ULL) >> 56) << (8 * b);
    }
    words[w] = (word << first) | carry;
    carry = first ? word >> 63 : 0;
  }
  if (carry) words[w] = carry;
}

/// One bit a voxel by a test of its value; with `pad` 1 a frame of zero voxels is laid around the volume.
template <class T, class Inside>
BitVolume pack(const Volume<T>& volume, int pad, Inside inside) {
  const Index3 n = volume.grid.size;
  BitVolume result({n[0] + 2 * pad, n[1] + 2 * pad, n[2] + 2 * pad});
  const std::size_t rows = static_cast<std::size_t>(n[1]) * static_cast<std::size_t>(n[2]);
  parallel_for(rows, row_grain(n[0]), [&](std::size_t begin, std::size_t end) {
    for (std::size_t r = begin; r < end; ++r) {
      const int j = static_cast<int>(r % static_cast<std::size_t>(n[1]));
      const int k = static_cast<int>(r / static_cast<std::size_t>(n[1]));
      pack_row(volume.voxels.data() + r * static_cast<std::size_t>(n[0]), n[0], pad,
               result.row(result.row_index(j + pad, k + pad)), inside);
    }
  });
  return result;
}

/// value ≥ level
BitVolume pack_at_least(const CtVolume& volume, double level, int pad = 0);
/// mask ≠ 0
BitVolume pack_nonzero(const LabelVolume& mask, int pad = 0);
/// mask = label
BitVolume pack_equal(const LabelVolume& mask, std::uint8_t label, int pad = 0);
/// Back to bytes of 0 and 1. `bits` must have the size of `grid`.
LabelVolume unpack(const BitVolume& bits, const Grid& grid);
/// All bits of voxels turned over; those after the end of a row stay zero.
BitVolume complement(const BitVolume& bits);

/// Calls visit(i) for each set bit of a word, i counted from `base`.
template <class Visit>
void for_each_bit(std::uint64_t word, int base, Visit&& visit) {
  for (; word; word &= word - 1) visit(base + std::countr_zero(word));
}

}  // namespace turgor::detail
