// What a model of motion, its barriers and the control of its steps must hold to. Internal to the module.
#pragma once

#include <span>
#include <string>

#include "turgor/dynamics/time_stepper.hpp"

namespace turgor::detail {

Error bad_motion(std::string what, std::string remedy);
Result<void> check_barriers(std::span<const Barrier> barriers, std::size_t points);
Result<void> check(const MotionModel& model);
Result<void> check_rest_length(int spring, double rest_length_mm, std::size_t springs);
/// The contact of a model that holds to all else.
Result<std::optional<SurfaceContact>> prepare_contact(const MotionModel& model);
Result<void> check_control(double duration_ms, const StepControl& control);

}  // namespace turgor::detail
