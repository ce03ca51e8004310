// Fitting the parameters of a model to reference responses (Morris 2006, sections 3.2 to 3.5).
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "turgor/calibration/forward_model.hpp"
#include "turgor/core/context.hpp"

namespace turgor {

/// Root mean squares over the points of a load, averaged over loads (the paper's formula divides by nothing,
/// its text takes the mean).
enum class ErrorMeasure : std::uint8_t {
  distance,  ///< of places: the paper's, mm
  shape,     ///< of places after the rigid motion that brings them nearest: blind to rigid motion (5.2), mm
  force,     ///< of measured forces, N
};
std::string_view name_of(ErrorMeasure measure);

struct ReferenceLoad {
  std::string name;
  Response reference;
  std::vector<double> weight;  ///< of each point, ≥ 0; empty: 1
  bool fitted = true;          ///< false: only measured, to see how the parameters carry over
  std::vector<Vec3> rest_mm =
      {};  ///< the points without the load, to know the size of its effect; may be empty
};

/// Error of one response against the reference; infinite where the response is not finite. Errors: of other
/// lengths; nothing to measure; weights that are negative, not finite, or all 0. Forces are not weighted.
Result<double> response_error(const ReferenceLoad& load, const Response& response, ErrorMeasure measure);

enum class FitMethod : std::uint8_t {
  gauss_newton,  ///< damped (Levenberg and Marquardt) with exact derivatives, within the bounds
  gradient,      ///< L-BFGS within the bounds on the gradient by the adjoint
  cma_es,        ///< covariance matrix adaptation (Hansen), a generation in parallel
  annealing,     ///< simulated annealing with adaptive neighbourhoods (Corana et al. 1987; pagmo's)
};
std::string_view name_of(FitMethod method);

struct FitOptions {
  FitMethod method = FitMethod::gauss_newton;
  ErrorMeasure measure = ErrorMeasure::distance;
  int coarse_samples = 100;  ///< ≥ 0, spread over the bounds to find a stable start; the guess is one more
  int budget =
      2000;  ///< samples of the search after these, ≥ 1; of gauss_newton: its iterations count one each
  int chains = 4;  ///< of annealing, in parallel, ≥ 1; shares the budget
  std::uint64_t seed = 1;
  double regularisation =
      0;  ///< of gauss_newton and gradient: weight of the squared logarithmic distance to the guess
};

/// One evaluation, in the order of the search (not of the clock).
struct FitSample {
  double error = 0;  ///< infinite: failed, the body did not come to rest
  double best = 0;   ///< least so far
  enum class Stage : std::uint8_t { guess, coarse, search } stage = Stage::search;
};

struct LoadFit {
  double before = 0, after = 0;  ///< with the guess and with the result; infinite: failed
  double reference = 0;          ///< of the body without the load: the size of its effect; 0: unknown
};

struct Fit {
  std::vector<double> parameters;  ///< the best found
  double error = 0;                ///< theirs, over the fitted loads
  double guess_error = 0;
  std::vector<LoadFit> loads;  ///< of all loads, fitted or not
  std::vector<FitSample> samples;
  int failed = 0;
  bool stopped = false;  ///< by the user; the best so far is kept
  /// Standard deviation of each parameter's logarithm (or of the parameter where not logarithmic), by the
  /// linearised fit with the residual as noise; empty where the model gives no derivatives.
  std::vector<double> deviation;
  double seconds = 0;
};

struct CalibrationProblem {
  const ForwardModel* model = nullptr;
  std::vector<FitParameter> parameters;
  std::vector<ReferenceLoad> loads;  ///< in the order of the model's
};

/// The error of a set of parameters over the fitted loads, one load after another, each from rest. Infinite:
/// the body does not come to rest, or the model cannot use these. Errors: cancelled; a fault of the system.
using SampleError = std::function<Result<double>(std::span<const double> parameters, Context& context)>;
/// `problem.model` must outlive it.
SampleError make_sample_error(const CalibrationProblem& problem, ErrorMeasure measure);

/// Where samples are evaluated: threads of this process, or processes under MPI.
class SampleFarm {
 public:
  virtual ~SampleFarm() = default;
  /// Samples worked on at once.
  [[nodiscard]] virtual int width() const = 0;
  /// Error of each set of parameters, infinite where it failed, in the same order whoever worked on them; not
  /// a number where the context was cancelled before it was known. Errors: of a sample, other than cancelled.
  virtual Result<std::vector<double>> errors(std::span<const std::vector<double>> parameters,
                                             Context& context) = 0;
};
/// One sample a thread.
std::unique_ptr<SampleFarm> make_thread_farm(SampleError sample_error);

/// Told after every sample or iteration, from one thread at a time.
using FitListener = std::function<void(const FitSample& sample, std::span<const double> best)>;

/// Coarse samples, the search, and what is known of its result. The same bits on any number of threads and
/// processes. Cancelled by the context: not an error, the best so far comes back with `stopped`. Errors: a
/// problem or option that cannot be used; no set of parameters at which the body comes to rest; cancelled
/// before there was one. `farm`: of the same problem and measure; null: threads.
Result<Fit> calibrate(const CalibrationProblem& problem, const FitOptions& options, Context& context,
                      SampleFarm* farm = nullptr, const FitListener& listener = {});

}  // namespace turgor
