#include <algorithm>
#include <cmath>

#include "anatomy/landmark_search.hpp"

namespace turgor {
namespace {

constexpr double kCutMarginMm = 1.5;
/// The furrow between the lips is measured against the lips this far above and below …
constexpr double kFurrowReachMm = 2.5;
/// … exists where it is deeper than this in the midline …
constexpr double kFurrowMm = 0.3;
/// … and ends where it is shallower than this. (Blur and smoothing take half of it.)
constexpr double kFurrowEndMm = 0.15;
/// The wings' walls are steeper than this (mm deeper per mm to the side) in the view from the front.
constexpr double kWallSlope = 2.0;

class SkinSearch {
 public:
  SkinSearch(const FaceProbe& skin, const FacePoints& bone, double orbit_height, double lowest_seen)
      : skin_(skin), bone_(bone), orbits_(orbit_height), lowest_(lowest_seen), s_(skin.frame().scale) {}

  FacePoints all() {
    nose();
    if (has("subnasale")) {
      wings();
      lips();
    }
    if (has("labrale_inferius")) chin();
    return std::move(found_);
  }

 private:
  [[nodiscard]] bool has(const char* name) const { return found_.contains(name); }
  void set(const std::string& name, const std::optional<Vec3>& p) {
    if (p && p->z > lowest_ + kCutMarginMm) found_[name] = *p;
  }
  [[nodiscard]] std::vector<ProfilePoint> midline(double low, double high) const {
    return skin_.front_profile(0, 0, std::max(low, lowest_ + 0.5), high, 0.25);
  }

  void nose() {
    const auto tip =
        middle_of_least(midline(orbits_ - 55 * s_, orbits_ - 6 * s_), [](const Vec3& p) { return p.y; });
    if (!tip) return;
    set("pronasale", tip);
    const auto glabella = foremost(midline(orbits_ + 14 * s_, orbits_ + 40 * s_));
    // From the tip the profile rises to the root; the root's hollow lies in its upper part.
    const double low = std::max(tip->z + 15 * s_, orbits_ - 8 * s_);
    if (glabella && glabella->z > low) set("soft_nasion", hollow(midline(low, glabella->z)));
    // Where nose and lip meet: furthest behind the line that leans on tip and lips.
    const auto below = midline(tip->z - 34 * s_, tip->z - 1 * s_);
    const auto lips = least(
        below, [&](const Vec3& p) { return p.z < tip->z - 12 * s_ ? (p.y - tip->y) / (tip->z - p.z) : 1e9; });
    if (lips) set("subnasale", furthest_behind(midline(lips->z, tip->z), *lips, *tip));
  }

  /// The wings stand out as walls in the view from the front: where depth changes most from the middle to the
  /// side. Alare is the wall's outermost place among the slices from subnasale to above the tip.
  void wings() {
    const Vec3 tip = found_.at("pronasale"), base = found_.at("subnasale");
    for (const int side : {1, -1}) {
      std::optional<Vec3> best;
      for (double z = base.z - 3 * s_; z <= std::max(tip.z, base.z) + 8 * s_; z += 0.5) {
        const auto wing = wall_in_slice(side, z);
        if (wing && (!best || side * wing->x > side * best->x)) best = wing;
      }
      set(side > 0 ? "alare_left" : "alare_right", best);
    }
  }
  [[nodiscard]] std::optional<Vec3> wall_in_slice(int side, double z) const {
    constexpr double kStep = 0.5;
    double where = 0, depth = 0;
    for (double x = 8 * s_; x < 26 * s_; x += kStep) {
      const auto inner = skin_.from_front(side * (x - kStep), z),
                 outer = skin_.from_front(side * (x + kStep), z);
      if (!inner || !outer || outer->y - inner->y < kWallSlope * 2 * kStep) continue;
      where = x, depth = 0.5 * (inner->y + outer->y);
    }
    if (where == 0) return std::nullopt;
    const auto wall = skin_.from_side(side, depth, z);
    if (wall && std::abs(side * wall->x - where) < 2 * s_) return wall;
    return skin_.from_front(side * where, z);
  }

  /// How much deeper the skin is at (x, z) than midway between the places above and below.
  [[nodiscard]] double furrow(double x, double z) const {
    const double reach = kFurrowReachMm * s_;
    const auto here = skin_.from_front(x, z), above = skin_.from_front(x, z + reach),
               below = skin_.from_front(x, z - reach);
    return here && above && below ? here->y - 0.5 * (above->y + below->y) : -1e9;
  }
  [[nodiscard]] double deepest_furrow(double x, double low, double high, double& depth) const {
    double best = low;
    depth = -1e9;
    for (double z = low; z <= high; z += 0.25) {
      const double d = (furrow(x - 1.5, z) + furrow(x, z) + furrow(x + 1.5, z)) / 3;
      if (d > depth) depth = d, best = z;
    }
    return best;
  }

