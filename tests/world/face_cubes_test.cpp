// The face as cubes: what they are made of, what holds them, and the face that they predict.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <set>

#include "phantom_patient.hpp"
#include "turgor/core/index.hpp"
#include "turgor/core/parallel.hpp"
#include "turgor/geometry/surface_query.hpp"
#include "turgor/geometry/voxel_solid.hpp"
#include "turgor/world/reference_bands.hpp"
#include "world/face_skin.hpp"
#include "world/face_supports.hpp"

namespace turgor {
namespace {

FaceSolid face_of(const PatientCase& patient, double spacing_mm) {
  Context context;
  auto face = build_face_solid(patient.head(), patient.tissue(), spacing_mm, context);
  if (!face) {
    ADD_FAILURE() << face.error().message();
    std::abort();
  }
  return *std::move(face);
}

// Coarse enough for a test, fine enough for lips.
SolverOptions coarse() {
  SolverOptions options;
  options.cubes.spacing_mm = 4.5;
  options.cubes.relative_residual = 1e-3;
  return options;
}

Prediction predicted(const PatientCase& patient, Solver solver, const SolverOptions& options = coarse()) {
  Context context;
  auto p = predict(patient, solver, options, context);
  if (!p) {
    ADD_FAILURE() << p.error().message();
    std::abort();
  }
  return *std::move(p);
}

TEST(FaceCubes, FillTheSoftTissueBetweenSkinAndBone) {
  const PatientCase& patient = phantom_case();
  const FaceSolid face = face_of(patient, 3);
  const Head& head = patient.head();
  const SurfaceQuery skin(head.skin), bone({&head.skull, &head.mandible});
  int outside = 0, in_bone = 0;
  constexpr int every = 37;
  for (int c = 0; c < face.cubes(); c += every) {
    Vec3 centre{};
    for (const int p : face.mesh.tetrahedra[at(5 * c + 4)]) centre += face.mesh.points[at(p)] * 0.25;
    outside += skin.inside(centre) ? 0 : 1;
    in_bone += bone.inside(centre) ? 1 : 0;
    EXPECT_LE(face.depth_mm[at(c)], 32.1F);
  }
  EXPECT_LE(outside, 1);
  EXPECT_LE(in_bone, 1);
  // About as much as the layered tissue holds, which ends at less depth where it met no bone.
  const double cubes_ml = face.cubes() * 27e-3;
  double layers_ml = 0;
  const LayeredTissue& tissue = patient.tissue();
  for (const Index3& t : tissue.surface.triangles) {
    const double depth =
        (tissue.thickness_mm[at(t[0])] + tissue.thickness_mm[at(t[1])] + tissue.thickness_mm[at(t[2])]) / 3;
    layers_ml += 0.5 * length(triangle_normal(tissue.surface, t)) * depth * 1e-3;
  }
  EXPECT_NEAR(cubes_ml / layers_ml, 1.0, 0.35);
}

TEST(FaceCubes, HaveNoFilmsBetweenTeeth) {
  const FaceSolid face = face_of(phantom_case(), 2);
  const auto cubes = hexahedra(face.mesh);
  const auto place = [&](std::size_t c) {
    const Vec3 low = (face.mesh.points[at(cubes[c][0])] - face.mesh.points[0]) / face.mesh.spacing;
    return Index3{static_cast<int>(std::lround(low.x)), static_cast<int>(std::lround(low.y)),
                  static_cast<int>(std::lround(low.z))};
  };
  std::set<Index3> there;
  for (std::size_t c = 0; c < cubes.size(); ++c) there.insert(place(c));
  const auto in_block = [&](const Index3& p) {
    for (int block = 0; block < 8; ++block) {
      bool full = true;
      for (int cell = 0; cell < 8 && full; ++cell) {
        Index3 q = p;
        for (std::size_t a = 0; a < 3; ++a) q[a] += ((cell >> a) & 1) - ((block >> a) & 1);
        full = there.contains(q);
      }
      if (full) return true;
    }
    return false;
  };
  // Only skin may be a single cube thick, of nostrils too, which lie deeper below the surface of the layers.
  int thin = 0, deep = 0;
  for (std::size_t c = 0; c < cubes.size(); ++c) {
    if (in_block(place(c))) continue;
    ++thin;
    deep += static_cast<double>(face.depth_mm[c]) > 2 * std::sqrt(3.0) * face.mesh.spacing ? 1 : 0;
  }
  EXPECT_GT(thin, 0);
  EXPECT_LE(deep, 10);
}

TEST(FaceCubes, TheLipsShareNoNode) {
  const PatientCase& patient = phantom_case();
  const LipSlit& slit = *patient.tissue().slit;
  for (const double spacing : {2.0, 3.1}) {
    const FaceSolid face = face_of(patient, spacing);
    for (std::size_t c = 0; c < at(face.cubes()); ++c) {
      double low = 1e9, high = -1e9;
      bool within = true;
      for (std::size_t t = 5 * c; t < 5 * c + 5; ++t) {
        for (const int p : face.mesh.tetrahedra[t]) {
          const double height = slit.plane.signed_distance(face.mesh.points[at(p)]);
          low = std::min(low, height), high = std::max(high, height);
          within = within && slit.covers(face.mesh.points[at(p)]);
        }
      }
      EXPECT_FALSE(within && low < -1e-9 && high > 1e-9) << "cube " << c << " spans the slit";
    }
  }
}

TEST(FaceCubes, AffineMotionOfTheNodesIsThatOfTheSkin) {
  const PatientCase& patient = phantom_case();
  const FaceSolid face = face_of(patient, 4);
  const auto field = [](const Vec3& p) {
    return Vec3{0.02 * p.x - 0.01 * p.z + 1, 0.03 * p.y + 0.01 * p.x - 2, 0.02 * p.z - 0.01 * p.y};
  };
  std::vector<Vec3> displacement;
  for (const Vec3& p : face.mesh.points) displacement.push_back(field(p));
  const std::vector<Vec3> carried = carry_skin(face, patient.tissue(), displacement);
  double worst = 0;
  for (std::size_t c = 0; c < carried.size(); ++c) {
    const Vec3 expected = patient.tissue().fixed[c] ? Vec3{} : field(patient.tissue().surface.points[c]);
    worst = std::max(worst, distance(carried[c], expected));
  }
  EXPECT_LT(worst, 0.15);
}

TEST(FaceCubes, NodesOnBoneHaveItsMotion) {
  const PatientCase patient = with_setback(6);
  const FaceSolid face = face_of(patient, 4);
  const auto supports = FaceSupports::find(patient, face);
  ASSERT_TRUE(static_cast<bool>(supports)) << supports.error().message();
  const auto& segments = patient.bones().segments();
  int moved = 0;
  for (const NodeSupport& s : supports->held()) {
    const Vec3& rest = face.mesh.points[at(s.node)];
    if (face.nodes[at(s.node)] == FaceNode::rim) {
      EXPECT_EQ(s.displacement_mm, Vec3{});
      continue;
    }
    ASSERT_EQ(face.nodes[at(s.node)], FaceNode::bone);
    if (s.displacement_mm == Vec3{}) continue;
    ++moved;
    const bool of_a_bone = std::any_of(segments.begin(), segments.end(), [&](const BoneSegment& b) {
      return distance(b.motion.point(rest) - rest, s.displacement_mm) < 1e-9;
    });
    EXPECT_TRUE(of_a_bone);
    EXPECT_NEAR(length(s.displacement_mm), 6, 1e-6);
  }
  EXPECT_GT(moved, 50);
  // Lips and cheeks slide on bone that has not moved under them without being pushed.
  const std::vector<Vec3> rest(face.mesh.points.begin(), face.mesh.points.end());
  const auto still = FaceSupports::find(patient, face);
  EXPECT_FALSE(still->contacts(rest).empty());
}

// By each solver once, for all tests of this process.
const Prediction& setback(Solver solver) {
  static const PatientCase patient = with_setback(6);
  static const Prediction solid = predicted(patient, Solver::solid), fem = predicted(patient, Solver::fem);
  return solver == Solver::solid ? solid : fem;
}

void expect_a_face(const Prediction& p) {
  EXPECT_TRUE(p.equilibrium.converged);
  for (const Vec3& x : p.skin.points) ASSERT_TRUE(is_finite(x));
  for (const Vec3& u : p.cubes->displacement_mm) ASSERT_TRUE(is_finite(u));
  EXPECT_LE(p.deepest_contact_mm, 0.3);
  bool judged = false;
  for (const BandResult& b : judge(with_setback(6), p)) {
    if (b.band->soft != "soft_pogonion") continue;
    judged = true;
    EXPECT_GE(b.ratio, 0.85);
    EXPECT_LE(b.ratio, 1.15);
  }
  EXPECT_TRUE(judged);
  EXPECT_LT(length(shift_of(p, "soft_nasion").after - shift_of(p, "soft_nasion").before), 0.1);
}

TEST(FaceCubes, ASetbackByTheLawTakesTheChinAlong) {
  expect_a_face(setback(Solver::fem));
  EXPECT_EQ(setback(Solver::fem).inverted, 0);
}

TEST(FaceCubes, ASetbackByTetrahedraTakesTheChinAlong) {
  expect_a_face(setback(Solver::solid));
  EXPECT_LE(setback(Solver::solid).inverted, 5);
}

TEST(FaceCubes, TheSameBitsOnOneAndTwoThreads) {
  const PatientCase patient = with_setback(6);
  SolverOptions options;
  options.cubes.spacing_mm = 6;
  options.cubes.relative_residual = 1e-3;
  for (const Solver solver : {Solver::solid, Solver::fem}) {
    set_thread_count(1);
    const Prediction one = predicted(patient, solver, options);
    set_thread_count(2);
    const Prediction two = predicted(patient, solver, options);
    set_thread_count(0);
    EXPECT_TRUE(one.cubes->displacement_mm == two.cubes->displacement_mm) << name_of(solver);
    EXPECT_TRUE(one.skin.points == two.skin.points) << name_of(solver);
  }
}

TEST(FaceCubes, AnOpenMouthPartsTheLips) {
  PatientCase patient = phantom_case();
  ASSERT_TRUE(static_cast<bool>(open_mouth(patient.bones(), patient_of(patient), radians(8))));
  SolverOptions options = coarse();
  options.cubes.material.law = ElasticLaw::linear;
  const Prediction p = predicted(patient, Solver::fem, options);
  const LandmarkShift &upper = shift_of(p, "labrale_superius"), &lower = shift_of(p, "labrale_inferius");
  EXPECT_GT(distance(upper.after, lower.after), distance(upper.before, lower.before) + 3);
  EXPECT_LT(length(upper.after - upper.before), 0.5 * length(lower.after - lower.before));
}

TEST(FaceCubes, TetrahedraAndTheLawPredictNearlyTheSameFace) {
  const PatientCase patient = with_setback(6);
  const Prediction &solid = setback(Solver::solid), &fem = setback(Solver::fem);
  for (const auto& [name, part] : skin_parts(patient)) {
    const SkinDistance d = compare(solid, fem, part);
    RecordProperty(name + "_mean", std::to_string(d.mean));
    RecordProperty(name + "_95", std::to_string(d.percentile_95));
    EXPECT_GT(d.points, 100) << name;
    EXPECT_LT(d.mean, 0.6) << name;
  }
}

TEST(FaceCubes, SpacingsThatMakeNoFaceAreErrors) {
  const PatientCase& patient = phantom_case();
  Context context;
  for (const double spacing : {0.0, -1.0, 0.1, 50.0, std::nan(""), HUGE_VAL}) {
    const auto face = build_face_solid(patient.head(), patient.tissue(), spacing, context);
    ASSERT_FALSE(static_cast<bool>(face)) << spacing;
    EXPECT_NE(face.error().message().find("spacing"), std::string::npos) << face.error().message();
  }
}

}  // namespace
}  // namespace turgor
