// Surfaces that follow a solid: the bunny of 50,000 faces on its voxels, about 13,000 tetrahedra, as in
// section 4.3 of Morris (2006). A ball stands in where the bunny is not at hand.
#include <benchmark/benchmark.h>

#include <cmath>

#include "inputs.hpp"
#include "turgor/core/parallel.hpp"
#include "turgor/geometry/mesh_edit.hpp"
#include "turgor/geometry/mesh_file.hpp"
#include "turgor/geometry/solid_skin.hpp"
#include "turgor/geometry/tetra_embedding.hpp"
#include "turgor/geometry/voxel_solid.hpp"

namespace {

using namespace turgor;

TriMesh ball() {
  TriMesh mesh;
  constexpr int around = 250, up = 100;
  for (int i = 0; i < around; ++i) {
    for (int j = 0; j < up; ++j) {
      const double a = radians(360) * i / around, b = radians(180) * (j + 0.5) / up;
      mesh.points.push_back(Vec3{std::sin(b) * std::cos(a), std::sin(b) * std::sin(a), std::cos(b)} * 75.0);
      const int next = (i + 1) % around * up + j, here = i * up + j;
      if (j + 1 == up) continue;
      mesh.triangles.push_back({here, here + 1, next});
      mesh.triangles.push_back({next, here + 1, next + 1});
    }
  }
  return mesh;
}

/// Turned or bent by 90 degrees from the bottom to the top of `box`, along y.
Vec3 twisted(const Vec3& p, const Box3& box) {
  const Vec3 d = p - box.centre();
  const double a = radians(90) * (p.y - box.lower.y) / box.size().y, c = std::cos(a), s = std::sin(a);
  return {c * d.x - s * d.z, d.y, s * d.x + c * d.z};
}
Vec3 bent(const Vec3& p, const Box3& box) {
  const Vec3 d = p - box.centre();
  const double radius = box.size().y / radians(90), a = (p.y - box.lower.y) / radius;
  return {radius - (radius - d.x) * std::cos(a), (radius - d.x) * std::sin(a), d.z};
}

struct Scene {
  TriMesh skin;
  SolidMesh solid;
  std::vector<Vec3> moved;

