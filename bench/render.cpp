// Pictures of a head-sized skin of about 200,000 triangles, as in the reports, and of a scene, as in movies.
#include <benchmark/benchmark.h>

#include <cmath>

#include "../tests/render/draped_scene.hpp"
#include "turgor/render/ray_tracer.hpp"
#include "turgor/render/scene_pictures.hpp"

namespace turgor {
namespace {

/// An egg with a nose, a chin and ripples: folds and shadows like a face's, at any resolution.
TriMesh bumpy_head(int rings) {
  TriMesh mesh;
  const int sectors = 2 * rings;
  const auto radius = [](const Vec3& d) {
    const auto bump = [&](const Vec3& at, double width, double height) {
      return height * std::exp(-squared_length(d - normalized(at)) / (width * width));
    };
    return 90 + bump({0, -1, -0.1}, 0.14, 26) + bump({0, -1, -0.75}, 0.25, 14) +
           bump({1, 0.1, -0.1}, 0.15, 22) + bump({-1, 0.1, -0.1}, 0.15, 22) - bump({0.35, -1, 0.2}, 0.18, 9) -
           bump({-0.35, -1, 0.2}, 0.18, 9) + 0.8 * std::sin(40 * d.z) * std::sin(30 * d.x);
  };
  for (int r = 0; r <= rings; ++r)
    for (int s = 0; s < sectors; ++s) {
      const double theta = radians(180.0 * (r + 0.5) / (rings + 1)), phi = radians(360.0 * s / sectors);
      const Vec3 d{std::sin(theta) * std::cos(phi), std::sin(theta) * std::sin(phi), std::cos(theta)};
      const double length_mm = radius(d);
      mesh.points.push_back({d.x * length_mm * 0.85, d.y * length_mm, d.z * length_mm * 1.2});
    }
  for (int r = 0; r < rings; ++r)
    for (int s = 0; s < sectors; ++s) {
      const int a = r * sectors + s, b = r * sectors + (s + 1) % sectors;
      mesh.triangles.push_back({a, a + sectors, b});
      mesh.triangles.push_back({b, a + sectors, b + sectors});
    }
  return mesh;
}

Box3 box_of(const TriMesh& mesh) {
  Box3 box;
  for (const Vec3& p : mesh.points) box.extend(p);
  return box;
}

constexpr int rings_for_200k = 224;

void CreateRenderer(benchmark::State& state) {
  const TriMesh head = bumpy_head(rings_for_200k);
  Context context;
  for (auto _ : state)
    benchmark::DoNotOptimize(Renderer::create({{&head, {MaterialKind::skin}, {}}}, context));
  state.counters["triangles"] = static_cast<double>(head.triangles.size());
}
BENCHMARK(CreateRenderer)->Unit(benchmark::kMillisecond)->MeasureProcessCPUTime()->UseRealTime();

void take_pictures(benchmark::State& state, const std::vector<Body>& bodies, const Box3& box,
                   StandardView view) {
  Context context;
  const auto renderer = Renderer::create(bodies, context);
  const RenderOptions options;
  for (auto _ : state) benchmark::DoNotOptimize(renderer->render(standard_view(view, box), options, context));
}

void SkinPicture(benchmark::State& state) {
  const TriMesh head = bumpy_head(rings_for_200k);
  take_pictures(state, {{&head, {MaterialKind::skin}, {}}}, box_of(head),
                static_cast<StandardView>(state.range(0)));
}
BENCHMARK(SkinPicture)
    ->Arg(0)
    ->Arg(1)
    ->Arg(3)
    ->ArgName("view")
    ->Unit(benchmark::kMillisecond)
    ->MeasureProcessCPUTime()
    ->UseRealTime();

void SuperimposedPicture(benchmark::State& state) {
  const TriMesh head = bumpy_head(rings_for_200k);
  TriMesh before = head;
  for (Vec3& p : before.points)
    if (p.y < 0 && p.z < -40) p.y -= 6;
  take_pictures(state,
                {{&head, {MaterialKind::skin}, {}},
                 {&before, {MaterialKind::plain, {0.1f, 0.25f, 0.75f}, 0.35, true}, {}}},
                box_of(head), StandardView::profile_right);
}
BENCHMARK(SuperimposedPicture)->Unit(benchmark::kMillisecond)->MeasureProcessCPUTime()->UseRealTime();

void EncodePng(benchmark::State& state) {
  const TriMesh head = bumpy_head(rings_for_200k);
  Context context;
  const auto image = render({{&head, {MaterialKind::skin}, {}}},
                            standard_view(StandardView::front, box_of(head)), RenderOptions{}, context);
  for (auto _ : state) benchmark::DoNotOptimize(encode_png(*image));
}
BENCHMARK(EncodePng)->Unit(benchmark::kMillisecond)->MeasureProcessCPUTime()->UseRealTime();

/// A frame of a movie: tissue of some 500 points a layer with its springs as lines, on a floor.
void SceneFrame(benchmark::State& state) {
  Scene scene;
  Context context;
  ScenePictureOptions options;
  options.samples = 4;
  if (!render_tests::add_draped_scene(scene, 23, 2)) state.SkipWithError("the scene cannot be built");
  scene.screen.viewports[0].stereo = state.range(0) != 0;
  for (auto _ : state) benchmark::DoNotOptimize(draw_screen(scene, options, context));
}
BENCHMARK(SceneFrame)
    ->ArgName("stereo")
    ->Arg(0)
    ->Arg(1)
    ->Unit(benchmark::kMillisecond)
    ->MeasureProcessCPUTime()
    ->UseRealTime();

}  // namespace
}  // namespace turgor
