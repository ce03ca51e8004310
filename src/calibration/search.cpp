#include "calibration/search.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace turgor {
namespace {

std::vector<double> guesses(std::span<const FitParameter> parameters) {
  std::vector<double> out;
  for (const FitParameter& p : parameters) out.push_back(p.guess);
  return out;
}

bool differentiates(FitMethod method) {
  return method == FitMethod::gauss_newton || method == FitMethod::gradient;
}

}  // namespace

bool is_failed_sample(const Error& error) {
  return error.kind == ErrorKind::not_converged || error.kind == ErrorKind::bad_input;
}

Search::Search(const CalibrationProblem& problem, const FitOptions& options, Context& context,
               SampleFarm& farm, const FitListener& listener)
    : problem_(problem),
      options_(options),
      context_(context),
      quiet_({}, {}, [&context] { return context.cancelled(); }),
      farm_(farm),
      listener_(listener),
      space_(problem.parameters),
      guess_(space_.unit(guesses(problem.parameters))),
      regularisation_(differentiates(options.method) ? options.regularisation : 0) {}

void Search::record(FitSample::Stage stage, const Eigen::VectorXd& unit, double error) {
  const double objective = error + penalty(unit);
  if (objective < best_objective_) {
    best_ = unit;
    best_error_ = error;
    best_objective_ = objective;
    best_parameters_ = space_.parameters(unit);
  }
  samples_.push_back({error, best_error_, stage});
  if (stage == FitSample::Stage::search) {
    ++searched_;
    context_.progress(static_cast<double>(searched_) / options_.budget);
  } else if (stage == FitSample::Stage::coarse) {
    context_.progress(static_cast<double>(samples_.size() - 1) / options_.coarse_samples);
  }
  if (std::isfinite(error) && (stage != FitSample::Stage::search || starts_.empty()))
    starts_.push_back({error, unit});
  if (listener_) listener_(samples_.back(), best_parameters_);
}

Result<std::vector<double>> Search::farm_errors(std::span<const Eigen::VectorXd> units) {
  std::vector<std::vector<double>> parameters;
  parameters.reserve(units.size());
  for (const Eigen::VectorXd& unit : units) parameters.push_back(space_.parameters(unit));
  TURGOR_TRY(std::vector<double> errors, farm_.errors(parameters, quiet_));
  if (errors.size() != units.size())
    return Error{ErrorKind::internal, "samples came back in another number than they were sent"};
  return errors;
}

Result<std::vector<double>> Search::evaluate(FitSample::Stage stage, std::span<const Eigen::VectorXd> units) {
  TURGOR_TRY(std::vector<double> errors, farm_errors(units));
  bool unknown = false;
  for (std::size_t i = 0; i < units.size(); ++i) {
    if (std::isnan(errors[i])) {
      unknown = true;
    } else {
      record(stage, units[i], errors[i]);
    }
  }
  if (unknown) return Error{ErrorKind::cancelled, "stopped on request"};
  TURGOR_CHECK(context_.check());
  return errors;
}

Result<void> Search::end_early(const Error& reason) {
  if (reason.kind != ErrorKind::not_converged) return reason;
  context_.warning("the search ended early: " + reason.message());
  return {};
}

double Search::penalty(const Eigen::VectorXd& unit) const {
  if (regularisation_ == 0) return 0;
  return regularisation_ * (unit - guess_).cwiseProduct(space_.range()).squaredNorm();
}

Eigen::VectorXd Search::penalty_gradient(const Eigen::VectorXd& unit) const {
  return penalty_curvature().cwiseProduct(unit - guess_);
}

Eigen::VectorXd Search::penalty_curvature() const {
  return 2 * regularisation_ * space_.range().cwiseAbs2();
}

std::vector<Search::Start> Search::starts() const {
  std::vector<Start> sorted = starts_;
  std::stable_sort(sorted.begin(), sorted.end(),
                   [](const Start& a, const Start& b) { return a.error < b.error; });
  return sorted;
}

}  // namespace turgor
