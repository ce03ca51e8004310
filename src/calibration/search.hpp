// What every method of calibration shares: the problem, the evaluation of samples, and the record of them.
#pragma once

#include <limits>
#include <optional>

#include "calibration/search_space.hpp"
#include "turgor/calibration/calibrate.hpp"

namespace turgor {

constexpr double failed_error = std::numeric_limits<double>::infinity();

/// Whether an error of the model means that these parameters failed, not the work as a whole.
bool is_failed_sample(const Error& error);

class Search {
 public:
  Search(const CalibrationProblem& problem, const FitOptions& options, Context& context, SampleFarm& farm,
         const FitListener& listener);

  [[nodiscard]] const CalibrationProblem& problem() const { return problem_; }
  [[nodiscard]] const FitOptions& options() const { return options_; }
  [[nodiscard]] const SearchSpace& space() const { return space_; }
  /// For the model's runs: cancelled with the caller's, otherwise silent.
  [[nodiscard]] Context& quiet() const { return quiet_; }
  /// The best so far stands, and the user is told why it was not sought further. Cancelled stays an error.
  Result<void> end_early(const Error& reason);

  /// Counts a sample that is known; the least objective is kept.
  void record(FitSample::Stage stage, const Eigen::VectorXd& unit, double error);
  /// By the farm, all at once, and recorded in their order. Errors: cancelled, after what is known is
  /// recorded.
  Result<std::vector<double>> evaluate(FitSample::Stage stage, std::span<const Eigen::VectorXd> units);
  /// The same without recording.
  Result<std::vector<double>> farm_errors(std::span<const Eigen::VectorXd> units);
  [[nodiscard]] int farm_width() const { return farm_.width(); }

  /// Samples that the search may still take.
  [[nodiscard]] int left() const { return options_.budget - searched_; }
  /// The penalty of distance from the guess, and its derivative by `unit`.
  [[nodiscard]] double penalty(const Eigen::VectorXd& unit) const;
  [[nodiscard]] Eigen::VectorXd penalty_gradient(const Eigen::VectorXd& unit) const;
  [[nodiscard]] Eigen::VectorXd penalty_curvature() const;

  [[nodiscard]] const Eigen::VectorXd& guess() const { return guess_; }
  [[nodiscard]] bool has_best() const { return best_objective_ < failed_error; }
  [[nodiscard]] const Eigen::VectorXd& best() const { return best_; }
  [[nodiscard]] double best_error() const { return best_error_; }
  /// Those known that came to rest, least error first.
  struct Start {
    double error;
    Eigen::VectorXd unit;
  };
  [[nodiscard]] std::vector<Start> starts() const;

  [[nodiscard]] const std::vector<FitSample>& samples() const { return samples_; }

 private:
  const CalibrationProblem& problem_;
  const FitOptions& options_;
  Context& context_;
  mutable Context quiet_;
  SampleFarm& farm_;
  const FitListener& listener_;
  SearchSpace space_;
  Eigen::VectorXd guess_, best_;
  double regularisation_ = 0;
  double best_error_ = failed_error, best_objective_ = failed_error;
  std::vector<double> best_parameters_;
  std::vector<FitSample> samples_;
  std::vector<Start> starts_;  // before the search, and the first that came to rest in it
  int searched_ = 0;
};

/// The guess is known already; coarse samples over the bounds, and where none came to rest, random ones until
/// one does or the budget is spent.
Result<void> sample_coarsely(Search& search);

/// From the best known on. Errors: cancelled; the model's.
Result<void> search_by_gauss_newton(Search& search);
Result<void> search_by_gradient(Search& search);
Result<void> search_by_cma_es(Search& search);
Result<void> search_by_annealing(Search& search);

}  // namespace turgor
