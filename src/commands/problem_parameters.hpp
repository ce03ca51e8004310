// Parameters of the search, shared by a problem's `method` and by `turgor calibrate`.
#pragma once

#include "short_forms.hpp"

namespace turgor::commands {

inline constexpr std::string_view kFitMethods[] = {"gauss_newton", "gradient", "cma_es", "annealing"};
inline constexpr Parameter kBudget = whole("budget", "2000", between(1, 10'000'000),
                                           "samples of the search, one for each iteration of gauss_newton");
inline constexpr Parameter kCoarse =
    whole("coarse", "100", between(0, 10'000'000),
          "samples spread over the bounds before the search, to find a stable start");
inline constexpr Parameter kChains =
    whole("chains", "4", between(1, 256), "annealing: chains side by side, which share the budget");
inline constexpr Parameter kSeed =
    whole("seed", "1", at_least(0), "of everything random; the same seed gives the same bits");
/// Goes before what the problem says, and has no default of its own.
constexpr Parameter before_problem(Parameter parameter) {
  parameter.fallback = {};
  return parameter;
}

}  // namespace turgor::commands
