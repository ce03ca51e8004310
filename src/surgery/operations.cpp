#include "turgor/surgery/operations.hpp"

#include <algorithm>
#include <optional>
#include <string>
#include <vector>

namespace turgor {
namespace {

// Reads landmarks by name and remembers the first that is missing.
class Needs {
 public:
  explicit Needs(const Landmarks& landmarks) : landmarks_(landmarks) {}
  Vec3 operator()(std::string_view name) {
    const auto it = landmarks_.find(name);
    if (it != landmarks_.end()) return it->second.point;
    if (missing_.empty()) missing_ = name;
    return {};
  }
  [[nodiscard]] Result<void> check(const std::string& operation) const {
    if (missing_.empty()) return {};
    return Error{ErrorKind::bad_command,
                 operation + " needs the landmark '" + missing_ + "', which the scan does not show", "",
                 "Set it with: landmark " + missing_ + " X Y Z"};
  }

 private:
  const Landmarks& landmarks_;
  std::string missing_;
};

Result<void> need_mandible(const Patient& patient, const std::string& operation) {
  if (patient.head.mandible_state != MandibleState::absent && !patient.head.mandible.empty()) return {};
  return Error{ErrorKind::bad_command, operation + " needs a mandible, and the scan shows none", "",
               "Use a scan that reaches below the chin"};
}

// Cuts the segment free unless an earlier command did, then moves it.
Result<void> cut_and_move(BonePlan& plan, const std::string& name, int of, const CutRegion& region,
                          const RigidTransform& motion) {
  if (plan.find(name) < 0) {
    const std::string parent = plan.segments()[static_cast<std::size_t>(of)].name;
    TURGOR_CHECK(plan.osteotomy(name, parent, region));
  }
  return plan.move(name, motion);
}

// The teeth of one jaw and side, as far as the head shows them.
struct ToothRow {
  double back_y = -1e9;  // of the last tooth
  double reach_x = 0;    // greatest distance from the midline
  std::optional<Vec3> last;
};

ToothRow tooth_row(const Patient& patient, bool upper) {
  ToothRow row;
  const auto& head = patient.head;
  if (!head.occlusal_plane) return row;
  for (const Vec3& p : head.teeth.points) {
    if ((head.occlusal_plane->signed_distance(p) > 0) != upper) continue;
    row.reach_x = std::max(row.reach_x, std::abs(head.midsagittal.signed_distance(p)));
    if (p.y > row.back_y) {
      row.back_y = p.y;
      row.last = p;
    }
  }
  return row;
}

// Plane through `point` whose positive side lies towards `direction`.
Plane side_of(const Vec3& point, const Vec3& direction) {
  return Plane::through(point, direction);
}

// The plane behind the maxilla, at the pterygomaxillary junction: behind the last upper tooth, or at the
// usual depth of the maxilla behind its front (about 50 mm in adults) where no teeth show.
Vec3 pterygomaxillary_point(const Patient& patient, const Vec3& front, const PatientAxes& axes) {
  const ToothRow row = tooth_row(patient, true);
  if (row.last) return *row.last - axes.forward * 6.0;
  return front - axes.forward * 50.0;
}

}  // namespace

PatientAxes patient_axes(const Head& head) {
  PatientAxes axes;
  axes.left = head.midsagittal.normal.x < 0 ? -head.midsagittal.normal : head.midsagittal.normal;
  axes.forward = normalized(cross(axes.left, Vec3{0, 0, -1}));
  if (axes.forward.y > 0) axes.forward = -axes.forward;
  axes.up = normalized(cross(axes.forward, axes.left));
  if (axes.up.z < 0) axes.up = -axes.up;
  return axes;
}

RigidTransform to_transform(const SegmentMove& move, const PatientAxes& axes, const Vec3& pivot) {
  const RigidTransform turn = RigidTransform::rotate_about(pivot, axes.up, move.yaw_rad) *
                              RigidTransform::rotate_about(pivot, axes.left, move.pitch_rad) *
                              RigidTransform::rotate_about(pivot, axes.forward, move.roll_rad);
  return RigidTransform::translate(axes.forward * move.forward + axes.up * move.up + axes.left * move.left) *
         turn;
}

Result<void> sagittal_split(BonePlan& plan, const Patient& patient, double forward_mm) {
  TURGOR_CHECK(need_mandible(patient, "a sagittal split"));
  Needs need(patient.landmarks);
  const Vec3 gonion[2] = {need("gonion_left"), need("gonion_right")};
  const Vec3 pogonion = need("pogonion");
  TURGOR_CHECK(need.check("a sagittal split"));
  const PatientAxes axes = patient_axes(patient.head);
  const ToothRow row = tooth_row(patient, false);
  CutRegion region;
  for (const Vec3& g : gonion) {
    const double body = dot(pogonion - g, axes.forward);
    // Behind the last tooth where teeth show, at the height of their roots' ends; else at the usual place.
    double behind_teeth = 0.45 * body, height = 30.0;
    if (row.last) {
      behind_teeth = std::clamp(dot(*row.last - g, axes.forward) - 4.0, 0.25 * body, 0.6 * body);
      height = dot(*row.last - g, axes.up);
    }
    const Vec3 notch = g + axes.forward * std::min(0.35 * body, behind_teeth);
    const Vec3 above = g + axes.forward * behind_teeth + axes.up * height;
    Vec3 normal = cross(axes.left, above - notch);
    if (dot(normal, axes.forward) < 0) normal = -normal;
    region.planes.push_back(side_of(notch, normal));
    // Ramus, coronoid and condyle lie above.
    region.planes.push_back(side_of(above + axes.up * 12.0, -axes.up));
  }
  const int whole = plan.segment_at(Bone::mandible, pogonion);
  return cut_and_move(plan, "distal", whole, region, RigidTransform::translate(axes.forward * forward_mm));
}

Result<void> genioplasty(BonePlan& plan, const Patient& patient, const SegmentMove& move) {
  TURGOR_CHECK(need_mandible(patient, "a genioplasty"));
  Needs need(patient.landmarks);
  const Vec3 pogonion = need("pogonion"), menton = need("menton"), b = need("b_point");
  TURGOR_CHECK(need.check("a genioplasty"));
  const PatientAxes axes = patient_axes(patient.head);
  // Enters between the deepest point of the chin's front and its most prominent one, slopes 12° down to the
  // back.
  const Vec3 entry = lerp(pogonion, b, 0.5);
  const Vec3 slope = rotation(axes.left, radians(12.0)) * -axes.forward;
  Vec3 normal = cross(axes.left, slope);
  if (dot(normal, axes.up) > 0) normal = -normal;
  CutRegion region;
  region.planes = {side_of(entry, normal), side_of(pogonion - axes.forward * 38.0, axes.forward)};
  const int whole = plan.segment_at(Bone::mandible, menton);
  return cut_and_move(plan, "chin", whole, region, to_transform(move, axes, pogonion));
}

Result<void> le_fort_1(BonePlan& plan, const Patient& patient, const SegmentMove& move) {
  Needs need(patient.landmarks);
  const Vec3 ans = need("ans");
  TURGOR_CHECK(need.check("a Le Fort I osteotomy"));
  const PatientAxes axes = patient_axes(patient.head);
  const ToothRow row = tooth_row(patient, true);
  CutRegion region;
  region.planes = {side_of(ans + axes.up * 4.0, -axes.up),
                   side_of(pterygomaxillary_point(patient, ans, axes), axes.forward)};
  const double half_width = (row.reach_x > 0 ? row.reach_x : 32.0) + 8.0;
  const Vec3 middle = ans - patient.head.midsagittal.normal * patient.head.midsagittal.signed_distance(ans);
  region.planes.push_back(side_of(middle + axes.left * half_width, -axes.left));
  region.planes.push_back(side_of(middle - axes.left * half_width, axes.left));
  return cut_and_move(plan, "maxilla", plan.segment_at(Bone::skull, ans), region,
                      to_transform(move, axes, ans));
}

Result<void> le_fort_2(BonePlan& plan, const Patient& patient, const SegmentMove& move) {
  Needs need(patient.landmarks);
  const Vec3 ans = need("ans"), nasion = need("nasion");
  const Vec3 orbitale[2] = {need("orbitale_left"), need("orbitale_right")};
  TURGOR_CHECK(need.check("a Le Fort II osteotomy"));
  const PatientAxes axes = patient_axes(patient.head);
  CutRegion region;
  region.planes = {side_of(nasion - axes.up * 2.0, -axes.up),
                   side_of(pterygomaxillary_point(patient, ans, axes), axes.forward)};
  for (const Vec3& o : orbitale) {
    // From the side of the nasal root through the infraorbital rim to the zygomaticomaxillary buttress.
    const double side = dot(o - ans, axes.left) > 0 ? 1.0 : -1.0;
    const Vec3 root = nasion + axes.left * (side * 10.0),
               buttress = o + axes.left * (side * 6.0) - axes.up * 14.0;
    Vec3 normal = cross(buttress - root, axes.forward);
    if (dot(normal, ans - root) < 0) normal = -normal;
    region.planes.push_back(side_of(root, normal));
  }
  return cut_and_move(plan, "midface_2", plan.segment_at(Bone::skull, ans), region,
                      to_transform(move, axes, ans));
}

Result<void> le_fort_3(BonePlan& plan, const Patient& patient, const SegmentMove& move) {
  Needs need(patient.landmarks);
  const Vec3 ans = need("ans"), nasion = need("nasion");
  const Vec3 left = need("orbitale_left"), right = need("orbitale_right");
  TURGOR_CHECK(need.check("a Le Fort III osteotomy"));
  const PatientAxes axes = patient_axes(patient.head);
  CutRegion region;
  // Behind the lateral orbital rims and through the arches, 30 mm behind the lower rims.
  region.planes = {side_of(nasion - axes.up * 2.0, -axes.up),
                   side_of((left + right) * 0.5 - axes.forward * 30.0, axes.forward)};
  return cut_and_move(plan, "midface_3", plan.segment_at(Bone::skull, ans), region,
                      to_transform(move, axes, ans));
}

Result<void> zygoma(BonePlan& plan, const Patient& patient, Side side, const SegmentMove& move) {
  const std::string suffix = side == Side::left ? "left" : "right";
  Needs need(patient.landmarks);
  const Vec3 orbitale = need("orbitale_" + suffix), zygion = need("zygion_" + suffix);
  TURGOR_CHECK(need.check("a zygoma osteotomy"));
  PatientAxes axes = patient_axes(patient.head);
  const Vec3 outwards = side == Side::left ? axes.left : -axes.left;
  CutRegion region;
  region.planes = {side_of(orbitale, normalized(outwards - axes.up * 0.3)),
                   side_of(orbitale + axes.up * 28.0, -axes.up), side_of(orbitale - axes.up * 30.0, axes.up),
                   side_of(lerp(orbitale, zygion, 0.8), axes.forward)};
  SegmentMove mirrored = move;
  if (side == Side::right) mirrored.left = -move.left;
  return cut_and_move(plan, "zygoma_" + suffix, plan.segment_at(Bone::skull, orbitale), region,
                      to_transform(mirrored, axes, lerp(orbitale, zygion, 0.5)));
}

Result<void> open_mouth(BonePlan& plan, const Patient& patient, double angle_rad) {
  TURGOR_CHECK(need_mandible(patient, "mouth opening"));
  Needs need(patient.landmarks);
  const Vec3 left = need("condylion_left"), right = need("condylion_right");
  TURGOR_CHECK(need.check("mouth opening"));
  const PatientAxes axes = patient_axes(patient.head);
  // The hinge runs through the middle of the condyles, about 6 mm below their tops.
  const Vec3 hinge = (left + right) * 0.5 - axes.up * 6.0;
  const RigidTransform turn = RigidTransform::rotate_about(hinge, normalized(left - right), angle_rad);
  std::vector<std::string> names;
  for (const BoneSegment& s : plan.segments()) {
    if (s.bone == Bone::mandible) names.push_back(s.name);
  }
  for (const std::string& name : names) TURGOR_CHECK(plan.move(name, turn));
  return {};
}

}  // namespace turgor
