// Halving of items by where they lie, for trees of boxes and blocks of neighbours. Internal.
#pragma once

#include <algorithm>
#include <cstddef>
#include <span>

#include "turgor/math/vec.hpp"

namespace turgor::detail {

/// Of equal sides the first.
inline int widest_axis(const Vec3& size) {
  return size.x >= size.y && size.x >= size.z ? 0 : size.y >= size.z ? 1 : 2;
}

/// Rearranges `items` so that those before the median along the longest side of their places come first, ties
/// by number; returns how many, half of them. place(item) is where it lies.
template <class Place>
std::size_t split_at_median(std::span<int> items, const Place& place) {
  Box3 box;
  for (const int i : items) box.extend(place(i));
  const int axis = widest_axis(box.size());
  const std::size_t half = items.size() / 2;
  std::nth_element(items.begin(), items.begin() + static_cast<std::ptrdiff_t>(half), items.end(),
                   [&](int p, int q) {
                     const double a = place(p)[axis], b = place(q)[axis];
                     return a != b ? a < b : p < q;
                   });
  return half;
}

}  // namespace turgor::detail
