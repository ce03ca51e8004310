#include "dynamics/motion_check.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "turgor/core/index.hpp"

namespace turgor::detail {

Error bad_motion(std::string what, std::string remedy) {
  return {ErrorKind::bad_input, std::move(what), "motion", std::move(remedy)};
}

namespace {

bool at_least_zero(double x) {
  return std::isfinite(x) && x >= 0;
}

Result<void> check_springs(const MotionModel& model) {
  if (!model.springs.empty() && model.springs.size() != model.network.springs.size()) {
    return bad_motion(fmt::format("{} viscosities are given for {} springs", model.springs.size(),
                                  model.network.springs.size()),
                      "Give one for each spring, or none");
  }
  for (std::size_t i = 0; i < model.springs.size(); ++i) {
    const SpringMotion& s = model.springs[i];
    if (!at_least_zero(s.viscosity) || !at_least_zero(s.cutoff_mm)) {
      return bad_motion(
          fmt::format("spring {} has the viscosity {} and the cut-off {}", i, s.viscosity, s.cutoff_mm),
          "Both must be finite numbers of at least 0");
    }
  }
  return {};
}

Result<void> check_relaxation(std::span<const Relaxation> relaxation) {
  double shares = 0;
  for (const Relaxation& r : relaxation) {
    if (!at_least_zero(r.share) || !(std::isfinite(r.time_ms) && r.time_ms > 0))
      return bad_motion(fmt::format("a share of {} relaxes with the time {} ms", r.share, r.time_ms),
                        "The share must be at least 0, the time above 0");
    shares += r.share;
  }
  if (!(shares < 1))
    return bad_motion(fmt::format("{} of the tension relaxes", shares),
                      "The shares must add up to less than 1");
  return {};
}

}  // namespace

Result<void> check_barriers(std::span<const Barrier> barriers, std::size_t points) {
  for (const Barrier& barrier : barriers) {
    TURGOR_CHECK(validate(barrier));
    for (const int p : barrier.points) {
      if (p < 0 || at(p) >= points)
        return bad_motion(fmt::format("a barrier acts on point {} of {}", p, points),
                          "Point numbers start at 0");
    }
  }
  return {};
}

Result<void> check(const MotionModel& model) {
  TURGOR_CHECK(validate(model.network));
  TURGOR_CHECK(check_springs(model));
  if (!model.mobile.empty() && model.mobile.size() != model.network.rest.size()) {
    return bad_motion(fmt::format("{} points are told mobile or fixed, of {}", model.mobile.size(),
                                  model.network.rest.size()),
                      "Tell it of each point, or of none");
  }
  for (std::size_t i = 0; i < model.network.rest.size(); ++i) {
    const bool mobile = model.mobile.empty() || model.mobile[i] != 0;
    if (mobile && !(model.network.mass_g[i] > 0)) {
      return bad_motion(fmt::format("the mobile point {} has no mass", i), "Give it one, or fix it");
    }
  }
  if (!is_finite(model.gravity_mm_ms2))
    return bad_motion("gravity is not finite", "Give an acceleration in mm/ms²");
  if (!at_least_zero(model.damping_g_ms)) {
    return bad_motion(fmt::format("the damping is {} g/ms", model.damping_g_ms),
                      "It must be a finite number of at least 0");
  }
  TURGOR_CHECK(check_barriers(model.barriers, model.network.rest.size()));
  for (const Grab& grab : model.grabs) TURGOR_CHECK(validate(grab, model.network.rest.size()));
  return check_relaxation(model.relaxation);
}

Result<void> check_rest_length(int spring, double rest_length_mm, std::size_t springs) {
  if (spring < 0 || at(spring) >= springs)
    return bad_motion(fmt::format("there is no spring {}, of {}", spring, springs), "Numbers start at 0");
  if (!(std::isfinite(rest_length_mm) && rest_length_mm > 0)) {
    return bad_motion(fmt::format("the rest length of spring {} is to be {} mm", spring, rest_length_mm),
                      "It must be a finite number above 0");
  }
  return {};
}

Result<void> check_control(double duration_ms, const StepControl& c) {
  const auto positive = [](double x) { return std::isfinite(x) && x > 0; };
  if (!positive(duration_ms) || !positive(c.tolerance_mm) || !positive(c.shortest_ms) ||
      !(std::isfinite(c.longest_ms) && c.longest_ms >= c.shortest_ms)) {
    return bad_motion(fmt::format("{} ms in steps of {} to {} ms with a tolerance of {} mm", duration_ms,
                                  c.shortest_ms, c.longest_ms, c.tolerance_mm),
                      "All must be above 0, the shortest step no longer than the longest");
  }
  return {};
}

}  // namespace turgor::detail
