// How often each value occurs, and levels found from that.
#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "turgor/imaging/volume.hpp"

namespace turgor {

/// Voxels of each whole value; other values are not counted.
struct Histogram {
  int lower = 0;                    ///< value of counts[0]
  std::vector<std::size_t> counts;  ///< voxels of value lower, lower + 1, …

  [[nodiscard]] std::size_t count(int value) const {
    const long long place = static_cast<long long>(value) - lower;
    return place < 0 || place >= static_cast<long long>(counts.size())
               ? 0
               : counts[static_cast<std::size_t>(place)];
  }
  [[nodiscard]] std::size_t total() const;
  /// Mean of the values counted; 0 where there are none.
  [[nodiscard]] double mean() const;
  /// Smallest value v such that at least the fraction (0 to 1) of what is counted is ≤ v. None where nothing
  /// is.
  [[nodiscard]] std::optional<int> quantile(double fraction) const;
  /// Most frequent value after averaging over 2 `half_width` + 1 values; the smallest of equals. None where
  /// nothing is counted.
  [[nodiscard]] std::optional<int> mode(int half_width = 5) const;
};

/// Values from lower to upper (both included), of all voxels or of those where `mask` ≠ 0 (a mask of another
/// size counts nothing).
Histogram histogram(const CtVolume& volume, int lower = -1024, int upper = 3071,
                    const LabelVolume* mask = nullptr);

/// The level between lower and upper that parts the values there into two classes with the largest variance
/// between their means (Otsu 1979): values ≥ level belong to the upper class. Midway where several are as
/// good, as between two separate peaks. None where fewer than two values occur in the range.
std::optional<double> otsu_level(const Histogram& histogram, int lower, int upper);

}  // namespace turgor
