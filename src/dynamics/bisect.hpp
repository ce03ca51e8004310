// Pieces of what lies in space. Internal to the module.
#pragma once

#include <algorithm>
#include <span>

#include "geometry/median_split.hpp"

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
  const std::size_t half = split_at_median(items, place);
  bisect(items.first(half), place, fits, emit);
  bisect(items.subspan(half), place, fits, emit);
}

}  // namespace turgor::detail
