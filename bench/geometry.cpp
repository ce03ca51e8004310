// Surfaces the size of those of a head CT: reduction, smoothing, cutting and queries.
#include "turgor/geometry/tri_mesh.hpp"

#include <benchmark/benchmark.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "turgor/core/parallel.hpp"
#include "turgor/core/random.hpp"
#include "turgor/geometry/embedding.hpp"
#include "turgor/geometry/mesh_edit.hpp"
#include "turgor/geometry/mesh_file.hpp"
#include "turgor/geometry/surface_query.hpp"

namespace {

using namespace turgor;

/// A closed bumpy ball of 12 * cells^2 triangles, radius about 90 mm, points in the order of an iso-surface's
/// sweep: a cube's sides blown up to the sphere.
TriMesh bumpy_ball(int cells) {
  TriMesh mesh;
  const int rim = cells + 1;
  for (int face = 0; face < 6; ++face) {
    for (int j = 0; j < rim; ++j) {
      for (int i = 0; i < rim; ++i) {
        const int axis = face / 2;
        Vec3 p;
        p[axis] = face % 2 ? 1 : -1;
        p[(axis + 1) % 3] = 2.0 * i / cells - 1;
        p[(axis + 2) % 3] = 2.0 * j / cells - 1;
        const Vec3 d = normalized(p);
        const double bump =
            4 * std::sin(9 * d.x) * std::sin(7 * d.y + 1) + std::sin(31 * d.z) * std::cos(29 * d.x);
        mesh.points.push_back(d * (90 + bump));
      }
    }
    for (int j = 0; j < cells; ++j) {
      for (int i = 0; i < cells; ++i) {
        const int p = (face * rim + j) * rim + i, q = p + rim;
        if (face % 2) {
          mesh.triangles.push_back({p, p + 1, q + 1});
          mesh.triangles.push_back({p, q + 1, q});
        } else {
          mesh.triangles.push_back({p, q + 1, p + 1});
          mesh.triangles.push_back({p, q, q + 1});
        }
      }
    }
  }
  // Weld the cube's edges: coordinates there are equal to the bit.
  std::vector<int> order(mesh.points.size()), map(mesh.points.size());
  for (std::size_t i = 0; i < order.size(); ++i) order[i] = static_cast<int>(i);
  const auto key = [&](int i) {
    const Vec3& p = mesh.points[static_cast<std::size_t>(i)];
    return std::array<long, 3>{std::lround(p.x * 1e6), std::lround(p.y * 1e6), std::lround(p.z * 1e6)};
  };
  std::sort(order.begin(), order.end(),
            [&](int a, int b) { return key(a) != key(b) ? key(a) < key(b) : a < b; });
  for (std::size_t i = 0; i < order.size(); ++i) {
    const bool same = i > 0 && key(order[i]) == key(order[i - 1]);
    map[static_cast<std::size_t>(order[i])] = same ? map[static_cast<std::size_t>(order[i - 1])] : order[i];
  }
  for (Index3& t : mesh.triangles) {
    for (int& p : t) p = map[static_cast<std::size_t>(p)];
  }
  return submesh(mesh, std::vector<bool>(mesh.triangles.size(), true));
}

const TriMesh& iso_surface() {
  static const TriMesh mesh = bumpy_ball(204);  // 499 392 triangles
  return mesh;
}
const TriMesh& display_skin() {
  static const TriMesh mesh = bumpy_ball(71);  // 60 492
  return mesh;
}

void decimate_to_a_tenth(benchmark::State& state) {
  const TriMesh& mesh = iso_surface();
  std::size_t left = 0;
  for (auto _ : state) left = decimate(mesh, 49939).triangles.size();
  state.counters["triangles"] = static_cast<double>(left);
}
BENCHMARK(decimate_to_a_tenth)->Unit(benchmark::kMillisecond);

void smooth_ten_rounds(benchmark::State& state) {
  const TriMesh& mesh = iso_surface();
  for (auto _ : state) benchmark::DoNotOptimize(smooth(mesh, 10, 0.1));
}
BENCHMARK(smooth_ten_rounds)->Unit(benchmark::kMillisecond)->UseRealTime();

void clip_with_cap(benchmark::State& state) {
  const TriMesh& mesh = iso_surface();
  for (auto _ : state) benchmark::DoNotOptimize(clip(mesh, {normalized(Vec3{1, 2, 3}), 7}, true));
}
BENCHMARK(clip_with_cap)->Unit(benchmark::kMillisecond);

void normals(benchmark::State& state) {
  const TriMesh& mesh = iso_surface();
  for (auto _ : state) benchmark::DoNotOptimize(point_normals(mesh));
}
BENCHMARK(normals)->Unit(benchmark::kMillisecond)->UseRealTime();

void find_topology(benchmark::State& state) {
  const TriMesh& mesh = iso_surface();
  for (auto _ : state) benchmark::DoNotOptimize(topology(mesh));
}
BENCHMARK(find_topology)->Unit(benchmark::kMillisecond)->UseRealTime();

void find_components(benchmark::State& state) {
  const TriMesh& mesh = iso_surface();
  for (auto _ : state) benchmark::DoNotOptimize(triangle_components(mesh));
}
BENCHMARK(find_components)->Unit(benchmark::kMillisecond)->UseRealTime();

void build_query(benchmark::State& state) {
  const TriMesh& mesh = iso_surface();
  for (auto _ : state) {
    const SurfaceQuery query(mesh);
    benchmark::DoNotOptimize(&query);
  }
}
BENCHMARK(build_query)->Unit(benchmark::kMillisecond)->UseRealTime();

/// Queries per second, both cores.
template <class Ask>
void ask_many(benchmark::State& state, const Ask& ask) {
  constexpr std::size_t count = 100'000;
  const RandomStream random(1);
  for (auto _ : state) {
    parallel_for(count, 1000, [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i) {
        const Vec3 d =
            normalized(Vec3{random.normal(3 * i), random.normal(3 * i + 1), random.normal(3 * i + 2)});
        ask(d);
      }
    });
  }
  state.SetItemsProcessed(static_cast<std::int64_t>(state.iterations() * count));
}

