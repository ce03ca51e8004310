#include "turgor/render/leak_picture.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "turgor/geometry/surface_query.hpp"
#include "turgor/render/annotate.hpp"
#include "turgor/render/ray_tracer.hpp"

namespace turgor {
namespace {

constexpr Vec3f kSurface{0.62F, 0.66F, 0.72F}, kWidest{0.85F, 0.02F, 0.02F}, kOther{0.95F, 0.40F, 0.0F};
constexpr double kCloseUp = 7;        ///< height of the near panel, in radii of the hole
constexpr double kTilt = 0.4;         ///< radians; a hole seen so is as good as one seen squarely
constexpr std::size_t kLidRays = 64;  ///< at most, to tell what is seen of a lid

/// Directions around each way through the lid, those first that show depth as well.
std::vector<Vec3> candidates(const Vec3& normal) {
  const Vec3 n = squared_length(normal) > 0 ? normal : Vec3{0, -1, 0};
  const Vec3 u = any_orthogonal(n), v = cross(n, u);
  std::vector<Vec3> out;
  for (const double way : {1.0, -1.0}) {
    for (const double tilt : {kTilt, 0.0, 2 * kTilt}) {
      for (int a = 0; a < (tilt > 0 ? 8 : 1); ++a) {
        const double angle = a * std::numbers::pi / 4;
        out.push_back(n * (way * std::cos(tilt)) +
                      (u * std::cos(angle) + v * std::sin(angle)) * std::sin(tilt));
      }
    }
  }
  return out;
}

/// Points within the lid.
std::vector<Vec3> lid_points(const SurfaceHole& hole) {
  std::vector<Vec3> points;
  const std::size_t step = 1 + hole.rim.size() / (kLidRays / 2);
  for (std::size_t e = 0; e < hole.rim.size(); e += step) {
    const Vec3 edge = (hole.rim[e][0] + hole.rim[e][1]) * 0.5;
    for (const double part : {0.45, 0.9}) points.push_back(lerp(hole.middle, edge, part));
  }
  return points;
}

TriMesh lid_of(const SurfaceHole& hole) {
  TriMesh lid;
  lid.points.push_back(hole.middle);
  for (const auto& [a, b] : hole.rim) {
    const auto first = static_cast<int>(lid.points.size());
    lid.points.push_back(a), lid.points.push_back(b);
    const bool turned = dot(cross(a - hole.middle, b - hole.middle), hole.normal) < 0;
    lid.triangles.push_back(turned ? Index3{0, first + 1, first} : Index3{0, first, first + 1});
  }
  return lid;
}

CameraView camera_at(const Vec3& target, const Vec3& to_viewer, double height, double depth) {
  CameraView camera;
  camera.target = target, camera.eye = target + to_viewer * depth, camera.height_mm = height;
  // Looking along z, y points up.
  if (std::abs(to_viewer.z) > 0.95) camera.up = {0, 1, 0};
  return camera;
}

void draw_rims(Image& image, const CameraView& camera, const std::vector<SurfaceHole>& holes) {
  for (std::size_t h = holes.size(); h-- > 0;) {
    const Vec3f colour = h == 0 ? kWidest : kOther;
    const double width = std::max(2.0, image.height / (h == 0 ? 160.0 : 260.0));
    for (const auto& [a, b] : holes[h].rim) draw_polyline(image, camera, {a, b}, width, colour);
  }
}

/// A ring about a hole that is small in the picture.
void draw_ring(Image& image, const CameraView& camera, const SurfaceHole& hole) {
  const auto centre = project(camera, image.width, image.height, hole.middle);
  if (!centre) return;
  const double unit = image.height / camera.height_mm;
  const double radius = std::max(0.7 * length(hole.box.size()) * unit, image.height / 28.0);
  constexpr int steps = 72;
  const auto at = [&](int s) { return 2 * std::numbers::pi * s / steps; };
  for (int s = 0; s < steps; ++s) {
    draw_segment(image, centre->x + radius * std::cos(at(s)), centre->y + radius * std::sin(at(s)),
                 centre->x + radius * std::cos(at(s + 1)), centre->y + radius * std::sin(at(s + 1)),
                 std::max(1.5, image.height / 300.0), kWidest);
  }
}

/// To two digits, without minus zero.
double rounded(double x) {
  return std::round(100 * x) / 100 + 0.0;
}

Result<void> check(const std::vector<SurfaceHole>& holes, const LeakPictureOptions& options) {
  if (holes.empty()) return Error{ErrorKind::bad_input, "the surface has no hole to show", "", ""};
  if (options.size < 64 || options.size > 4096 || options.samples < 1 || options.samples > 4096) {
    return Error{
        ErrorKind::bad_input,
        fmt::format("a picture of {} pixels with {} rays each cannot be made", options.size, options.samples),
        "", "Give 64 to 4096 pixels, and 1 to 4096 rays"};
  }
  return {};
}

}  // namespace

Vec3 best_view(const TriMesh& surface, const SurfaceHole& hole) {
  const SurfaceQuery query(surface);
  const std::vector<Vec3> points = lid_points(hole);
  const double near = 1e-6 * (length(bounds(surface).size()) + 1e-300);
  Vec3 best = hole.normal;
  double best_score = -1;
  for (const Vec3& to_viewer : candidates(hole.normal)) {
    const auto seen = std::count_if(points.begin(), points.end(), [&](const Vec3& p) {
      return !query.first_hit(p, to_viewer, near).has_value();
    });
    const double score =
        static_cast<double>(seen) * std::clamp(std::abs(dot(to_viewer, hole.normal)), 0.1, std::cos(kTilt));
    if (score > best_score + 1e-9) best_score = score, best = to_viewer;
  }
  return best;
}

Result<Image> leak_picture(const TriMesh& surface, const std::vector<SurfaceHole>& holes,
                           const LeakPictureOptions& options, Context& context) {
  const Stage stage(context, "picture of the leak");
  TURGOR_CHECK(check(holes, options));
  const SurfaceHole& widest = holes[0];
  const TriMesh lid = lid_of(widest);
  TURGOR_TRY(const Renderer renderer, Renderer::create({{&surface, {MaterialKind::plain, kSurface}, {}},
                                                        {&lid, {MaterialKind::plain, kWidest, 0.45}, {}}},
                                                       context));
  const Vec3 to_viewer = best_view(surface, widest);
  const Box3 box = bounds(surface);
  const double whole = 1.08 * length(box.size());
  const double near = std::min(whole, std::max(kCloseUp * widest.radius, 1.5 * length(widest.box.size())));
  RenderOptions render;
  render.width = render.height = options.size, render.samples = options.samples;
  std::vector<Image> panels;
  for (const CameraView& camera : {camera_at(box.centre(), to_viewer, whole, 2 * whole),
                                   camera_at(widest.middle, to_viewer, near, 2 * whole)}) {
    TURGOR_TRY(Image image, renderer.render(camera, render, context));
    draw_rims(image, camera, holes);
    if (panels.empty()) draw_ring(image, camera, widest);
    draw_scale_bar(image, camera);
    panels.push_back(std::move(image));
  }
  const std::string count = holes.size() == 1 ? "one hole" : fmt::format("{} holes", holes.size());
  return side_by_side(panels,
                      {fmt::format("{}, seen from ({:g}, {:g}, {:g})", count, rounded(to_viewer.x),
                                   rounded(to_viewer.y), rounded(to_viewer.z)),
                       widest.text()},
                      2);
}

}  // namespace turgor
