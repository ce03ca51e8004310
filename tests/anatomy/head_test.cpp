#include "turgor/anatomy/head.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>

#include "support/example_scan.hpp"
#include "support/phantom_scan.hpp"
#include "turgor/core/parallel.hpp"
#include "turgor/geometry/surface_query.hpp"

namespace turgor {
namespace {

using test::phantom_scan;
using test::require;
using Distance = std::function<double(const Vec3&)>;

constexpr double kVoxel = 1.5;

double mean_distance(const TriMesh& mesh, const Distance& truth) {
  double sum = 0;
  for (const Vec3& p : mesh.points) sum += std::abs(truth(p));
  return sum / static_cast<double>(mesh.points.size());
}

/// Part of the points at which the surface's normal points the way in which the true distance grows.
double part_facing_out(const TriMesh& mesh, const Distance& truth) {
  const std::vector<Vec3> normals = point_normals(mesh);
  std::size_t out = 0, all = 0;
  for (std::size_t p = 0; p < mesh.points.size(); p += 7) {
    ++all;
    if (truth(mesh.points[p] + normals[p]) > truth(mesh.points[p] - normals[p])) ++out;
  }
  return static_cast<double>(out) / static_cast<double>(all);
}

/// Every edge of the surface's boundary lies in the lowest slice of the scan.
void expect_open_only_below(const TriMesh& mesh, const Head& head) {
  std::map<std::pair<int, int>, int> uses;
  for (const Index3& t : mesh.triangles) {
    for (std::size_t e = 0; e < 3; ++e) {
      const int a = t[e], b = t[(e + 1) % 3];
      ++uses[{std::min(a, b), std::max(a, b)}];
    }
  }
  for (const auto& [edge, count] : uses) {
    if (count != 1) continue;
    EXPECT_NEAR(mesh.points[static_cast<std::size_t>(edge.first)].z, head.scan_box.lower.z, 0.01);
  }
}

void expect_sound(const TriMesh& mesh) {
  const auto valid = validate(mesh);
  ASSERT_TRUE(valid) << valid.error().message();
  const Topology shape = topology(mesh);
  EXPECT_EQ(shape.components, 1);
  EXPECT_EQ(shape.non_manifold_edges, 0);
}

Scan filled(const Index3& size, double spacing, const std::function<double(const Vec3&)>& value) {
  Scan scan;
  Grid g;
  g.size = size;
  g.spacing = {spacing, spacing, spacing};
  g.origin = Vec3{-0.5 * size[0], -0.5 * size[1], -0.5 * size[2]} * spacing;
  scan.hu = CtVolume(g);
  for (int k = 0; k < size[2]; ++k) {
    for (int j = 0; j < size[1]; ++j) {
      for (int i = 0; i < size[0]; ++i) {
        const Vec3 p = g.to_patient({double(i), double(j), double(k)});
        scan.hu.at(i, j, k) = static_cast<std::int16_t>(value(p));
      }
    }
  }
  return scan;
}

/// A head of plain shapes, quick to make: brain case with brain, face with jaw bone and airway, neck.
Scan simple_head() {
  return filled({70, 80, 90}, 3, [](const Vec3& p) {
    const double vault = std::hypot(p.x / 70, (p.y - 5) / 85, (p.z - 40) / 68);
    const bool air = std::abs(p.x) < 10 && p.y > -78 && p.y < -5 && std::abs(p.z + 45) < 15;
    const bool jaw = std::abs(p.x) < 36 && p.y > -86 && p.y < -35 && p.z > -78 && p.z < 12;
    const bool hollow = std::abs(p.x) < 30 && p.y > -80 && p.z < 4;
    const bool face = std::abs(p.x) < 52 && p.y > -98 && p.y < 0 && p.z > -95 && p.z < 30;
    const bool neck = std::hypot(p.x, p.y - 25) < 52 && p.z < 40;
    if (air) return -1000;
    if ((vault > 0.93 && vault < 1) || (jaw && !hollow)) return 1100;
    return vault < 1.08 || face || neck ? 40 : -1000;
  });
}

TEST(Head, SurfacesOfThePhantomLieWithinAQuarterOfAVoxelOfTheTruth) {
  const Phantom phantom = require(Phantom::create(test::phantom_parameters(kVoxel)));
  Context context;
  const Head head = require(build_head(phantom_scan(kVoxel), {}, context));
  const Distance skin = [&](const Vec3& p) { return phantom.skin(p); };
  const Distance skull = [&](const Vec3& p) { return phantom.skull(p); };
  const Distance mandible = [&](const Vec3& p) { return phantom.mandible(p); };

  EXPECT_LT(mean_distance(head.skin, skin), 0.25 * kVoxel);
  EXPECT_LT(mean_distance(head.skull, skull), 0.25 * kVoxel);
  EXPECT_LT(mean_distance(head.mandible, mandible), 0.25 * kVoxel);
  for (const TriMesh* mesh : {&head.skin, &head.skull, &head.mandible}) {
    expect_sound(*mesh);
    expect_open_only_below(*mesh, head);
  }
  EXPECT_EQ(topology(head.mandible).boundary_edges, 0);
  EXPECT_GT(part_facing_out(head.skin, skin), 0.99);
  EXPECT_GT(part_facing_out(head.skull, skull), 0.97);
  EXPECT_GT(part_facing_out(head.mandible, mandible), 0.97);
  EXPECT_GT(enclosed_volume(head.mandible), 20e3);

  EXPECT_NEAR(static_cast<double>(head.skin.triangles.size()), 60'000, 600);
  EXPECT_NEAR(static_cast<double>(head.skull.triangles.size() + head.mandible.triangles.size()), 90'000, 900);
  EXPECT_NE(head.mandible_state, MandibleState::absent);
  EXPECT_TRUE(head.rami.empty());
  EXPECT_FALSE(head.teeth.empty());
  EXPECT_FALSE(head.airway.empty());
  EXPECT_GE(head.removed_pieces, 1);
  EXPECT_TRUE(head.open_below);
  EXPECT_NEAR(head.skin_level_hu, -480, 30);
  EXPECT_LT(std::abs(head.midsagittal.offset), 0.3);
  EXPECT_GT(head.midsagittal.normal.x, std::cos(radians(0.3)));
  ASSERT_TRUE(head.occlusal_plane);
  EXPECT_GT(head.occlusal_plane->normal.z, 0.97);
}

TEST(Head, MandibleIsCutFreeWhereCondylesAndTeethTouchTheSkull) {
  const Phantom phantom = require(Phantom::create(test::phantom_parameters(kVoxel, true)));
  Context context;
  const Head head = require(build_head(phantom_scan(kVoxel, true), {}, context));
  ASSERT_EQ(head.mandible_state, MandibleState::cut);
  expect_sound(head.mandible);
  expect_sound(head.skull);
  EXPECT_EQ(topology(head.mandible).boundary_edges, 0);
  EXPECT_LT(mean_distance(head.mandible, [&](const Vec3& p) { return phantom.mandible(p); }), 0.25 * kVoxel);
  EXPECT_LT(mean_distance(head.skull, [&](const Vec3& p) { return phantom.skull(p); }), 0.25 * kVoxel);
  // Nowhere has one bone kept a piece of the other that is worth the name.
  for (const Vec3& p : head.mandible.points) EXPECT_LT(phantom.mandible(p), 7);
  // The cut is shown where the bones touch: at both joints and between the teeth.
  ASSERT_FALSE(head.mandible_cut.empty());
  const Landmarks truth = [&] {
    Landmarks all;
    for (const auto& [name, point] : phantom.landmarks()) all[name] = {point, false};
    return all;
  }();
  const SurfaceQuery cut(head.mandible_cut);
  EXPECT_TRUE(cut.nearest(truth.at("condylion_left").point, 8));
  EXPECT_TRUE(cut.nearest(truth.at("condylion_right").point, 8));
  const std::vector<Notice> notices = context.notices();
  EXPECT_TRUE(std::any_of(notices.begin(), notices.end(),
                          [](const Notice& n) { return n.text.find("cut free") != std::string::npos; }));
}

TEST(Head, GivenOcclusalPlaneIsUsedAndReported) {
  const Scan& scan = phantom_scan(kVoxel);
  Context context;
  const Head found = require(build_head(scan, {}, context));
  ASSERT_TRUE(found.occlusal_plane);
  HeadOptions options;
  options.occlusal_plane = found.occlusal_plane;
  options.occlusal_plane->offset -= 3;
  const Head corrected = require(build_head(scan, options, context));
  ASSERT_TRUE(corrected.occlusal_plane);
  EXPECT_DOUBLE_EQ(corrected.occlusal_plane->offset, found.occlusal_plane->offset - 3);
  EXPECT_EQ(corrected.mandible_state, MandibleState::cut);
}

TEST(Head, MandibleStaysWithTheSkullWhereSeparationIsOff) {
  HeadOptions options;
  options.separate_mandible = false;
  Context context;
  const Head head = require(build_head(phantom_scan(kVoxel), options, context));
  EXPECT_EQ(head.mandible_state, MandibleState::absent);
  EXPECT_TRUE(head.mandible.empty());
}

/// The scan from slice `first` on.
Scan from_slice(const Scan& scan, int first) {
  const Grid& g = scan.hu.grid;
  Scan part = scan;
  part.hu.grid.size[2] -= first;
  part.hu.grid.origin = g.to_patient({0, 0, double(first)});
  part.hu.voxels.assign(scan.hu.voxels.begin() + static_cast<std::ptrdiff_t>(g.offset(0, 0, first)),
                        scan.hu.voxels.end());
  return part;
}

int slice_at(const Scan& scan, double z) {
  return static_cast<int>(scan.hu.grid.to_index({0, 0, z}).z);
}

TEST(Head, ScanThatEndsAtTheUpperTeethHasRamiButNoMandible) {
  const Scan scan = from_slice(phantom_scan(kVoxel), slice_at(phantom_scan(kVoxel), -44));
  Context context;
  const Head head = require(build_head(scan, {}, context));
  EXPECT_EQ(head.mandible_state, MandibleState::absent);
  EXPECT_TRUE(head.mandible.empty());
  EXPECT_TRUE(head.mandible_cut.empty());
  EXPECT_EQ(topology(head.rami).components, 2);
  expect_sound(head.skull);
  const Phantom phantom = require(Phantom::create(test::phantom_parameters(kVoxel)));
  EXPECT_LT(mean_distance(head.rami, [&](const Vec3& p) { return phantom.mandible(p); }), 0.75);
  const Landmarks landmarks = find_landmarks(head, context);
  for (const char* name :
       {"pogonion", "menton", "b_point", "gonion_left", "soft_pogonion", "labrale_inferius"}) {
    EXPECT_FALSE(landmarks.contains(name)) << name;
  }
  for (const char* name : {"nasion", "ans", "pronasale", "subnasale", "zygion_left", "orbitale_right"}) {
    EXPECT_TRUE(landmarks.contains(name)) << name;
  }
}

TEST(Head, HolderThatTouchesTheHeadIsRemoved) {
  const Phantom phantom = require(Phantom::create(test::phantom_parameters(kVoxel)));
  Scan scan = phantom_scan(kVoxel);
  // A plate 4 mm thick that rests against the back of the head.
  const double back = [&] {
    double y = 0;
    while (phantom.skin({0, y, 45}) < 0) y += 0.5;
    return y;
  }();
  for (int k = 0; k < scan.hu.grid.size[2]; ++k) {
    for (int j = 0; j < scan.hu.grid.size[1]; ++j) {
      for (int i = 0; i < scan.hu.grid.size[0]; ++i) {
        const Vec3 p = scan.hu.grid.to_patient({double(i), double(j), double(k)});
        const bool in_plate = p.y > 60 && std::abs(p.x) < 70 && std::abs(p.z - 55) < 50 &&
                              std::abs(p.y + 0.004 * p.x * p.x - (back + 1.5)) < 2;
        if (in_plate && phantom.skin(p) > 0) scan.hu.at(i, j, k) = 300;
      }
    }
  }
  Context context;
  const Head head = require(build_head(scan, {}, context));
  EXPECT_LT(mean_distance(head.skin, [&](const Vec3& p) { return phantom.skin(p); }), 0.25 * kVoxel);
  double furthest = 0;
  for (const Vec3& p : head.skin.points) {
    if (p.y > 50) furthest = std::max(furthest, phantom.skin(p));
  }
  // Where the plate lies flat against the head a low dome of it stays.
  EXPECT_LT(furthest, 5);
}

TEST(Head, TurnsWithThePatient) {
  Scan scan = phantom_scan(kVoxel);
  Context context;
  const Head upright = require(build_head(scan, {}, context));
  const RigidTransform turn =
      RigidTransform::rotate_about({0, 0, 0}, normalized(Vec3{1, 0.4, 0.5}), radians(12));
  scan.hu.grid.origin = turn.point(scan.hu.grid.origin);
  scan.hu.grid.direction = turn.rotation * scan.hu.grid.direction;
  const Head turned = require(build_head(scan, {}, context));
  EXPECT_EQ(turned.mandible_state, upright.mandible_state);
  EXPECT_LT(length(cross(turned.midsagittal.normal, turn.direction(upright.midsagittal.normal))),
            radians(0.5));
  const Landmarks before = find_landmarks(upright, context), after = find_landmarks(turned, context);
  for (const char* name :
       {"nasion", "pogonion", "pronasale", "gonion_left", "zygion_right", "labrale_superius"}) {
    ASSERT_TRUE(before.contains(name) && after.contains(name)) << name;
    EXPECT_LT(distance(turn.point(before.at(name).point), after.at(name).point), 4) << name;
  }
}

void expect_same_for_any_number_of_threads(const Scan& scan) {
  Context context;
  set_thread_count(1);
  const Head one = require(build_head(scan, {}, context));
  const Landmarks landmarks_one = find_landmarks(one, context);
  set_thread_count(2);
  const Head two = require(build_head(scan, {}, context));
  const Landmarks landmarks_two = find_landmarks(two, context);
  set_thread_count(0);
  EXPECT_EQ(one.skin.points, two.skin.points);
  EXPECT_EQ(one.skull.triangles, two.skull.triangles);
  EXPECT_EQ(one.skull.points, two.skull.points);
  EXPECT_EQ(one.rami.points, two.rami.points);
  EXPECT_EQ(one.teeth.points, two.teeth.points);
  EXPECT_EQ(one.airway.points, two.airway.points);
  EXPECT_EQ(one.midsagittal.normal, two.midsagittal.normal);
  ASSERT_EQ(landmarks_one.size(), landmarks_two.size());
  for (const auto& [name, landmark] : landmarks_one)
    EXPECT_EQ(landmark.point, landmarks_two.at(name).point) << name;
}

TEST(Head, IsTheSameForAnyNumberOfThreads) {
  expect_same_for_any_number_of_threads(simple_head());
}

TEST(RealHead, IsTheSameForAnyNumberOfThreads) {
  TURGOR_NEED_EXAMPLE_SCAN();
  Context context;
  expect_same_for_any_number_of_threads(require(read_scan(test::example_scan(), {}, context)));
}

TEST(Head, StopsWhenTheUserCancels) {
  // At the first question, and at every later one.
  for (int patience = 0; patience < 12; ++patience) {
    int asked = 0;
    Context context({}, {}, [&] { return asked++ >= patience; });
    const auto head = build_head(simple_head(), {}, context);
    ASSERT_FALSE(head) << patience;
    EXPECT_EQ(head.error().kind, ErrorKind::cancelled);
  }
}

// Scans that are no use.

TEST(SimpleHead, IsGoodEnoughToBeDoctored) {
  Context context;
  const Head head = require(build_head(simple_head(), {}, context));
  EXPECT_EQ(head.mandible_state, MandibleState::absent);
  expect_sound(head.skin);
  expect_sound(head.skull);
}

std::string complaint(const Scan& scan) {
  Context context;
  const auto head = build_head(scan, {}, context);
  if (head) return "no complaint";
  EXPECT_EQ(head.error().kind, ErrorKind::bad_input);
  EXPECT_FALSE(head.error().remedy.empty());
  return head.error().what;
}

void expect_complaint(const Scan& scan, const std::string& part) {
  EXPECT_NE(complaint(scan).find(part), std::string::npos) << complaint(scan);
}

/// Each voxel from another place of the same scan, or with another value.
template <class Change>
Scan doctored(const Scan& scan, Change&& change) {
  Scan out = scan;
  const Index3 n = scan.hu.grid.size;
  for (int k = 0; k < n[2]; ++k) {
    for (int j = 0; j < n[1]; ++j) {
      for (int i = 0; i < n[0]; ++i) out.hu.at(i, j, k) = static_cast<std::int16_t>(change(i, j, k));
    }
  }
  return out;
}

TEST(BadScan, OfOneVoxelOrTooFewIsRefused) {
  expect_complaint(filled({1, 1, 1}, 1, [](const Vec3&) { return 40; }),
                   "too small for a head: 1 x 1 x 1 voxels");
  expect_complaint(filled({200, 200, 1}, 1, [](const Vec3&) { return 40; }), "too small");
  expect_complaint(filled({60, 60, 60}, 1, [](const Vec3&) { return 40; }), "too small");
}

TEST(BadScan, OfNothingButAirOrOfNoAirShowsNoSkin) {
  expect_complaint(filled({60, 60, 60}, 3, [](const Vec3&) { return -1000; }), "no skin");
  expect_complaint(filled({60, 60, 60}, 3, [](const Vec3& p) { return length(p) < 60 ? 1000 : 40; }),
                   "no skin");
}

TEST(BadScan, WithoutBoneIsRefused) {
  const Scan scan = simple_head();
  expect_complaint(
      doctored(scan, [&](int i, int j, int k) { return std::min<int>(scan.hu.at(i, j, k), 120); }),
      "no bone");
}

TEST(BadScan, OfAnotherPartOfTheBodyIsNotAHead) {
  // A thigh with its bone, and a trunk with a spine and ribs' worth of rods.
  expect_complaint(filled({70, 70, 80}, 3,
                          [](const Vec3& p) {
                            const double r = std::hypot(p.x, p.y);
                            return r < 8 ? 300 : r < 15 ? 1200 : r < 80 ? 50 : -1000;
                          }),
                   "no cranial vault");
  expect_complaint(filled({100, 80, 80}, 3,
                          [](const Vec3& p) {
                            const double r = std::hypot(p.x / 1.4, p.y);
                            const bool rib = r > 86 && r < 92 && std::fmod(p.z + 300, 30) < 9;
                            const bool spine = std::hypot(p.x, p.y - 70) < 18;
                            const bool lung = std::hypot(std::abs(p.x) - 55, p.y) < 40;
                            return rib || spine ? 900 : r > 100 ? -1000 : lung ? -850 : 40;
                          }),
                   "no cranial vault");
}

TEST(BadScan, TurnedTheWrongWayIsNamed) {
  const Scan scan = simple_head();
  const Index3 n = scan.hu.grid.size;
  expect_complaint(doctored(scan, [&](int i, int j, int k) { return scan.hu.at(i, j, n[2] - 1 - k); }),
                   "upside down");
  expect_complaint(
      doctored(scan, [&](int i, int j, int k) { return scan.hu.at(i, n[1] - 1 - j, n[2] - 1 - k); }),
      "upside down");
  expect_complaint(
      doctored(scan, [&](int i, int j, int k) { return scan.hu.at(n[0] - 1 - i, n[1] - 1 - j, k); }),
      "back to front");
}

TEST(BadScan, WithTheFaceCutAwayIsRefused) {
  const Scan scan = simple_head();
  // Wiped out in front of the brain and below its floor, as tools that hide a patient's face do.
  expect_complaint(doctored(scan,
                            [&](int i, int j, int k) {
                              const Vec3 p = scan.hu.grid.to_patient({double(i), double(j), double(k)});
                              return p.y < -25 && p.z < 10 ? -1000 : int(scan.hu.at(i, j, k));
                            }),
                   "face");
  // A scan of the vault alone.
  expect_complaint(from_slice(scan, slice_at(scan, 10)), "face");
  // A field of view that ends behind the face.
  Scan part = scan;
  const int first = static_cast<int>(scan.hu.grid.to_index({0, -50, 0}).y);
  part.hu.grid.size[1] -= first;
  part.hu.grid.origin = scan.hu.grid.to_patient({0, double(first), 0});
  part.hu.voxels.resize(part.hu.grid.voxel_count());
  for (int k = 0; k < part.hu.grid.size[2]; ++k) {
    for (int j = 0; j < part.hu.grid.size[1]; ++j) {
      for (int i = 0; i < part.hu.grid.size[0]; ++i) part.hu.at(i, j, k) = scan.hu.at(i, j + first, k);
    }
  }
  expect_complaint(part, "face");
}

TEST(RealHead, IsBuiltWithoutItsHolderAndWithTheRamiOfItsMandible) {
  TURGOR_NEED_EXAMPLE_SCAN();
  Context context;
  const Scan scan = require(read_scan(test::example_scan(), {}, context));
  const Head head = require(build_head(scan, {}, context));
  expect_sound(head.skin);
  expect_sound(head.skull);
  expect_open_only_below(head.skin, head);
  expect_open_only_below(head.skull, head);
  EXPECT_EQ(head.removed_pieces, 2);
  EXPECT_EQ(head.mandible_state, MandibleState::absent);
  EXPECT_TRUE(head.mandible.empty());
  EXPECT_EQ(topology(head.rami).components, 2);
  EXPECT_TRUE(head.open_below);
  EXPECT_NEAR(head.skin_level_hu, -490, 20);
  EXPECT_GT(head.bone_level_hu, 180);
  EXPECT_LT(head.bone_level_hu, 330);
  EXPECT_NEAR(head.skin_volume_ml, 3250, 150);
  EXPECT_NEAR(head.bone_volume_ml, 590, 60);
  // No hollow of the inside is part of the skin: rays from afar meet it and never come to a deeper sheet than
  // the nose's or the ears' own.
  EXPECT_LT(surface_area(head.skin), 170e3);
  EXPECT_GT(head.midsagittal.normal.x, 0.999);
  EXPECT_FALSE(head.airway.empty());
  EXPECT_FALSE(head.teeth.empty());
}

}  // namespace
}  // namespace turgor
