// What contact adds to a step: two balls of some 10,000 tetrahedra each, apart and pressed together.
#include <benchmark/benchmark.h>

#include "../tests/support/soft_blocks.hpp"
#include "turgor/core/parallel.hpp"

namespace {

using namespace turgor;
using benchmark::Counter;

enum Where : std::int64_t { kWithoutContact, kApart, kTouching };

constexpr int kRadius = 8;  // voxels of 1 mm

SolidMesh ball() {
  constexpr int n = 2 * kRadius + 2;
  VoxelGrid grid(Index3{n, n, n});
  grid.lower = Vec3{1, 1, 1} * (-0.5 * n);
  for (int k = 0; k < n; ++k)
    for (int j = 0; j < n; ++j)
      for (int i = 0; i < n; ++i)
        if (length(grid.lower + Vec3{i + 0.5, j + 0.5, k + 0.5}) < kRadius) grid.set(i, j, k);
  return *solid_of(grid);
}

/// Heun steps of the longest stable length. Apart, nothing is ever near; touching, the balls lie with their
/// flat sides 0.2 mm within the thickness, and stay.
void BM_ContactStep(benchmark::State& state) {
  set_thread_count(static_cast<int>(state.range(1)));
  const auto where = state.range(0);
  const SolidMesh solid = ball();
  MotionModel model;
  support::Block body;
  body.self = state.range(2) != 0;
  add_body(model, solid, body);
  const double apart = where == kTouching ? 0.8 : 20;
  body.place = RigidTransform::translate({0.3, 0.2, 2 * kRadius + apart});
  add_body(model, solid, body);
  model.damping_g_ms = 1e-3;
  model.contact->thickness_mm = 1;
  model.contact->stiffness_n_mm = 0.01;
  if (where == kWithoutContact) model.contact.reset();
  const auto stepper = TimeStepper::prepare(model);
  MotionState motion = stepper->rest();
  const double dt = 0.9 * stepper->stable_step_ms(motion, Integrator::heun);
  Context context;
  TimeStepper::Workspace workspace;
  int sub_steps = 0;
  for (auto _ : state)
    sub_steps += stepper->step(motion, dt, Integrator::heun, context, workspace)->sub_steps;
  state.counters["tetrahedra"] = static_cast<double>(model.network.volumes.size());
  state.counters["sub_steps"] = Counter(sub_steps, Counter::kAvgIterations);
  state.counters["contacts"] = stepper->contact_measures(motion).contacts;
  set_thread_count(0);
}
BENCHMARK(BM_ContactStep)
    ->ArgNames({"where", "threads", "self"})
    ->ArgsProduct({{kWithoutContact, kApart, kTouching}, {1, 2}, {0, 1}})
    ->Unit(benchmark::kMicrosecond)
    ->UseRealTime();

/// Finding candidates afresh, as after a long way, and finding touches in them.
void BM_FindContact(benchmark::State& state) {
  const SolidMesh solid = ball();
  MotionModel model;
  support::Block body;
  body.self = state.range(0) != 0;
  add_body(model, solid, body);
  body.place = RigidTransform::translate({0.3, 0.2, 2 * kRadius + 0.8});
  add_body(model, solid, body);
  const std::vector<double> inverse_mass(model.network.rest.size(), 1);
  const auto contact = SurfaceContact::prepare(*model.contact, model.network.rest, inverse_mass);
  const std::vector<Vec3>& near = model.network.rest;
  SurfaceContact::Workspace kept;
  for (auto _ : state) {
    if (state.range(1) != 0) kept = {};
    benchmark::DoNotOptimize(contact->find(near, kept).size());
  }
  state.counters["contacts"] = static_cast<double>(kept.touches().size());
}
BENCHMARK(BM_FindContact)
    ->ArgNames({"self", "afresh"})
    ->ArgsProduct({{0, 1}, {0, 1}})
    ->Unit(benchmark::kMicrosecond)
    ->UseRealTime();

}  // namespace
