// What a prediction leaves behind: meshes, numbers, pictures and the report.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "turgor/core/context.hpp"
#include "turgor/render/case_pictures.hpp"
#include "turgor/world/prediction.hpp"

namespace turgor {

/// How the run was asked for; goes into result.json and the report as it is.
struct RunRecord {
  std::string version;  ///< of the program
  std::string command_line;
  std::string plan_name;  ///< file name of the plan
  std::string plan_text;  ///< the commands executed, one a line, in canonical form
  SolverOptions solver_options;
};

/// Everything in one place for the writers below. `predictions.front()` is the main one, shown in the
/// pictures.
struct CaseResults {
  const PatientCase& patient;
  const std::vector<Prediction>& predictions;
  RunRecord record;
};

/// Meshes, result.json, pictures and report.html, into `folder` (which exists; callers stage it).
Result<void> write_results(const CaseResults& results, const std::filesystem::path& folder, Context& context);

/// result.json: every input, parameter, version, count, timing, landmark displacement, ratio and distance
/// between solvers.
std::string result_json(const CaseResults& results, const Context& context);
/// report.html: one file without outside links; it ends with `json`, that of result_json().
std::string report_html(const CaseResults& results, const std::vector<Picture>& pictures,
                        std::string_view json, const Context& context);
/// skin_before, skin_after (.ply, .vtp, .glb), bones, tissue.vtu.
Result<void> write_meshes(const CaseResults& results, const std::filesystem::path& folder);

}  // namespace turgor
