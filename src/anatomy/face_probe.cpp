#include "anatomy/face_probe.hpp"

#include <cmath>

namespace turgor {

FaceFrame FaceFrame::levelled(const Vec3& direction) const {
  const Vec3 left = axes.c[0];
  const Vec3 back = normalized(direction - left * dot(direction, left));
  return {origin, Mat3{{left, back, cross(left, back)}}, scale};
}

FaceProbe::FaceProbe(const TriMesh& surface, const FaceFrame& frame) : frame_(frame), query_(surface) {
  points_.reserve(surface.points.size());
  for (const Vec3& p : surface.points) {
    points_.push_back(frame.to_face(p));
    box_.extend(points_.back());
  }
}

std::optional<Vec3> FaceProbe::meet(const Vec3& from, const Vec3& direction) const {
  if (empty()) return std::nullopt;
  const Vec3 origin = frame_.to_patient(from), along = frame_.axes * direction;
  const auto hit = query_.first_hit(origin, along);
  if (!hit) return std::nullopt;
  return frame_.to_face(origin + along * hit->distance);
}

std::optional<Vec3> FaceProbe::from_front(double x, double z) const {
  return meet({x, box_.lower.y - 10, z}, {0, 1, 0});
}
std::optional<Vec3> FaceProbe::from_side(int side, double y, double z) const {
  const double x = side > 0 ? box_.upper.x + 10 : box_.lower.x - 10;
  return meet({x, y, z}, {side > 0 ? -1.0 : 1.0, 0, 0});
}
std::optional<Vec3> FaceProbe::from_below(double x, double y) const {
  return meet({x, y, box_.lower.z - 10}, {0, 0, 1});
}

std::vector<ProfilePoint> FaceProbe::front_profile(double x, double half_width, double low, double high,
                                                   double step) const {
  std::vector<ProfilePoint> profile;
  for (double z = low; z <= high; z += step) {
    // The sides of the strip count where they stand clearly before its middle (a gap between two incisors, a
    // spine that bends).
    constexpr double kClearlyMm = 0.7;
    ProfilePoint best{z, {}, false};
    for (const double dx : {0.0, -half_width, half_width}) {
      const auto p = from_front(x + dx, z);
      if (p && (!best.met || p->y < best.point.y - kClearlyMm)) best = {z, *p, true};
      if (half_width == 0) break;
    }
    profile.push_back(best);
  }
  return profile;
}

std::optional<Vec3> furthest_behind(const std::vector<ProfilePoint>& profile, const Vec3& a, const Vec3& b) {
  // Normal of the line within the sagittal plane, pointing to the back.
  Vec3 normal{0, std::abs(b.z - a.z), 0};
  normal.z = b.z > a.z ? -(b.y - a.y) : (b.y - a.y);
  return least(profile, [&](const Vec3& p) { return -dot(p - a, normal); });
}

std::optional<Vec3> hollow(const std::vector<ProfilePoint>& profile) {
  std::vector<ProfilePoint> met;
  for (const ProfilePoint& p : profile) {
    if (p.met) met.push_back(p);
  }
  if (met.size() < 3) return std::nullopt;
  const auto lowest = deepest(met);
  if (lowest->z > met.front().at + 1e-9 && lowest->z < met.back().at - 1e-9) return lowest;
  return furthest_behind(met, met.front().point, met.back().point);
}

}  // namespace turgor
