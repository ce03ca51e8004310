#include <algorithm>
#include <cmath>

#include "anatomy/landmark_search.hpp"

namespace turgor {
namespace {

/// What is this near to the scan's lower end may go on below it.
constexpr double kCutMarginMm = 3;

class BoneSearch {
 public:
  BoneSearch(const FaceProbe& skull, const FaceProbe& mandible, double orbit_height, double lowest_seen)
      : skull_(skull),
        mandible_(mandible),
        orbits_(orbit_height),
        lowest_(lowest_seen),
        s_(skull.frame().scale) {}

  FacePoints all() {
    for (const int side : {1, -1}) orbitale(side), zygion(side);
    nasion();
    maxilla();
    if (!mandible_.empty()) {
      chin();
      for (const int side : {1, -1}) ramus(side);
    }
    return std::move(found_);
  }

 private:
  /// Mean of the points of the highest value, to within a little: steady on flat tops.
  template <class Value>
  static std::optional<Vec3> extreme(const std::vector<Vec3>& points, Value&& value, double flat_mm = 0.15) {
    if (points.empty()) return std::nullopt;
    double top = -1e300;
    for (const Vec3& p : points) top = std::max(top, value(p));
    Vec3 sum, nearest = points.front();
    double count = 0;
    for (const Vec3& p : points) {
      if (value(p) >= top - flat_mm) sum += p, count += 1;
    }
    for (const Vec3& p : points) {
      if (value(p) >= top - flat_mm && distance(p, sum / count) < distance(nearest, sum / count)) nearest = p;
    }
    return nearest;
  }

  static std::string named(const char* name, int side) {
    return std::string(name) + (side > 0 ? "_left" : "_right");
  }
  void set(const std::string& name, const std::optional<Vec3>& p) {
    if (p) found_[name] = *p;
  }

  /// The rim in a column: the edge seen from in front and above.
  std::optional<Vec3> lower_rim(double x) const {
    return middle_of_least(skull_.front_profile(x, 0, orbits_ - 34 * s_, orbits_ - 6 * s_, 0.25),
                           [](const Vec3& p) { return 0.7 * (p.y - p.z); });
  }

  void orbitale(int side) {
    std::optional<Vec3> best;
    for (double x = 22; x <= 41; x += 0.5) {
      const auto rim = lower_rim(side * x * s_);
      if (rim && (!best || rim->z < best->z)) best = rim;
    }
    set(named("orbitale", side), best);
  }

  void zygion(int side) {
    const auto orbitale = found_.find(named("orbitale", side));
    if (orbitale == found_.end()) return;
    const Vec3 o = orbitale->second;
    std::vector<Vec3> arch;
    for (double y = o.y + 20 * s_; y <= o.y + 72 * s_; y += 0.5) {
      for (double z = o.z - 9 * s_; z <= o.z + 12 * s_; z += 0.5) {
        if (const auto p = skull_.from_side(side, y, z)) arch.push_back(*p);
      }
    }
    set(named("zygion", side), extreme(arch, [side](const Vec3& p) { return side * p.x; }));
  }

  void nasion() {
    const auto root = skull_.front_profile(0, 1.5 * s_, orbits_ - 12 * s_, orbits_ + 40 * s_);
    const auto part = [&](double low, double high) {
      std::vector<ProfilePoint> cut;
      for (const ProfilePoint& p : root) {
        if (p.at >= low && p.at <= high) cut.push_back(p);
      }
      return cut;
    };
    const auto glabella = foremost(part(orbits_ + 14 * s_, orbits_ + 40 * s_));
    const auto nose = foremost(part(orbits_ - 12 * s_, orbits_ + 6 * s_));
    if (!glabella || !nose) return;
    set("nasion", hollow(part(nose->z, glabella->z)));
  }

