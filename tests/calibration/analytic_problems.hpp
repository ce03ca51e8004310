// Calibrations whose answers are known, of the models of analytic_models.hpp.
#pragma once

#include <gtest/gtest.h>

#include <limits>
#include <vector>

#include "calibration/analytic_models.hpp"

namespace turgor::testing_models {

inline constexpr double infinity = std::numeric_limits<double>::infinity();
inline constexpr FitMethod all_methods[] = {FitMethod::gauss_newton, FitMethod::gradient, FitMethod::cma_es,
                                            FitMethod::annealing};

inline Fit fit_of(const CalibrationProblem& problem, const FitOptions& options, SampleFarm* farm = nullptr,
                  const FitListener& listener = {}) {
  Context context;
  auto fit = calibrate(problem, options, context, farm, listener);
  EXPECT_TRUE(fit) << (fit ? "" : fit.error().message());
  return fit ? *fit : Fit{};
}

inline FitOptions options_of(FitMethod method, int budget = 2000) {
  FitOptions options;
  options.method = method;
  options.coarse_samples = 20;
  options.budget = budget;
  return options;
}

// Springs of 2, 0.5 and 8 N/mm to be found from under two loads, and a third that is only measured.
struct Chain {
  std::vector<double> truth{2, 0.5, 8};
  FormulaModel model{3, 3, [](std::span<const double> k, std::size_t load) { return spring_chain(k, load); }};
  CalibrationProblem problem;

  Chain() {
    problem.model = &model;
    problem.parameters.assign(3, logarithmic(0.05, 50, 1));
    for (std::size_t load = 0; load < 3; ++load)
      problem.loads.push_back({"pull", spring_chain(truth, load).response, {}, load < 2, {}});
  }
};

struct Valley {
  FormulaModel model{2, 1, [](std::span<const double> p, std::size_t) { return rosenbrock(p); }};
  CalibrationProblem problem{
      &model, {linear(-2, 2, -0.2), linear(-1, 3, -0.2)}, {{"", {{{0, 0, 0}}, {}}, {}}}};
};

}  // namespace turgor::testing_models
