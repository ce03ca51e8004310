// Tetrahedra fitted to the elasticity of the cubes that they fill (Morris 2006, sections 3.4 to 3.6): the
// problems of examples/calibration, each by several methods. Errors are in percent of the reference's root
// mean square displacement, and in metres: of the fitted loads before and after, and of those held out.
#include <benchmark/benchmark.h>

#include <array>
#include <filesystem>
#include <optional>
#include <string>

#include "turgor/calibration/calibrate.hpp"
#include "turgor/commands/problem.hpp"

namespace {

using namespace turgor;

/// From where benchmarks are run or where the sources lie.
Result<CalibrationOptions> example(const std::string& name, Context& context) {
  std::filesystem::path folder = "examples/calibration";
  if (!std::filesystem::exists(folder)) folder = "../../examples/calibration";
  TURGOR_TRY(const Problem problem, read_problem(folder / name));
  return calibration_options(problem, context);
}

/// Of the loads that were fitted, or of those that were not, means.
struct Errors {
  double before_m = 0, after_m = 0, reference_m = 0;
};

Errors errors_of(const CalibrationCase& problem, const Fit& fit, bool held_out) {
  Errors out;
  double count = 0;
  for (std::size_t l = 0; l < fit.loads.size(); ++l) {
    if (problem.loads()[l].held_out != held_out) continue;
    out.before_m += 1e-3 * fit.loads[l].before, out.after_m += 1e-3 * fit.loads[l].after;
    out.reference_m += 1e-3 * fit.loads[l].reference, ++count;
  }
  for (double* const value : {&out.before_m, &out.after_m, &out.reference_m}) *value /= count;
  return out;
}

void count(benchmark::State& state, const std::string& which, const Errors& errors) {
  state.counters[which + "_before_percent"] = 100 * errors.before_m / errors.reference_m;
  state.counters[which + "_after_percent"] = 100 * errors.after_m / errors.reference_m;
  state.counters[which + "_before_m"] = errors.before_m;
  state.counters[which + "_after_m"] = errors.after_m;
}

void report(benchmark::State& state, const CalibrationCase& problem, const Fit& fit) {
  count(state, "fitted", errors_of(problem, fit, false));
  count(state, "other", errors_of(problem, fit, true));
  state.counters["parameters"] = static_cast<double>(fit.parameters.size());
  state.counters["samples"] = static_cast<double>(fit.samples.size());
  state.counters["failed"] = fit.failed;
  if (const auto found = modulus_correlation(problem, problem.stiffness(fit.parameters)))
    state.counters["correlation"] = *found;
  state.SetLabel(std::to_string(problem.mesh().points.size()) + " points, " +
                 std::string(name_of(problem.options().fit.method)));
}

void run(benchmark::State& state, Result<CalibrationOptions> options) {
  Context context;
  auto problem = options ? CalibrationCase::prepare(*std::move(options), context)
                         : Result<CalibrationCase>(options.error());
  if (!problem) {
    state.SkipWithError(problem.error().message().c_str());
    return;
  }
  for (auto _ : state) {
    const auto fit = calibrate(problem->problem(), problem->options().fit, context);
    if (!fit) {
      state.SkipWithError(fit.error().message().c_str());
      return;
    }
    report(state, *problem, *fit);
  }
}

/// As the example has it.
void BM_Example(benchmark::State& state, const std::string& name) {
  Context context;
  run(state, example(name, context));
}

void once(benchmark::internal::Benchmark* b) {
  b->Unit(benchmark::kSecond)->Iterations(1)->UseRealTime()->MeasureProcessCPUTime();
}
BENCHMARK_CAPTURE(BM_Example, gear, "gear.problem")->Apply(once);
BENCHMARK_CAPTURE(BM_Example, gear_grid, "gear_grid.problem")->Apply(once);
BENCHMARK_CAPTURE(BM_Example, cube, "cube.problem")->Apply(once);
BENCHMARK_CAPTURE(BM_Example, bar, "bar.problem")->Apply(once);

/// The homogeneous gear: method, samples after the guess, the first hundred of them coarse where it samples.
void BM_GearBy(benchmark::State& state) {
  Context context;
  auto options = example("gear.problem", context);
  if (options) {
    FitOptions& fit = options->fit;
    fit.method = static_cast<FitMethod>(state.range(0));
    const bool derivatives = fit.method == FitMethod::gauss_newton || fit.method == FitMethod::gradient;
    fit.coarse_samples = derivatives ? 0 : 100;
    if (!derivatives) options->model.relative_residual = 1e-5;  // errors of a thousandth are compared
    fit.budget = static_cast<int>(state.range(1)) - fit.coarse_samples;
  }
  run(state, std::move(options));
}
BENCHMARK(BM_GearBy)
    ->ArgNames({"method", "samples"})
    ->Args({0, 60})
    ->Args({1, 100})
    ->Args({2, 500})
    ->Args({3, 2000})
    ->Apply(once);

/// The same under other laws of the reference: what small displacements leave out.
void BM_GearUnder(benchmark::State& state) {
  Context context;
  auto options = example("gear.problem", context);
  if (options) {
    for (ReferenceRegion& region : options->reference)
      region.material.law = kElasticLaws[static_cast<std::size_t>(state.range(0))];
  }
  run(state, std::move(options));
}
BENCHMARK(BM_GearUnder)->ArgName("law")->DenseRange(0, 3)->Apply(once);

/// Figure 12: each load by itself, homogeneous and on the grid, with nothing that holds the constants.
void BM_GearOfFigure12(benchmark::State& state) {
  Context context;
  auto options = example("gear_grid.problem", context);
  if (options) {
    const auto fitted = static_cast<std::size_t>(state.range(1));
    for (std::size_t l = 0; l < options->loads.size(); ++l) options->loads[l].held_out = l != fitted;
    if (state.range(0) == 0) options->model.grid = {1, 1, 1}, options->model.proportional = false;
    options->probes = {};
    options->fit.regularisation = 1e-3;
  }
  run(state, std::move(options));
}
BENCHMARK(BM_GearOfFigure12)->ArgNames({"grid", "load"})->ArgsProduct({{0, 1}, {0, 1}})->Apply(once);

/// One run of the gear from rest on the grid, then its derivatives (0: the run, 1: and the Jacobian, 2: and
/// the adjoint).
void BM_GearRun(benchmark::State& state) {
  Context context;
  auto options = example("gear_grid.problem", context);
  auto problem = options ? CalibrationCase::prepare(*std::move(options), context)
                         : Result<CalibrationCase>(options.error());
  if (!problem) {
    state.SkipWithError(problem.error().message().c_str());
    return;
  }
  const std::vector<double> guess = problem->guess();
  for (auto _ : state) {
    const auto rest = problem->problem().model->run(guess, 0, nullptr, context);
    if (!rest) {
      state.SkipWithError(rest.error().message().c_str());
      return;
    }
    if (state.range(0) == 1) benchmark::DoNotOptimize((*rest)->jacobian(context));
    if (state.range(0) == 2)
      benchmark::DoNotOptimize(
          (*rest)->adjoint(std::vector<double>((*rest)->response().rows(), 1.0), context));
  }
}
BENCHMARK(BM_GearRun)->ArgName("derivatives")->DenseRange(0, 2)->Unit(benchmark::kMillisecond)->UseRealTime();

}  // namespace
