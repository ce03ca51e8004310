#include "calibration/fit_point.hpp"

#include <optional>

#include "turgor/core/parallel.hpp"

namespace turgor {

std::vector<std::size_t> fitted_loads(const CalibrationProblem& problem) {
  std::vector<std::size_t> out;
  for (std::size_t load = 0; load < problem.loads.size(); ++load) {
    if (problem.loads[load].fitted) out.push_back(load);
  }
  return out;
}

Result<Eigen::MatrixXd> FitPoint::jacobian(const Search& search, std::size_t index) const {
  TURGOR_TRY(const DenseMatrix response, runs[index]->jacobian(search.quiet()));
  if (response.rows != runs[index]->response().rows() || response.columns != parameters.size() ||
      response.values.size() != response.rows * response.columns)
    return Error{ErrorKind::internal, "derivatives of another size than response and parameters"};
  Eigen::MatrixXd out = misfits[index].jacobian(response);
  out = out * search.space().slope(parameters).asDiagonal();
  if (!out.allFinite()) return Error{ErrorKind::not_converged, "derivatives that are not finite"};
  return out;
}

Result<FitPoint> rest_at(const Search& search, const Eigen::VectorXd& unit,
                         const std::vector<std::size_t>& loads, const FitPoint* near, Context& context) {
  const CalibrationProblem& problem = search.problem();
  FitPoint point;
  point.unit = unit;
  point.parameters = search.space().parameters(unit);
  point.loads = loads;
  point.runs.resize(loads.size());
  point.misfits.resize(loads.size());
  point.errors.assign(loads.size(), failed_error);
  std::vector<std::optional<Error>> faults(loads.size());
  parallel_for(loads.size(), 1, [&](std::size_t i, std::size_t) {
    auto run = problem.model->run(point.parameters, loads[i], near != nullptr ? near->runs[i].get() : nullptr,
                                  context);
    if (!run) {
      if (!is_failed_sample(run.error())) faults[i] = run.error();
      return;
    }
    auto misfit = misfit_of(problem.loads[loads[i]], (*run)->response(), search.options().measure);
    if (!misfit) {
      faults[i] = misfit.error();
      return;
    }
    point.runs[i] = *std::move(run);
    point.misfits[i] = *std::move(misfit);
    point.errors[i] = point.misfits[i].error();
  });
  for (const auto& fault : faults) {
    if (fault) return *fault;
  }
  for (const double error : point.errors) point.error += error / static_cast<double>(loads.size());
  return point;
}

}  // namespace turgor
