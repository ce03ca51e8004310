// Least squares by Levenberg (1944) within bounds, damped by Nielsen's rule (1999).
//
// The error is a mean of norms, Σ |r_l| / n, where least squares would sum |r_l|². With ω_l = 1 / (n |r_l|)
// of the present point, ½ Σ ω_l |r_l|² has the error's gradient there and, but for a constant, is never below
// it (√ is concave): iteratively reweighted least squares. Trial steps are judged by the error itself.
#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <optional>

#include "calibration/fit_point.hpp"
#include "turgor/core/parallel.hpp"

namespace turgor {
namespace {

struct Quadratic {
  Eigen::MatrixXd hessian;  // of Gauss and Newton
  Eigen::VectorXd gradient;
};

Result<Quadratic> quadratic_at(const Search& search, const FitPoint& point) {
  const Eigen::Index size = search.space().size();
  const auto loads = static_cast<double>(point.loads.size());
  // A load that is met exactly would else outweigh all others.
  const double floor = 1e-3 * *std::max_element(point.errors.begin(), point.errors.end());
  std::vector<std::optional<Quadratic>> parts(point.loads.size());
  std::vector<std::optional<Error>> faults(point.loads.size());
  parallel_for(parts.size(), 1, [&](std::size_t i, std::size_t) {
    const auto jacobian = point.jacobian(search, i);
    if (!jacobian) {
      faults[i] = jacobian.error();
      return;
    }
    const double weight = 1 / (loads * std::max(point.errors[i], floor));
    parts[i] = Quadratic{weight * (jacobian->transpose() * *jacobian),
                         weight * (jacobian->transpose() * point.misfits[i].residual)};
  });
  Quadratic out{search.penalty_curvature().asDiagonal(), search.penalty_gradient(point.unit)};
  for (std::size_t i = 0; i < parts.size(); ++i) {
    if (faults[i]) return *faults[i];
    out.hessian += parts[i]->hessian;
    out.gradient += parts[i]->gradient;
  }
  if (!out.hessian.allFinite() || out.gradient.size() != size)
    return Error{ErrorKind::not_converged, "derivatives that are not finite"};
  return out;
}

// The least of the damped quadratic within the bounds: variables that would leave them are put there, one
// solution after another. Those at a bound that the gradient points out of stay.
Eigen::VectorXd bounded_step(const Quadratic& model, double damping, const Eigen::VectorXd& unit) {
  const Eigen::Index size = unit.size();
  Eigen::VectorXd step = Eigen::VectorXd::Zero(size);
  std::vector<Eigen::Index> free;
  for (Eigen::Index i = 0; i < size; ++i) {
    const bool held = (unit[i] <= 0 && model.gradient[i] >= 0) || (unit[i] >= 1 && model.gradient[i] <= 0);
    if (!held) free.push_back(i);
  }
  while (!free.empty()) {
    for (const Eigen::Index i : free) step[i] = 0;
    Eigen::MatrixXd matrix = model.hessian(free, free);
    matrix.diagonal().array() += damping;
    const Eigen::VectorXd right = -(model.gradient + model.hessian * step)(free);
    const Eigen::VectorXd solution = matrix.ldlt().solve(right);
    std::vector<Eigen::Index> inside;
    for (std::size_t k = 0; k < free.size(); ++k) {
      const Eigen::Index i = free[k];
      const double end = unit[i] + solution[static_cast<Eigen::Index>(k)];
      step[i] = std::clamp(end, 0.0, 1.0) - unit[i];
      if (end >= 0 && end <= 1) inside.push_back(i);
    }
    if (inside.size() == free.size()) break;
    free = std::move(inside);
  }
  return step;
}

// Of all variables alike: on 0 to 1 between their bounds they have a common measure, and those that the loads
// hardly tell apart, of which a fine grid has many, are held back with the others. Scaled by the curvature of
// each (Marquardt) they would run to their bounds.
class Damping {
 public:
  [[nodiscard]] double of(const Eigen::MatrixXd& hessian) {
    scale_ = std::max(scale_, hessian.diagonal().maxCoeff());
    return factor_ * scale_;
  }
  void accepted(double gain) {
    factor_ *= std::max(1.0 / 3, 1 - std::pow(2 * std::min(gain, 1.0) - 1, 3));
    factor_ = std::max(factor_, 1e-15);
    growth_ = 2;
  }
  void rejected() {
    factor_ *= growth_;
    growth_ *= 2;
  }
  [[nodiscard]] bool hopeless() const { return factor_ > 1e15; }

 private:
  double factor_ = 1e-3, growth_ = 2, scale_ = 0;
};

// Whether the last steps were worth their samples.
class Progress {
 public:
  // Takes the objective after each step, the first before them.
  [[nodiscard]] bool made(double objective) {
    objectives_.push_back(objective);
    const std::size_t count = objectives_.size();
    return count <= steps || objective < (1 - least) * objectives_[count - 1 - steps];
  }

 private:
  static constexpr std::size_t steps = 3;
  static constexpr double least = 1e-3;
  std::vector<double> objectives_;
};

double objective_of(const Search& search, const FitPoint& point) {
  return point.error + search.penalty(point.unit);
}

// From `point` to the next that is better; nothing where there is none.
Result<std::optional<FitPoint>> improve(Search& search, const FitPoint& point, const Quadratic& model,
                                        Damping& damping) {
  const double objective = objective_of(search, point);
  while (search.left() > 0 && !damping.hopeless()) {
    const Eigen::VectorXd step = bounded_step(model, damping.of(model.hessian), point.unit);
    const double expected = -step.dot(model.gradient + 0.5 * (model.hessian * step));
    // Gone as far as numbers tell.
    if (std::abs(expected) <= 1e-13 * objective || step.cwiseAbs().maxCoeff() < 1e-12)
      return std::optional<FitPoint>{};
    // Variables put at their bounds can turn a long step uphill, never a short one.
    if (!(expected > 0)) {
      damping.rejected();
      continue;
    }
    const Eigen::VectorXd unit = (point.unit + step).cwiseMax(0.0).cwiseMin(1.0);
    TURGOR_TRY(FitPoint trial, rest_at(search, unit, point.loads, &point, search.quiet()));
    search.record(FitSample::Stage::search, unit, trial.error);
    const double gain = (objective - objective_of(search, trial)) / expected;
    if (gain > 1e-4) {
      damping.accepted(gain);
      return std::optional<FitPoint>(std::move(trial));
    }
    damping.rejected();
  }
  return std::optional<FitPoint>{};
}

}  // namespace

Result<void> search_by_gauss_newton(Search& search) {
  TURGOR_TRY(FitPoint point,
             rest_at(search, search.best(), fitted_loads(search.problem()), nullptr, search.quiet()));
  Damping damping;
  Progress progress;
  for (bool first = true; search.left() > 0 && std::isfinite(point.error) && point.error > 0; first = false) {
    if (!progress.made(objective_of(search, point))) break;
    TURGOR_CHECK(search.quiet().check());
    const auto model = quadratic_at(search, point);
    if (!model) return first ? model.error() : search.end_early(model.error());
    TURGOR_TRY(auto next, improve(search, point, *model, damping));
    if (!next) break;
    point = *std::move(next);
  }
  return {};
}

}  // namespace turgor
