// The scripts of the thesis (Pieper 1989, chapter 6) without pictures, from the first command to the last
// step: `times` tells how much faster than real time.
#include <benchmark/benchmark.h>

#include <string>

#include "turgor/commands/session.hpp"
#include "turgor/core/parallel.hpp"

namespace {

using namespace turgor;
using benchmark::Counter;

std::string wound_closure() {
  std::string script = R"(
instance_object fusiform
flesh_out fusiform -dfth 0.07 -sfth 0.07 -me 1
)";
  const char* const names[] = {"bonesuture", "smassuture", "skinsuture"};
  for (int layer = 0; layer < 3; ++layer) {
    const std::string where = " " + std::to_string(layer) + " " + std::to_string(layer) + " -c 5 -m 4\n";
    for (const char* points : {"102 103", "91 92", "81 82", "70 71"})
      script += std::string("add_muscle ") + names[layer] + " " + points + where;
    script += std::string("setup twitch ") + names[layer] + " 0 1 5 0.1 10 0.01 40 0.01 50 .5 -start 0.5\n";
  }
  return script + "damping 0.2\nsimulate -dt 0.01 -skip 5 -runge_kutta -until 100\n";
}

constexpr auto kBallDrape = R"(
instance_object grid.10.10 sourcegrid
instance_object sphere.obj ball
instance_object grid.5.5 floor
edit_xform floor -t 0 0 -0.2501 -s 4 4 1
flesh_out sourcegrid -dfth 0.1 -sfth 0.1 -me 1
gravity_face -g 0.1
drape -c 1000 -s ball
drape -c 1000 -p floor
damping 0.2
simulate -dt 0.05 -skip 2 -runge_kutta -until 50
)";

constexpr auto kTwitch = R"(
instance_object grid.10.10 sourcegrid
edit_xform sourcegrid -r 0 10 0
harden sourcegrid
instance_object grid.5.5 floor
edit_xform floor -t 0 0 -0.4501 -s 4 4 1
flesh_out sourcegrid -sc 2 -dfth 0.1 -sfth 0.1 -me 1
gravity_face -g 0.1
drape -c 1000 -p floor
add_muscle muscle 13 83 1 1 -m 4 -c 20
add_muscle muscle 33 63 1 1 -m 4 -c 20
add_muscle muscle 14 84 1 1 -m 4 -c 20
add_muscle muscle 34 64 1 1 -m 4 -c 20
add_muscle muscle 15 85 1 1 -m 4 -c 20
add_muscle muscle 35 65 1 1 -m 4 -c 20
setup twitch muscle 0 1 10 0.3 30 0.3 40 1 -start 2
damping 0.3
simulate -dt 0.05 -skip 5 -runge_kutta -until 50
)";

/// On one thread, which is all that networks of one block take.
void BM_Script(benchmark::State& state, const std::string& script, double simulated_s) {
  set_thread_count(1);
  for (auto _ : state) {
    Context context;
    Session session({}, context);
    Result<void> done = session.enter_text(script, "script");
    if (done) done = session.run();
    if (!done) {
      state.SkipWithError(done.error().message().c_str());
      break;
    }
  }
  set_thread_count(0);
  state.counters["times"] = Counter(simulated_s, Counter::kIsIterationInvariantRate);
}
BENCHMARK_CAPTURE(BM_Script, wound_closure, wound_closure(), 100)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(BM_Script, balldrape, kBallDrape, 50)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(BM_Script, twitch, kTwitch, 50)->Unit(benchmark::kMillisecond);

}  // namespace
