#include "turgor/dynamics/grab.hpp"

#include <fmt/format.h>

#include <cmath>

#include "turgor/core/index.hpp"
#include "turgor/tissue/network.hpp"

namespace turgor {
namespace {

Error bad_grab(std::string what, std::string remedy) {
  return {ErrorKind::bad_input, std::move(what), "grab", std::move(remedy)};
}

bool is_positive(double x) {
  return std::isfinite(x) && x > 0;
}

}  // namespace

Result<void> validate(const Grab& grab, std::size_t point_count) {
  if (grab.points.empty() || grab.points.size() != grab.weights.size()) {
    return bad_grab(
        fmt::format("{} points are grabbed with {} weights", grab.points.size(), grab.weights.size()),
        "Give at least one point, and a weight for each");
  }
  double sum = 0;
  for (std::size_t i = 0; i < grab.points.size(); ++i) {
    const int p = grab.points[i];
    if (p < 0 || at(p) >= point_count) {
      return bad_grab(fmt::format("point {} of {} is grabbed", p, point_count), "Point numbers start at 0");
    }
    if (!is_positive(grab.weights[i])) {
      return bad_grab(fmt::format("the weight of point {} is {}", p, grab.weights[i]),
                      "Weights must be finite numbers above 0");
    }
    sum += grab.weights[i];
  }
  if (!(std::abs(sum - 1) <= 1e-9))
    return bad_grab(fmt::format("the weights add up to {}", sum), "They must add up to 1");
  if (!is_within_reach(grab.target)) {
    return bad_grab(fmt::format("the target is ({}, {}, {}) mm", grab.target.x, grab.target.y, grab.target.z),
                    "Keep it within a thousand kilometres");
  }
  if (!(std::isfinite(grab.stiffness_n_mm) && grab.stiffness_n_mm >= 0)) {
    return bad_grab(fmt::format("the stiffness is {} N/mm", grab.stiffness_n_mm),
                    "It must be a finite number of at least 0");
  }
  if (!is_positive(grab.limit_n)) {
    return bad_grab(fmt::format("the limit is {} N", grab.limit_n), "It must be a finite number above 0");
  }
  return {};
}

GrabResponse respond(const Grab& grab, std::span<const Vec3> positions) {
  Vec3 mean;
  for (std::size_t i = 0; i < grab.points.size(); ++i)
    mean += positions[at(grab.points[i])] * grab.weights[i];
  const Vec3 to_target = grab.target - mean;
  const double d = length(to_target), k = grab.stiffness_n_mm, pull = k * d;
  if (!(pull > 0)) return {0, {}, k};
  if (pull <= grab.limit_n) return {0.5 * pull * d, to_target * k, k};
  const Vec3 force = to_target * (grab.limit_n / d);
  return {grab.limit_n * (d - 0.5 * grab.limit_n / k), force, k};
}

}  // namespace turgor
