// The body at rest under several loads with one set of parameters, kept for its derivatives.
#pragma once

#include "calibration/misfit.hpp"
#include "calibration/search.hpp"

namespace turgor {

struct FitPoint {
  Eigen::VectorXd unit;
  std::vector<double> parameters;
  std::vector<std::size_t> loads;
  std::vector<std::unique_ptr<ForwardRun>> runs;  ///< of each of the loads; null: failed
  std::vector<Misfit> misfits;
  std::vector<double> errors;  ///< of each of the loads, infinite: failed
  double error = 0;            ///< their mean

  /// ∂ residual / ∂ unit of one of the loads.
  [[nodiscard]] Result<Eigen::MatrixXd> jacobian(const Search& search, std::size_t index) const;
};

std::vector<std::size_t> fitted_loads(const CalibrationProblem& problem);

/// Loads in parallel. `near`: of the same loads, or null. Errors: cancelled; other than of a failed sample.
Result<FitPoint> rest_at(const Search& search, const Eigen::VectorXd& unit,
                         const std::vector<std::size_t>& loads, const FitPoint* near, Context& context);

}  // namespace turgor
