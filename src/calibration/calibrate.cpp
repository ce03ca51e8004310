#include "turgor/calibration/calibrate.hpp"

#include <fmt/format.h>

#include <chrono>
#include <cmath>

#include "calibration/deviation.hpp"
#include "calibration/fit_point.hpp"
#include "calibration/search.hpp"

namespace turgor {
namespace {

Error unusable(std::string what, std::string where = {}, std::string remedy = {}) {
  return {ErrorKind::bad_input, std::move(what), std::move(where), std::move(remedy)};
}

Result<void> check_parameter(const FitParameter& p) {
  if (!std::isfinite(p.low) || !std::isfinite(p.high) || !(p.low < p.high) || !std::isfinite(p.high - p.low))
    return unusable(fmt::format("bounds {} to {}", p.low, p.high), p.name, "The lower must be the smaller");
  if (p.logarithmic && !(p.low > 0))
    return unusable(fmt::format("a lower bound of {}", p.low), p.name,
                    "Searched by its logarithm it must be above 0");
  if (!(p.guess >= p.low && p.guess <= p.high))
    return unusable(fmt::format("a guess of {} outside its bounds {} to {}", p.guess, p.low, p.high), p.name,
                    "Widen the bounds, or guess within");
  return {};
}

Result<void> check_problem(const CalibrationProblem& problem) {
  if (problem.model == nullptr || problem.parameters.empty())
    return unusable("a calibration without a model or without parameters");
  if (problem.parameters.size() != problem.model->parameter_count() ||
      problem.loads.size() != problem.model->load_count())
    return unusable("a calibration with other numbers of parameters or loads than its model");
  if (fitted_loads(problem).empty()) return unusable("a calibration without a load to fit");
  for (const FitParameter& parameter : problem.parameters) TURGOR_CHECK(check_parameter(parameter));
  return {};
}

Result<void> check_options(const FitOptions& options, std::size_t parameters) {
  constexpr int most = 10'000'000;
  if (options.coarse_samples < 0 || options.coarse_samples > most / static_cast<double>(parameters))
    return unusable(fmt::format("{} coarse samples", options.coarse_samples), "",
                    fmt::format("Between 0 and {} in all parameters together", most));
  if (options.budget < 1 || options.budget > most)
    return unusable(fmt::format("a budget of {} samples", options.budget), "",
                    fmt::format("Between 1 and {}", most));
  if (options.chains < 1 || options.chains > 256)
    return unusable(fmt::format("{} chains of annealing", options.chains), "", "Between 1 and 256");
  if (!(options.regularisation >= 0) || !std::isfinite(options.regularisation))
    return unusable(fmt::format("a regularisation of {}", options.regularisation), "", "At least 0");
  return {};
}

std::vector<std::size_t> all_loads(const CalibrationProblem& problem) {
  std::vector<std::size_t> out(problem.loads.size());
  for (std::size_t i = 0; i < out.size(); ++i) out[i] = i;
  return out;
}

// As samples count it: failed where one of the fitted loads failed.
double fitted_error(const CalibrationProblem& problem, const FitPoint& point) {
  double sum = 0, count = 0;
  for (std::size_t load = 0; load < problem.loads.size(); ++load) {
    if (problem.loads[load].fitted) sum += point.errors[load], ++count;
  }
  return sum / count;
}

Result<double> effect_of(const ReferenceLoad& load, ErrorMeasure measure) {
  if (measure != ErrorMeasure::force && load.rest_mm.empty()) return 0.0;
  Response rest{load.rest_mm, std::vector<double>(load.reference.force_n.size(), 0.0)};
  if (measure == ErrorMeasure::force) rest.position_mm = load.reference.position_mm;
  return response_error(load, rest, measure);
}

Result<void> begin_at_guess(Search& search, Context& context, Fit& fit) {
  const Stage stage(context, "Guess");
  const CalibrationProblem& problem = search.problem();
  TURGOR_TRY(const FitPoint guess,
             rest_at(search, search.guess(), all_loads(problem), nullptr, search.quiet()));
  for (std::size_t load = 0; load < problem.loads.size(); ++load) {
    TURGOR_TRY(const double effect, effect_of(problem.loads[load], search.options().measure));
    fit.loads.push_back({guess.errors[load], failed_error, effect});
  }
  fit.guess_error = fitted_error(problem, guess);
  search.record(FitSample::Stage::guess, guess.unit, fit.guess_error);
  return {};
}

Result<void> search_from_best(Search& search, Context& context) {
  {
    const Stage stage(context, "Coarse samples");
    TURGOR_CHECK(sample_coarsely(search));
  }
  if (!search.has_best() || search.left() < 1) return {};
  const Stage stage(context, fmt::format("Calibrate by {}", name_of(search.options().method)));
  switch (search.options().method) {
    case FitMethod::gauss_newton:
      return search_by_gauss_newton(search);
    case FitMethod::gradient:
      return search_by_gradient(search);
    case FitMethod::cma_es:
      return search_by_cma_es(search);
    case FitMethod::annealing:
      break;
  }
  return search_by_annealing(search);
}

Error none_rests(const Search& search) {
  Error error{ErrorKind::not_converged,
              fmt::format("at none of {} sets of parameters the body comes to rest", search.samples().size()),
              "", "Change the bounds or the guess, or make the loads smaller"};
  for (const std::size_t load : fitted_loads(search.problem())) {
    const auto run =
        search.problem().model->run(search.space().parameters(search.guess()), load, nullptr, search.quiet());
    if (!run) {
      error.what += "; with the guess: " + run.error().message();
      break;
    }
  }
  return error;
}

// What the best is worth, each load from rest; after a stop too, and then without asking again.
Result<void> measure_best(const Search& search, Context& context, Fit& fit) {
  const Stage stage(context, "Result");
  Context unstoppable;
  const CalibrationProblem& problem = search.problem();
  TURGOR_TRY(const FitPoint best, rest_at(search, search.best(), all_loads(problem), nullptr, unstoppable));
  for (std::size_t load = 0; load < problem.loads.size(); ++load) fit.loads[load].after = best.errors[load];
  fit.parameters = best.parameters;
  const double error = fitted_error(problem, best);
  fit.error = std::isfinite(error) ? error : search.best_error();
  if (fit.stopped || !std::isfinite(error)) return {};
  auto deviation = deviation_at(search, best);
  fit.stopped = !deviation;
  if (deviation) fit.deviation = *std::move(deviation);
  return {};
}

}  // namespace

Result<Fit> calibrate(const CalibrationProblem& problem, const FitOptions& options, Context& context,
                      SampleFarm* farm, const FitListener& listener) {
  TURGOR_CHECK(check_problem(problem));
  TURGOR_CHECK(check_options(options, problem.parameters.size()));
  const auto start = std::chrono::steady_clock::now();
  const auto threads =
      farm == nullptr ? make_thread_farm(make_sample_error(problem, options.measure)) : nullptr;
  Search search(problem, options, context, farm == nullptr ? *threads : *farm, listener);
  Fit fit;
  TURGOR_CHECK(begin_at_guess(search, context, fit));
  const auto searched = search_from_best(search, context);
  if (!searched && (searched.error().kind != ErrorKind::cancelled || !search.has_best()))
    return searched.error();
  if (!search.has_best()) return none_rests(search);
  fit.stopped = !searched;
  TURGOR_CHECK(measure_best(search, context, fit));
  fit.samples = search.samples();
  for (const FitSample& sample : fit.samples) fit.failed += std::isinf(sample.error) ? 1 : 0;
  fit.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  return fit;
}

}  // namespace turgor
