#include <cmath>
#include <limits>
#include <optional>

#include "calibration/search.hpp"
#include "turgor/core/parallel.hpp"

namespace turgor {
namespace {

Result<double> error_over_loads(const CalibrationProblem& problem, ErrorMeasure measure,
                                std::span<const double> parameters, Context& context) {
  double sum = 0;
  int fitted = 0;
  for (std::size_t load = 0; load < problem.loads.size(); ++load) {
    if (!problem.loads[load].fitted) continue;
    const auto run = problem.model->run(parameters, load, nullptr, context);
    if (!run) {
      if (is_failed_sample(run.error())) return failed_error;
      return run.error();
    }
    TURGOR_TRY(const double error, response_error(problem.loads[load], (*run)->response(), measure));
    sum += error;
    ++fitted;
  }
  return sum / fitted;
}

class ThreadFarm : public SampleFarm {
 public:
  explicit ThreadFarm(SampleError sample_error) : sample_error_(std::move(sample_error)) {}

  [[nodiscard]] int width() const override { return thread_count(); }

  Result<std::vector<double>> errors(std::span<const std::vector<double>> parameters,
                                     Context& context) override {
    std::vector<double> out(parameters.size(), std::numeric_limits<double>::quiet_NaN());
    std::vector<std::optional<Error>> faults(parameters.size());
    parallel_for(parameters.size(), 1, [&](std::size_t i, std::size_t) {
      if (context.cancelled()) return;
      const auto error = sample_error_(parameters[i], context);
      if (error) {
        out[i] = std::isnan(*error) ? failed_error : *error;
      } else if (error.error().kind != ErrorKind::cancelled) {
        faults[i] = error.error();
      }
    });
    for (const auto& fault : faults) {
      if (fault) return *fault;
    }
    return out;
  }

 private:
  SampleError sample_error_;
};

}  // namespace

SampleError make_sample_error(const CalibrationProblem& problem, ErrorMeasure measure) {
  return [problem, measure](std::span<const double> parameters, Context& context) {
    return error_over_loads(problem, measure, parameters, context);
  };
}

std::unique_ptr<SampleFarm> make_thread_farm(SampleError sample_error) {
  return std::make_unique<ThreadFarm>(std::move(sample_error));
}

}  // namespace turgor
