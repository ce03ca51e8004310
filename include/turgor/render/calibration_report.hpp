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

/// An error, or a size that errors are compared with: forces in N; lengths in metres and mm, of bodies below
/// 0.1 m in mm first: "0.104 m (104 mm)". "did not come to rest" where it is not finite.
std::string error_text(const CalibrationResults& results, double error);
/// The material of the uncalibrated guess and its constants, the same throughout: one line.
std::string guess_text(const CalibrationResults& results);
/// For a terminal: the guess, and of each load the errors before and after, and the reference; a line each.
std::string calibration_summary(const CalibrationResults& results);

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
/// constants.vtu: the calibrated constants (write_solid_constants()), for a scene to load.
/// load_N.vtu: displacements and errors, mm, of reference, uncalibrated and calibrated model under that load;
/// load_N_….ply: those shapes' surfaces.
Result<void> write_calibration_meshes(const CalibrationResults& results, const std::filesystem::path& folder);

}  // namespace turgor
