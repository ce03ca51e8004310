#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "html.hpp"
#include "render/calibration_sections.hpp"
#include "render/calibration_view.hpp"
#include "render/picture_files.hpp"
#include "report_style.hpp"
#include "turgor/core/file.hpp"
#include "turgor/render/face_calibration_report.hpp"
#include "turgor/render/ray_tracer.hpp"

namespace turgor {

using namespace render_detail;

namespace {

using html::escape;
using html::section;

std::vector<double> distances(const Prediction& a, const Prediction& b) {
  std::vector<double> out;
  for (std::size_t p = 0; p < a.skin.points.size(); ++p)
    out.push_back(distance(a.skin.points[p], b.skin.points[p]));
  return out;
}

/// All faces from one side, errors in colours on one scale.
class FaceStudio {
 public:
  FaceStudio(const FaceCalibrationResults& results, Context& context) : results_(results), context_(context) {
    render_.width = 560, render_.height = 620, render_.samples = 16;
    const PatientCase& patient = *results.moves.front().patient;
    // From before the patient's right cheek, where chin and lips show in depth.
    constexpr Vec3 seen_from{-0.75, -1, 0.05};
    std::vector<Vec3> face;
    for (const Vec3& p : patient.tissue().surface.points) face.push_back(p);
    camera_ = camera_about(face, seen_from, render_.width, render_.height);
  }

  Result<Picture> picture(std::size_t m) {
    const FaceMove& move = results_.moves[m];
    const Prediction &before = results_.outcome.uncalibrated[m], &after = results_.outcome.calibrated[m];
    const auto greatest = lower_third_distance(move, before).greatest;
    const double top = round_up(std::max(greatest, lower_third_distance(move, after).greatest));
    std::vector<Image> panels;
    TURGOR_TRY(Image rest, draw(move.patient->skin(), {}, top));
    panels.push_back(captioned(rest, "(a) before surgery"));
    TURGOR_TRY(Image reference, draw(move.reference.skin, {}, top));
    panels.push_back(captioned(reference, "(b) reference"));
    const int size = letters(rest);
    for (const auto& [caption, prediction] :
         {std::pair("(c) uncalibrated", &before), std::pair("(d) calibrated", &after)}) {
      TURGOR_TRY(Image image, draw(prediction->skin, distances(*prediction, move.reference), top));
      panels.push_back(captioned(
          image, fmt::format("{}: {:.2f} mm", caption, lower_third_distance(move, *prediction).mean)));
    }
    return Picture{
        fmt::format("load_{}", m + 1),
        fmt::format("{}{}. (c) and (d) Distance of the skin from the reference, and its mean in "
                    "the lower third",
                    move.name, move.held_out ? ", not calibrated with" : ""),
        encode_png(with_legend(side_by_side(panels, {}, 2), 0, top, "distance, mm", light_colour_map, size))};
  }

 private:
  Result<Image> draw(const TriMesh& skin, const std::vector<double>& errors, double top) {
    TURGOR_CHECK(context_.check());
    Body body{&skin, {MaterialKind::skin}, {}};
    if (!errors.empty()) body.material.kind = MaterialKind::plain;
    for (const double e : errors) body.point_colours.push_back(light_colour_map(e / top));
    TURGOR_TRY(const Renderer renderer, Renderer::create({body}, context_));
    return renderer.render(camera_, render_, context_);
  }

