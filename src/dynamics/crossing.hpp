// When a moving point passes through a moving triangle. Internal to the module.
#pragma once

#include <array>
#include <optional>
#include <span>

#include "turgor/math/vec.hpp"

namespace turgor {

/// Rising roots within [0, 1] of c[0] + c[1] t + c[2] t² + c[3] t³; of a polynomial that is zero all along
/// none.
struct Roots {
  std::array<double, 3> t;
  int count = 0;
};
Roots cubic_roots(const std::array<double, 4>& c);

struct Crossing {
  double time;                    ///< 0 to 1
  std::array<double, 4> weights;  ///< 1, then the negative barycentric ones of the place
  Vec3 normal;                    ///< unit, of the face then, to its front
};
/// The first time that the point goes through the triangle from its front, while the point and the corners
/// a, b, c go straight from from[i] to to[i], i = 0 the point. What starts behind the face by up to `slack`
/// and goes on counts as at its front.
std::optional<Crossing> first_crossing(const std::array<Vec3, 4>& from, const std::array<Vec3, 4>& to,
                                       double slack);

}  // namespace turgor
