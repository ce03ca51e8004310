// Looking at a surface from the front, the sides and below, in a frame set upright by the face.
#pragma once

#include <optional>
#include <vector>

#include "turgor/geometry/surface_query.hpp"

namespace turgor {

/// Face coordinates: x to the patient's left from the midsagittal plane, y to the back, z up, mm. Near to
/// Frankfurt horizontal.
struct FaceFrame {
  Vec3 origin;
  Mat3 axes;         ///< columns: left, back, up
  double scale = 1;  ///< size of this head over an adult's

  [[nodiscard]] Vec3 to_face(const Vec3& patient) const { return axes.transposed() * (patient - origin); }
  [[nodiscard]] Vec3 to_patient(const Vec3& face) const { return origin + axes * face; }
  /// The same, tilted about the left axis so that `direction` (patient, pointing to the back) becomes level.
  [[nodiscard]] FaceFrame levelled(const Vec3& direction) const;
};

/// Half-open steps of a profile: what a ray meets, or nothing.
struct ProfilePoint {
  double at = 0;  ///< coordinate along the profile
  Vec3 point;     ///< face coordinates
  bool met = false;
};

class FaceProbe {
 public:
  FaceProbe(const TriMesh& surface, const FaceFrame& frame);

  [[nodiscard]] const FaceFrame& frame() const { return frame_; }
  [[nodiscard]] bool empty() const { return points_.empty(); }
  /// Points of the surface and their bounds, in face coordinates.
  [[nodiscard]] const std::vector<Vec3>& points() const { return points_; }
  [[nodiscard]] const Box3& box() const { return box_; }

  /// What is met first looking from the front at (x, z), from the side (+1 left) at (y, z), from below at (x,
  /// y).
  [[nodiscard]] std::optional<Vec3> from_front(double x, double z) const;
  [[nodiscard]] std::optional<Vec3> from_side(int side, double y, double z) const;
  [[nodiscard]] std::optional<Vec3> from_below(double x, double y) const;

  /// Front profile for z from `low` to `high`: the foremost of a strip of `half_width` about `x`.
  [[nodiscard]] std::vector<ProfilePoint> front_profile(double x, double half_width, double low, double high,
                                                        double step = 0.5) const;

 private:
  [[nodiscard]] std::optional<Vec3> meet(const Vec3& from, const Vec3& direction) const;
  FaceFrame frame_;
  std::vector<Vec3> points_;
  Box3 box_;
  SurfaceQuery query_;
};

/// The met profile point with the least value(point), if any.
template <class Value>
std::optional<Vec3> least(const std::vector<ProfilePoint>& profile, Value&& value) {
  const ProfilePoint* best = nullptr;
  for (const ProfilePoint& p : profile) {
    if (p.met && (best == nullptr || value(p.point) < value(best->point))) best = &p;
  }
  if (best == nullptr) return std::nullopt;
  return best->point;
}
/// The point in the middle of the stretch around it where the value is the least to within a little: steady
/// on flat tops.
template <class Value>
std::optional<Vec3> middle_of_least(const std::vector<ProfilePoint>& profile, Value&& value) {
  const auto best = least(profile, value);
  if (!best) return std::nullopt;
  constexpr double kFlatMm = 0.15;
  std::size_t first = 0;
  while (!profile[first].met || !(profile[first].point == *best)) ++first;
  std::size_t last = first;
  const auto flat = [&](std::size_t i) {
    return profile[i].met && value(profile[i].point) <= value(*best) + kFlatMm;
  };
  while (first > 0 && flat(first - 1)) --first;
  while (last + 1 < profile.size() && flat(last + 1)) ++last;
  return profile[(first + last) / 2].point;
}
inline std::optional<Vec3> foremost(const std::vector<ProfilePoint>& profile) {
  return least(profile, [](const Vec3& p) { return p.y; });
}
inline std::optional<Vec3> deepest(const std::vector<ProfilePoint>& profile) {
  return least(profile, [](const Vec3& p) { return -p.y; });
}
/// The point furthest behind the straight line between two points of the profile.
std::optional<Vec3> furthest_behind(const std::vector<ProfilePoint>& profile, const Vec3& a, const Vec3& b);
/// The deepest point where that is not an end of the profile; otherwise the one furthest behind the line
/// between its ends.
std::optional<Vec3> hollow(const std::vector<ProfilePoint>& profile);

}  // namespace turgor
