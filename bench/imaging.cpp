// Surfaces, masks and filters on a whole head scan: the real one of the Debian package invesalius-examples
// where it is installed, else a synthetic head of the same size (the label says which). The argument is the
// number of threads.
#include <benchmark/benchmark.h>

#include <cmath>
#include <filesystem>

#include "turgor/core/parallel.hpp"
#include "turgor/core/random.hpp"
#include "turgor/imaging/filter.hpp"
#include "turgor/imaging/histogram.hpp"
#include "turgor/imaging/isosurface.hpp"
#include "turgor/imaging/scan.hpp"
#include "turgor/imaging/segmentation.hpp"

namespace turgor {
namespace {

constexpr double kSkin = -200, kBone = 226;

/// Skin, fat, a skull with diploe, brain and noise as nested ellipsoids.
CtVolume synthetic_head() {
  Grid grid;
  grid.size = {256, 256, 108};
  grid.spacing = {0.957, 0.957, 1.5};
  CtVolume volume(grid);
  const RandomStream random(1);
  for (int k = 0; k < grid.size[2]; ++k) {
    for (int j = 0; j < grid.size[1]; ++j) {
      for (int i = 0; i < grid.size[0]; ++i) {
        const Vec3 p{(i - 127.5) / 95, (j - 127.5) / 110, (k - 20.0) / 75};
        const double depth = 90 * (1 - length(p));  // mm, nearly
        const double value = depth < 0    ? -1000
                             : depth < 2  ? 50
                             : depth < 6  ? -80
                             : depth < 8  ? 1400
                             : depth < 11 ? 600
                             : depth < 13 ? 1400
                                          : 20;
        const std::size_t v = grid.offset(i, j, k);
        volume.voxels[v] = static_cast<std::int16_t>(std::lround(value + 12 * random.normal(v)));
      }
    }
  }
  return volume;
}

struct Input {
  CtVolume volume;
  const char* name;
};

const Input& input() {
  static const Input head = [] {
    const std::filesystem::path path = "/usr/share/doc/invesalius-examples/examples/Cranium.inv3";
    Context context;
    if (std::filesystem::exists(path)) {
      if (Result<Scan> scan = read_scan(path, {}, context)) return Input{std::move(scan->hu), "real scan"};
    }
    return Input{synthetic_head(), "synthetic head"};
  }();
  return head;
}

/// Runs body() on the number of threads that the benchmark's argument names.
template <class Body>
void measure(benchmark::State& state, Body&& body) {
  state.SetLabel(input().name);
  set_thread_count(static_cast<int>(state.range(0)));
  for (auto _ : state) benchmark::DoNotOptimize(body());
  set_thread_count(0);
}

void SkinSurface(benchmark::State& state) {
  measure(state, [] { return isosurface(input().volume, kSkin); });
}
void BoneSurface(benchmark::State& state) {
  measure(state, [] { return isosurface(input().volume, kBone); });
}
void BoneSurfaceWithin(benchmark::State& state) {
  const LabelVolume bone = threshold(input().volume, static_cast<int>(kBone), 4000);
  measure(state, [&] { return isosurface_within(input().volume, kBone, bone, 1, -1000); });
}
void SkinSurfaceOfLabel(benchmark::State& state) {
  const LabelVolume head = fill_holes(threshold(input().volume, static_cast<int>(kSkin), 4000));
  measure(state, [&] { return isosurface_of_label(input().volume, kSkin, head); });
}
void RefineBoneSurface(benchmark::State& state) {
  const TriMesh start = isosurface(input().volume, kBone);
  state.counters["points"] = static_cast<double>(start.points.size());
  measure(state, [&] {
    TriMesh mesh = start;
    return refine_to_local_level(mesh, input().volume, 3, 1.5);
  });
}
void Threshold(benchmark::State& state) {
  measure(state, [] { return threshold(input().volume, static_cast<int>(kBone), 4000); });
}
void HistogramOfScan(benchmark::State& state) {
  measure(state, [] { return histogram(input().volume); });
}
void MedianFilter(benchmark::State& state) {
  measure(state, [] { return median_filter(input().volume); });
}
void ConnectedComponents(benchmark::State& state) {
  const LabelVolume bone = threshold(input().volume, static_cast<int>(kBone), 4000);
  measure(state, [&] { return connected_components(bone); });
}
void LargestComponent(benchmark::State& state) {
  const LabelVolume bone = threshold(input().volume, static_cast<int>(kBone), 4000);
  measure(state, [&] { return largest_component(bone); });
}
void FillHoles(benchmark::State& state) {
  const LabelVolume head = threshold(input().volume, static_cast<int>(kSkin), 4000);
  measure(state, [&] { return fill_holes(head); });
}
void DistanceWhole(benchmark::State& state) {
  const LabelVolume bone = threshold(input().volume, static_cast<int>(kBone), 4000);
  measure(state, [&] { return distance_to(bone); });
}
void DistanceWithin5Mm(benchmark::State& state) {
  const LabelVolume bone = threshold(input().volume, static_cast<int>(kBone), 4000);
  measure(state, [&] { return distance_to(bone, 5); });
}
void CloseGaps10Mm(benchmark::State& state) {
  const LabelVolume head = threshold(input().volume, static_cast<int>(kSkin), 4000);
  measure(state, [&] { return close_gaps(head, 10); });
}
void GrowErodedPieces(benchmark::State& state) {
  const LabelVolume bone = threshold(input().volume, static_cast<int>(kBone), 4000);
  const Components pieces = connected_components(erode(bone, 1.6));
  LabelVolume seeds(bone.grid);
  for (std::size_t v = 0; v < seeds.voxels.size(); ++v) {
    seeds.voxels[v] = static_cast<std::uint8_t>(std::min(pieces.labels.voxels[v], 255));
  }
  measure(state, [&] { return grow_labels(bone, seeds); });
}

void one_and_two_threads(benchmark::internal::Benchmark* b) {
  b->Arg(1)->Arg(2)->Unit(benchmark::kMillisecond)->UseRealTime();
}

BENCHMARK(SkinSurface)->Apply(one_and_two_threads);
BENCHMARK(BoneSurface)->Apply(one_and_two_threads);
BENCHMARK(BoneSurfaceWithin)->Apply(one_and_two_threads);
BENCHMARK(SkinSurfaceOfLabel)->Apply(one_and_two_threads);
BENCHMARK(RefineBoneSurface)->Apply(one_and_two_threads);
BENCHMARK(Threshold)->Apply(one_and_two_threads);
BENCHMARK(HistogramOfScan)->Apply(one_and_two_threads);
BENCHMARK(MedianFilter)->Apply(one_and_two_threads);
BENCHMARK(ConnectedComponents)->Apply(one_and_two_threads);
BENCHMARK(LargestComponent)->Apply(one_and_two_threads);
BENCHMARK(FillHoles)->Apply(one_and_two_threads);
BENCHMARK(DistanceWhole)->Apply(one_and_two_threads);
BENCHMARK(DistanceWithin5Mm)->Apply(one_and_two_threads);
BENCHMARK(CloseGaps10Mm)->Apply(one_and_two_threads);
BENCHMARK(GrowErodedPieces)->Apply(one_and_two_threads);

}  // namespace
}  // namespace turgor
