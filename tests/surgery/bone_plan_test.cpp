#include "turgor/surgery/bone_plan.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "support/phantom_case.hpp"
#include "turgor/surgery/operations.hpp"

namespace turgor {
namespace {

// A closed box, outward triangles.
TriMesh box(const Vec3& lower, const Vec3& upper) {
  TriMesh mesh;
  for (int i = 0; i < 8; ++i) {
    mesh.points.push_back(
        {(i & 1) ? upper.x : lower.x, (i & 2) ? upper.y : lower.y, (i & 4) ? upper.z : lower.z});
  }
  mesh.triangles = {{0, 2, 1}, {1, 2, 3}, {4, 5, 6}, {5, 7, 6}, {0, 1, 4}, {1, 5, 4},
                    {2, 6, 3}, {3, 6, 7}, {0, 4, 2}, {2, 4, 6}, {1, 3, 5}, {3, 7, 5}};
  return mesh;
}

Head box_head() {
  Head head;
  head.skull = box({-50, -50, 0}, {50, 50, 80});
  head.mandible = box({-40, -50, -40}, {40, 0, -5});
  head.mandible_state = MandibleState::separate;
  return head;
}

TEST(BonePlan, AnOsteotomyKeepsTheVolumeAndClosesBothParts) {
  BonePlan plan(box_head());
  CutRegion region;
  region.planes = {Plane::through({0, -20, 0}, {0, -1, 0.2}), Plane::through({0, 0, -20}, {0, 0, -1})};
  const double whole = enclosed_volume(plan.segments()[1].surface);
  ASSERT_TRUE(static_cast<bool>(plan.osteotomy("chin", "mandible", region)));
  double parts = 0;
  for (const char* name : {"mandible", "chin"}) {
    const TriMesh& surface = plan.segments()[static_cast<std::size_t>(plan.find(name))].surface;
    EXPECT_TRUE(topology(surface).closed()) << name;
    parts += enclosed_volume(surface);
  }
  EXPECT_NEAR(parts, whole, 1e-6 * whole);
}

TEST(BonePlan, PointsBelongToTheInnermostSegmentThatHoldsThem) {
  BonePlan plan(box_head());
  CutRegion front, chin;
  front.planes = {Plane::through({0, -20, 0}, {0, -1, 0})};
  chin.planes = {Plane::through({0, 0, -30}, {0, 0, -1})};
  ASSERT_TRUE(static_cast<bool>(plan.osteotomy("distal", "mandible", front)));
  ASSERT_TRUE(static_cast<bool>(plan.osteotomy("chin", "distal", chin)));
  const auto name_at = [&](Bone bone, const Vec3& p) {
    return plan.segments()[static_cast<std::size_t>(plan.segment_at(bone, p))].name;
  };
  EXPECT_EQ(name_at(Bone::mandible, {0, -10, -35}), "mandible");
  EXPECT_EQ(name_at(Bone::mandible, {0, -40, -20}), "distal");
  EXPECT_EQ(name_at(Bone::mandible, {0, -40, -35}), "chin");
  EXPECT_EQ(name_at(Bone::skull, {0, -40, -35}), "skull");
}

TEST(BonePlan, MistakesAreNamed) {
  BonePlan plan(box_head());
  CutRegion miss, all;
  miss.planes = {Plane::through({0, 0, 500}, {0, 0, 1})};
  all.planes = {Plane::through({0, 0, -500}, {0, 0, 1})};
  const auto message = [&](const Result<void>& r) {
    return r ? std::string("no error") : r.error().message();
  };
  EXPECT_NE(message(plan.osteotomy("x", "mandible", miss)).find("miss the bone"), std::string::npos);
  EXPECT_NE(message(plan.osteotomy("x", "mandible", all)).find("cut nothing"), std::string::npos);
  EXPECT_NE(message(plan.osteotomy("x", "femur", miss)).find("no bone segment 'femur'"), std::string::npos);
  EXPECT_NE(message(plan.osteotomy("skull", "mandible", miss)).find("taken"), std::string::npos);
  EXPECT_NE(message(plan.move("femur", {})).find("skull, mandible"), std::string::npos);
}

TEST(Operations, ASetbackMovesTheChinBackAndKeepsTheCondyles) {
  const auto& c = test::phantom_case();
  BonePlan plan(c.head);
  const Patient patient{c.head, c.landmarks};
  const auto done = sagittal_split(plan, patient, -6);
  ASSERT_TRUE(static_cast<bool>(done)) << done.error().message();
  const auto shift = [&](const char* name) {
    const Vec3 p = c.landmarks.find(name)->second.point;
    const int s = plan.segment_at(Bone::mandible, p);
    return plan.segments()[static_cast<std::size_t>(s)].motion.point(p) - p;
  };
  EXPECT_NEAR(shift("pogonion").y, 6, 0.05);
  EXPECT_NEAR(length(shift("pogonion")), 6, 1e-9);
  EXPECT_EQ(length(shift("condylion_left")), 0);
  EXPECT_EQ(length(shift("gonion_right")), 0);
  EXPECT_NEAR(length(shift("lower_incisor")), 6, 1e-9);
}

TEST(Operations, MouthOpeningTurnsTheWholeMandibleDownAboutTheCondyles) {
  const auto& c = test::phantom_case();
  BonePlan plan(c.head);
  const Patient patient{c.head, c.landmarks};
  ASSERT_TRUE(static_cast<bool>(sagittal_split(plan, patient, -2)));
  ASSERT_TRUE(static_cast<bool>(open_mouth(plan, patient, radians(20))));
  const RigidTransform& motion = plan.segments()[static_cast<std::size_t>(plan.find("distal"))].motion;
  const Vec3 menton = c.landmarks.find("menton")->second.point;
  EXPECT_LT(motion.point(menton).z, menton.z - 14);
  EXPECT_GT(motion.point(menton).y, menton.y + 10);
  const Vec3 condyle = c.landmarks.find("condylion_left")->second.point;
  const RigidTransform& ramus = plan.segments()[static_cast<std::size_t>(plan.find("mandible"))].motion;
  EXPECT_LT(distance(ramus.point(condyle), condyle), 4);
}

TEST(Operations, EachCutsAPartOfItsBoneAndMovesItAsAsked) {
  const auto& c = test::phantom_case();
  const Patient patient{c.head, c.landmarks};
  SegmentMove move;
  move.forward = 5;
  move.up = 2;
  const auto volume = [](const TriMesh& m) { return std::abs(enclosed_volume(m)); };
  const auto check = [&](const char* segment, Bone bone, auto&& operate) {
    BonePlan plan(c.head);
    const auto done = operate(plan);
    ASSERT_TRUE(static_cast<bool>(done)) << segment << ": " << done.error().message();
    const int i = plan.find(segment);
    ASSERT_GE(i, 0) << segment;
    const BoneSegment& s = plan.segments()[static_cast<std::size_t>(i)];
    EXPECT_EQ(s.bone, bone);
    EXPECT_NEAR(s.motion.translation.y, -5, 0.2) << segment;
    EXPECT_NEAR(s.motion.translation.z, 2, 0.2) << segment;
    const double part = volume(s.surface) / volume(bone == Bone::skull ? c.head.skull : c.head.mandible);
    EXPECT_GT(part, 0.004) << segment;
    EXPECT_LT(part, 0.6) << segment;
  };
  check("chin", Bone::mandible, [&](BonePlan& p) { return genioplasty(p, patient, move); });
  check("maxilla", Bone::skull, [&](BonePlan& p) { return le_fort_1(p, patient, move); });
  check("midface_2", Bone::skull, [&](BonePlan& p) { return le_fort_2(p, patient, move); });
  check("midface_3", Bone::skull, [&](BonePlan& p) { return le_fort_3(p, patient, move); });
  check("zygoma_left", Bone::skull, [&](BonePlan& p) { return zygoma(p, patient, Side::left, move); });
  check("zygoma_right", Bone::skull, [&](BonePlan& p) { return zygoma(p, patient, Side::right, move); });
}

TEST(Operations, WithoutAMandibleTheErrorSaysSo) {
  Head head = box_head();
  head.mandible = {};
  head.mandible_state = MandibleState::absent;
  BonePlan plan(head);
  const auto done = sagittal_split(plan, {head, {}}, -6);
  ASSERT_FALSE(static_cast<bool>(done));
  EXPECT_NE(done.error().message().find("needs a mandible"), std::string::npos);
}

}  // namespace
}  // namespace turgor
