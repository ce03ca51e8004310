#include <cmath>

#include "render/calibration_sections.hpp"
#include "turgor/render/calibration_report.hpp"

namespace turgor {

using namespace render_detail;

namespace {

Json body_json(const CalibrationCase& problem) {
  const SolidMesh& mesh = problem.mesh();
  Box3 box;
  for (const Vec3& p : mesh.points) box.extend(p);
  return {{"points", mesh.points.size()},         {"cubes", mesh.tetrahedra.size() / 5},
          {"tetrahedra", mesh.tetrahedra.size()}, {"cube_mm", mesh.spacing},
          {"lower_mm", triple(box.lower)},        {"upper_mm", triple(box.upper)},
          {"held_points", problem.held().size()}};
}

Json region_json(const RestRegion& region) {
  Json out = Json::object();
  if (region.box) out["box_mm"] = Json::array({triple(region.box->lower), triple(region.box->upper)});
  if (region.centre) out["sphere"] = {{"centre_mm", triple(*region.centre)}, {"radius_mm", region.radius_mm}};
  if (region.beyond)
    out["plane"] = {{"normal", triple(region.beyond->normal)}, {"offset_mm", region.beyond->offset}};
  return out;
}

Json reference_json(const CalibrationCase& problem) {
  Json out = Json::array();
  for (const ReferenceRegion& r : problem.options().reference) {
    out.push_back({{"law", name_of(r.material.law)},
                   {"youngs_modulus_mpa", r.material.youngs_modulus_mpa},
                   {"poissons_ratio", r.material.poissons_ratio},
                   {"c20_mpa", r.material.c20_mpa},
                   {"region", region_json(r.region)}});
  }
  return out;
}

Json model_json(const CalibrationCase& problem) {
  const TetrahedraModel& m = problem.options().model;
  const auto [k_d, k_a, k_v] = guess_mpa(problem);
  return {{"kind", "tetrahedra"},
          {"grid_nodes", m.grid},
          {"proportional", m.proportional},
          {"relative_residual", m.relative_residual},
          {"guess",
           {{"youngs_modulus_mpa", m.guess.youngs_modulus_mpa},
            {"poissons_ratio", m.guess.poissons_ratio},
            {"area_share", m.guess.area_share},
            {"k_d_mpa", k_d},
            {"k_a_mpa", k_a},
            {"k_v_mpa", k_v}}},
          {"bounds_of_guess", {m.low, m.high}}};
}

/// Root mean square distance, as the measure has it, over that of the reference from rest.
Json share(double error, double reference) {
  return reference > 0 ? finite(error / reference) : Json(nullptr);
}

/// Lengths in metres besides; forces have none.
void add_metres(Json& to, bool lengths, std::initializer_list<std::pair<const char*, double>> values) {
  if (!lengths) return;
  for (const auto& [name, mm] : values) to[name] = finite(mm / 1000);
}

Json loads_json(const CalibrationResults& results) {
  Json out = Json::array();
  const bool lengths = results.problem.options().fit.measure != ErrorMeasure::force;
  for (std::size_t l = 0; l < results.problem.loads().size(); ++l) {
    const PreparedLoad& load = results.problem.loads()[l];
    const LoadFit& fit = results.outcome.fit.loads[l];
    Vec3 total;
    for (const Vec3& f : load.force_n) total += f;
    out.push_back({{"name", load.name},
                   {"calibrated_with", !load.held_out},
                   {"made_up", load.probe},
                   {"force_n", triple(total)},
                   {"displaced_points", load.displaced.size()},
                   {"reference_residual", load.reference_residual},
                   {"reference", fit.reference},
                   {"error_before", finite(fit.before)},
                   {"error_after", finite(fit.after)},
                   {"part_before", share(fit.before, fit.reference)},
                   {"part_after", share(fit.after, fit.reference)}});
    add_metres(
        out.back(), lengths,
        {{"reference_m", fit.reference}, {"error_before_m", fit.before}, {"error_after_m", fit.after}});
  }
  return out;
}

}  // namespace

namespace render_detail {

Json finite(double v) {
  return std::isfinite(v) ? Json(v) : Json(nullptr);
}

Json search_json(const FitOptions& o, const Fit& fit) {
  return {{"method", name_of(o.method)},
          {"measure", name_of(o.measure)},
          {"coarse_samples", o.coarse_samples},
          {"budget", o.budget},
          {"chains", o.chains},
          {"seed", o.seed},
          {"regularisation", o.regularisation},
          {"stopped_by_user", fit.stopped},
          {"samples", fit.samples.size()},
          {"failed_samples", fit.failed},
          {"seconds", fit.seconds}};
}

Json parameters_json(const std::vector<FitParameter>& parameters, const Fit& fit) {
  Json out = Json::array();
  for (std::size_t p = 0; p < parameters.size(); ++p) {
    const FitParameter& f = parameters[p];
    Json one{{"name", f.name}, {"unit", f.unit}, {"value", fit.parameters[p]},  {"guess", f.guess},
             {"low", f.low},   {"high", f.high}, {"logarithmic", f.logarithmic}};
    if (p < fit.deviation.size())
      one[f.logarithmic ? "deviation_of_logarithm" : "deviation"] = finite(fit.deviation[p]);
    out.push_back(std::move(one));
  }
  return out;
}

Json samples_json(const Fit& fit) {
  constexpr const char* stages[] = {"guess", "coarse", "search"};
  Json out = Json::array();
  for (const FitSample& s : fit.samples) {
    out.push_back({{"stage", stages[static_cast<std::size_t>(s.stage)]},
                   {"error", finite(s.error)},
                   {"best", finite(s.best)}});
  }
  return out;
}

Json notes_json(const Context& context) {
  Json notices = Json::array(), times = Json::object();
  for (const Notice& n : context.notices()) notices.push_back(n.text);
  for (const StageTime& t : context.stage_times()) times[t.stage] = t.seconds;
  return {{"notices", notices}, {"seconds", times}};
}

}  // namespace render_detail

std::string calibration_json(const CalibrationResults& results, const Context& context) {
  const Fit& fit = results.outcome.fit;
  const bool force = results.problem.options().fit.measure == ErrorMeasure::force;
  const auto correlation = modulus_correlation(results.problem, results.outcome.stiffness);
  Json out{{"program", "turgor " + results.record.version},
           {"command_line", results.record.command_line},
           {"problem", {{"file", results.record.problem_name}, {"text", results.record.problem_text}}},
           {"body", body_json(results.problem)},
           {"reference", reference_json(results.problem)},
           {"model", model_json(results.problem)},
           {"search", search_json(results.problem.options().fit, fit)},
           {"error_unit", force ? "N" : "mm"},
           {"error_before", finite(fit.guess_error)},
           {"error_after", finite(fit.error)}};
  add_metres(out, !force, {{"error_before_m", fit.guess_error}, {"error_after_m", fit.error}});
  out["modulus_correlation"] = correlation ? Json(*correlation) : Json(nullptr);
  out["loads"] = loads_json(results);
  out["parameters"] = parameters_json(results.problem.problem().parameters, fit);
  out["samples"] = samples_json(fit);
  out["run"] = notes_json(context);
  return out.dump(2) + "\n";
}

}  // namespace turgor
