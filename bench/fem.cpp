// Linear elasticity of the bunny's voxels: held below, under its weight, to a relative residual of 1e-6; then
// large strains of a slab.
// The printed table is of runs in a process of their own, so that its peak memory is its own (less what the
// solid takes); the benchmarks after it are of the operator alone, beside a copy of the same memory.
#include <benchmark/benchmark.h>
#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <optional>
#include <string>

#include "../tests/support/shell.hpp"
#include "fem/voxel_operator.hpp"
#include "inputs.hpp"
#include "turgor/core/parallel.hpp"
#include "turgor/fem/response_space.hpp"
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

std::vector<NodeSupport> base_of(const SolidMesh& solid) {
  double lowest = 1e300;
  for (const Vec3& p : solid.points) lowest = std::min(lowest, p.y);
  std::vector<NodeSupport> supports;
  for (std::size_t p = 0; p < solid.points.size(); ++p) {
    if (solid.points[p].y < lowest + 0.5 * solid.spacing)
      supports.push_back({static_cast<int>(p), {true, true, true}, {}});
  }
  return supports;
}

Run measure(const Row& row) {
  Run run;
  const SolidMesh solid = bunny_solid(row.resolution);
  run.cubes = solid.tetrahedra.size() / 5;
  run.solid_mb = bench::peak_mb();
  const std::vector<NodeSupport> supports = base_of(solid);
  ElasticBody body;
  body.materials[0].poissons_ratio = row.ratio;
  ElasticLoad load;
  load.gravity_mm_ms2 = {0, -0.00981, 0};
  Context context;
  for (int repeat = 0; repeat < (run.cubes > 200000 ? 2 : 5); ++repeat) {
    auto start = std::chrono::steady_clock::now();
    const auto fem = VoxelElasticity::prepare(solid, body, {supports, {}}, {}, context);
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
  const std::string printed = support::shell(fmt::format("'{}' --row {}", program, row)).text;
  if (std::sscanf(printed.c_str(), "%zu %d %lf %lf %lf %lf", &run.cubes, &run.iterations, &run.set_up_s,
                  &run.solve_s, &run.solid_mb, &run.peak_mb) != 6)
    run = {};
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

// Soft tissue of a face under the Mooney-Rivlin law (Nazari et al. 2010): a slab 16 mm thick, held below but
// for a ring, within which its support moves by 6 mm; then by one more.
void print_large_strains() {
  fmt::print("{:>10}{:>6}{:>8}{:>12}{:>11}{:>10}\n", "cubes", "nu", "steps", "iterations", "solve ms", "");
  for (const int across : {40, 80}) {
    for (const double ratio : {0.45, 0.49}) {
      const double spacing = 80.0 / across;
      VoxelGrid grid({across + 2, across + 2, across / 5 + 2});
      grid.spacing = spacing;
      grid.lower = Vec3{-spacing, -spacing, -spacing};
      for (int k = 1; k <= across / 5; ++k)
        for (int j = 1; j <= across; ++j)
          for (int i = 1; i <= across; ++i) grid.set(i, j, k);
      const auto solid = solid_of(grid);
      if (!solid) return;
      ElasticSupports supports;
      std::vector<Vec3> further;
      for (std::size_t p = 0; p < solid->points.size(); ++p) {
        const Vec3 x = solid->points[p];
        const double r = std::hypot(x.x - 40, x.y - 40);
        if (x.z > 1e-9 || (r >= 15 && r <= 25)) continue;
        const Vec3 move = r < 15 ? Vec3{0, 0.667, -0.745} : Vec3{};
        supports.nodes.push_back({static_cast<int>(p), {true, true, true}, move * 6.0});
        further.push_back(move * 7.0);
      }
      ElasticBody body;
      body.materials[0] = ElasticMaterial::mooney_rivlin(0.0025, 0.001175, ratio);
      Context context;
      auto fem = VoxelElasticity::prepare(*solid, body, supports, {}, context);
      if (!fem) return;
      std::vector<Vec3> before;
      for (const bool moved : {false, true}) {
        const auto start = std::chrono::steady_clock::now();
        const auto s = fem->solve({}, context, before);
        if (!s || !fem->set_displacements(further)) return;
        before = s->displacement_mm;
        fmt::print("{:>10}{:>6}{:>8}{:>12}{:>11.0f}  {}\n", solid->tetrahedra.size() / 5, ratio,
                   s->newton_steps, s->iterations, 1e3 * bench::seconds_since(start),
                   !s->converged ? "not converged"
                   : moved       ? "1 mm more"
                                 : "from rest");
        std::fflush(stdout);
      }
    }
  }
}

// What stands on the bunny's base and what its top moves with: a bone that is shifted, time and again.
class MovedBone {
 public:
  explicit MovedBone(int resolution) : solid_(bunny_solid(resolution)) {
    const auto [low, high] = std::minmax_element(solid_.points.begin(), solid_.points.end(),
                                                 [](const Vec3& a, const Vec3& b) { return a.y < b.y; });
    top_ = high->y - 0.1 * (high->y - low->y);
    for (std::size_t p = 0; p < solid_.points.size(); ++p) {
      if (solid_.points[p].y < low->y + 0.5 * solid_.spacing || solid_.points[p].y > top_)
        supports_.nodes.push_back({static_cast<int>(p), {true, true, true}, {}});
    }
    const ElasticBody body;
    auto fem = VoxelElasticity::prepare(solid_, body, supports_, {}, context_);
    if (fem) fem_.emplace(*std::move(fem));
    (void)known_.add(std::vector<Vec3>(supports_.nodes.size()), std::vector<Vec3>(solid_.points.size()));
  }
  [[nodiscard]] std::size_t cubes() const { return solid_.tetrahedra.size() / 5; }
  /// Seconds to the next solution, and its iterations.
  std::pair<double, int> shift(const Vec3& by) {
    if (!fem_) return {};
    std::vector<Vec3> held;
    for (const NodeSupport& s : supports_.nodes)
      held.push_back(solid_.points[static_cast<std::size_t>(s.node)].y > top_ ? by : Vec3{});
    const auto start = std::chrono::steady_clock::now();
    const auto near = known_.start(held);
    if (!near || !fem_->set_displacements(held)) return {};
    const auto solution = fem_->solve({}, context_, *near);
    const double seconds = bench::seconds_since(start);
    if (!solution || !known_.add(held, solution->displacement_mm)) return {};
    return {seconds, solution->iterations};
  }

 private:
  Context context_;
  SolidMesh solid_;
  double top_ = 0;
  ElasticSupports supports_;
  std::optional<VoxelElasticity> fem_;
  ResponseSpace known_;
};

void print_moved_bone() {
  fmt::print("\nA bone moved by 6 mm, then by 1 mm more, from the solutions before (ms, iterations)\n");
  fmt::print("{:>10}{:>16}{:>16}{:>16}{:>16}{:>16}\n", "cubes", "from rest", "same way", "another way",
             "a third way", "any way then");
  for (const int resolution : {30, 50, 75}) {
    MovedBone bone(resolution);
    fmt::print("{:>10}", bone.cubes());
    for (const Vec3& by : {Vec3{0, 6, 0}, Vec3{0, 7, 0}, Vec3{1, 7, 0}, Vec3{1, 7, 1}, Vec3{0.5, 6, 0.5}}) {
      const auto [seconds, iterations] = bone.shift(by);
      fmt::print("{:>12.1f}{:>4}", 1e3 * seconds, iterations);
    }
    fmt::print("\n");
    std::fflush(stdout);
  }
}

// The same deck by CalculiX 2.20's iterative solver and its linear hexahedra, where it is installed.
double calculix_seconds(const SolidMesh& solid, const std::vector<NodeSupport>& supports) {
  const fs::path folder = fs::temp_directory_path() / fmt::format("turgor_ccx_{}", ::getpid());
  fs::create_directories(folder);
  std::ofstream out(folder / "case.inp");
  out << "*NODE, NSET=ALL\n";
  for (std::size_t p = 0; p < solid.points.size(); ++p)
    out << fmt::format("{}, {:.9g}, {:.9g}, {:.9g}\n", p + 1, solid.points[p].x, solid.points[p].y,
                       solid.points[p].z);
  out << "*ELEMENT, TYPE=C3D8, ELSET=BODY\n";
  std::size_t number = 0;
  for (const auto& e : hexahedra(solid))
    out << fmt::format("{}, {}, {}, {}, {}, {}, {}, {}, {}\n", ++number, e[0] + 1, e[1] + 1, e[2] + 1,
                       e[3] + 1, e[4] + 1, e[5] + 1, e[6] + 1, e[7] + 1);
  const ElasticMaterial m;
  out << fmt::format("*MATERIAL, NAME=M\n*ELASTIC\n{}, {}\n*DENSITY\n{}\n", m.youngs_modulus_mpa,
                     m.poissons_ratio, m.density_g_mm3)
      << "*SOLID SECTION, ELSET=BODY, MATERIAL=M\n*STEP\n*STATIC, SOLVER=ITERATIVE CHOLESKY\n*BOUNDARY\n";
  for (const NodeSupport& s : supports) out << fmt::format("{}, 1, 3, 0\n", s.node + 1);
  out << "*DLOAD\nBODY, GRAV, 0.00981, 0, -1, 0\n*NODE FILE\nU\n*END STEP\n";
  out.close();
  const auto start = std::chrono::steady_clock::now();
  const std::string command =
      fmt::format("cd '{}' && OMP_NUM_THREADS={} ccx case > ccx.log 2>&1", folder.string(), thread_count());
  const bool done = std::system(command.c_str()) == 0;
  const double seconds = bench::seconds_since(start);
  fs::remove_all(folder);
  return done ? seconds : -1;
}

void print_calculix() {
  if (std::system("command -v ccx > /dev/null 2>&1") != 0) {
    fmt::print("\nCalculiX: ccx is not installed\n");
    return;
  }
  for (const int resolution : {30, 50}) {
    const SolidMesh solid = bunny_solid(resolution);
    const double seconds = calculix_seconds(solid, base_of(solid));
    fmt::print("\nCalculiX, {} cubes, ν 0.45, deck to result: {:.1f} s\n", solid.tetrahedra.size() / 5,
               seconds);
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
  else {
    print_table(argv[0]);
    print_moved_bone();
    print_calculix();
  }
  print_large_strains();
  benchmark::Initialize(&argc, argv);
  benchmark::RunSpecifiedBenchmarks();
  return 0;
}
