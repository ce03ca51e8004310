// Values at the corners of a cube (or at its Gauss points) and its modes 1, ξ, η, ξη, …: Walsh transforms;
// and symmetric matrices of which the upper half is kept. Internal.
#pragma once

#include <cstddef>

namespace turgor::detail {

/// Values at corners (or points), by bits x 1, y 2, z 4, to modes: sums with the modes' signs.
template <class R>
inline void to_modes(R (&v)[8]) {
  for (const unsigned bit : {1U, 2U, 4U}) {
    for (unsigned i = 0; i < 8; ++i) {
      if ((i & bit) != 0) continue;
      const R low = v[i], high = v[i | bit];
      v[i] = low + high, v[i | bit] = high - low;
    }
  }
}
/// And back, without the eighth: its transpose.
template <class R>
inline void from_modes(R (&v)[8]) {
  for (const unsigned bit : {1U, 2U, 4U}) {
    for (unsigned i = 0; i < 8; ++i) {
      if ((i & bit) != 0) continue;
      const R constant = v[i], along = v[i | bit];
      v[i] = constant - along, v[i | bit] = constant + along;
    }
  }
}

/// Where the upper half of a symmetric matrix of n rows has an entry; row ≤ column.
template <std::size_t n>
constexpr std::size_t packed(std::size_t row, std::size_t column) {
  return row * n - row * (row + 1) / 2 + column;
}
template <std::size_t n>
inline constexpr std::size_t kPackedSize = n*(n + 1) / 2;

}  // namespace turgor::detail
