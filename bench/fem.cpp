// Linear elasticity of the bunny's voxels: held below, under its weight, to a relative residual of 1e-6.
// The printed table is of runs in a process of their own, so that its peak memory is its own (less what the
// solid takes); the benchmarks after it are of the operator alone, beside a copy of the same memory.
#include <benchmark/benchmark.h>
#include <fmt/format.h>
#include <sys/wait.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <filesystem>

#include "fem/voxel_operator.hpp"
#include "inputs.hpp"
#include "turgor/core/parallel.hpp"
#include "turgor/fem/voxel_elasticity.hpp"
#include "turgor/geometry/mesh_file.hpp"
#include "turgor/geometry/voxel_solid.hpp"

namespace {

using namespace turgor;
namespace fs = std::filesystem;

struct Row {
  int resolution;
  double ratio;
  double goal_s;  // of the solution, and of the set-up; 0: none
};
constexpr Row kTable[] = {{30, 0.3, 0},    {30, 0.45, 0.06}, {30, 0.49, 0.24}, {50, 0.3, 0},
                          {50, 0.45, 0.2}, {50, 0.49, 0.8},  {75, 0.3, 0},     {75, 0.45, 0.6},
                          {75, 0.49, 2.4}, {168, 0.45, 8}};

struct Run {
  std::size_t cubes = 0;
  int iterations = 0;
  double set_up_s = 1e9, solve_s = 1e9, solid_mb = 0, peak_mb = 0;
};

SolidMesh bunny_solid(int resolution) {
  const auto surface = bench::bunny_surface();
  if (!surface) return {};
  VoxelOptions options;
  options.resolution = resolution;
  return bench::solid_in(*surface, options).value_or(SolidMesh{});
}

Run measure(const Row& row) {
  Run run;
  const SolidMesh solid = bunny_solid(row.resolution);
  run.cubes = solid.tetrahedra.size() / 5;
  run.solid_mb = bench::peak_mb();
  double lowest = 1e300;
  for (const Vec3& p : solid.points) lowest = std::min(lowest, p.y);
  std::vector<NodeSupport> supports;
  for (std::size_t p = 0; p < solid.points.size(); ++p) {
    if (solid.points[p].y < lowest + 0.5 * solid.spacing)
      supports.push_back({static_cast<int>(p), {true, true, true}, {}});
  }
  ElasticBody body;
  body.materials[0].poissons_ratio = row.ratio;
  ElasticLoad load;
  load.gravity_mm_ms2 = {0, -0.00981, 0};
  Context context;
  for (int repeat = 0; repeat < (run.cubes > 200000 ? 2 : 5); ++repeat) {
    auto start = std::chrono::steady_clock::now();
    const auto fem = VoxelElasticity::prepare(solid, body, supports, {}, context);
    run.set_up_s = std::min(run.set_up_s, bench::seconds_since(start));
    start = std::chrono::steady_clock::now();
    const auto solution = fem ? fem->solve(load, context) : Result<ElasticSolution>(fem.error());
    run.solve_s = std::min(run.solve_s, bench::seconds_since(start));
    if (!solution) {
      std::fprintf(stderr, "%s\n", solution.error().message().c_str());
      return run;
    }
    run.iterations = solution->iterations;
    if (repeat == 0) run.peak_mb = bench::peak_mb();
  }
  return run;
}

/// Runs `program --row N` and reads what it prints.
Run measure_apart(const char* program, std::size_t row) {
  Run run;
  FILE* pipe = ::popen(fmt::format("'{}' --row {}", program, row).c_str(), "r");
  if (pipe == nullptr) return run;
  if (std::fscanf(pipe, "%zu %d %lf %lf %lf %lf", &run.cubes, &run.iterations, &run.set_up_s, &run.solve_s,
                  &run.solid_mb, &run.peak_mb) != 6)
    run = {};
  ::pclose(pipe);
  return run;
}

void print_table(const char* program) {
  fmt::print("{:>5}{:>10}{:>6}{:>11}{:>12}{:>12}{:>10}{:>12}{:>10}\n", "N", "cubes", "nu", "iterations",
             "set-up ms", "solve ms", "goal ms", "solid MB", "peak MB");
  for (std::size_t r = 0; r < std::size(kTable); ++r) {
    const Run run = measure_apart(program, r);
    fmt::print("{:>5}{:>10}{:>6}{:>11}{:>12.1f}{:>12.1f}{:>10.0f}{:>12.0f}{:>10.0f}\n", kTable[r].resolution,
               run.cubes, kTable[r].ratio, run.iterations, 1e3 * run.set_up_s, 1e3 * run.solve_s,
               1e3 * kTable[r].goal_s, run.solid_mb, run.peak_mb);
    std::fflush(stdout);
  }
}

// A full block of n³ cubes.
template <class T>
void stiffness_operator(benchmark::State& state) {
  const auto n = static_cast<int>(state.range(0));
  const auto rows_of_cells = static_cast<std::size_t>(n) * static_cast<std::size_t>(n);
  const detail::VoxelRows rows({n, n, n}, std::vector<detail::CellSpan>(rows_of_cells, {0, n}),
                               rows_of_cells * static_cast<std::size_t>(n));
  std::vector<T> shear(rows.cell_count, T(1)), bulk(rows.cell_count, T(10));
  if (rows.cell_count != rows_of_cells * static_cast<std::size_t>(n)) {
    state.SkipWithError("n must be a multiple of eight");
    return;
  }
  const detail::VoxelOperator<T> op(rows, detail::cube_stiffness(1), shear, bulk, nullptr);
  std::vector<T> in(rows.values(), T(1)), out(rows.values());
  for (auto _ : state) {
    op.apply(in.data(), out.data(), [](std::size_t, std::size_t, std::size_t) {});
    benchmark::DoNotOptimize(out.data());
  }
  state.counters["unknowns"] =
      benchmark::Counter(3.0 * std::pow(n + 1, 3), benchmark::Counter::kIsIterationInvariantRate);
}
BENCHMARK_TEMPLATE(stiffness_operator, float)->Arg(32)->Arg(64)->Arg(128)->UseRealTime();
BENCHMARK_TEMPLATE(stiffness_operator, double)->Arg(32)->Arg(64)->Arg(128)->UseRealTime();

// What memory allows: as many floats read and written once.
void copy(benchmark::State& state) {
  const auto n = static_cast<std::size_t>(3 * std::pow(state.range(0) + 1, 3));
  std::vector<float> in(n, 1.0F), out(n);
  for (auto _ : state) {
    parallel_for(n, 1 << 16, [&](std::size_t begin, std::size_t end) {
      std::copy(in.begin() + static_cast<std::ptrdiff_t>(begin),
                in.begin() + static_cast<std::ptrdiff_t>(end),
                out.begin() + static_cast<std::ptrdiff_t>(begin));
    });
    benchmark::DoNotOptimize(out.data());
  }
  state.counters["unknowns"] =
      benchmark::Counter(static_cast<double>(n), benchmark::Counter::kIsIterationInvariantRate);
}
BENCHMARK(copy)->Arg(32)->Arg(64)->Arg(128)->UseRealTime();

}  // namespace

int main(int argc, char** argv) {
  if (argc == 3 && std::strcmp(argv[1], "--row") == 0) {
    const Run run = measure(kTable[static_cast<std::size_t>(std::atoi(argv[2])) % std::size(kTable)]);
    fmt::print("{} {} {} {} {} {}\n", run.cubes, run.iterations, run.set_up_s, run.solve_s, run.solid_mb,
               run.peak_mb);
    return 0;
  }
  if (bench::mesh_folder().empty())
    fmt::print("no table: bunny.ply is looked for in ../shared/data/meshes, which is not there\n");
  else
    print_table(argv[0]);
  benchmark::Initialize(&argc, argv);
  benchmark::RunSpecifiedBenchmarks();
  return 0;
}
