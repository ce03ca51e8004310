#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "html.hpp"
#include "render/calibration_sections.hpp"
#include "report_style.hpp"
#include "turgor/render/calibration_report.hpp"

namespace turgor {

using namespace render_detail;

namespace {

using html::escape;
using html::section;

std::string number(double v) {
  return std::isfinite(v) ? fmt::format("{:.4g}", v) : "did not come to rest";
}

std::string deviation_text(const FitParameter& p, double value, double deviation) {
  if (!std::isfinite(deviation)) return "not determined";
  if (!p.logarithmic) return fmt::format("± {:.2g}", deviation);
  if (deviation > 2.3) return "more than ten times either way";
  return deviation > 0.3
             ? fmt::format("{:.3g} to {:.3g}", value * std::exp(-deviation), value * std::exp(deviation))
             : fmt::format("± {:.2g} %", 100 * deviation);
}

std::string head(const CalibrationResults& results) {
  const SolidMesh& mesh = results.problem.mesh();
  Box3 box;
  for (const Vec3& p : mesh.points) box.extend(p);
  const Vec3 size = box.size() / 1000;
  return fmt::format(
      "<header><p class=\"brand\">Turgor {}</p><h1>Calibration: {}</h1>\n"
      "<p class=\"facts\">{:.3g} &times; {:.3g} &times; {:.3g} m, {} cubes of {:.3g} mm as {} tetrahedra, {} "
      "points, {} of them held &middot; {} "
      "loads &middot; {} parameters</p></header>\n",
      escape(results.record.version), escape(results.record.problem_name), size.x, size.y, size.z,
      mesh.tetrahedra.size() / 5, mesh.spacing, mesh.tetrahedra.size(), mesh.points.size(),
      results.problem.held().size(), results.problem.loads().size(),
      results.problem.problem().parameters.size());
}

// The one sentence that a reader in a hurry takes along.
std::string summary(const CalibrationResults& results) {
  const Fit& fit = results.outcome.fit;
  const std::string after = error_text(results, fit.error);
  std::string text =
      std::isfinite(fit.guess_error)
          ? fmt::format("The error falls from <b>{}</b> to <b>{}</b>", error_text(results, fit.guess_error),
                        after)
          : fmt::format("The uncalibrated body does not come to rest; calibrated, the error is <b>{}</b>",
                        after);
  double reference = 0, count = 0;
  for (std::size_t l = 0; l < fit.loads.size(); ++l)
    if (!results.problem.loads()[l].held_out) reference += fit.loads[l].reference, ++count;
  if (reference > 0) {
    text += fmt::format(
        ", {:.2g} % of the root mean square {} of the reference", 100 * fit.error * count / reference,
        results.problem.options().fit.measure == ErrorMeasure::force ? "force" : "displacement");
  }
  text += ".";
  if (fit.stopped) {
    text +=
        " <b>The search was stopped by the user; this is the best found until then, not the end of the "
        "search.</b>";
  }
  return "<p class=\"lead\">" + text + "</p>\n";
}

std::string load_table(const CalibrationResults& results) {
  std::vector<std::vector<std::string>> rows;
  for (std::size_t l = 0; l < results.problem.loads().size(); ++l) {
    const PreparedLoad& load = results.problem.loads()[l];
    const LoadFit& fit = results.outcome.fit.loads[l];
    rows.push_back(
        {escape(load.name),
         std::string(load.held_out ? "held out" : "calibrated with") + (load.probe ? ", made up" : ""),
         error_text(results, fit.reference), error_text(results, fit.before),
         part_text(fit.before, fit.reference), error_text(results, fit.after),
         part_text(fit.after, fit.reference)});
  }
  return html::table({"Load", "", "reference", "error before", "of it", "error after", "of it"}, rows) +
         "<p>Root mean squares over all points; the reference's is that of its distance from rest, of which "
         "errors are parts. Loads held out were not seen by the search: they tell how the constants carry "
         "over.</p>\n";
}

/// Least, median and greatest over the nodes, of each kind of parameter.
std::string constant_table(const CalibrationResults& results) {
  const auto& grouped = results.problem.grouped();
  std::vector<std::vector<std::string>> rows;
  for (std::size_t p = 0; p < grouped.group.size();) {
    std::vector<double> values;
    const std::size_t first = p;
    for (; p < grouped.group.size() && grouped.group[p] == grouped.group[first]; ++p)
      values.push_back(results.outcome.fit.parameters[p]);
    std::ranges::sort(values);
    const FitParameter& one = grouped.parameters[first];
    rows.push_back({escape(one.name.substr(0, one.name.find(" at node"))), escape(one.unit),
                    number(one.guess), number(values.front()), number(values[values.size() / 2]),
                    number(values.back())});
  }
  return "<p>" + escape(guess_text(results)) + ".</p>\n" +
         html::table({"Parameter", "", "guess", "least", "median", "greatest"}, rows) +
         "<p>A stiffness, times the rest volume that an element stands for (a sixth of each tetrahedron "
         "around "
         "an edge, a quarter of each around a triangle), is the element's constant. constants.vtu has both "
         "for "
         "each element.</p>\n";
}

std::string region_text(const CalibrationResults& results) {
  const auto found = modulus_correlation(results.problem, results.outcome.stiffness);
  if (!found) return {};
  return fmt::format(
      "<p>Learned stiffness against the reference's modulus: correlation <b>{:.2f}</b>, of the logarithms of "
      "k_d and of Young's modulus over all edges.</p>\n",
      *found);
}

std::string reference(const CalibrationResults& results) {
  std::vector<std::vector<std::string>> rows;
  for (const ReferenceRegion& r : results.problem.options().reference) {
    std::string law(name_of(r.material.law));
    std::ranges::replace(law, '_', ' ');
    const bool everywhere = !r.region.box && !r.region.centre && !r.region.beyond;
    rows.push_back({law, number(r.material.youngs_modulus_mpa), number(r.material.poissons_ratio),
                    r.material.c20_mpa > 0 ? number(r.material.c20_mpa) : "",
                    everywhere ? "everywhere" : "within a region"});
  }
  double residual = 0;
  for (const PreparedLoad& l : results.problem.loads()) residual = std::max(residual, l.reference_residual);
  return html::table({"Law", "Young's modulus MPa", "Poisson's ratio", "c20 MPa", ""}, rows) +
         fmt::format(
             "<p>Finite elements on the body's cubes, whose points are those of the tetrahedra; largest "
             "relative residual {:.1e}.</p>\n<pre>{}</pre>\n",
             residual, escape(results.record.problem_text));
}

std::string limits() {
  return "<ul><li>The reference is a finite element solution of the material given, not a measurement.</li>"
         "<li>Constants are those of this mesh: another resolution needs its own calibration (Morris 2006, "
         "section 3.1).</li>"
         "<li>Where no load moves the body, its constants are not determined; their deviations say "
         "so.</li></ul>\n";
}

}  // namespace

namespace render_detail {

std::string pictures_of(const std::vector<Picture>& pictures, std::string_view prefix) {
  std::string out = "<div class=\"row\">";
  for (const Picture& p : pictures)
    if (p.name.starts_with(prefix)) out += html::figure(p.png, p.caption, "wide");
  return out + "</div>\n";
}

std::string parameter_table(const std::vector<FitParameter>& parameters, const Fit& fit) {
  std::vector<std::vector<std::string>> rows;
  for (std::size_t p = 0; p < parameters.size(); ++p) {
    const FitParameter& f = parameters[p];
    const double value = fit.parameters[p];
    const bool at_low = value <= f.low * (1 + 1e-6), at_high = value >= f.high * (1 - 1e-6);
    rows.push_back({escape(f.name), fmt::format("{:.4g} {}", value, escape(f.unit)),
                    p < fit.deviation.size() ? deviation_text(f, value, fit.deviation[p]) : "",
                    number(f.guess),
                    at_low    ? "at its lower bound"
                    : at_high ? "at its upper bound"
                              : ""});
  }
  const std::string table = html::table({"Parameter", "calibrated", "standard deviation", "guess", ""}, rows);
  const std::string note =
      fit.deviation.empty()
          ? "<p>This model gives no derivatives: deviations are not known.</p>\n"
          : "<p>Deviations are those of the linearised fit, with what is left of the error as noise.</p>\n";
  if (rows.size() <= 12) return table + note;
  return fmt::format("{}<details><summary>All {} parameters</summary>{}</details>\n", note, rows.size(),
                     table);
}

std::string search_section(const FitOptions& o, const Fit& fit, const std::vector<Picture>& pictures) {
  std::string method(name_of(o.method));
  std::ranges::replace(method, '_', ' ');
  return pictures_of(pictures, "search") +
         fmt::format(
             "<p>Method: {}. {} samples in {:.1f} s, {} of which did not come to rest. Seed {}.{}</p>\n",
             method, fit.samples.size(), fit.seconds, fit.failed, o.seed,
             fit.stopped ? " <b>Stopped by the user before its end.</b>" : "");
}

}  // namespace render_detail

std::string calibration_html(const CalibrationResults& results, const std::vector<Picture>& pictures,
                             std::string_view json, const Context& context) {
  std::string page = report_head("Calibration") + head(results) + summary(results);
  page += section("Errors", load_table(results));
  page += section("Shapes", pictures_of(pictures, "load_"));
  page += section("Calibrated constants",
                  pictures_of(pictures, "constants") + region_text(results) + constant_table(results) +
                      parameter_table(results.problem.problem().parameters, results.outcome.fit));
  page += section("The search", search_section(results.problem.options().fit, results.outcome.fit, pictures));
  page += section("The reference and the problem", reference(results));
  page += section("What this does not tell", limits());
  page += html::run_details(context, json);
  return page + std::string(report_tail);
}

}  // namespace turgor