  Scene() {
    const auto bunny = bench::bunny_surface();
    skin = bunny ? decimate(*bunny, 50'000) : ball();
    for (Vec3& p : skin.points) p *= bunny ? 1000 : 1;  // metres
    VoxelOptions options;
    options.resolution = bunny ? 21 : 15;
    solid = bench::solid_in(skin, options).value_or(SolidMesh{});
    for (const Vec3& p : solid.points) moved.push_back(twisted(p, bounds(skin)));
  }
};

const Scene& scene() {
  static const Scene scene;
  return scene;
}

void describe(benchmark::State& state) {
  state.counters["faces"] = static_cast<double>(scene().skin.triangles.size());
  state.counters["tetrahedra"] = static_cast<double>(scene().solid.tetrahedra.size());
}

void bind_skin(benchmark::State& state) {
  describe(state);
  for (auto _ : state) benchmark::DoNotOptimize(SolidSkin::bind(scene().solid, scene().skin));
}
BENCHMARK(bind_skin)->Unit(benchmark::kMillisecond)->UseRealTime();

/// Threads; whether normals are made.
void apply_skin(benchmark::State& state) {
  const auto skin = SolidSkin::bind(scene().solid, scene().skin);
  std::vector<Vec3> points(scene().skin.points.size()), normals(state.range(1) ? points.size() : 0);
  set_thread_count(static_cast<int>(state.range(0)));
  for (auto _ : state) {
    skin->apply(scene().moved, points, normals);
    benchmark::DoNotOptimize(points.data());
  }
  set_thread_count(0);
  // What is bound and what comes out, once each: six votes of 20 bytes and 24 of position a point, and for
  // normals five directions of 12 bytes and 24 of normal.
  const double bytes =
      static_cast<double>(points.size()) * (6 * 20 + 24 + (normals.empty() ? 0 : 5 * 12 + 24));
  state.SetBytesProcessed(static_cast<std::int64_t>(bytes) * state.iterations());
}
BENCHMARK(apply_skin)
    ->ArgsProduct({{1, 2}, {0, 1}})
    ->ArgNames({"threads", "normals"})
    ->Unit(benchmark::kMicrosecond)
    ->UseRealTime();

void bind_barycentric(benchmark::State& state) {
  describe(state);
  const auto& [skin, solid, moved] = scene();
  for (auto _ : state)
    benchmark::DoNotOptimize(TetraEmbedding::bind(solid.points, solid.tetrahedra, skin.points));
}
BENCHMARK(bind_barycentric)->Unit(benchmark::kMillisecond)->UseRealTime();

/// 35,000 points through the bunny's box, more than half of them outside, in some 36,000 tetrahedra.
void bind_barycentric_cloud(benchmark::State& state) {
  VoxelOptions options;
  options.resolution = 30;
  const auto voxels = voxelise(scene().skin, options);
  const auto solid = solid_of(*voxels);
  const Box3 box = bounds(scene().skin);
  std::vector<Vec3> targets;
  for (int i = 0; i < 35'000; ++i) {
    const auto part = [&](double step) { return std::fmod(i * step, 1.0); };  // a quasi-random sequence
    const Vec3 size = box.size();
    targets.push_back(box.lower + Vec3{size.x * part(0.8191725134), size.y * part(0.6710436067),
                                       size.z * part(0.5497004779)});
  }
  for (auto _ : state)
    benchmark::DoNotOptimize(TetraEmbedding::bind(solid->points, solid->tetrahedra, targets));
  state.counters["tetrahedra"] = static_cast<double>(solid->tetrahedra.size());
}
BENCHMARK(bind_barycentric_cloud)->Unit(benchmark::kMillisecond)->UseRealTime();

void apply_barycentric(benchmark::State& state) {
  const auto& [skin, solid, moved] = scene();
  const auto embedding = TetraEmbedding::bind(solid.points, solid.tetrahedra, skin.points);
  std::vector<Vec3> points(skin.points.size());
  set_thread_count(static_cast<int>(state.range(0)));
  for (auto _ : state) {
    embedding->apply(moved, points);
    benchmark::DoNotOptimize(points.data());
  }
  set_thread_count(0);
  state.SetBytesProcessed(static_cast<std::int64_t>(points.size() * (48 + 16 + 24)) * state.iterations());
}
BENCHMARK(apply_barycentric)
    ->Arg(1)
    ->Arg(2)
    ->ArgName("threads")
    ->Unit(benchmark::kMicrosecond)
    ->UseRealTime();

/// How far each way is from the motion itself: see docs/models.md. Times mean nothing here.
void shape(benchmark::State& state) {
  const auto& [skin, solid, unused] = scene();
  const Box3 box = bounds(skin);
  const auto motion = state.range(0) ? bent : twisted;
  TriMesh truth = skin;
  for (Vec3& p : truth.points) p = motion(p, box);
  std::vector<Vec3> positions;
  for (const Vec3& p : solid.points) positions.push_back(motion(p, box));
  TriMesh carried = skin;
  for (auto _ : state) {
    if (const auto neighbours = static_cast<int>(state.range(1))) {
      SolidSkin::bind(solid, skin, neighbours)->apply(positions, carried.points, {});
    } else {
      TetraEmbedding::bind(solid.points, solid.tetrahedra, skin.points)->apply(positions, carried.points);
    }
  }
  const auto off = difference(truth, carried);
  double turned = 0;
  for (const Index3& t : skin.triangles)
    turned += dot(triangle_normal(carried, t), triangle_normal(truth, t)) < 0;
  state.counters["rms_mm"] = off->root_mean_square_mm;
  state.counters["greatest_mm"] = off->greatest_mm;
  state.counters["normals_deg"] = off->mean_normal_angle_deg;
  state.counters["turned_faces"] = turned;
  state.counters["volume_percent"] = 100 * (enclosed_volume(carried) / enclosed_volume(truth) - 1);
}
BENCHMARK(shape)->ArgsProduct({{0, 1}, {0, 1, 5, 16}})->ArgNames({"bent", "neighbours"})->Iterations(1);

/// What the memory gives for as many bytes as apply_skin moves: the roof.
void copy(benchmark::State& state) {
  const std::size_t count = 5'000'000 / sizeof(Vec3);
  const std::vector<Vec3> from(count, Vec3{1, 2, 3});
  std::vector<Vec3> to(count);
  set_thread_count(static_cast<int>(state.range(0)));
  for (auto _ : state) {
    parallel_for(count, 4096, [&](std::size_t begin, std::size_t end) {
      std::copy(from.data() + begin, from.data() + end, to.data() + begin);
    });
    benchmark::DoNotOptimize(to.data());
  }
  set_thread_count(0);
  state.SetBytesProcessed(static_cast<std::int64_t>(2 * count * sizeof(Vec3)) * state.iterations());
}
BENCHMARK(copy)->Arg(1)->Arg(2)->ArgName("threads")->Unit(benchmark::kMicrosecond)->UseRealTime();

}  // namespace
