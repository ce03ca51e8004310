// Pieces of what lies in space. Internal to the module.
#pragma once

#include <algorithm>
#include <span>

#include "turgor/math/vec.hpp"

namespace turgor::detail {

/// Halves `items` at the median along the longest side until fits(piece), and emits every piece in rising
/// order. place(item) is where it lies. At least one piece, of nothing where there is nothing.
template <class Place, class Fits, class Emit>
void bisect(std::span<int> items, const Place& place, const Fits& fits, const Emit& emit) {
  if (items.size() < 2 || fits(std::span<const int>(items))) {
    std::sort(items.begin(), items.end());
    emit(std::span<const int>(items));
    return;
  }
  Box3 box;
  for (const int i : items) box.extend(place(i));
  const Vec3 size = box.size();
  const int axis = size.x >= size.y && size.x >= size.z ? 0 : size.y >= size.z ? 1 : 2;
  const std::size_t half = items.size() / 2;
  std::nth_element(items.begin(), items.begin() + static_cast<std::ptrdiff_t>(half), items.end(),
                   [&](int p, int q) {
                     const double a = place(p)[axis], b = place(q)[axis];
                     return a != b ? a < b : p < q;
                   });
  bisect(items.first(half), place, fits, emit);
  bisect(items.subspan(half), place, fits, emit);
}

}  // namespace turgor::detail
