#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "render/calibration_sections.hpp"
#include "render/calibration_view.hpp"
#include "render/shown_solid.hpp"
#include "turgor/core/index.hpp"
#include "turgor/render/calibration_report.hpp"
#include "turgor/render/plot.hpp"
#include "turgor/render/ray_tracer.hpp"

namespace turgor {

using namespace render_detail;

namespace {

constexpr Vec3f kPlain{0.62f, 0.64f, 0.66f}, kHeld{0.10f, 0.25f, 0.75f}, kForce{0.02f, 0.42f, 0.10f},
    kDisplaced{0.75f, 0.30f, 0.02f}, kOutline{0.05f, 0.12f, 0.40f}, kRestOutline{0.30f, 0.30f, 0.32f};
/// From the right, the front and above.
constexpr Vec3 kSeenFrom{0.5, -1, 0.8};

std::vector<double> distances(std::span<const Vec3> a, std::span<const Vec3> b) {
  std::vector<double> out;
  for (std::size_t p = 0; p < a.size(); ++p) out.push_back(distance(a[p], b[p]));
  return out;
}

/// All but two in a hundred are smaller: a point under a load does not take the colours from all others.
double nearly_greatest(std::vector<double> values) {
  if (values.empty()) return 0;
  const auto rank = values.begin() + (std::ssize(values) - 1) * 98 / 100;
  std::ranges::nth_element(values, rank);
  return *rank;
}

/// Another shape of the body, drawn as a line.
struct Outline {
  std::span<const Vec3> positions;
  Vec3f colour;
};

class Studio {
 public:
  static Result<Studio> create(const CalibrationResults& results, const PictureOptions& options,
                               Context& context) {
    const CalibrationCase& problem = results.problem;
    const auto* body = std::get_if<SurfaceBody>(&problem.options().body);
    TURGOR_TRY(ShownSolid shown, ShownSolid::create(problem.mesh(), body ? &body->surface : nullptr));
    return Studio(results, std::move(shown), options, context);
  }

  /// Undeformed, reference, uncalibrated, calibrated.
  Result<Picture> load_picture(std::size_t l) {
    const PreparedLoad& load = results_.problem.loads()[l];
    const LoadShapes& shapes = results_.outcome.loads[l];
    const LoadFit& fit = results_.outcome.fit.loads[l];
    const std::vector<double> before = distances(shapes.guess, load.reference),
                              after = distances(shapes.calibrated, load.reference);
    const double top = round_up(std::max(nearly_greatest(before), nearly_greatest(after)));
    std::vector<Image> panels;
    const auto add = [&](const Image& image, const std::string& caption) {
      panels.push_back(captioned(image, caption));
    };
    const Outline from_rest{results_.problem.mesh().points, kRestOutline},
        from_reference{load.reference, kOutline};
    TURGOR_TRY(const Image rest, undeformed(load));
    add(rest, "(a) undeformed");
    TURGOR_TRY(const Image reference, shape(load.reference, {}, 1, from_rest));
    add(reference, "(b) reference");
    TURGOR_TRY(const Image guess, shape(shapes.guess, before, top, from_reference));
    add(guess, "(c) uncalibrated: " + error_text(results_, fit.before));
    TURGOR_TRY(const Image calibrated, shape(shapes.calibrated, after, top, from_reference));
    add(calibrated, "(d) calibrated: " + error_text(results_, fit.after));
    return Picture{
        fmt::format("load_{}", l + 1),
        fmt::format(
            "{}{}. (a) What holds the body in blue, forces in green. (b) With the outline of the "
            "undeformed body. (c) and (d) Distance of each point from the reference, whose outline is "
            "drawn in blue",
            load.name, load.held_out ? ", not calibrated with" : ""),
        encode_png(
            with_legend(side_by_side(panels, {}, 2), 0, top, "error, mm", light_colour_map, letters(rest)))};
  }

  /// The reference's modulus and the calibrated constants, on the body at rest.
  Result<Picture> constants_picture() {
    std::vector<Image> panels;
    TURGOR_TRY(const Image modulus, field("E", 2, moduli()));
    panels.push_back(captioned(modulus, "Young's modulus of the reference"));
    for (std::size_t c = 0; c < 3; ++c) {
      const std::string name(kSolidConstants[c]);
      TURGOR_TRY(const Image image, field(name, c, results_.outcome.stiffness[c]));
      panels.push_back(captioned(image, "calibrated " + name));
    }
    return Picture{"constants",
                   "The reference's modulus, and the calibrated constants over the volume that an element "
                   "stands for, on the body at rest",
                   encode_png(side_by_side(panels, {}, 2))};
  }

