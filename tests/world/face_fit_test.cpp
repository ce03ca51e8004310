#include "turgor/world/face_fit.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "phantom_patient.hpp"
#include "turgor/core/index.hpp"

namespace turgor {
namespace {

// Few columns: each run takes a tenth of a second.
const PatientCase& small_case() {
  static const PatientCase patient = [] {
    CaseOptions options;
    options.head.skin_triangles = 12'000;
    options.head.bone_triangles = 20'000;
    options.tissue.columns = 700;
    return phantom_case(options);
  }();
  return patient;
}

std::shared_ptr<const PatientCase> moved(double mm) {
  auto patient = std::make_shared<PatientCase>(small_case());
  const auto done = sagittal_split(patient->bones(), patient_of(small_case()), -mm);
  EXPECT_TRUE(static_cast<bool>(done)) << done.error().message();
  return patient;
}

Prediction predicted(const PatientCase& patient, Solver solver, const SolverOptions& options) {
  Context context;
  auto p = predict(patient, solver, options, context);
  EXPECT_TRUE(static_cast<bool>(p)) << p.error().message();
  return p ? *std::move(p) : Prediction{};
}

// A setback of 6 mm to fit, one of 8 mm held out.
std::vector<FaceMove> moves_by(Solver reference, const SolverOptions& options) {
  std::vector<FaceMove> moves;
  for (const double mm : {6.0, 8.0}) {
    auto patient = moved(mm);
    Prediction prediction = predicted(*patient, reference, options);
    moves.push_back({mm == 6 ? "setback" : "larger", mm != 6, std::move(patient), std::move(prediction)});
  }
  return moves;
}

FaceOutcome calibrated(const std::vector<FaceMove>& moves, int budget) {
  Context context;
  auto face = make_face_fit(moves, {});
  EXPECT_TRUE(static_cast<bool>(face)) << face.error().message();
  FitOptions search;
  search.coarse_samples = 0, search.budget = budget, search.regularisation = 1e-4;
  auto fit = calibrate(face->problem, search, context);
  EXPECT_TRUE(static_cast<bool>(fit)) << fit.error().message();
  auto outcome = outcome_of(moves, *face, *std::move(fit), {}, context);
  EXPECT_TRUE(static_cast<bool>(outcome)) << outcome.error().message();
  return *std::move(outcome);
}

double mean_distance(const FaceMove& move, const Prediction& network) {
  for (const auto& [name, within] : skin_parts(*move.patient))
    if (name == kLowerThird) return compare(network, move.reference, within).mean;
  ADD_FAILURE() << "no lower third";
  return 0;
}

TEST(FaceFit, FindsAFaceWhoseConstantsAreOthers) {
  SolverOptions other;
  other.factors.factors = {{"diagonal springs of layer 1", 6.0}, {"volumes of layer 2", 0.3}};
  const std::vector<FaceMove> moves = moves_by(Solver::network, other);
  const FaceOutcome outcome = calibrated(moves, 6);
  for (std::size_t m = 0; m < moves.size(); ++m) {
    const double before = mean_distance(moves[m], outcome.uncalibrated[m]),
                 after = mean_distance(moves[m], outcome.calibrated[m]);
    RecordProperty(moves[m].name, std::to_string(before) + " " + std::to_string(after));
    EXPECT_GT(before, 0.05) << moves[m].name;
    EXPECT_LT(after, 0.35 * before) << moves[m].name;
  }
}

TEST(FaceFit, ComesNearerToFiniteElementsInTheMoveThatIsFittedAndInAnother) {
  SolverOptions coarse;
  coarse.cubes.spacing_mm = 5;
  coarse.cubes.material = ElasticMaterial{};
  coarse.cubes.material.youngs_modulus_mpa = 0.015;
  coarse.cubes.material.poissons_ratio = 0.45;
  const std::vector<FaceMove> moves = moves_by(Solver::fem, coarse);
  const FaceOutcome outcome = calibrated(moves, 5);
  for (std::size_t m = 0; m < moves.size(); ++m) {
    const double before = mean_distance(moves[m], outcome.uncalibrated[m]),
                 after = mean_distance(moves[m], outcome.calibrated[m]);
    RecordProperty(moves[m].name, std::to_string(before) + " " + std::to_string(after));
    EXPECT_LT(after, 0.85 * before) << moves[m].name;
  }
}

TEST(FaceFit, FactorsScaleTheirLayerAndKindAlone) {
  const LayeredTissue& tissue = small_case().tissue();
  const auto network = make_network(tissue, {});
  ASSERT_TRUE(static_cast<bool>(network));
  SpringNetwork scaled = *network;
  const LayerFactors factors{{1, 1, 1}, {{"vertical springs of layer 1", 3.0}, {"volumes of layer 0", 0.5}}};
  ASSERT_TRUE(static_cast<bool>(scale_layers(tissue, factors, scaled)));
  for (std::size_t s = 0; s < scaled.springs.size(); ++s) {
    const Spring& spring = network->springs[s];
    const int layer = std::min(spring.a, spring.b) / tissue.columns();
    const double factor = spring.kind == SpringKind::vertical && layer == 1 ? 3 : 1;
    ASSERT_NEAR(scaled.springs[s].stiffness_n, factor * spring.stiffness_n, 1e-12 * spring.stiffness_n);
  }
  for (std::size_t v = 0; v < scaled.volumes.size(); ++v) {
    const VolumeElement& volume = network->volumes[v];
    const double factor = *std::min_element(volume.p, volume.p + 4) < tissue.columns() ? 0.5 : 1;
    ASSERT_NEAR(scaled.volumes[v].modulus_mpa, factor * volume.modulus_mpa, 1e-12 * volume.modulus_mpa);
  }
}

TEST(FaceFit, RefusesFactorsThatTheTissueDoesNotHave) {
  const LayeredTissue& tissue = small_case().tissue();
  auto network = make_network(tissue, {});
  ASSERT_TRUE(static_cast<bool>(network));
  for (const auto& [name, factor] :
       {std::pair("vertical springs of layer 7", 1.0), std::pair("vertical springs of layer 1", 0.0),
        std::pair("vertical springs of layer 1", std::nan(""))}) {
    SpringNetwork copy = *network;
    EXPECT_FALSE(static_cast<bool>(scale_layers(tissue, {{1, 1, 1}, {{name, factor}}}, copy))) << name;
  }
  EXPECT_FALSE(static_cast<bool>(make_face_fit({}, {})));
}

}  // namespace
}  // namespace turgor
