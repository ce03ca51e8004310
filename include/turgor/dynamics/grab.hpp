// A hand, a hook or a haptic device on tissue: points pulled to a target by a spring that gives way.
#pragma once

#include <span>
#include <vector>

#include "turgor/core/error.hpp"
#include "turgor/math/vec.hpp"

namespace turgor {

/// Pulls the weighted mean g = Σ wᵢ xᵢ of its points to the target with the force min(k d, limit) at the
/// distance d = |target − g|, shared by the weights: the exact gradient of ½ k d² up to d* = limit/k, of
/// limit (d − d*/2) beyond.
struct Grab {
  std::vector<int> points;      ///< at least one
  std::vector<double> weights;  ///< as many, > 0, adding up to 1
  Vec3 target;                  ///< mm
  double stiffness_n_mm = 1;    ///< k, ≥ 0
  double limit_n = 1e9;         ///< > 0
};
/// Errors name what is out of range.
Result<void> validate(const Grab& grab, std::size_t point_count);

struct GrabResponse {
  double energy;     ///< N·mm
  Vec3 force;        ///< on the tissue, N; its length is what the hand feels
  double stiffness;  ///< a bound, N/mm
};
GrabResponse respond(const Grab& grab, std::span<const Vec3> positions);

}  // namespace turgor
