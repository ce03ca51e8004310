// Parameters of the search, shared by a problem's `method` and by `turgor calibrate`.
#pragma once

#include "turgor/commands/declaration.hpp"

namespace turgor::commands {

inline constexpr std::string_view kFitMethods[] = {"gauss_newton", "gradient", "cma_es", "annealing"};
inline constexpr Parameter kBudget{
    .name = "budget",
    .type = ValueType::integer,
    .range = between(1, 10'000'000),
    .fallback = "2000",
    .help = "samples of the search, one for each iteration of gauss_newton",
};
inline constexpr Parameter kCoarse{
    .name = "coarse",
    .type = ValueType::integer,
    .range = between(0, 10'000'000),
    .fallback = "100",
    .help = "samples spread over the bounds before the search, to find a stable start",
};
inline constexpr Parameter kChains{
    .name = "chains",
    .type = ValueType::integer,
    .range = between(1, 256),
    .fallback = "4",
    .help = "annealing: chains side by side, which share the budget",
};
inline constexpr Parameter kSeed{
    .name = "seed",
    .type = ValueType::integer,
    .range = at_least(0),
    .fallback = "1",
    .help = "of everything random; the same seed gives the same bits",
};
/// Goes before what the problem says, and has no default of its own.
constexpr Parameter before_problem(Parameter parameter) {
  parameter.fallback = {};
  return parameter;
}

}  // namespace turgor::commands
