// Limited-memory BFGS (Nocedal 1980) projected to the bounds, on the gradient by the adjoint: one linear
// system a load, however many parameters.
//
// What descends is half the square of the error, which has the same least point and no edge there.
#include <algorithm>
#include <cmath>
#include <deque>
#include <optional>

#include "calibration/fit_point.hpp"
#include "turgor/core/parallel.hpp"

namespace turgor {
namespace {

struct Slope {
  double value = 0;          // ½ (error + penalty)²
  Eigen::VectorXd gradient;  // by unit
};

double half_square(const Search& search, const FitPoint& point) {
  const double objective = point.error + search.penalty(point.unit);
  return 0.5 * objective * objective;
}

Result<Slope> slope_at(const Search& search, const FitPoint& point) {
  std::vector<std::optional<Error>> faults(point.loads.size());
  std::vector<Eigen::VectorXd> parts(point.loads.size());
  parallel_for(parts.size(), 1, [&](std::size_t i, std::size_t) {
    const ForwardRun& run = *point.runs[i];
    const auto adjoint = run.adjoint(point.misfits[i].error_gradient(run.response().rows()), search.quiet());
    if (!adjoint) {
      faults[i] = adjoint.error();
    } else if (adjoint->size() != point.parameters.size()) {
      faults[i] = Error{ErrorKind::internal, "a gradient of another length than the parameters"};
    } else {
      parts[i] = Eigen::VectorXd::Map(adjoint->data(), search.space().size());
    }
  });
  Eigen::VectorXd sum = Eigen::VectorXd::Zero(search.space().size());
  for (std::size_t i = 0; i < parts.size(); ++i) {
    if (faults[i]) return *faults[i];
    sum += parts[i];
  }
  sum = sum.cwiseProduct(search.space().slope(point.parameters)) / static_cast<double>(parts.size());
  sum += search.penalty_gradient(point.unit);
  if (!sum.allFinite()) return Error{ErrorKind::not_converged, "derivatives that are not finite"};
  const double value = half_square(search, point);
  return Slope{value, std::sqrt(2 * value) * sum};
}

// The inverse Hessian's product by the two loops over the last pairs.
class Curvature {
 public:
  void add(const Eigen::VectorXd& step, const Eigen::VectorXd& change) {
    if (step.dot(change) <= 1e-10 * step.norm() * change.norm()) return;
    pairs_.push_back({step, change});
    if (pairs_.size() > 10) pairs_.pop_front();
  }
  void forget() { pairs_.clear(); }
  [[nodiscard]] bool empty() const { return pairs_.empty(); }

  // `free`: 1 where the variable may move, else 0.
  [[nodiscard]] Eigen::VectorXd direction(const Eigen::VectorXd& gradient,
                                          const Eigen::VectorXd& free) const {
    Eigen::VectorXd d = -gradient.cwiseProduct(free);
    std::vector<double> along(pairs_.size(), 0.0);
    double scale = 0;
    for (std::size_t k = pairs_.size(); k-- > 0;) {
      const Eigen::VectorXd s = pairs_[k].step.cwiseProduct(free), y = pairs_[k].change.cwiseProduct(free);
      const double sy = s.dot(y);
      if (sy <= 0) continue;
      along[k] = s.dot(d) / sy;
      d -= along[k] * y;
      if (scale == 0) scale = sy / y.squaredNorm();
    }
    if (scale > 0) d *= scale;
    for (std::size_t k = 0; k < pairs_.size(); ++k) {
      const Eigen::VectorXd s = pairs_[k].step.cwiseProduct(free), y = pairs_[k].change.cwiseProduct(free);
      const double sy = s.dot(y);
      if (sy > 0) d += (along[k] - y.dot(d) / sy) * s;
    }
    return d.cwiseProduct(free);
  }

 private:
  struct Pair {
    Eigen::VectorXd step, change;
  };
  std::deque<Pair> pairs_;
};

Eigen::VectorXd free_variables(const Eigen::VectorXd& unit, const Eigen::VectorXd& gradient) {
  Eigen::VectorXd free = Eigen::VectorXd::Ones(unit.size());
  for (Eigen::Index i = 0; i < unit.size(); ++i) {
    if ((unit[i] <= 0 && gradient[i] >= 0) || (unit[i] >= 1 && gradient[i] <= 0)) free[i] = 0;
  }
  return free;
}

// Downhill, and no longer than a quarter of the bounds' width; a tenth while nothing is known of the
// curvature.
Eigen::VectorXd direction_at(const Curvature& curvature, const Eigen::VectorXd& unit, const Slope& slope) {
  const Eigen::VectorXd free = free_variables(unit, slope.gradient);
  Eigen::VectorXd d = curvature.direction(slope.gradient, free);
  if (!(d.dot(slope.gradient) < 0) || !d.allFinite()) d = -slope.gradient.cwiseProduct(free);
  const double longest = d.cwiseAbs().maxCoeff();
  if (!(longest > 0)) return Eigen::VectorXd::Zero(unit.size());
  return curvature.empty() ? Eigen::VectorXd(d * (0.1 / longest))
                           : Eigen::VectorXd(d * std::min(1.0, 0.25 / longest));
}

// Armijo's rule along the projected path; the next length from the parabola through what is known.
Result<std::optional<FitPoint>> search_line(Search& search, const FitPoint& point, const Slope& slope,
                                            const Eigen::VectorXd& direction) {
  double length = 1;
  while (search.left() > 0 && length * direction.cwiseAbs().maxCoeff() > 1e-10) {
    const Eigen::VectorXd unit = (point.unit + length * direction).cwiseMax(0.0).cwiseMin(1.0);
    const double descent = slope.gradient.dot(unit - point.unit);
    if (!(descent < 0)) break;
    TURGOR_TRY(FitPoint trial, rest_at(search, unit, point.loads, &point, search.quiet()));
    search.record(FitSample::Stage::search, unit, trial.error);
    const double value = half_square(search, trial);
    if (value <= slope.value + 1e-4 * descent) return std::optional<FitPoint>(std::move(trial));
    const double parabola = -descent / (2 * (value - slope.value - descent));
    length *= std::isfinite(value) ? std::clamp(parabola, 0.1, 0.5) : 0.25;
  }
  return std::optional<FitPoint>{};
}

}  // namespace

Result<void> search_by_gradient(Search& search) {
  TURGOR_TRY(FitPoint point,
             rest_at(search, search.best(), fitted_loads(search.problem()), nullptr, search.quiet()));
  if (!std::isfinite(point.error)) return {};
  TURGOR_TRY(Slope slope, slope_at(search, point));
  Curvature curvature;
  int still = 0;  // steps one after another that brought nothing
  while (search.left() > 0 && slope.value > 0 && still < 3) {
    TURGOR_CHECK(search.quiet().check());
    const Eigen::VectorXd direction = direction_at(curvature, point.unit, slope);
    TURGOR_TRY(auto next, search_line(search, point, slope, direction));
    if (!next) {
      if (curvature.empty()) break;
      curvature.forget();
      continue;
    }
    auto beyond = slope_at(search, *next);
    if (!beyond) return search.end_early(beyond.error());
    curvature.add(next->unit - point.unit, beyond->gradient - slope.gradient);
    still = slope.value - beyond->value < 1e-12 * slope.value ? still + 1 : 0;
    point = *std::move(next);
    slope = *std::move(beyond);
  }
  return {};
}

}  // namespace turgor
