// From a scan to a head and its landmarks, on the real scan of the Debian package invesalius-examples where
// it is installed; flesh over a grid of 100 000 columns. The argument is the number of threads; the counters
// give the seconds of each stage.
#include <benchmark/benchmark.h>

#include <cstdlib>
#include <filesystem>
#include <optional>

#include "../tests/support/grid_surface.hpp"
#include "turgor/anatomy/flesh.hpp"
#include "turgor/anatomy/head.hpp"
#include "turgor/core/parallel.hpp"

namespace turgor {
namespace {

const Scan* real_scan() {
  static const std::optional<Scan> scan = []() -> std::optional<Scan> {
    const char* given = std::getenv("TURGOR_EXAMPLE_SCAN");
    const std::filesystem::path path =
        given ? given : "/usr/share/doc/invesalius-examples/examples/Cranium.inv3";
    if (!std::filesystem::exists(path)) return std::nullopt;
    Context context;
    auto read = read_scan(path, {}, context);
    if (!read) return std::nullopt;
    return *std::move(read);
  }();
  return scan ? &*scan : nullptr;
}

void BuildHead(benchmark::State& state) {
  const Scan* scan = real_scan();
  if (scan == nullptr) return state.SkipWithError("the package invesalius-examples is not installed");
  set_thread_count(static_cast<int>(state.range(0)));
  std::map<std::string, double> seconds;
  for (auto _ : state) {
    Context context;
    auto head = build_head(*scan, {}, context);
    if (!head) return state.SkipWithError(head.error().what.c_str());
    benchmark::DoNotOptimize(head->skin.points.data());
    for (const StageTime& time : context.stage_times()) seconds[time.stage] += time.seconds;
  }
  for (const auto& [stage, sum] : seconds) {
    state.counters[stage] = benchmark::Counter(sum, benchmark::Counter::kAvgIterations);
  }
  set_thread_count(0);
}
BENCHMARK(BuildHead)->Arg(1)->Arg(2)->Unit(benchmark::kMillisecond)->UseRealTime();

void FindLandmarks(benchmark::State& state) {
  const Scan* scan = real_scan();
  if (scan == nullptr) return state.SkipWithError("the package invesalius-examples is not installed");
  set_thread_count(static_cast<int>(state.range(0)));
  Context context;
  const auto head = build_head(*scan, {}, context);
  if (!head) return state.SkipWithError(head.error().what.c_str());
  for (auto _ : state) benchmark::DoNotOptimize(find_landmarks(*head, context));
  set_thread_count(0);
}
BENCHMARK(FindLandmarks)->Arg(1)->Arg(2)->Unit(benchmark::kMillisecond)->UseRealTime();

void FleshNetworkOfAGrid(benchmark::State& state) {
  set_thread_count(static_cast<int>(state.range(0)));
  FleshOptions options;
  if (state.range(1) != 0) options.volume_modulus_mpa = 0.1;
  const auto flesh = flesh_out(support::make_grid(400, 250), options);
  for (auto _ : state) {
    auto network = make_network(*flesh);
    benchmark::DoNotOptimize(network);
    state.counters["springs"] = static_cast<double>(network->network.springs.size());
  }
  set_thread_count(0);
}
BENCHMARK(FleshNetworkOfAGrid)
    ->ArgNames({"threads", "volumes"})
    ->ArgsProduct({{1, 2}, {0, 1}})
    ->Unit(benchmark::kMillisecond)
    ->UseRealTime();

// A tenth of 200 000 triangles is split and joined again.
void AdaptFlesh(benchmark::State& state) {
  set_thread_count(static_cast<int>(state.range(0)));
  AdaptiveFlesh adaptive(*flesh_out(support::make_grid(400, 250), {}));
  for (auto _ : state) {
    std::vector<double> measure(adaptive.flesh().surface.ends.size(), 0);
    std::fill_n(measure.begin(), 20'000, 1.0);
    benchmark::DoNotOptimize(adaptive.adapt(measure, {}));
    measure.assign(adaptive.flesh().surface.ends.size(), 0);
    benchmark::DoNotOptimize(adaptive.adapt(measure, {}));
  }
  set_thread_count(0);
}
BENCHMARK(AdaptFlesh)->Arg(1)->Arg(2)->Unit(benchmark::kMillisecond)->UseRealTime();

}  // namespace
}  // namespace turgor
