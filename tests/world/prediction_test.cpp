#include "turgor/world/prediction.hpp"

#include <gtest/gtest.h>

#include "phantom_patient.hpp"
#include "support/example_scan.hpp"
#include "turgor/core/parallel.hpp"
#include "turgor/surgery/operations.hpp"
#include "turgor/world/reference_bands.hpp"

namespace turgor {
namespace {

Prediction predicted_setback(const ContactOptions& contact) {
  CaseOptions options;
  options.contact = contact;
  PatientCase patient = phantom_case(options);
  EXPECT_TRUE(static_cast<bool>(sagittal_split(patient.bones(), patient_of(patient), -6)));
  Context context;
  auto p = predict(patient, Solver::network, {}, context);
  EXPECT_TRUE(static_cast<bool>(p)) << p.error().message();
  return *std::move(p);
}

TEST(Predict, ASetbackOnThePhantomTakesTheSoftChinAlong) {
  const PatientCase patient = with_setback(6);
  Context context;
  const auto p = predict(patient, Solver::network, {}, context);
  ASSERT_TRUE(static_cast<bool>(p)) << p.error().message();
  EXPECT_TRUE(p->equilibrium.converged);
  EXPECT_LT(p->inverted, patient.tissue().prisms() / 500);
  EXPECT_LT(p->deepest_contact_mm, 1.5);
  bool judged = false;
  for (const BandResult& b : judge(patient, *p)) {
    RecordProperty(std::string(b.band->soft), std::to_string(b.ratio));
    if (b.band->soft != "soft_pogonion") continue;
    judged = true;
    EXPECT_GE(b.ratio, 0.85);
    EXPECT_LE(b.ratio, 1.15);
  }
  EXPECT_TRUE(judged);
  // The upper face stays.
  EXPECT_LT(length(shift_of(*p, "pronasale").after - shift_of(*p, "pronasale").before), 1.0);
  EXPECT_LT(length(shift_of(*p, "soft_nasion").after - shift_of(*p, "soft_nasion").before), 0.1);
}

TEST(Predict, TheChainAgreesInDirectionAndKeepsTheUpperFace) {
  const PatientCase patient = with_setback(6);
  Context context;
  const auto p = predict(patient, Solver::chain, {}, context);
  ASSERT_TRUE(static_cast<bool>(p)) << p.error().message();
  const LandmarkShift& chin = shift_of(*p, "soft_pogonion");
  EXPECT_GT(chin.after.y - chin.before.y, 3.0);
  EXPECT_LT(length(shift_of(*p, "soft_nasion").after - shift_of(*p, "soft_nasion").before), 1.0);
}

TEST(Predict, MouthOpeningPartsTheLips) {
  PatientCase patient = phantom_case();
  ASSERT_TRUE(static_cast<bool>(open_mouth(patient.bones(), patient_of(phantom_case()), radians(20))));
  Context context;
  SolverOptions options;
  options.equilibrium.relative_residual = 1e-3;
  const auto p = predict(patient, Solver::network, options, context);
  ASSERT_TRUE(static_cast<bool>(p)) << p.error().message();
  const LandmarkShift &upper = shift_of(*p, "labrale_superius"), &lower = shift_of(*p, "labrale_inferius");
  const double before = distance(upper.before, lower.before), after = distance(upper.after, lower.after);
  EXPECT_GT(after, before + 8);
  EXPECT_LT(length(upper.after - upper.before), 0.5 * length(lower.after - lower.before));
  EXPECT_LT(p->inverted, patient.tissue().prisms() / 50);
}

TEST(Predict, MucosaSlidesOverTheTeethButDoesNotLeaveThem) {
  const auto follow = [](double adhesion_n_mm) {
    ContactOptions contact;
    contact.adhesion_n_mm = adhesion_n_mm;
    const Prediction p = predicted_setback(contact);
    const LandmarkShift& lip = shift_of(p, "labrale_inferius");
    return lip.after.y - lip.before.y;
  };
  const double wet = follow(0.1), dry = follow(0);
  EXPECT_GT(wet, dry + 1.0) << "a dry lip stays before its teeth as they go back";
  EXPECT_LT(wet, 6.0 * 1.15);
}

TEST(Predict, FreeTissueStaysOutOfBoneThatComesForward) {
  PatientCase patient = phantom_case();
  ASSERT_TRUE(static_cast<bool>(sagittal_split(patient.bones(), patient_of(phantom_case()), 6)));
  Context context;
  const auto p = predict(patient, Solver::network, {}, context);
  ASSERT_TRUE(static_cast<bool>(p)) << p.error().message();
  EXPECT_LT(p->deepest_contact_mm, 3.0);
  for (const char* name : {"soft_pogonion", "labrale_inferius"}) {
    EXPECT_LT(shift_of(*p, name).after.y, shift_of(*p, name).before.y - 3.0) << name;
  }
}

TEST(Predict, UnderminedTissueFollowsNeitherBone) {
  const auto inverted = [](double undermining_mm) {
    ContactOptions contact;
    contact.undermining_mm = undermining_mm;
    return predicted_setback(contact).inverted;
  };
  EXPECT_LT(inverted(10), inverted(0)) << "held on both sides of the cut, prisms fold";
}

TEST(Predict, IsTheSameOnOneAndTwoThreads) {
  const PatientCase patient = with_setback(6);
  Context context;
  set_thread_count(1);
  const auto one = predict(patient, Solver::network, {}, context);
  set_thread_count(2);
  const auto two = predict(patient, Solver::network, {}, context);
  set_thread_count(0);
  ASSERT_TRUE(one && two);
  EXPECT_TRUE(one->skin.points == two->skin.points);
}

TEST(Predict, APlanThatMovesNothingIsAnError) {
  Context context;
  const auto p = predict(phantom_case(), Solver::network, {}, context);
  ASSERT_FALSE(static_cast<bool>(p));
  EXPECT_NE(p.error().message().find("no bone under the tissue moves"), std::string::npos);
}

TEST(Predict, AMoveThatDrivesBoneThroughSkinIsAnError) {
  PatientCase patient = phantom_case();
  ASSERT_TRUE(static_cast<bool>(patient.bones().move("mandible", RigidTransform::translate({0, -70, 0}))));
  Context context;
  for (const Solver solver : {Solver::network, Solver::chain}) {
    const auto p = predict(patient, solver, {}, context);
    ASSERT_FALSE(static_cast<bool>(p)) << name_of(solver);
    EXPECT_NE(p.error().message().find("'mandible'"), std::string::npos) << p.error().message();
  }
}

TEST(Predict, ReleasedTissueDoesNotFollowTheBone) {
  PatientCase released = with_setback(6);
  ASSERT_TRUE(static_cast<bool>(released.edit_attachment({false, "distal", {}, {}})));
  Context context;
  const auto all = predict(released, Solver::network, {}, context);
  EXPECT_FALSE(static_cast<bool>(all));  // nothing is left that moves

  // Only the chin's point goes back: what is off the bone there stays with the tissue around it.
  SegmentMove back;
  back.forward = -6;
  PatientCase held = phantom_case();
  ASSERT_TRUE(static_cast<bool>(genioplasty(held.bones(), patient_of(held), back)));
  PatientCase part = held;
  const Vec3 chin = held.landmarks().find("pogonion")->second.point;
  ASSERT_TRUE(static_cast<bool>(part.edit_attachment({false, "chin", {}, std::pair{chin, 18.0}})));
  const auto a = predict(held, Solver::network, {}, context), b = predict(part, Solver::network, {}, context);
  ASSERT_TRUE(a && b);
  const auto follow = [](const Prediction& p) {
    return shift_of(p, "soft_pogonion").after.y - shift_of(p, "soft_pogonion").before.y;
  };
  EXPECT_LT(follow(*b), follow(*a) - 0.4);
}

TEST(Predict, TheRealScansMidfaceComesForward) {
  TURGOR_NEED_EXAMPLE_SCAN();
  Context context;
  auto patient = PatientCase::open(test::example_scan(), {}, context);
  ASSERT_TRUE(static_cast<bool>(patient)) << patient.error().message();
  EXPECT_EQ(patient->head().mandible_state, MandibleState::absent);
  EXPECT_TRUE(patient->scan_info().stored_left_handed);
  SegmentMove move;
  move.forward = 5;
  const auto cut = le_fort_1(patient->bones(), {patient->head(), patient->landmarks()}, move);
  ASSERT_TRUE(static_cast<bool>(cut)) << cut.error().message();
  const auto p = predict(*patient, Solver::network, {}, context);
  ASSERT_TRUE(static_cast<bool>(p)) << p.error().message();
  EXPECT_LT(p->inverted, patient->tissue().prisms() / 500);
  const LandmarkShift& base = shift_of(*p, "subnasale");
  EXPECT_LT(base.after.y, base.before.y - 1.0);
  EXPECT_LT(length(shift_of(*p, "soft_nasion").after - shift_of(*p, "soft_nasion").before), 0.5);
}

}  // namespace
}  // namespace turgor