 private:
  Studio(const CalibrationResults& results, ShownSolid shown, const PictureOptions& options, Context& context)
      : results_(results), shown_(std::move(shown)), context_(context) {
    render_.width = options.width, render_.height = options.height, render_.samples = options.samples;
    const CalibrationCase& problem = results.problem;
    std::vector<Vec3> all(problem.mesh().points.begin(), problem.mesh().points.end());
    Box3 box;
    for (const Vec3& p : all) box.extend(p);
    size_mm_ = length(box.size());
    for (std::size_t l = 0; l < problem.loads().size(); ++l) {
      for (const auto* shape : {&problem.loads()[l].reference, &results.outcome.loads[l].guess,
                                &results.outcome.loads[l].calibrated}) {
        // A guess that is far off does not shrink all others.
        for (const Vec3& p : *shape)
          if (distance(p, box.centre()) < 1.2 * size_mm_) all.push_back(p);
      }
    }
    camera_ =
        camera_about(all, problem.options().seen_from.value_or(kSeenFrom), render_.width, render_.height);
  }

  Result<Image> draw(const std::vector<Body>& bodies) {
    TURGOR_CHECK(context_.check());
    TURGOR_TRY(const Renderer renderer, Renderer::create(bodies, context_));
    return renderer.render(camera_, render_, context_);
  }

  Result<Image> undeformed(const PreparedLoad& load) {
    const CalibrationCase& problem = results_.problem;
    Body body;
    const TriMesh mesh = shown_.shape(problem.mesh().points);
    body.mesh = &mesh;
    body.point_colours = colours_of(load);
    TURGOR_TRY(Image image, draw({body}));
    draw_forces(image, load);
    draw_scale_bar(image, camera_, letters(image));
    return image;
  }

  /// What is held, and what the load displaces.
  [[nodiscard]] std::vector<Vec3f> colours_of(const PreparedLoad& load) const {
    std::vector<Vec3> parts(results_.problem.mesh().points.size());
    for (const int p : results_.problem.held()) parts[at(p)].x = 1;
    for (const NodeSupport& s : load.displaced) parts[at(s.node)].y = 1;
    std::vector<Vec3f> colours;
    for (const Vec3& part : shown_.carried(parts))
      colours.push_back(part.x > 0.5 ? kHeld : part.y > 0.5 ? kDisplaced : kPlain);
    return colours;
  }

  /// Arrows at points that can be told apart.
  void draw_forces(Image& image, const PreparedLoad& load) const {
    const auto& points = results_.problem.mesh().points;
    std::vector<PicturePoint> tips;
    const auto draw_at = [&](const Vec3& tip, const Vec3& along, const Vec3f& colour) {
      const auto seen = project(camera_, image.width, image.height, tip);
      const double room = 0.08 * image.height;
      const auto near = [&](const PicturePoint& t) {
        return std::hypot(t.x - seen->x, t.y - seen->y) < room;
      };
      if (!seen || std::ranges::any_of(tips, near)) return;
      tips.push_back(*seen);
      draw_arrow(image, camera_, tip, along, 0.12 * size_mm_, colour);
    };
    for (std::size_t p = 0; p < load.force_n.size(); ++p)
      if (length(load.force_n[p]) > 0) draw_at(points[p], load.force_n[p], kForce);
    for (const NodeSupport& s : load.displaced) draw_at(points[at(s.node)], s.displacement_mm, kDisplaced);
  }

  Result<Image> shape(const std::vector<Vec3>& positions, const std::vector<double>& errors, double top,
                      const Outline& outline) {
    if (positions.empty()) return nothing_to_show();
    const TriMesh mesh = shown_.shape(positions);
    Body body;
    body.mesh = &mesh, body.material.colour = kPlain;
    if (!errors.empty())
      for (const double e : shown_.carried(errors)) body.point_colours.push_back(light_colour_map(e / top));
    std::vector<Body> bodies{body};
    const TriMesh other = shown_.shape(outline.positions);
    bodies.push_back({&other, {MaterialKind::plain, outline.colour, 0, true}, {}});
    return draw(bodies);
  }

  [[nodiscard]] Image nothing_to_show() const {
    Image image = filled_image(render_.width, render_.height, {1, 1, 1});
    const std::string text = "did not come to rest";
    const int size = std::max(14, render_.height / 24);
    draw_text(image, (render_.width - text_width(text, size)) / 2, render_.height / 2, size, text);
    return image;
  }

