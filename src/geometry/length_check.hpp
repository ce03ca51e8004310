// Whether coordinates can be computed with. Internal to the module.
#pragma once

#include <fmt/format.h>

#include <cmath>
#include <span>

#include "turgor/core/error.hpp"
#include "turgor/math/vec.hpp"

namespace turgor::detail {

/// Lengths up to here keep their fourth powers finite, and themselves in single precision.
constexpr double most_mm = 1e30;

/// Error where a coordinate is not finite or beyond most_mm; `name` says what the points are.
inline Result<void> check_lengths(std::span<const Vec3> points, const char* name) {
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Vec3& p = points[i];
    if (std::abs(p.x) <= most_mm && std::abs(p.y) <= most_mm && std::abs(p.z) <= most_mm) continue;
    return Error{ErrorKind::bad_input,
                 fmt::format("{} {} has a coordinate that is not a finite length", name, i), "",
                 "Repair the mesh"};
  }
  return {};
}

}  // namespace turgor::detail
