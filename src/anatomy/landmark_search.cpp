#include "anatomy/landmark_search.hpp"

#include <algorithm>
#include <cmath>

namespace turgor {
namespace {

/// Breadth of an adult's brain case.
constexpr double kAdultBreadthMm = 148;

FaceFrame first_frame(const Head& head) {
  FaceFrame frame;
  const Vec3 left = normalized(head.midsagittal.normal);
  const Vec3 centre = bounds(head.skull).centre();
  frame.origin = centre - left * head.midsagittal.signed_distance(centre);
  const Vec3 up = normalized(Vec3{0, 0, 1} - left * left.z);
  frame.axes = Mat3{{left, cross(up, left), up}};
  double breadth = 0;
  for (const Vec3& p : head.skull.points)
    breadth = std::max(breadth, std::abs(head.midsagittal.signed_distance(p)));
  frame.scale = std::clamp(2 * breadth / kAdultBreadthMm, 0.5, 1.5);
  return frame;
}

/// From orbitale to zygion, both sides: the direction that sets the head level.
std::optional<Vec3> level_direction(const FacePoints& bone, const FaceFrame& frame) {
  Vec3 sum;
  for (const char* side : {"left", "right"}) {
    const auto orbitale = bone.find(std::string("orbitale_") + side),
               zygion = bone.find(std::string("zygion_") + side);
    if (orbitale == bone.end() || zygion == bone.end()) continue;
    sum += frame.axes * (zygion->second - orbitale->second);
  }
  if (length(sum) < 20) return std::nullopt;
  return sum;
}

/// Where the field of view cuts the head, an outermost point is not the head's. (The lower end is seen to
/// before.)
bool at_side_of_scan(const Vec3& p, const Box3& scan) {
  constexpr double kMarginMm = 1.5;
  return p.x < scan.lower.x + kMarginMm || p.x > scan.upper.x - kMarginMm || p.y < scan.lower.y + kMarginMm ||
         p.y > scan.upper.y - kMarginMm || p.z > scan.upper.z - kMarginMm;
}

/// z of the scan's lower end at the face, in face coordinates.
double lowest_seen(const Head& head, const FaceFrame& frame) {
  const Vec3 front = frame.to_patient({0, -90 * frame.scale, 0});
  return frame.to_face({front.x, front.y, head.scan_box.lower.z}).z;
}

}  // namespace

namespace {

/// Middles of the stretches of a front profile that lie deep behind bone both above and below.
void add_deep_stretches(const std::vector<ProfilePoint>& profile, double scale,
                        std::vector<double>& middles) {
  const double step = profile.size() > 1 ? profile[1].at - profile[0].at : 1;
  const int reach = static_cast<int>(32 * scale / step), n = static_cast<int>(profile.size());
  const auto depth = [&](int i) {
    const auto& p = profile[static_cast<std::size_t>(i)];
    return p.met ? p.point.y : 1e9;
  };
  const auto foremost_between = [&](int from, int to) {
    double y = 1e9;
    for (int i = std::max(0, from); i <= std::min(n - 1, to); ++i) y = std::min(y, depth(i));
    return y;
  };
  int start = -1;
  for (int i = 0; i < n; ++i) {
    const double rims = std::max(foremost_between(i - reach, i - 1), foremost_between(i + 1, i + reach));
    const bool deep = rims < 1e8 && depth(i) > rims + 8 * scale;
    if (deep && start < 0) start = i;
    if (deep || start < 0) continue;
    const double height = (i - start) * step;
    if (height > 16 * scale && height < 50 * scale) {
      middles.push_back(
          0.5 * (profile[static_cast<std::size_t>(i - 1)].at + profile[static_cast<std::size_t>(start)].at));
    }
    start = -1;
  }
}

}  // namespace

std::optional<double> find_orbit_height(const FaceProbe& skull) {
  const double s = skull.frame().scale;
  constexpr double kStep = 2;
  std::vector<double> middles;
  for (const int side : {-1, 1}) {
    for (double x = 24; x <= 40; x += 2) {
      add_deep_stretches(
          skull.front_profile(side * x * s, 0, skull.box().lower.z, skull.box().upper.z, kStep), s, middles);
    }
  }
  if (middles.size() < 4) return std::nullopt;
  std::sort(middles.begin(), middles.end());
  // The densest stretch of 10 mm.
  std::size_t best = 0, best_count = 0;
  for (std::size_t i = 0; i < middles.size(); ++i) {
    std::size_t j = i;
    while (j < middles.size() && middles[j] < middles[i] + 10 * s) ++j;
    if (j - i > best_count) best_count = j - i, best = i;
  }
  return middles[best + best_count / 2];
}

Landmarks find_landmarks(const Head& head, Context& context) {
  const Stage stage(context, "Landmarks");
  Landmarks landmarks;
  if (head.skull.empty() || head.skin.empty()) return landmarks;
  FaceFrame frame = first_frame(head);
  FacePoints points;
  for (int pass = 0; pass < 2; ++pass) {
    const FaceProbe skull(head.skull, frame), mandible(head.mandible, frame);
    const auto orbits = find_orbit_height(skull);
    if (!orbits || context.cancelled()) break;
    const double lowest = lowest_seen(head, frame);
    points = find_bone_landmarks(skull, mandible, *orbits, lowest);
    const auto level = level_direction(points, frame);
    if (pass == 0 && level) {
      frame = frame.levelled(*level);
      continue;
    }
    points.merge(find_skin_landmarks(FaceProbe(head.skin, frame), points, *orbits, lowest));
    break;
  }
  for (const auto& [name, point] : points) {
    const Vec3 p = frame.to_patient(point);
    if (!at_side_of_scan(p, head.scan_box)) landmarks[name] = {p, false};
  }
  return landmarks;
}

}  // namespace turgor