void first_hits(benchmark::State& state) {
  const SurfaceQuery query(display_skin());
  ask_many(state, [&](const Vec3& d) { benchmark::DoNotOptimize(query.first_hit({}, d)); });
}
BENCHMARK(first_hits)->Unit(benchmark::kMillisecond)->UseRealTime();

void nearest_points_close_by(benchmark::State& state) {
  const SurfaceQuery query(display_skin());
  ask_many(state, [&](const Vec3& d) { benchmark::DoNotOptimize(query.nearest(d * 88.0)); });
}
BENCHMARK(nearest_points_close_by)->Unit(benchmark::kMillisecond)->UseRealTime();

void inside_tests(benchmark::State& state) {
  const SurfaceQuery query(display_skin());
  ask_many(state, [&](const Vec3& d) { benchmark::DoNotOptimize(query.inside(d * 80.0)); });
}
BENCHMARK(inside_tests)->Unit(benchmark::kMillisecond)->UseRealTime();

/// A quarter of a million points on a simulation skin of about 5000.
const TriMesh& simulation_skin() {
  static const TriMesh mesh = decimate(display_skin(), 10'000);
  return mesh;
}

void embedding_bind(benchmark::State& state) {
  (void)simulation_skin(), (void)iso_surface();
  for (auto _ : state) {
    const SurfaceEmbedding embedding(simulation_skin(), iso_surface().points, 5, 10);
    benchmark::DoNotOptimize(&embedding);
  }
  state.counters["points"] = static_cast<double>(iso_surface().points.size());
}
BENCHMARK(embedding_bind)->Unit(benchmark::kMillisecond)->UseRealTime();

void embedding_apply(benchmark::State& state) {
  const SurfaceEmbedding embedding(simulation_skin(), iso_surface().points, 5, 10);
  std::vector<Vec3> move;
  for (const Vec3& p : simulation_skin().points)
    move.push_back({0, std::exp(-squared_length(p) / 5000), 0.01 * p.x});
  for (auto _ : state) benchmark::DoNotOptimize(embedding.displacements(move));
}
BENCHMARK(embedding_apply)->Unit(benchmark::kMillisecond)->UseRealTime();

}  // namespace
