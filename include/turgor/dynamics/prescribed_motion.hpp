// What is prescribed of a network's motion: where its moved points go, and which points stay.
#pragma once

#include <span>
#include <vector>

#include "turgor/core/error.hpp"
#include "turgor/math/vec.hpp"

namespace turgor {

/// Positions of the moved points, and the fixed points. All others are free.
struct PrescribedMotion {
  std::vector<int> moved;       ///< point numbers, ascending
  std::vector<Vec3> positions;  ///< of the moved points, mm
  std::vector<int> fixed;       ///< ascending, none of them moved
};

/// Errors: numbers out of range, not ascending, both moved and fixed, without a position, positions not
/// finite.
Result<void> validate(const PrescribedMotion& motion, int point_count);

}  // namespace turgor