  /// Of each tetrahedron.
  [[nodiscard]] std::vector<double> moduli() const {
    const std::size_t cells = results_.problem.mesh().tetrahedra.size();
    std::vector<double> out;
    for (std::size_t t = 0; t < cells; ++t)
      out.push_back(results_.problem.reference_body().of(t / 5).youngs_modulus_mpa);
    return out;
  }
  /// Means over the elements around each point.
  template <class Elements>
  [[nodiscard]] std::vector<double> at_points(const Elements& elements,
                                              const std::vector<double>& values) const {
    std::vector<double> sum(results_.problem.mesh().points.size()), count(sum.size());
    for (std::size_t e = 0; e < values.size(); ++e)
      for (const int p : elements[e]) sum[at(p)] += values[e], count[at(p)] += 1;
    for (std::size_t p = 0; p < sum.size(); ++p) sum[p] /= std::max(1.0, count[p]);
    return sum;
  }

  /// Values of the edges (0), triangles (1) or tetrahedra (2); logarithms where they span more than ten
  /// times.
  Result<Image> field(const std::string& symbol, std::size_t kind, std::vector<double> values) {
    const auto [least, greatest] = std::ranges::minmax(values);
    const bool logarithmic = least > 0 && greatest > 10 * least;
    if (logarithmic)
      for (double& v : values) v = std::log10(v);
    auto [low, high] = std::ranges::minmax(values);
    if (!(high - low > 1e-6 * std::abs(high))) low = 0, high *= 2;  // uniform
    const Solid& solid = results_.problem.elements();
    const std::vector<double> of_points = kind == 0   ? at_points(solid.edges, values)
                                          : kind == 1 ? at_points(solid.triangles, values)
                                                      : at_points(solid.tetrahedra, values);
    const TriMesh shape = shown_.shape(results_.problem.mesh().points);
    Body body;
    body.mesh = &shape;
    for (const double v : shown_.carried(of_points))
      body.point_colours.push_back(colour_map((v - low) / (high - low)));
    TURGOR_TRY(const Image image, draw({body}));
    return with_legend(image, low, high, logarithmic ? "log10 (" + symbol + "/MPa)" : symbol + ", MPa",
                       colour_map, letters(image));
  }

  const CalibrationResults& results_;
  ShownSolid shown_;
  Context& context_;
  RenderOptions render_;
  CameraView camera_;
  double size_mm_ = 1;
};

}  // namespace

namespace render_detail {

Result<Picture> trajectory(const Fit& fit, const FitOptions& options) {
  Curve coarse{"coarse samples", {}, {}, {0.45f, 0.50f, 0.58f}, true},
      search{"search", {}, {}, {0.06f, 0.20f, 0.65f}, true},
      best{"best so far", {}, {}, {0.02f, 0.45f, 0.12f}};
  for (std::size_t s = 0; s < fit.samples.size(); ++s) {
    const FitSample& sample = fit.samples[s];
    Curve& dots = sample.stage == FitSample::Stage::search ? search : coarse;
    dots.x.push_back(static_cast<double>(s)), dots.y.push_back(sample.error);
    for (const double y : {s > 0 ? fit.samples[s - 1].best : sample.best, sample.best})
      best.x.push_back(static_cast<double>(s)), best.y.push_back(y);  // a staircase
  }
  Plot plot;
  plot.width = 1100, plot.height = 620;
  plot.x.title = "sample";
  plot.y.title = options.measure == ErrorMeasure::force ? "error, N" : "error, mm";
  // A model that is its own reference has no error to take the logarithm of.
  plot.y.logarithmic = std::ranges::any_of(
      fit.samples, [](const FitSample& s) { return s.error > 0 && std::isfinite(s.error); });
  for (Curve* curve : {&coarse, &search, &best})
    if (!curve->x.empty()) plot.curves.push_back(*curve);
  TURGOR_TRY(const Image image, draw_plot(plot));
  std::string caption = "Error of each sample, on a logarithmic scale, and the best so far";
  if (options.regularisation > 0)
    caption += "; the best is that of error and regularisation together, so that its error may rise";
  if (fit.failed > 0) caption += fmt::format("; {} samples did not come to rest and have no dot", fit.failed);
  return Picture{"search", caption, encode_png(image)};
}

}  // namespace render_detail

Result<std::vector<Picture>> calibration_pictures(const CalibrationResults& results,
                                                  const PictureOptions& options, Context& context) {
  const Stage stage(context, "pictures");
  std::vector<Picture> pictures;
  TURGOR_TRY(Studio studio, Studio::create(results, options, context));
  const std::size_t count = results.problem.loads().size();
  for (std::size_t l = 0; l < count; ++l) {
    context.progress(static_cast<double>(l) / static_cast<double>(count + 1));
    TURGOR_TRY(Picture picture, studio.load_picture(l));
    pictures.push_back(std::move(picture));
  }
  TURGOR_TRY(Picture constants, studio.constants_picture());
  pictures.push_back(std::move(constants));
  TURGOR_TRY(Picture search, trajectory(results.outcome.fit, results.problem.options().fit));
  pictures.push_back(std::move(search));
  return pictures;
}

}  // namespace turgor
