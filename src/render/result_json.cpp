#include <algorithm>

#include "render/json.hpp"
#include "turgor/anatomy/tissue_network.hpp"
#include "turgor/render/results.hpp"
#include "turgor/world/reference_bands.hpp"

namespace turgor {

using namespace render_detail;

namespace {

Json scan_json(const PatientCase& patient) {
  const Grid& grid = patient.scan_grid();
  return {{"path", patient.scan_path().string()},
          {"format", patient.scan_info().format},
          {"modality", patient.scan_info().modality},
          {"series", patient.scan_info().series},
          {"size", grid.size},
          {"spacing_mm", triple(grid.spacing)},
          {"origin_mm_lps", triple(grid.origin)},
          {"gantry_tilt_deg", patient.scan_info().gantry_tilt_deg},
          {"stored_left_handed", patient.scan_info().stored_left_handed},
          {"skipped_files", patient.scan_info().skipped_files}};
}

Json head_json(const Head& head) {
  constexpr const char* states[] = {"separate", "cut", "absent"};
  return {{"skin_level_hu", head.skin_level_hu},
          {"bone_level_hu", head.bone_level_hu},
          {"skin_triangles", head.skin.triangles.size()},
          {"skull_triangles", head.skull.triangles.size()},
          {"mandible_triangles", head.mandible.triangles.size()},
          {"mandible", states[static_cast<std::size_t>(head.mandible_state)]},
          {"removed_pieces", head.removed_pieces},
          {"open_below", head.open_below},
          {"skin_volume_ml", head.skin_volume_ml},
          {"bone_volume_ml", head.bone_volume_ml}};
}

Json tissue_json(const LayeredTissue& tissue) {
  const auto [low, high] = std::minmax_element(tissue.thickness_mm.begin(), tissue.thickness_mm.end());
  double mean = 0;
  for (const double t : tissue.thickness_mm) mean += t / static_cast<double>(tissue.thickness_mm.size());
  return {{"columns", tissue.columns()},
          {"sheets", tissue.sheets},
          {"points", tissue.points.size()},
          {"prisms", tissue.prisms()},
          {"springs", spring_count(tissue)},
          {"layer_fractions", tissue.layer_fractions},
          {"thickness_mm", {{"mean", mean}, {"least", *low}, {"greatest", *high}}},
          {"mean_hit_thickness_mm", tissue.mean_hit_thickness_mm},
          {"upper_centre_mm", triple(tissue.upper_centre)},
          {"lower_centre_mm", triple(tissue.lower_centre)},
          {"lip_level_mm", tissue.lip_level_mm},
          {"skin_points_above_bone", tissue.skin_points_above_bone},
          {"rays_missed_and_filled", tissue.rays_missed},
          {"prisms_repaired", tissue.prisms_repaired},
          {"prisms_inverted", count_inverted(tissue, tissue.points)},
          {"attached_columns", std::count(tissue.attached.begin(), tissue.attached.end(), true)}};
}

Json parameters_json(const CaseResults& results) {
  const CaseOptions& o = results.patient.options();
  const SolverOptions& s = results.record.solver_options;
  return {{"bone_threshold_hu", o.head.bone_threshold_hu},
          {"refine_bone_threshold", o.head.refine_bone_threshold},
          {"skin_triangles", o.head.skin_triangles},
          {"bone_triangles", o.head.bone_triangles},
          {"smoothing", o.head.smoothing},
          {"tissue_columns", o.tissue.columns},
          {"layer_fractions", o.tissue.fractions},
          {"layer_thickness_mm", o.tissue.thickness_mm},
          {"least_thickness_mm", o.tissue.least_thickness_mm},
          {"greatest_thickness_mm", o.tissue.greatest_thickness_mm},
          {"neck_mm", o.tissue.neck_mm},
          {"release_near_teeth_mm", o.tissue.release_near_teeth_mm},
          {"undermining_mm", o.contact.undermining_mm},
          {"adhesion_n_mm", o.contact.adhesion_n_mm},
          {"young_mpa", o.material.young_mpa},
          {"inversion_guard_mpa", o.material.inversion_guard_mpa},
          {"poisson", o.material.poisson},
          {"chain",
           {{"alpha", s.chain.alpha},
            {"column_alpha", s.chain.column_alpha},
            {"fixed_points", s.chain.fixed_points == FixedPoints::hold ? "hold" : "inert"},
            {"semi_active_passes", s.chain.semi_active_passes},
            {"beta", s.chain.beta},
            {"max_stretch", s.chain.max_stretch},
            {"max_compression", s.chain.max_compression}}},
          {"equilibrium",
           {{"relative_residual", s.equilibrium.relative_residual},
            {"max_newton_steps", s.equilibrium.max_newton_steps},
            {"load_steps", s.equilibrium.load_steps}}},
          {"cubes",
           {{"spacing_mm", s.cubes.spacing_mm},
            {"law", name_of(s.cubes.material.law)},
            {"youngs_modulus_mpa", s.cubes.material.youngs_modulus_mpa},
            {"poissons_ratio", s.cubes.material.poissons_ratio},
            {"c20_mpa", s.cubes.material.c20_mpa},
            {"relative_residual", s.cubes.relative_residual}}}};
}

Json bones_json(const BonePlan& plan) {
  Json out = Json::array();
  for (const BoneSegment& s : plan.segments()) {
    Json rotation = Json::array();
    for (int row = 0; row < 3; ++row) {
      rotation.push_back(
          {s.motion.rotation.c[0][row], s.motion.rotation.c[1][row], s.motion.rotation.c[2][row]});
    }
    out.push_back({{"name", s.name},
                   {"triangles", s.surface.triangles.size()},
                   {"rotation_rows", rotation},
                   {"translation_mm", triple(s.motion.translation)}});
  }
  return out;
}

Json prediction_json(const PatientCase& patient, const Prediction& p) {
  Json landmarks = Json::object();
  for (const LandmarkShift& l : p.landmarks) {
    const Vec3 d = l.after - l.before;
    landmarks[l.name] = {
        {"before_mm", triple(l.before)}, {"displacement_mm", triple(d)}, {"distance_mm", length(d)}};
  }
  Json ratios = Json::array();
  for (const SoftToHard& r : p.ratios) {
    ratios.push_back({{"soft", r.soft},
                      {"hard", r.hard},
                      {"soft_mm", r.soft_mm},
                      {"hard_mm", r.hard_mm},
                      {"ratio", r.ratio()}});
  }
  Json bands = Json::array();
  for (const BandResult& b : judge(patient, p)) {
    bands.push_back({{"operation", b.band->operation},
                     {"soft", b.band->soft},
                     {"relative_to", b.band->hard},
                     {"ratio", b.ratio},
                     {"low", b.band->low},
                     {"high", b.band->high},
                     {"inside", b.inside()},
                     {"source", b.band->source}});
  }
  Json out{{"solver", name_of(p.solver)},
           {"points", p.points},
           {"springs", p.springs},
           {"volume_elements", p.volumes}};
  if (p.cubes != nullptr) out["cubes"] = p.cubes->face.cubes();
  if (p.solver != Solver::chain) {
    out["newton_steps"] = p.equilibrium.newton_steps;
    out["linear_iterations"] = p.equilibrium.linear_iterations;
    out["residual_n"] = p.equilibrium.residual_n;
    out["relative_residual"] = p.equilibrium.relative_residual;
    out["energy_nmm"] = p.equilibrium.energy_nmm;
  }
  out["largest_skin_stretch"] = p.largest_stretch;
  if (p.solver != Solver::chain) out["deepest_in_bone_mm"] = p.deepest_contact_mm;
  out[p.cubes == nullptr ? "prisms_inverted" : "elements_inverted"] = p.inverted;
  out["soft_to_hard"] = ratios;
  out["reference_bands"] = bands;
  out["landmarks"] = landmarks;
  return out;
}

// Of every pair.
Json distances_json(const CaseResults& results) {
  Json out = Json::array();
  for (std::size_t i = 0; i < results.predictions.size(); ++i) {
    for (std::size_t j = i + 1; j < results.predictions.size(); ++j) {
      const Prediction &a = results.predictions[i], &b = results.predictions[j];
      Json pair{{"between", {name_of(a.solver), name_of(b.solver)}}};
      pair.update(distance_json(compare(a, b)));
      for (const auto& [name, part] : skin_parts(results.patient))
        pair[name] = distance_json(compare(a, b, part));
      out.push_back(std::move(pair));
    }
  }
  return out;
}

Json times_json(const CaseResults& results, const Context& context) {
  Json out = Json::object();
  for (const StageTime& t : context.stage_times()) out[t.stage] = out.value(t.stage, 0.0) + t.seconds;
  for (const Prediction& p : results.predictions) {
    out[std::string(name_of(p.solver)) + " set-up"] = p.setup_seconds;
    out[std::string(name_of(p.solver)) + " solve"] = p.solve_seconds;
  }
  return out;
}

}  // namespace

std::string result_json(const CaseResults& results, const Context& context) {
  Json out{{"turgor", results.record.version}, {"command", results.record.command_line}};
  out["units"] = "mm, g, ms, N, MPa; coordinates LPS";
  out["scan"] = scan_json(results.patient);
  out["plan"] = {{"name", results.record.plan_name}, {"commands", results.record.plan_text}};
  out["parameters"] = parameters_json(results);
  out["head"] = head_json(results.patient.head());
  out["tissue"] = tissue_json(results.patient.tissue());
  out["bones"] = bones_json(results.patient.bones());
  out["predictions"] = Json::array();
  for (const Prediction& p : results.predictions)
    out["predictions"].push_back(prediction_json(results.patient, p));
  out["distances_between_solvers"] = distances_json(results);
  out["notices"] = Json::array();
  for (const Notice& n : context.notices()) out["notices"].push_back(n.text);
  out["seconds"] = times_json(results, context);
  // Names of files may hold bytes that are not UTF-8: they are replaced, never thrown at.
  return out.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

}  // namespace turgor
