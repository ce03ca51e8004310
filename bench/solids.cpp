// Solids in motion (Morris 2006, section 4.1): one Verlet step of voxel solids and of arbitrary tetrahedra,
// what it moves and computes beside the copy bandwidth measured in the same run, the way to rest, and
// Bullet's soft body on the same mesh. `threads` is the last argument.
#include <benchmark/benchmark.h>
#ifdef TURGOR_BENCH_BULLET
#include <BulletSoftBody/btSoftBody.h>
#endif

#include <algorithm>
#include <cstring>
#include <filesystem>
#include <numbers>
#include <numeric>
#include <optional>
#include <string>

#include "inputs.hpp"
#include "machine.hpp"
#include "turgor/core/parallel.hpp"
#include "turgor/core/random.hpp"
#include "turgor/dynamics/implicit_stepper.hpp"
#include "turgor/dynamics/time_stepper.hpp"
#include "turgor/geometry/mesh_file.hpp"
#include "turgor/geometry/voxel_solid.hpp"

namespace {

using namespace turgor;
using benchmark::Counter;
namespace fs = std::filesystem;

BENCHMARK(bench::copy)->Arg(1)->Arg(2)->Unit(benchmark::kMillisecond)->UseRealTime();

std::optional<SolidMesh> bunny(int resolution, bool border) {
  const auto surface = bench::bunny_surface();
  if (!surface) return std::nullopt;
  VoxelOptions options;
  options.resolution = resolution;
  options.border = border;
  return bench::solid_in(*surface, options);
}

enum Shape : std::int64_t { kLattice, kVarying, kArbitrary };

/// 150 mm long, of soft tissue. Varying: each tetrahedron has a stiffness of its own. Arbitrary: points moved
/// aside by up to an eighth of a voxel, tetrahedra and points numbered anew within runs of some hundred.
std::optional<MotionModel> model_of(int resolution, bool border, Shape shape) {
  auto mesh = bunny(resolution, border);
  if (!mesh) return std::nullopt;
  const RandomStream random(1);
  MotionModel model;
  const double scale = 150.0 / (resolution * mesh->spacing), size = scale * mesh->spacing;
  std::vector<Vec3> rest(mesh->points.begin(), mesh->points.end());
  for (Vec3& x : rest) x *= scale;
  std::vector<std::array<int, 4>> tetrahedra(mesh->tetrahedra.begin(), mesh->tetrahedra.end());
  if (shape == kArbitrary) {
    const auto shuffle = [&](std::size_t count, std::uint64_t stream) {
      const RandomStream order(2, stream);
      std::vector<int> to(count);
      std::iota(to.begin(), to.end(), 0);
      for (std::size_t i = count - 1; i > 0; --i) {
        const std::size_t run = std::min<std::size_t>(i + 1, 256);
        std::swap(to[i], to[i - order.bits(i) % run]);
      }
      return to;
    };
    const auto point = shuffle(rest.size(), 0), cell = shuffle(tetrahedra.size(), 1);
    std::vector<Vec3> moved(rest.size());
    for (std::size_t i = 0; i < rest.size(); ++i) {
      const Vec3 aside{random.uniform(3 * i) - 0.5, random.uniform(3 * i + 1) - 0.5,
                       random.uniform(3 * i + 2) - 0.5};
      moved[static_cast<std::size_t>(point[i])] = rest[i] + aside * (0.25 * size);
    }
    std::vector<std::array<int, 4>> renumbered(tetrahedra.size());
    for (std::size_t i = 0; i < tetrahedra.size(); ++i)
      for (std::size_t c = 0; c < 4; ++c)
        renumbered[static_cast<std::size_t>(cell[i])][c] = point[static_cast<std::size_t>(tetrahedra[i][c])];
    rest = std::move(moved);
    tetrahedra = std::move(renumbered);
  }
  auto solid =
      make_solid(std::move(tetrahedra), static_cast<int>(rest.size()), shape == kArbitrary ? 0 : size);
  if (!solid) return std::nullopt;
  std::vector<SolidStiffness> stiffness(shape == kVarying ? solid->tetrahedra.size() : 1, stiffness_of({}));
  if (shape == kVarying) {
    for (std::size_t i = 0; i < stiffness.size(); ++i) {
      const double factor = 0.5 + random.uniform(i);
      stiffness[i].length *= factor, stiffness[i].area *= factor, stiffness[i].volume *= factor;
    }
  }
  if (!set_stiffness(*solid, rest, stiffness)) return std::nullopt;
  model.network.mass_g.assign(rest.size(), 0);
  add_mass(*solid, rest, SolidMaterial{}.density_g_mm3, model.network.mass_g);
  model.network.rest = std::move(rest);
  model.network.solids.push_back(*std::move(solid));
  return model;
}

// Per tetrahedron of a lattice: corners (16 B a cube), with constants of their own 39 floats a cube; of an
// arbitrary one corners (8 B) and 20 floats. Per point: position and velocity read and written (96 B, and 48
// B for the lines written to), rest (24 B), mass and decay (16 B), lists (8 B); of each block that it is in,
// about 1.4, its place, rest and number read again, its force written and read. Operations are counted in the
// source.
constexpr double kTetraBytes[] = {16.0 / 5, 172.0 / 5, 88}, kPointBytes = 192 + 1.4 * (48 + 8 + 32);
constexpr double kTetraFlops[] = {1560.0 / 5, 1560.0 / 5, 590}, kPointFlops = 45;

void BM_Step(benchmark::State& state) {
  const auto shape = static_cast<Shape>(state.range(0));
  const int resolution = static_cast<int>(state.range(1));
  const bench::Threads threads(state.range(3));
  auto model = model_of(resolution, state.range(2) != 0, shape);
  if (!model) return state.SkipWithError("the bunny is not there, see ../shared/data/meshes");
  const auto tetrahedra = static_cast<double>(model->network.solids[0].tetrahedra.size());
  const auto points = static_cast<double>(model->network.rest.size());
  model->gravity_mm_ms2 = {0, 0, -0.00980665};
  model->damping_g_ms = 1e-4;
  const auto stepper = TimeStepper::prepare(*std::move(model));
  if (!stepper) return state.SkipWithError(stepper.error().message().c_str());
  MotionState motion = stepper->rest();
  const double dt = 0.5 * stepper->stable_step_ms(motion, Integrator::verlet);
  Context context;
  TimeStepper::Workspace workspace;
  for (auto _ : state)
    benchmark::DoNotOptimize(stepper->step(motion, dt, Integrator::verlet, context, workspace));
  state.counters["tetrahedra"] = tetrahedra;
  state.counters["tetrahedra/s"] = Counter(tetrahedra, Counter::kIsIterationInvariantRate, Counter::kIs1000);
  state.counters["B/s"] = Counter(tetrahedra * kTetraBytes[shape] + points * kPointBytes,
                                  Counter::kIsIterationInvariantRate, Counter::kIs1000);
  state.counters["flop/s"] = Counter(tetrahedra * kTetraFlops[shape] + points * kPointFlops,
                                     Counter::kIsIterationInvariantRate, Counter::kIs1000);
  state.counters["dt_ms"] = dt;
}
BENCHMARK(BM_Step)
    ->ArgNames({"shape", "resolution", "border", "threads"})
    ->ArgsProduct({{kLattice}, {21, 30, 46, 75}, {1}, {1, 2}})
    ->ArgsProduct({{kVarying}, {30, 75}, {1}, {1, 2}})
    ->ArgsProduct({{kArbitrary}, {21, 30, 43}, {1}, {1, 2}})
    ->Unit(benchmark::kMicrosecond)
    ->UseRealTime();
/// Half the period of the slowest swing: until what has gone farthest turns back, after it has been let go.
double half_period_ms(const TimeStepper& stepper) {
  MotionState motion = stepper.rest();
  const auto& rest = stepper.model().network.rest;
  const double dt = 0.95 * stepper.stable_step_ms(motion, Integrator::verlet);
  Context context;
  TimeStepper::Workspace workspace;
  double farthest = 0, now = 0;
  do {
    farthest = now, now = 0;
    if (!stepper.step(motion, 20 * dt, Integrator::verlet, context, workspace)) return 0;
    for (std::size_t p = 0; p < rest.size(); ++p) now = std::max(now, distance(motion.position[p], rest[p]));
  } while (now > farthest);
  return motion.time_ms;
}

/// Whether all forces together are below a thousandth of the mean weight of a point, everywhere, and so are
/// those of damping.
bool is_at_rest(const TimeStepper& stepper, const MotionState& motion, std::vector<Vec3>& forces) {
  const MotionModel& model = stepper.model();
  const auto& mass = model.network.mass_g;
  const double mean = std::accumulate(mass.begin(), mass.end(), 0.0) / static_cast<double>(mass.size());
  const double allowed = 1e-3 * length(model.gravity_mm_ms2) * mean;
  stepper.forces(motion, forces);
  for (std::size_t p = 0; p < forces.size(); ++p)
    if (length(forces[p]) > allowed || model.damping_g_ms * length(motion.velocity[p]) > allowed)
      return false;
  return true;
}

/// The bunny of 36,000 tetrahedra on a base that is held, which will sag under its weight; damped near to
/// critically for its slowest swing, which is of its ears: 0.75 was found by trial. Forces in double
/// precision: rounding in single leaves some two thousandths of the weight, as the ears bend far.
std::optional<MotionModel> sagging_bunny() {
  auto model = model_of(30, true, kLattice);
  if (!model) return std::nullopt;
  const auto& rest = model->network.rest;
  double lowest = rest[0].y;
  for (const Vec3& x : rest) lowest = std::min(lowest, x.y);
  for (const Vec3& x : rest) model->mobile.push_back(x.y > lowest + 6 ? 1 : 0);
  model->gravity_mm_ms2 = {0, -0.00980665, 0};
  const double mass = *std::max_element(model->network.mass_g.begin(), model->network.mass_g.end());
  const double half = half_period_ms(*TimeStepper::prepare(*model));
  model->damping_g_ms = 0.75 * std::numbers::pi / half * mass;
  model->exact_solids = true;
  return model;
}

/// Three ways to rest, each until is_at_rest, or given up with `rests` 0: steps of Verlet's method, implicit
/// steps of 50 s, and Newton's method for the equilibrium.
enum Way { kVerlet, kImplicit, kEquilibrium };
void BM_ToRest(benchmark::State& state) {
  const bench::Threads threads(state.range(1));
  auto model = sagging_bunny();
  if (!model) return state.SkipWithError("the bunny is not there, see ../shared/data/meshes");
  const auto stepper = TimeStepper::prepare(*model);
  std::vector<Vec3> forces(model->network.rest.size());
  int steps = 0;
  bool rests = false;
  for (auto _ : state) {
    MotionState motion = stepper->rest();
    Context context;
    TimeStepper::Workspace workspace;
    auto implicit = ImplicitStepper::prepare(*model, context);
    rests = false;
    const int most = state.range(0) == kVerlet ? 60'000 : 100;
    for (steps = 0; steps < most && !rests; rests = is_at_rest(*stepper, motion, forces)) {
      if (state.range(0) == kVerlet) {
        const double dt = 0.95 * stepper->stable_step_ms(motion, Integrator::verlet);
        for (int i = 0; i < 50; ++i, ++steps)
          benchmark::DoNotOptimize(stepper->step(motion, dt, Integrator::verlet, context, workspace));
      } else if (state.range(0) == kImplicit) {
        benchmark::DoNotOptimize(implicit->step(motion, 50'000, context, 1e-5));
        ++steps;
      } else {
        EquilibriumOptions options;
        options.relative_residual = 1e-5;
        const auto result = implicit->settle(motion, options, context);
        steps += result ? std::max(1, result->newton_steps) : most;
      }
    }
  }
  state.counters["steps"] = steps;
  state.counters["rests"] = rests ? 1 : 0;
}
BENCHMARK(BM_ToRest)
    ->ArgNames({"way", "threads"})
    ->ArgsProduct({{kVerlet, kImplicit, kEquilibrium}, {1, 2}})
    ->Iterations(1)
    ->Unit(benchmark::kMillisecond)
    ->UseRealTime();

#ifdef TURGOR_BENCH_BULLET
/// One step of Bullet's soft body on the same mesh: it moves points by their velocity, passes once over the
/// edges, each corrected at once (position based, in single precision, one thread), and refits its tree of
/// boxes; neither areas nor volumes.
void BM_BulletLinks(benchmark::State& state) {
  const auto model = model_of(static_cast<int>(state.range(0)), true, kLattice);
  if (!model) return state.SkipWithError("the bunny is not there, see ../shared/data/meshes");
  const auto& net = model->network;
  std::vector<btVector3> x;
  std::vector<btScalar> mass;
  for (std::size_t p = 0; p < net.rest.size(); ++p) {
    x.emplace_back(static_cast<btScalar>(net.rest[p].x), static_cast<btScalar>(net.rest[p].y),
                   static_cast<btScalar>(net.rest[p].z));
    mass.push_back(static_cast<btScalar>(net.mass_g[p]));
  }
  btSoftBodyWorldInfo world;
  world.m_gravity = btVector3(0, 0, -0.0098F);
  btSoftBody body(&world, static_cast<int>(x.size()), x.data(), mass.data());
  for (const auto& e : net.solids[0].edges) body.appendLink(e[0], e[1]);
  body.m_cfg.piterations = 1;
  for (auto _ : state) {
    body.predictMotion(0.1F);
    body.solveConstraints();
    body.integrateMotion();
    benchmark::DoNotOptimize(body.m_nodes[0].m_x);
  }
  const auto tetrahedra = static_cast<double>(net.solids[0].tetrahedra.size());
  state.counters["tetrahedra"] = tetrahedra;
  state.counters["links"] = static_cast<double>(net.solids[0].edges.size());
  state.counters["tetrahedra/s"] = Counter(tetrahedra, Counter::kIsIterationInvariantRate, Counter::kIs1000);
}
BENCHMARK(BM_BulletLinks)->Arg(21)->Arg(30)->Unit(benchmark::kMicrosecond);
#endif

}  // namespace
