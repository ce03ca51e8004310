// What every solver of a prediction needs: its time, and whether what it found is an answer.
#pragma once

#include <chrono>

#include "turgor/core/error.hpp"
#include "turgor/dynamics/equilibrium.hpp"
#include "turgor/world/prediction.hpp"

namespace turgor {

using Clock = std::chrono::steady_clock;
inline double seconds_since(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

/// Short of the residual asked for the solver warns and the report states what was reached. Error: beyond
/// `usable_residual`, where it is no answer.
Result<void> check_usable(Solver solver, const EquilibriumResult& equilibrium, double usable_residual);

}  // namespace turgor
