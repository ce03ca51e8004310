// The prisms between two layers of tissue as tetrahedra. Internal to the module.
#pragma once

#include <algorithm>
#include <array>

namespace turgor::detail {

/// The three tetrahedra of a prism over the triangle `column`: point numbers of the outer triangle,
/// anticlockwise seen from outside, and of the inner one. Their volumes are positive where the prism is not
/// turned over. The diagonals start at the smaller column numbers, so neighbouring prisms split their common
/// face alike.
inline std::array<std::array<int, 4>, 3> split_prism(std::array<int, 3> column, std::array<int, 3> outer,
                                                     std::array<int, 3> inner) {
  while (column[0] > column[1] || column[0] > column[2]) {
    std::rotate(column.begin(), column.begin() + 1, column.end());
    std::rotate(outer.begin(), outer.begin() + 1, outer.end());
    std::rotate(inner.begin(), inner.begin() + 1, inner.end());
  }
  const auto [a, b, c] = outer;
  const auto [d, e, f] = inner;
  if (column[1] < column[2]) return {{{a, d, f, e}, {a, b, e, f}, {a, b, f, c}}};
  return {{{a, d, f, e}, {a, c, e, f}, {a, b, e, c}}};
}

}  // namespace turgor::detail
