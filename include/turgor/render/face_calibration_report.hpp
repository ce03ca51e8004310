// What a calibration of a face leaves behind: its constants, the distances before and after, pictures.
#pragma once

#include <filesystem>

#include "turgor/core/context.hpp"
#include "turgor/render/calibration_report.hpp"
#include "turgor/world/face_fit.hpp"

namespace turgor {

struct FaceCalibrationResults {
  const std::vector<FaceMove>& moves;
  const FaceFit& face;
  const FitOptions& search;
  const FaceOutcome& outcome;
  CalibrationRecord record;
};
/// Distances of the network from the reference in the lower third of the face, where that is known; else over
/// all of it.
SkinDistance lower_third_distance(const FaceMove& move, const Prediction& network);
/// How far the reference moves the skin there: what such distances are parts of.
SkinDistance reference_movement(const FaceMove& move);

/// Every input, factor with its bounds and deviation, distance of each move, sample.
std::string face_calibration_json(const FaceCalibrationResults& results, const Context& context);
/// One file without outside links; it ends with `json`, that of face_calibration_json().
std::string face_calibration_html(const FaceCalibrationResults& results, const std::vector<Picture>& pictures,
                                  std::string_view json, const Context& context);
/// calibration.json, which predict takes with -constants, report.html and pictures, into `folder` (which
/// exists; callers stage it).
Result<void> write_face_calibration(const FaceCalibrationResults& results,
                                    const std::filesystem::path& folder, Context& context);

}  // namespace turgor
