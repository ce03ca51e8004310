// Named operations of orthognathic and craniofacial surgery: their cuts are set from landmarks.
#pragma once

#include "turgor/anatomy/head.hpp"
#include "turgor/surgery/bone_plan.hpp"

namespace turgor {

/// A movement in the patient's directions, mm and radians; rotations right-handed about the segment's own
/// pivot, in the order roll (about the forward axis), pitch (about the left axis: + turns the front
/// downwards), yaw (about the up axis).
struct SegmentMove {
  double forward = 0, up = 0, left = 0;
  double pitch_rad = 0, roll_rad = 0, yaw_rad = 0;
};

/// What an operation needs to know of the patient.
struct Patient {
  const Head& head;
  const Landmarks& landmarks;
};

/// Unit vectors of the patient in LPS: forward and up lie in the midsagittal plane.
struct PatientAxes {
  Vec3 left, forward, up;
};
PatientAxes patient_axes(const Head& head);
/// The move in patient coordinates, its turns about `pivot`.
RigidTransform to_transform(const SegmentMove& move, const PatientAxes& axes, const Vec3& pivot);

/// Bilateral sagittal split: the tooth-bearing part of the mandible becomes the segment "distal". Each side
/// is cut in one plane from behind the last tooth to the antegonial notch, a plane stand-in for the stepped
/// split of the ramus. Forward (+) advances, backward (−) sets back, along the patient's forward axis. Errors
/// here and below: the scan shows no mandible (or maxilla), a landmark is missing, the cut misses the bone.
Result<void> sagittal_split(BonePlan& plan, const Patient& patient, double forward_mm);
/// Sliding genioplasty: the lower border of the chin becomes the segment "chin", cut below the tooth roots
/// and sloping to the lower border.
Result<void> genioplasty(BonePlan& plan, const Patient& patient, const SegmentMove& move);
/// Segment "maxilla": cut above the roots at the level of the nasal floor back to the pterygomaxillary
/// junction.
Result<void> le_fort_1(BonePlan& plan, const Patient& patient, const SegmentMove& move);
/// Segment "midface_2": the pyramid of nose and maxilla below the nasofrontal suture.
Result<void> le_fort_2(BonePlan& plan, const Patient& patient, const SegmentMove& move);
/// Segment "midface_3": the face from nasofrontal and zygomaticofrontal sutures down, with both zygomata.
Result<void> le_fort_3(BonePlan& plan, const Patient& patient, const SegmentMove& move);
enum class Side : std::uint8_t { left, right };
/// Segment "zygoma_left" or "zygoma_right"; `move.left` here means outwards, away from the midline.
Result<void> zygoma(BonePlan& plan, const Patient& patient, Side side, const SegmentMove& move);
/// Turns the whole mandible, cut or not, about the axis through both condyles; positive opens.
Result<void> open_mouth(BonePlan& plan, const Patient& patient, double angle_rad);

}  // namespace turgor
