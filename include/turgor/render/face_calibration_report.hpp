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

/// calibration.json, which predict takes with -constants, report.html and pictures, into `folder` (which
/// exists; callers stage it).
Result<void> write_face_calibration(const FaceCalibrationResults& results,
                                    const std::filesystem::path& folder, Context& context);

}  // namespace turgor
