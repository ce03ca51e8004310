// How far two shapes are apart at most.
#pragma once

#include <algorithm>
#include <vector>

#include "turgor/math/vec.hpp"

namespace turgor::support {

inline double largest_distance(const std::vector<Vec3>& a, const std::vector<Vec3>& b) {
  double largest = 0;
  for (std::size_t i = 0; i < a.size(); ++i) largest = std::max(largest, distance(a[i], b[i]));
  return largest;
}

}  // namespace turgor::support