  void lips() {
    const Vec3 base = found_.at("subnasale");
    const auto incisor = bone_.find("upper_incisor");
    double low = base.z - 34 * s_, high = base.z - 13 * s_;
    if (incisor != bone_.end()) {
      low = std::max(low, incisor->second.z - 6 * s_);
      high = std::min(high, incisor->second.z + 9 * s_);
    }
    double depth = -1e9, z = 0;
    if (low > lowest_ + kFurrowReachMm) z = deepest_furrow(0, low, high, depth);
    const bool closed = depth > kFurrowMm * s_;
    if (closed) {
      set("stomion", skin_.from_front(0, z));
      set("labrale_inferius", foremost(midline(z - 13 * s_, z - 1 * s_)));
      corners(z);
    }
    upper_lip(base, closed ? z : std::max(low, lowest_ + 1), closed);
  }

  /// `end`: stomion, or where the scan ends.
  void upper_lip(const Vec3& base, double end, bool whole) {
    const auto lip_profile = midline(end, base.z);
    const auto last = skin_.from_front(0, end);
    if (!last || end > base.z - 9 * s_) return;
    // Furthest before the line from subnasale to the lip's end.
    std::vector<ProfilePoint> lower_part;
    for (const ProfilePoint& p : lip_profile) {
      if (p.at < base.z - 5 * s_) lower_part.push_back(p);
    }
    const double slope = (base.y - last->y) / (base.z - end);
    const auto lip = least(lower_part, [&](const Vec3& p) { return p.y - slope * (p.z - end); });
    // A lip that still comes forward where the scan ends is not shown whole.
    if (!lip || (!whole && lip->z < end + 1.5 * s_)) return;
    set("labrale_superius", lip);
    set("soft_a_point", furthest_behind(midline(lip->z, base.z), *lip, base));
  }

  /// Both corners at once: the furrow fades so slowly that only the mean of both sides tells where it ends.
  void corners(double height) {
    double heights[2] = {height, height};
    std::optional<Vec3> last[2];
    int missed = 0;
    for (double x = 4 * s_; x < 40 * s_ && missed < 9; x += 0.5) {
      double z[2], depths[2];
      for (int side = 0; side < 2; ++side) {
        z[side] =
            deepest_furrow(side == 0 ? x : -x, heights[side] - 2 * s_, heights[side] + 2 * s_, depths[side]);
      }
      if (0.5 * (depths[0] + depths[1]) < kFurrowEndMm * s_) {
        ++missed;
        continue;
      }
      missed = 0;
      for (int side = 0; side < 2; ++side) {
        heights[side] = z[side];
        last[side] = skin_.from_front(side == 0 ? x : -x, z[side]);
      }
    }
    if (!last[0] || !last[1] || last[0]->x < 12 * s_) return;
    set("cheilion_left", last[0]);
    set("cheilion_right", last[1]);
  }

  void chin() {
    const auto bone = bone_.find("pogonion");
    if (bone == bone_.end()) return;
    const double z = bone->second.z, lip = found_.at("labrale_inferius").z;
    const auto pogonion = foremost(midline(z - 8 * s_, std::min(z + 8 * s_, lip - 12 * s_)));
    if (!pogonion) return;
    set("soft_pogonion", pogonion);
    set("soft_b_point", hollow(midline(pogonion->z, lip)));
    if (!bone_.contains("menton")) return;
    std::vector<ProfilePoint> underside;
    for (double y = pogonion->y + 3 * s_; y < pogonion->y + 28 * s_; y += 0.25) {
      const auto p = skin_.from_below(0, y);
      underside.push_back({y, p.value_or(Vec3{}), p.has_value()});
    }
    set("soft_menton", middle_of_least(underside, [](const Vec3& p) { return p.z; }));
  }

  const FaceProbe& skin_;
  const FacePoints& bone_;
  double orbits_, lowest_, s_;
  FacePoints found_;
};

}  // namespace

FacePoints find_skin_landmarks(const FaceProbe& skin, const FacePoints& bone, double orbit_height,
                               double lowest_seen) {
  return SkinSearch(skin, bone, orbit_height, lowest_seen).all();
}

}  // namespace turgor
