// Solids of the bunny's voxels (Morris 2006, sections 2 and 4.1): from rest to equilibrium under gravity or
// with the ears pulled, the lowest layer fixed; and one implicit step. All from memory.
#include <benchmark/benchmark.h>

#include <algorithm>
#include <filesystem>
#include <optional>

#include "inputs.hpp"
#include "turgor/core/parallel.hpp"
#include "turgor/dynamics/equilibrium.hpp"
#include "turgor/dynamics/implicit_stepper.hpp"
#include "turgor/geometry/mesh_file.hpp"
#include "turgor/geometry/voxel_solid.hpp"

namespace {

using namespace turgor;
namespace fs = std::filesystem;

constexpr double kTall = 150;  // mm

struct Bunny {
  MotionModel model;
  PrescribedMotion base;
  std::vector<int> ears;  // the highest two layers
};

// Upright along y, as the file has it.
std::optional<Bunny> make_bunny(int resolution, const SolidMaterial& material) {
  auto surface = bench::bunny_surface();
  if (!surface) return std::nullopt;
  Box3 box;
  for (const Vec3& p : surface->points) box.extend(p);
  for (Vec3& p : surface->points) p = (p - box.lower) * (kTall / box.size().y);
  VoxelOptions options;
  options.resolution = resolution;
  const auto mesh = bench::solid_in(*surface, options);
  if (!mesh) return std::nullopt;
  Bunny bunny;
  SpringNetwork& net = bunny.model.network;
  net.rest.assign(mesh->points.begin(), mesh->points.end());
  net.mass_g.assign(net.rest.size(), 0);
  Solid solid = *make_solid({mesh->tetrahedra.begin(), mesh->tetrahedra.end()},
                            static_cast<int>(net.rest.size()), mesh->spacing);
  const SolidStiffness stiffness = stiffness_of(material);
  if (!set_stiffness(solid, net.rest, {&stiffness, 1})) return std::nullopt;
  add_mass(solid, net.rest, material.density_g_mm3, net.mass_g);
  net.solids.push_back(std::move(solid));
  Box3 lattice;
  for (const Vec3& p : net.rest) lattice.extend(p);
  bunny.model.gravity_mm_ms2 = {0, -0.00980665, 0};
  bunny.model.mobile.assign(net.rest.size(), 1);
  for (std::size_t p = 0; p < net.rest.size(); ++p) {
    if (net.rest[p].y < lattice.lower.y + 0.5 * mesh->spacing) {
      bunny.base.fixed.push_back(static_cast<int>(p));
      bunny.model.mobile[p] = 0;
    }
    if (net.rest[p].y > lattice.upper.y - 1.5 * mesh->spacing) bunny.ears.push_back(static_cast<int>(p));
  }
  return bunny;
}

SolidMaterial material_of(const benchmark::State& state) {
  return {static_cast<double>(state.range(1)) * 1e-3, 0.45, 1.04e-3, 0.2};
}

void label(benchmark::State& state, const Bunny& bunny) {
  state.SetLabel(std::to_string(bunny.model.network.rest.size()) + " points, " +
                 std::to_string(bunny.model.network.solids[0].tetrahedra.size()) + " tetrahedra");
}

void run_equilibrium(benchmark::State& state, bool gravity) {
  set_thread_count(static_cast<int>(state.range(2)));
  const auto bunny = make_bunny(static_cast<int>(state.range(0)), material_of(state));
  if (!bunny) {
    state.SkipWithError("../shared/data/meshes/bunny.ply is not there");
    return;
  }
  PrescribedMotion motion = bunny->base;
  Loads loads;
  if (gravity) loads.gravity_mm_ms2 = bunny->model.gravity_mm_ms2;
  if (!gravity) {
    motion.moved = bunny->ears;
    for (const int p : motion.moved)
      motion.positions.push_back(bunny->model.network.rest[static_cast<std::size_t>(p)] + Vec3{20, 20, 0});
  }
  EquilibriumResult result;
  for (auto _ : state) {
    Context context;
    auto solved = solve_equilibrium(bunny->model.network, motion, loads, {}, context);
    if (!solved || !solved->converged) state.SkipWithError("no equilibrium");
    if (solved) result = *std::move(solved);
  }
  state.counters["newton"] = result.newton_steps;
  state.counters["cg"] = result.linear_iterations;
  state.counters["residual"] = result.relative_residual;
  label(state, *bunny);
  set_thread_count(0);
}

/// Under gravity: resolution, Young's modulus in kPa, threads.
void BM_SolidUnderGravity(benchmark::State& state) {
  run_equilibrium(state, true);
}
BENCHMARK(BM_SolidUnderGravity)
    ->ArgNames({"resolution", "kPa", "threads"})
    ->Args({30, 15, 1})
    ->Args({30, 15, 2})
    ->Args({30, 100, 2})
    ->Args({60, 15, 2})
    ->Unit(benchmark::kMillisecond)
    ->UseRealTime();

/// The ears 28 mm away.
void BM_SolidPulledAtTheEars(benchmark::State& state) {
  run_equilibrium(state, false);
}
BENCHMARK(BM_SolidPulledAtTheEars)
    ->ArgNames({"resolution", "kPa", "threads"})
    ->Args({30, 15, 2})
    ->Unit(benchmark::kMillisecond)
    ->UseRealTime();

/// Implicit steps of 10 ms, falling from rest and sagging.
void BM_SolidImplicitStep(benchmark::State& state) {
  set_thread_count(static_cast<int>(state.range(2)));
  auto bunny = make_bunny(static_cast<int>(state.range(0)), material_of(state));
  if (!bunny) {
    state.SkipWithError("../shared/data/meshes/bunny.ply is not there");
    return;
  }
  Context context;
  auto stepper = ImplicitStepper::prepare(bunny->model, context);
  MotionState motion{bunny->model.network.rest, std::vector<Vec3>(bunny->model.network.rest.size()), 0};
  int newton = 0, cg = 0;
  for (auto _ : state) {
    const auto report = stepper->step(motion, 10, context);
    if (!report || !report->converged) state.SkipWithError("the step failed");
    if (report) newton += report->newton_steps, cg += report->linear_iterations;
  }
  state.counters["newton"] = benchmark::Counter(newton, benchmark::Counter::kAvgIterations);
  state.counters["cg"] = benchmark::Counter(cg, benchmark::Counter::kAvgIterations);
  label(state, *bunny);
  set_thread_count(0);
}
BENCHMARK(BM_SolidImplicitStep)
    ->ArgNames({"resolution", "kPa", "threads"})
    ->Args({30, 15, 1})
    ->Args({30, 15, 2})
    ->Unit(benchmark::kMillisecond)
    ->UseRealTime();

/// Edges and triangles found and constants set.
void BM_MakeSolid(benchmark::State& state) {
  set_thread_count(static_cast<int>(state.range(1)));
  const auto bunny = make_bunny(static_cast<int>(state.range(0)), {});
  if (!bunny) {
    state.SkipWithError("../shared/data/meshes/bunny.ply is not there");
    return;
  }
  const SpringNetwork& net = bunny->model.network;
  const SolidStiffness stiffness = stiffness_of({});
  for (auto _ : state) {
    auto solid = make_solid(net.solids[0].tetrahedra, static_cast<int>(net.rest.size()), 0);
    if (!solid || !set_stiffness(*solid, net.rest, {&stiffness, 1})) state.SkipWithError("no solid");
  }
  label(state, *bunny);
  set_thread_count(0);
}
BENCHMARK(BM_MakeSolid)
    ->ArgNames({"resolution", "threads"})
    ->Args({30, 1})
    ->Args({75, 1})
    ->Args({75, 2})
    ->Unit(benchmark::kMillisecond)
    ->UseRealTime();

}  // namespace
