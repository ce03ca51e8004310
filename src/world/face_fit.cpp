#include "turgor/world/face_fit.hpp"

#include <algorithm>
#include <utility>

#include "turgor/core/index.hpp"
#include "world/bone_contact.hpp"
#include "world/tissue_motion.hpp"
#include "world/tissue_solve.hpp"

namespace turgor {
namespace {

/// What a run needs of a move.
struct PreparedMove {
  PreparedMove(std::shared_ptr<const PatientCase> of, TissueMotion moved)
      : patient(std::move(of)), motion(std::move(moved)), bone(*patient) {}
  std::shared_ptr<const PatientCase> patient;
  TissueMotion motion;
  BoneContact bone;
};

NetworkLoad load_of(const std::string& name, std::shared_ptr<const PreparedMove> move) {
  NetworkLoad load{name, move->motion.motion, {}};
  load.rest = [move = std::move(move)](SpringNetwork& network, const EquilibriumOptions& options,
                                       const std::vector<Vec3>* start, Context& context) {
    return settle_network(*move->patient, options, move->motion, move->bone, network, start, nullptr,
                          context);
  };
  return load;
}

std::vector<double> weights_of(const PatientCase& patient, std::span<const int> points, double elsewhere) {
  std::vector<double> out(points.size(), 1);
  for (const auto& [name, within] : parts_of_face(patient, patient.tissue().surface.points)) {
    if (name != kLowerThird) continue;
    for (std::size_t i = 0; i < out.size(); ++i)
      if (!within[at(points[i])]) out[i] = elsewhere;
  }
  return out;
}

ReferenceLoad reference_of(const FaceMove& move, std::span<const int> points, double elsewhere) {
  ReferenceLoad out{move.name, {}, weights_of(*move.patient, points, elsewhere), !move.held_out, {}};
  for (const int p : points) {
    out.reference.position_mm.push_back(move.reference.surface_points[at(p)]);
    out.rest_mm.push_back(move.patient->tissue().surface.points[at(p)]);
  }
  return out;
}

}  // namespace

LayerFactors FaceFit::factors(std::span<const double> values) const {
  LayerFactors out{nodes, {}};
  for (std::size_t p = 0; p < values.size(); ++p)
    out.factors.emplace_back(problem.parameters[p].name, values[p]);
  return out;
}

Result<FaceFit> make_face_fit(const std::vector<FaceMove>& moves, const FaceFitOptions& options) {
  if (moves.empty()) {
    return Error{ErrorKind::bad_input, "there is no move to calibrate with", "calibration of a face",
                 "Give at least one plan"};
  }
  FaceFit out;
  out.nodes = options.nodes;
  const LayeredTissue& tissue = moves.front().patient->tissue();
  TURGOR_TRY(SpringNetwork network, make_network(tissue, moves.front().patient->options().material));
  for (int c = 0; c < tissue.columns(); ++c)
    if (!tissue.fixed[at(c)]) out.points.push_back(c);
  std::vector<NetworkLoad> loads;
  for (const FaceMove& move : moves) {
    out.problem.loads.push_back(reference_of(move, out.points, options.weight_elsewhere));
    TURGOR_TRY(TissueMotion motion, tissue_motion(*move.patient));
    loads.push_back(load_of(move.name, std::make_shared<PreparedMove>(move.patient, std::move(motion))));
  }
  TURGOR_TRY(LayeredFit fit, make_layered_fit(std::move(network), tissue, options.nodes, std::move(loads)));
  fit.fit.points = out.points;
  fit.fit.options.relative_residual = options.relative_residual;
  out.parameters = std::move(fit.parameters);
  out.problem.parameters = out.parameters.parameters;
  for (FitParameter& p : out.problem.parameters) p.low = options.low, p.high = options.high;
  TURGOR_TRY(out.model, make_forward_model(std::move(fit.fit)));
  out.problem.model = out.model.get();
  return out;
}

Result<FaceOutcome> outcome_of(const std::vector<FaceMove>& moves, const FaceFit& face, Fit fit,
                               SolverOptions options, Context& context) {
  FaceOutcome out;
  for (const auto& [factors, predictions] : {std::pair(LayerFactors{}, &out.uncalibrated),
                                             std::pair(face.factors(fit.parameters), &out.calibrated)}) {
    options.factors = factors;
    for (const FaceMove& move : moves) {
      TURGOR_TRY(Prediction prediction, predict(*move.patient, Solver::network, options, context));
      predictions->push_back(std::move(prediction));
    }
  }
  out.fit = std::move(fit);
  return out;
}

}  // namespace turgor