  /// From the nasal opening downwards: spine, hollow, incisors.
  void maxilla() {
    const auto profile = skull_.front_profile(0, 1.5 * s_, orbits_ - 75 * s_, orbits_ - 8 * s_, 0.25);
    const auto face = foremost(profile);
    if (!face) return;
    // The opening is the highest run of deep view; its floor is where bone comes near again.
    const auto deep = [&](const ProfilePoint& p) { return !p.met || p.point.y > face->y + 16 * s_; };
    std::size_t i = profile.size();
    while (i > 0 && !deep(profile[i - 1])) --i;
    while (i > 0 && deep(profile[i - 1])) --i;
    if (i == 0) return;
    const double floor = profile[i - 1].at;
    if (floor < lowest_ + kCutMarginMm) return;
    const auto between = [&](double low, double high) {
      std::vector<ProfilePoint> part;
      for (const ProfilePoint& p : profile) {
        if (p.at >= low && p.at <= high) part.push_back(p);
      }
      return part;
    };
    const auto spine = foremost(between(floor - 5 * s_, floor));
    if (!spine) return;
    set("ans", spine);
    incisor_above(*spine);
    const auto edge = found_.find("upper_incisor");
    const double below =
        edge != found_.end() ? edge->second.z + 9 * s_ : std::max(spine->z - 17 * s_, lowest_ + 3);
    if (below < spine->z - 4 * s_) set("a_point", hollow(between(below, spine->z - 1.5 * s_)));
  }

  /// Edge of the left central incisor: the highest value of p·up (or down) over its breadth.
  std::optional<Vec3> incisor_edge(const FaceProbe& bone, double breadth, int up, double front, double low,
                                   double high) const {
    std::vector<Vec3> edge;
    for (const Vec3& p : bone.points()) {
      const bool here = p.x > 0.5 * s_ && p.x < breadth * s_ && std::abs(p.y - front) < 14 * s_;
      if (here && p.z > low && p.z < high) edge.push_back(p);
    }
    return extreme(
        edge, [up](const Vec3& p) { return up * p.z; }, 0.4);
  }

  void incisor_above(const Vec3& spine) {
    const auto edge = incisor_edge(skull_, 7.5, -1, spine.y, spine.z - 45 * s_, spine.z - 10 * s_);
    if (edge && edge->z > lowest_ + kCutMarginMm) set("upper_incisor", edge);
  }

  void chin() {
    const Box3& box = mandible_.box();
    const double front_third = box.lower.y + box.size().y / 3;
    std::vector<Vec3> border;
    double top = -1e9;
    for (const Vec3& p : mandible_.points()) {
      if (p.y < front_third && std::abs(p.x) < 7 * s_) top = std::max(top, p.z);
    }
    for (double y = box.lower.y; y < front_third; y += 0.25) {
      if (const auto p = mandible_.from_below(0, y)) border.push_back(*p);
    }
    const auto menton = extreme(border, [](const Vec3& p) { return -p.z; });
    if (!menton) return;
    if (menton->z > lowest_ + kCutMarginMm) set("menton", menton);
    const double height = top - menton->z;
    const bool teeth = height > 30 * s_;
    if (teeth)
      set("lower_incisor", incisor_edge(mandible_, 5.2, 1, box.lower.y + 6 * s_, top - 6 * s_, top + 1));
    const auto profile = mandible_.front_profile(0, 1.0 * s_, menton->z, top, 0.25);
    const auto between = [&](double low, double high) {
      std::vector<ProfilePoint> part;
      for (const ProfilePoint& p : profile) {
        if (p.at >= low && p.at <= high) part.push_back(p);
      }
      return part;
    };
    const auto pogonion = foremost(between(menton->z + 1 * s_, menton->z + 0.45 * height));
    if (!pogonion || pogonion->z < lowest_ + kCutMarginMm) return;
    set("pogonion", pogonion);
    set("b_point", hollow(between(pogonion->z, top - (teeth ? 10 : 4) * s_)));
  }

  void ramus(int side) {
    std::vector<Vec3> half;
    for (const Vec3& p : mandible_.points()) {
      if (side * p.x > 15 * s_) half.push_back(p);
    }
    const auto gonion =
        extreme(half, [side](const Vec3& p) { return 0.3 * side * p.x + 0.7 * p.y - 0.7 * p.z; });
    const auto condylion = extreme(half, [](const Vec3& p) { return 0.7 * (p.y + p.z); });
    if (gonion && gonion->z > lowest_ + kCutMarginMm) set(named("gonion", side), gonion);
    set(named("condylion", side), condylion);
  }

  const FaceProbe& skull_;
  const FaceProbe& mandible_;
  double orbits_, lowest_, s_;
  FacePoints found_;
};

}  // namespace

FacePoints find_bone_landmarks(const FaceProbe& skull, const FaceProbe& mandible, double orbit_height,
                               double lowest_seen) {
  return BoneSearch(skull, mandible, orbit_height, lowest_seen).all();
}

}  // namespace turgor
