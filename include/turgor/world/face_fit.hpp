// The layered network of a face, fitted to predictions by a constitutive law of the same moves of the bones.
#pragma once

#include <memory>
#include <span>
#include <string>
#include <vector>

#include "turgor/calibration/calibrate.hpp"
#include "turgor/core/context.hpp"
#include "turgor/world/layered_fit.hpp"
#include "turgor/world/patient_case.hpp"
#include "turgor/world/prediction.hpp"

namespace turgor {

/// A plan carried out on the patient, and what the reference (`fem`) says of it.
struct FaceMove {
  std::string name;
  bool held_out = false;                       ///< only measured: how the constants carry over
  std::shared_ptr<const PatientCase> patient;  ///< of one scan and tissue for all moves
  Prediction reference;
};

struct FaceFitOptions {
  Index3 nodes{1, 1, 1};          ///< of the grid of factors over the tissue
  double low = 0.01, high = 100;  ///< bounds of the factors
  /// Weight of skin outside the lower third, where that is known: what the operation is not about.
  double weight_elsewhere = 0.1;
  double relative_residual = 1e-4;
};

/// Compared are the places of the layered tissue's skin points.
struct FaceFit {
  GroupedParameters parameters;
  std::unique_ptr<ForwardModel> model;
  CalibrationProblem problem;  ///< points to the model
  std::vector<int> points;     ///< of the tissue's skin, that are compared
  Index3 nodes{1, 1, 1};

  /// As SolverOptions take them.
  [[nodiscard]] LayerFactors factors(std::span<const double> parameters) const;
};
/// Planes of the bone are laid anew in every run, as in predict(). Errors: no moves; those of make_network(),
/// tissue_motion() and make_layered_fit().
Result<FaceFit> make_face_fit(const std::vector<FaceMove>& moves, const FaceFitOptions& options);

/// What the search means for the face: predictions by the network, in the order of the moves.
struct FaceOutcome {
  Fit fit;
  std::vector<Prediction> uncalibrated, calibrated;
};
/// Errors: those of predict().
Result<FaceOutcome> outcome_of(const std::vector<FaceMove>& moves, const FaceFit& face, Fit fit,
                               SolverOptions options, Context& context);

}  // namespace turgor