  const FaceCalibrationResults& results_;
  Context& context_;
  RenderOptions render_;
  CameraView camera_;
};

Result<std::vector<Picture>> pictures_of_faces(const FaceCalibrationResults& results, Context& context) {
  const Stage stage(context, "pictures");
  std::vector<Picture> out;
  FaceStudio studio(results, context);
  for (std::size_t m = 0; m < results.moves.size(); ++m) {
    context.progress(static_cast<double>(m) / static_cast<double>(results.moves.size()));
    TURGOR_TRY(Picture picture, studio.picture(m));
    out.push_back(std::move(picture));
  }
  TURGOR_TRY(Picture search, trajectory(results.outcome.fit, results.search));
  out.push_back(std::move(search));
  return out;
}

std::array<SkinDistance, 2> before_and_after(const FaceCalibrationResults& results, std::size_t m) {
  return {lower_third_distance(results.moves[m], results.outcome.uncalibrated[m]),
          lower_third_distance(results.moves[m], results.outcome.calibrated[m])};
}

std::string distance_table(const FaceCalibrationResults& results) {
  std::vector<std::vector<std::string>> rows;
  const auto mm = [](double v) { return fmt::format("{:.2f}", v); };
  const auto with_part = [&](double v, double of) {
    return of > 0 ? fmt::format("{:.2f}&nbsp;({:.2g}&nbsp;%)", v, 100 * v / of) : mm(v);
  };
  for (std::size_t m = 0; m < results.moves.size(); ++m) {
    const FaceMove& move = results.moves[m];
    const auto [before, after] = before_and_after(results, m);
    const double of = reference_movement(move).mean;
    rows.push_back({escape(move.name), move.held_out ? "held out" : "calibrated with", mm(of),
                    with_part(before.mean, of), mm(before.percentile_95), with_part(after.mean, of),
                    mm(after.percentile_95),
                    fmt::format("{:.1f}", move.reference.setup_seconds + move.reference.solve_seconds),
                    fmt::format("{:.1f}", results.outcome.calibrated[m].solve_seconds)});
  }
  return html::table({"Move", "", "reference moves, mm", "mean before, mm (of it)", "95 % before",
                      "mean after, mm (of it)", "95 % after", "reference, s", "network, s"},
                     rows) +
         "<p>Distances of the network's skin from the reference's in the lower third of the face, over "
         "points that move by more than 0.1 mm in either, and the reference's mean movement there. Moves "
         "held out were not seen by the search.</p>\n";
}

}  // namespace

SkinDistance lower_third_distance(const FaceMove& move, const Prediction& network) {
  for (const auto& [name, within] : skin_parts(*move.patient))
    if (name == kLowerThird) return compare(network, move.reference, within);
  return compare(network, move.reference);
}

SkinDistance reference_movement(const FaceMove& move) {
  Prediction rest;
  rest.skin = move.patient->skin();
  rest.displacement_mm.assign(rest.skin.points.size(), 0);
  return lower_third_distance(move, rest);
}

std::string face_calibration_json(const FaceCalibrationResults& results, const Context& context) {
  Json moves = Json::array();
  for (std::size_t m = 0; m < results.moves.size(); ++m) {
    const FaceMove& move = results.moves[m];
    const auto [before, after] = before_and_after(results, m);
    moves.push_back({{"name", move.name},
                     {"calibrated_with", !move.held_out},
                     {"lower_third_movement", distance_json(reference_movement(move))},
                     {"lower_third_before", distance_json(before)},
                     {"lower_third_after", distance_json(after)},
                     {"inverted_prisms", results.outcome.calibrated[m].inverted},
                     {"reference_residual", move.reference.equilibrium.relative_residual},
                     {"reference_seconds", move.reference.solve_seconds},
                     {"network_seconds", results.outcome.calibrated[m].solve_seconds}});
  }
  const Fit& fit = results.outcome.fit;
  const Json out{{"program", "turgor " + results.record.version},
                 {"command_line", results.record.command_line},
                 {"problem", {{"file", results.record.problem_name}, {"text", results.record.problem_text}}},
                 {"model", {{"kind", "network"}, {"grid_nodes", results.face.nodes}}},
                 {"search", search_json(results.search, fit)},
                 {"error_unit", "mm"},
                 {"error_before", finite(fit.guess_error)},
                 {"error_after", finite(fit.error)},
                 {"error_before_m", finite(fit.guess_error / 1000)},
                 {"error_after_m", finite(fit.error / 1000)},
                 {"loads", moves},
                 {"parameters", parameters_json(results.face.problem.parameters, fit)},
                 {"samples", samples_json(fit)},
                 {"run", notes_json(context)}};
  return out.dump(2) + "\n";
}

std::string face_calibration_html(const FaceCalibrationResults& results, const std::vector<Picture>& pictures,
                                  std::string_view json, const Context& context) {
  const Fit& fit = results.outcome.fit;
  std::string page =
      report_head("Calibration") +
      fmt::format(
          "<header><p class=\"brand\">Turgor {}</p><h1>Calibration: {}</h1>\n<p class=\"facts\">layered "
          "network of the face &middot; {} moves &middot; {} parameters</p></header>\n<p "
          "class=\"lead\">The error falls from <b>{:.3g} mm ({:.3g} m)</b> to <b>{:.3g} mm ({:.3g} m)</b>, "
          "root "
          "mean square over the skin, the lower third before all.{}</p>\n",
          escape(results.record.version), escape(results.record.problem_name), results.moves.size(),
          fit.parameters.size(), fit.guess_error, fit.guess_error / 1000, fit.error, fit.error / 1000,
          fit.stopped ? " <b>The search was stopped by the user.</b>" : "");
  page += section("Distances", distance_table(results));
  page += section("Faces", pictures_of(pictures, "load_"));
  page += section("Factors of the constants", "<p>Uncalibrated, all factors are 1.</p>\n" +
                                                  parameter_table(results.face.problem.parameters, fit));
  page += section("The search", search_section(results.search, fit, pictures));
  page += section("The problem", "<pre>" + escape(results.record.problem_text) + "</pre>\n");
  page +=
      section("What this does not tell",
              "<ul><li>The reference is a finite element solution of one tissue for the whole face, not a "
              "measurement.</li><li>Factors are those of this tissue model: another number of points or "
              "layers needs its own calibration.</li></ul>\n");
  page += html::run_details(context, json);
  return page + std::string(report_tail);
}

Result<void> write_face_calibration(const FaceCalibrationResults& results,
                                    const std::filesystem::path& folder, Context& context) {
  TURGOR_TRY(const std::vector<Picture> pictures, pictures_of_faces(results, context));
  const Stage stage(context, "files");
  TURGOR_CHECK(render_detail::write_pictures(pictures, folder / "pictures", context));
  const std::string json = face_calibration_json(results, context);
  TURGOR_CHECK(write_file(folder / "report.html", face_calibration_html(results, pictures, json, context)));
  return write_file(folder / "calibration.json", json);
}

}  // namespace turgor
