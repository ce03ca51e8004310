#include "turgor/world/reference_bands.hpp"

#include <algorithm>

#include "turgor/surgery/operations.hpp"

namespace turgor {
namespace {

constexpr std::string_view setback = "mandibular setback";
constexpr std::string_view advancement = "mandibular advancement";
constexpr std::string_view maxilla_forward = "maxillary advancement";
constexpr std::string_view chin_forward = "genioplasty advancement";

const LandmarkShift* find(const Prediction& prediction, std::string_view name) {
  const auto it = std::find_if(prediction.landmarks.begin(), prediction.landmarks.end(),
                               [&](const LandmarkShift& l) { return l.name == name; });
  return it == prediction.landmarks.end() ? nullptr : &*it;
}

bool is_identity(const RigidTransform& motion) {
  return length(motion.translation) < 1e-9 && distance(motion.rotation.c[0], Vec3{1, 0, 0}) < 1e-12 &&
         distance(motion.rotation.c[1], Vec3{0, 1, 0}) < 1e-12;
}

// The published operation that the plan is, where it is one.
std::string_view operation_of(const PatientCase& patient) {
  const BoneSegment* moved = nullptr;
  for (const BoneSegment& s : patient.bones().segments()) {
    if (is_identity(s.motion)) continue;
    if (moved != nullptr) return {};
    moved = &s;
  }
  if (moved == nullptr) return {};
  const double forward =
      dot(moved->motion.point(moved->surface.points.front()) - moved->surface.points.front(),
          patient_axes(patient.head()).forward);
  if (moved->name == "distal") return forward < 0 ? setback : advancement;
  if (moved->name == "maxilla" && forward > 0) return maxilla_forward;
  if (moved->name == "chin" && forward > 0) return chin_forward;
  return {};
}

}  // namespace

const std::vector<ReferenceBand>& reference_bands() {
  constexpr std::string_view ejo = "about 1:1, Eur J Orthod 30:359";
  constexpr std::string_view angle = "26 patients in 3D, Angle Orthod 80:896";
  static const std::vector<ReferenceBand> bands{
      {setback, "distal", "soft_pogonion", "pogonion", 0.85, 1.15, ejo},
      {setback, "distal", "soft_b_point", "b_point", 0.85, 1.15, ejo},
      {setback, "distal", "labrale_inferius", "pogonion", 0.50, 0.85,
       "0.66, PMC6173856; 1.0, Angle Orthod 80:896"},
      {setback, "distal", "cheilion_left", "pogonion", 0.35, 0.65, angle},
      {setback, "distal", "cheilion_right", "pogonion", 0.35, 0.65, angle},
      {setback, "distal", "labrale_superius", "pogonion", 0.0, 0.25, angle},
      {advancement, "distal", "soft_pogonion", "pogonion", 0.85, 1.15, ejo},
      {advancement, "distal", "labrale_inferius", "pogonion", 0.50, 0.85, "0.66, PMC6173856"},
      {maxilla_forward, "maxilla", "labrale_superius", "ans", 0.20, 0.70,
       "0.21, PMC6173856; up to 0.7 in other series"},
      {maxilla_forward, "maxilla", "pronasale", "ans", 0.10, 0.35, "0.17, PMC6173856"},
      {chin_forward, "chin", "soft_pogonion", "pogonion", 0.85, 1.15, "1.05, 75 patients"},
  };
  return bands;
}

std::vector<BandResult> judge(const PatientCase& patient, const Prediction& prediction) {
  std::vector<BandResult> results;
  const std::string_view operation = operation_of(patient);
  for (const ReferenceBand& band : reference_bands()) {
    if (band.operation != operation) continue;
    const LandmarkShift *soft = find(prediction, band.soft), *hard = find(prediction, band.hard);
    if (soft == nullptr || hard == nullptr) continue;
    const Vec3 step = hard->after - hard->before;
    if (length(step) < 0.5) continue;
    results.push_back({&band, dot(soft->after - soft->before, step) / squared_length(step)});
  }
  return results;
}

}  // namespace turgor
