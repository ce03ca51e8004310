// The solvers of tissue models on networks of the size of Duysak and Zhang's face (2005, section 4) and
// beyond. Counters set what a solve moves and computes against the copy bandwidth measured in the same run
// (BM_Copy). `threads` is the last argument.
#include <benchmark/benchmark.h>

#include <algorithm>
#include <cstring>
#include <numeric>

#include "../tests/support/layered_slab.hpp"
#include "machine.hpp"
#include "turgor/core/parallel.hpp"
#include "turgor/core/random.hpp"
#include "turgor/dynamics/chain.hpp"
#include "turgor/dynamics/equilibrium.hpp"
#include "turgor/dynamics/time_stepper.hpp"
#include "turgor/tissue/network_energy.hpp"
#include "turgor/tissue/stiffness_matrix.hpp"

namespace {

using namespace turgor;
using benchmark::Counter;

/// A third of the bone points moves 6 mm down the face, the rest stays.
PrescribedMotion third_of_the_bone(const support::Slab& slab) {
  PrescribedMotion motion;
  for (int c = 0; c < slab.columns; ++c) {
    if (3 * c < slab.columns) {
      motion.moved.push_back(c);
      motion.positions.push_back(slab.network.rest[c] + Vec3{0, -6, 0});
    } else {
      motion.fixed.push_back(c);
    }
  }
  return motion;
}

BENCHMARK(bench::copy)->Arg(1)->Arg(2)->Unit(benchmark::kMillisecond)->UseRealTime();

/// The paper's face with every sheet `scale` times as long and wide.
support::Slab face(int scale) {
  support::SlabOptions options = support::duysak_zhang_size();
  options.nx *= scale;
  options.ny *= scale;
  options.dropped_edges *= scale * scale;
  return support::make_slab(options);
}

/// Points numbered at random: the worst order that a network can come in.
support::Slab shuffled(support::Slab slab) {
  std::vector<int> number(slab.network.rest.size());
  std::iota(number.begin(), number.end(), 0);
  const RandomStream random(1);
  for (std::size_t i = number.size() - 1; i > 0; --i) std::swap(number[i], number[random.bits(i) % (i + 1)]);
  const std::vector<Vec3> rest = slab.network.rest;
  for (std::size_t i = 0; i < rest.size(); ++i)
    slab.network.rest[static_cast<std::size_t>(number[i])] = rest[i];
  for (Spring& s : slab.network.springs)
    s.a = number[static_cast<std::size_t>(s.a)], s.b = number[static_cast<std::size_t>(s.b)];
  return slab;
}

// Per spring: two links (16 B) and two visit marks (4 B); an edge written and read (24 B each); rest of both
// ends and the displacement of one (72 B), the other's read and written (48 B). About 75 operations in the
// formula.
constexpr double kChainBytes = 2 * 16 + 2 * 4 + 2 * 24 + 72 + 48, kChainFlops = 75;

void run_chain(benchmark::State& state, const support::Slab& slab, const PrescribedMotion& motion,
               FixedPoints fixed) {
  const ChainSolver solver(slab.network);
  ChainParameters parameters;
  parameters.fixed_points = fixed;
  ChainWorkspace workspace;
  std::vector<Vec3> positions;
  for (auto _ : state) {
    if (!solver.solve(motion, parameters, workspace, positions)) state.SkipWithError("the chain failed");
    benchmark::DoNotOptimize(positions.data());
  }
  const auto springs = static_cast<double>(slab.network.springs.size());
  state.counters["springs"] = springs;
  state.counters["steps"] = workspace.steps;
  state.counters["s/spring"] = Counter(springs, Counter::kIsIterationInvariantRate | Counter::kInvert);
  state.counters["B/s"] =
      Counter(springs * kChainBytes, Counter::kIsIterationInvariantRate, Counter::kIs1000);
  state.counters["flop/s"] =
      Counter(springs * kChainFlops, Counter::kIsIterationInvariantRate, Counter::kIs1000);
}

/// As printed: the wave runs over the whole face.
void BM_ChainAsPrinted(benchmark::State& state) {
  const support::Slab slab = face(static_cast<int>(state.range(0)));
  run_chain(state, slab, third_of_the_bone(slab), FixedPoints::inert);
}
BENCHMARK(BM_ChainAsPrinted)->Arg(1)->Arg(2)->Arg(4)->Arg(7)->Unit(benchmark::kMicrosecond);

/// With bone that holds the tissue above it, the default.
void BM_ChainHeld(benchmark::State& state) {
  const support::Slab slab = face(static_cast<int>(state.range(0)));
  run_chain(state, slab, third_of_the_bone(slab), FixedPoints::hold);
}
BENCHMARK(BM_ChainHeld)->Arg(1)->Arg(2)->Arg(4)->Arg(7)->Unit(benchmark::kMicrosecond);

void BM_ChainShuffledPoints(benchmark::State& state) {
  support::Slab slab = face(static_cast<int>(state.range(0)));
  PrescribedMotion motion;
  for (int p = 0; p < slab.columns / 3; ++p) {
    motion.moved.push_back(p);  // anywhere, after the shuffle
    motion.positions.emplace_back();
  }
  slab = shuffled(std::move(slab));
  for (std::size_t i = 0; i < motion.moved.size(); ++i)
    motion.positions[i] = slab.network.rest[i] + Vec3{0, -6, 0};
  run_chain(state, slab, motion, FixedPoints::inert);
}
BENCHMARK(BM_ChainShuffledPoints)->Arg(1)->Arg(7)->Unit(benchmark::kMicrosecond);

enum Network : std::int64_t { kBraced, kLayered, kWithVolumes };

support::Slab network(std::int64_t which) {
  support::SlabOptions options = support::duysak_zhang_size_braced();
  if (which != kBraced) {
    options.tripods = false;
    options.diagonals = true;
    options.dropped_edges = 0;
  }
  options.volumes = which == kWithVolumes;
  return support::make_slab(options);
}

void label(benchmark::State& state, const support::Slab& slab) {
  state.SetLabel(std::to_string(slab.network.rest.size()) + " points, " +
                 std::to_string(slab.network.springs.size()) + " springs, " +
                 std::to_string(slab.network.volumes.size()) + " volumes");
}

/// From rest to a relative residual of 1e-4, everything included.
void BM_Equilibrium(benchmark::State& state) {
  const bench::Threads threads(state.range(1));
  const support::Slab slab = network(state.range(0));
  const PrescribedMotion motion = third_of_the_bone(slab);
  EquilibriumResult result;
  for (auto _ : state) {
    Context context;
    auto solved = solve_equilibrium(slab.network, motion, {}, context);
    if (!solved || !solved->converged) state.SkipWithError("no equilibrium");
    if (solved) result = *std::move(solved);
  }
  state.counters["newton"] = result.newton_steps;
  state.counters["cg"] = result.linear_iterations;
  state.counters["residual"] = result.relative_residual;
  label(state, slab);
}
BENCHMARK(BM_Equilibrium)
    ->ArgsProduct({{kBraced, kLayered, kWithVolumes}, {1, 2}})
    ->Unit(benchmark::kMillisecond)
    ->UseRealTime();

/// Energy and forces, once.
void BM_Forces(benchmark::State& state) {
  const bench::Threads threads(state.range(1));
  const support::Slab slab = network(state.range(0));
  const auto energy = NetworkEnergy::prepare(slab.network);
  std::vector<Vec3> forces(slab.network.rest.size());
  NetworkEnergy::Workspace workspace;
  for (auto _ : state) benchmark::DoNotOptimize(energy->forces(slab.network.rest, forces, workspace));
  // Per spring: ends, constants and two positions in, a force out and twice in; per volume four of each.
  const double springs = static_cast<double>(slab.network.springs.size());
  const double volumes = static_cast<double>(slab.network.volumes.size());
  state.counters["B/s"] = Counter(springs * (8 + 16 + 48 + 24 + 56) + volumes * (16 + 56 + 96 + 96 + 112),
                                  Counter::kIsIterationInvariantRate, Counter::kIs1000);
  label(state, slab);
}
BENCHMARK(BM_Forces)
    ->ArgsProduct({{kBraced, kLayered, kWithVolumes}, {1, 2}})
    ->Unit(benchmark::kMicrosecond)
    ->UseRealTime();

/// Element blocks and their sum into the matrix of the free points, once.
void BM_Stiffness(benchmark::State& state) {
  const bench::Threads threads(state.range(1));
  const support::Slab slab = network(state.range(0));
  const auto energy = NetworkEnergy::prepare(slab.network);
  std::vector<int> unknowns(slab.network.rest.size() - static_cast<std::size_t>(slab.columns));
  std::iota(unknowns.begin(), unknowns.end(), slab.columns);
  StiffnessMatrix matrix(*energy, unknowns);
  ElementStiffness stiffness;
  for (auto _ : state) {
    energy->linearise(slab.network.rest, 1.0, stiffness);
    matrix.assemble(*energy, stiffness);
    benchmark::DoNotOptimize(matrix.blocks().data());
  }
  state.counters["blocks"] = static_cast<double>(matrix.blocks().size());
  label(state, slab);
}
BENCHMARK(BM_Stiffness)
    ->ArgsProduct({{kBraced, kLayered, kWithVolumes}, {1, 2}})
    ->Unit(benchmark::kMicrosecond)
    ->UseRealTime();

// An Euler step. Per spring: ends (8 B), rest length, stiffness and viscosity (24 B), some 75 operations; per
// point position and velocity read and written (96 B, and 48 B for the lines written to), mass and decay (16
// B), its number (4 B), some 45 operations. Springs between blocks count once.
constexpr double kStepSpringBytes = 32, kStepPointBytes = 164, kStepSpringFlops = 75, kStepPointFlops = 45;

void run_steps(benchmark::State& state, const support::Slab& slab, Integrator integrator, double viscosity) {
  MotionModel model;
  model.network = slab.network;
  model.network.mass_g.assign(model.network.rest.size(), 0.05);
  if (viscosity > 0) model.springs.assign(model.network.springs.size(), {viscosity, 0});
  model.gravity_mm_ms2 = {0, 0, -0.0098};
  const auto springs = static_cast<double>(model.network.springs.size());
  const auto points = static_cast<double>(model.network.rest.size());
  const auto stepper = TimeStepper::prepare(std::move(model));
  MotionState motion = stepper->rest();
  const double dt = 0.5 * stepper->stable_step_ms(motion, integrator);
  Context context;
  TimeStepper::Workspace workspace;
  for (auto _ : state) {
    benchmark::DoNotOptimize(stepper->step(motion, dt, integrator, context, workspace));
  }
  const double passes = integrator == Integrator::euler ? 1 : 2;
  state.counters["s/spring"] =
      Counter(springs * passes, Counter::kIsIterationInvariantRate | Counter::kInvert);
  state.counters["B/s"] = Counter(passes * (springs * kStepSpringBytes + points * kStepPointBytes),
                                  Counter::kIsIterationInvariantRate, Counter::kIs1000);
  state.counters["flop/s"] = Counter(passes * (springs * kStepSpringFlops + points * kStepPointFlops),
                                     Counter::kIsIterationInvariantRate, Counter::kIs1000);
  label(state, slab);
}

/// One Euler step of the paper's face, `scale` times as long and wide; forces, stable step and update.
void BM_TimeStep(benchmark::State& state) {
  const bench::Threads threads(state.range(1));
  run_steps(state, face(static_cast<int>(state.range(0))), Integrator::euler, 0.01);
}
BENCHMARK(BM_TimeStep)->ArgsProduct({{1, 7}, {1, 2}})->Unit(benchmark::kMillisecond)->UseRealTime();

/// The same with points numbered at random.
void BM_TimeStepShuffledPoints(benchmark::State& state) {
  const bench::Threads threads(state.range(1));
  run_steps(state, shuffled(face(static_cast<int>(state.range(0)))), Integrator::euler, 0.01);
}
BENCHMARK(BM_TimeStepShuffledPoints)
    ->Args({7, 1})
    ->Args({7, 2})
    ->Unit(benchmark::kMillisecond)
    ->UseRealTime();

/// A Heun step of a network as small as the thesis's scripts (1989, chapter 6); springs are evaluated twice.
void BM_ScriptStep(benchmark::State& state) {
  const bench::Threads threads(state.range(0));
  support::SlabOptions options;
  options.nx = options.ny = 13;
  run_steps(state, support::make_slab(options), Integrator::heun, 0.01);
}
BENCHMARK(BM_ScriptStep)->Arg(1)->Arg(2)->Unit(benchmark::kMicrosecond)->UseRealTime();

/// An Euler and a Heun step of volume elements alone, three a prism: `side`² columns. Heun needs the
/// stiffness in one of its two evaluations.
void BM_VolumeStep(benchmark::State& state) {
  const bench::Threads threads(state.range(2));
  support::SlabOptions options;
  options.nx = options.ny = static_cast<int>(state.range(0));
  options.volumes = true;
  MotionModel model;
  model.network = support::make_slab(options).network;
  model.network.springs.clear();
  model.network.mass_g.assign(model.network.rest.size(), 0.05);
  const auto volumes = static_cast<double>(model.network.volumes.size());
  const Integrator integrator = state.range(1) == 1 ? Integrator::euler : Integrator::heun;
  const auto stepper = TimeStepper::prepare(std::move(model));
  MotionState motion = stepper->rest();
  const double dt = 0.5 * stepper->stable_step_ms(motion, integrator);
  Context context;
  TimeStepper::Workspace workspace;
  for (auto _ : state) benchmark::DoNotOptimize(stepper->step(motion, dt, integrator, context, workspace));
  state.counters["volumes"] = volumes;
  state.counters["s/volume"] = Counter(volumes * static_cast<double>(state.range(1)),
                                       Counter::kIsIterationInvariantRate | Counter::kInvert);
}
BENCHMARK(BM_VolumeStep)
    ->ArgNames({"side", "evaluations", "threads"})
    ->ArgsProduct({{15, 21, 290}, {1, 2}, {1, 2}})
    ->Unit(benchmark::kMicrosecond)
    ->UseRealTime();

}  // namespace
