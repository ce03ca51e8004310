// What a calibration leaves behind: numbers, meshes, pictures and the report (Morris 2006, figures 7 to 14).
#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "turgor/core/context.hpp"
#include "turgor/render/case_pictures.hpp"
#include "turgor/world/calibration_case.hpp"

namespace turgor {

/// How the run was asked for; goes into calibration.json and the report as it is.
struct CalibrationRecord {
  std::string version;  ///< of the program
  std::string command_line;
  std::string problem_name;  ///< file name of the problem
  std::string problem_text;  ///< its commands, one a line, in canonical form
};
/// Everything in one place for the writers below.
struct CalibrationResults {
  const CalibrationCase& problem;
  const CalibrationOutcome& outcome;
  CalibrationRecord record;
};

/// calibration.json, report.html, pictures, shapes of each load and the calibrated constants, into `folder`
/// (which exists; callers stage it).
Result<void> write_calibration(const CalibrationResults& results, const std::filesystem::path& folder,
                               Context& context);

/// Of each load the undeformed body, the reference, the uncalibrated and the calibrated one beside each
/// other, errors in colours on one scale (figures 7, 10 and 13); the search (figure 8); the constants on the
/// body (figures 13 and 14).
Result<std::vector<Picture>> calibration_pictures(const CalibrationResults& results,
                                                  const PictureOptions& options, Context& context);
/// Every input, parameter with its bounds and deviation, error of each load, sample.
std::string calibration_json(const CalibrationResults& results, const Context& context);
/// One file without outside links; it ends with `json`, that of calibration_json().
std::string calibration_html(const CalibrationResults& results, const std::vector<Picture>& pictures,
                             std::string_view json, const Context& context);
/// constants.vtu: the edges, triangles and tetrahedra of the model (2, 3 and 4 `corners`) at rest, with their
/// calibrated constants k_d, k_a and k_v in N·mm as tissue/solid.hpp takes them, and as stiffness in MPa.
/// load_N.vtu: displacements and errors, mm, of reference, uncalibrated and calibrated model under that load;
/// load_N_….ply: those shapes' surfaces.
Result<void> write_calibration_meshes(const CalibrationResults& results, const std::filesystem::path& folder);

}  // namespace turgor
