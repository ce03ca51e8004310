#include "anatomy/phantom_pose.hpp"

namespace turgor::phantom {
namespace {

// How a window sees the soft tissue: as it is, or as it was before the jaw's protrusion carried it.
enum class Pose : std::uint8_t { carried, at_rest };

// A window of rays against `outward` through a rectangle around `centre`, and what they first meet of one
// part.
class Window {
 public:
  Window(const PosedParts& parts, Part part, const Vec3& centre, const Vec3& outward, const Vec3& along,
         Pose pose = Pose::carried)
      : parts_(parts),
        part_(part),
        pose_(pose),
        centre_(centre),
        outward_(normalized(outward)),
        v_(normalized(along - outward_ * dot(along, outward_))),
        u_(cross(v_, outward_)),
        reach_(14 * parts.parameters().size) {}

  /// Height over the window's plane, along `outward`, of the surface point at (u, v); far below where there
  /// is none.
  [[nodiscard]] double height(double u, double v) const {
    const Vec3 from = centre_ + u_ * u + v_ * v + outward_ * reach_;
    const double slope = parts_.lipschitz(part_);
    double t = 0, value = value_at(from);
    if (value < 0) return reach_;  // starts inside: as high as the window sees
    double before = 0;
    while (t < 2 * reach_) {
      before = t;
      t += std::max(value / slope, 0.02);
      value = value_at(from - outward_ * t);
      if (value < 0) break;
    }
    if (value >= 0) return -reach_;
    for (int i = 0; i < 40; ++i) {
      const double middle = 0.5 * (before + t);
      (value_at(from - outward_ * middle) >= 0 ? before : t) = middle;
    }
    return reach_ - 0.5 * (before + t);
  }
  [[nodiscard]] Vec3 point(double u, double v) const {
    return centre_ + u_ * u + v_ * v + outward_ * height(u, v);
  }

  /// The highest (or, `deepest`, lowest) point for |u| ≤ half_u, |v| ≤ half_v: a scan, then ever smaller
  /// steps.
  [[nodiscard]] Vec3 extreme(double half_u, double half_v, bool deepest = false) const {
    const double sign = deepest ? -1 : 1;
    double best_u = 0, best_v = 0, best = -1e9;
    const auto consider = [&](double u, double v) {
      if (std::abs(u) > half_u || std::abs(v) > half_v) return false;
      const double h = sign * height(u, v);
      if (h <= best) return false;
      best = h, best_u = u, best_v = v;
      return true;
    };
    constexpr int n = 8;
    for (int i = -n; i <= n; ++i) {
      for (int j = -n; j <= n; ++j) {
        if (half_u > 0 || i == 0) consider(half_u * i / n, half_v * j / n);
      }
    }
    for (double step = std::max(half_u, half_v) / n; step > 1e-4; step /= 2) {
      bool moved = true;
      while (moved) {
        moved = false;
        const double u = best_u, v = best_v;
        for (const double s : {-step, step})
          moved = consider(u + s, v) || moved, moved = consider(u, v + s) || moved;
      }
    }
    return point(best_u, best_v);
  }

 private:
  [[nodiscard]] double value_at(const Vec3& p) const {
    return parts_.value(part_, pose_ == Pose::carried ? p : parts_.place_soft(p / parts_.parameters().size));
  }

  const PosedParts& parts_;
  Part part_;
  Pose pose_;
  Vec3 centre_, outward_, v_, u_;
  double reach_;
};

constexpr Vec3 up{0, 0, 1}, front{0, -1, 0}, left{1, 0, 0};

class LandmarkSearch {
 public:
  explicit LandmarkSearch(const PosedParts& parts) : parts_(parts), size_(parts.parameters().size) {}

  std::map<std::string, Vec3> all() {
    skull();
    mandible();
    lips();
    soft_profile();
    soft_sides();
    for (const char* name : {"gonion", "condylion", "orbitale", "zygion", "cheilion", "alare"}) {
      const Vec3 p = found_.at(std::string(name) + "_left");
      found_[std::string(name) + "_right"] = {-p.x, p.y, p.z};
    }
    return std::move(found_);
  }

 private:
  Vec3 fixed(const Vec3& q) const { return q * size_; }

  // Midline point of `part` near `centre`, within ± half of it along `along`.
  Vec3 midline(Part part, const Vec3& centre, double half, bool deepest, const Vec3& outward = front,
               const Vec3& along = up, Pose pose = Pose::carried) const {
    return Window(parts_, part, centre, outward, along, pose).extreme(0, half * size_, deepest);
  }

  void skull() {
    found_["nasion"] = midline(Part::skull, fixed({0, -87, 26}), 8, true);
    found_["ans"] = midline(Part::skull, fixed({0, -88, -25}), 4, false);
    found_["a_point"] = midline(Part::skull, fixed({0, -86, -31}), 4.5, true);
    found_["upper_incisor"] = Window(parts_, Part::upper_teeth, fixed({4.35, -91, -49}), -up, front)
                                  .extreme(0.5 * size_, 3 * size_);
    found_["zygion_left"] =
        Window(parts_, Part::skull, fixed({63, -33, -2}), left, up).extreme(22 * size_, 8 * size_);
    orbitale();
  }

  // The lowest point of the rim, which at each breadth is the edge seen from front and above.
  void orbitale() {
    const auto rim = [&](double x) {
      return Window(parts_, Part::skull, fixed({x, -80, -2}), {0, -1, 1}, up).extreme(0, 7 * size_);
    };
    double best = 31, step = 2;
    for (double x = 22; x <= 41; x += step) {
      if (rim(x).z < rim(best).z) best = x;
    }
    for (; step > 1e-3; step /= 2) {
      for (const double x : {best - step, best + step}) {
        if (x >= 20 && x <= 42 && rim(x).z < rim(best).z) best = x;
      }
    }
    found_["orbitale_left"] = rim(best);
  }

  void mandible() {
    const auto at = [&](const Vec3& q) { return parts_.place_bone(q); };
    found_["pogonion"] = midline(Part::mandible, at({0, -87, -82}), 7, false);
    found_["b_point"] = midline(Part::mandible, at({0, -83, -69}), 7, true);
    found_["menton"] = midline(Part::mandible, at({0, -80, -90}), 7, false, -up, front);
    found_["lower_incisor"] =
        Window(parts_, Part::lower_teeth, at({2.75, -88, -50}), up, front).extreme(0.5 * size_, 3 * size_);
    found_["condylion_left"] =
        Window(parts_, Part::mandible, at({50, -10, 1}), {0, 1, 1}, up).extreme(8 * size_, 5 * size_);
    found_["gonion_left"] = Window(parts_, Part::mandible, at({46, -14, -62}), {0.3, 0.7, -0.7}, up)
                                .extreme(8 * size_, 10 * size_);
  }

  void soft_profile() {
    const auto at = [&](const Vec3& q) { return parts_.place_soft(q); };
    const auto skin = [&](const Vec3& q, double half, bool deepest) {
      return midline(Part::skin, at(q), half, deepest);
    };
    found_["soft_nasion"] = skin({0, -93, 22}, 9, true);
    found_["pronasale"] = skin({0, -117, -13}, 7, false);
    const Vec3 subnasale = midline(Part::skin, at({0, -103, -26}), 6, true, {0, -1, -1});
    const Vec3 upper_lip = found_.at("labrale_superius");
    found_["subnasale"] = subnasale;
    const Vec3 chord = upper_lip - subnasale;
    found_["soft_a_point"] = midline(Part::skin, (subnasale + upper_lip) * 0.5, 0.45 * length(chord) / size_,
                                     true, cross(normalized(chord), left), chord);
    found_["soft_b_point"] = skin({0, -97, -65}, 7, true);
    found_["soft_pogonion"] = skin({0, -99, -81}, 8, false);
    found_["soft_menton"] = midline(Part::skin, at({0, -84, -97}), 10, false, -up, front);
  }

  void soft_sides() {
    found_["alare_left"] =
        Window(parts_, Part::skin, fixed({17, -98.5, -17}), left, up).extreme(3 * size_, 5 * size_);
  }

  // Between lips that a protrusion has set far apart no foremost and deepest points need be left (a retruded
  // lower lip falls away steadily). So those of the head at rest are found, and go where their tissue goes.
  void lips() {
    const auto carried = [&](const Vec3& p) { return parts_.place_soft(p / size_); };
    const auto lip = [&](const Vec3& q, double half, bool deepest) {
      return carried(midline(Part::skin, fixed(q), half, deepest, front, up, Pose::at_rest));
    };
    found_["labrale_superius"] = lip({0, -106, -41.5}, 4.5, false);
    found_["stomion"] = lip({0, -101, -47}, 3, true);
    found_["labrale_inferius"] = lip({0, -104, -53}, 4.5, false);
    found_["cheilion_left"] = carried(cheilion());
  }

  // Where the furrow between the lips at rest runs out: its depth, between the lips 2.5 mm above and below,
  // falls to 0.3 mm.
  [[nodiscard]] Vec3 cheilion() const {
    const auto deepest = [&](double x) {
      const Window window(parts_, Part::skin, fixed({x, -94, -47}), front, up, Pose::at_rest);
      double depth = -1e9, v_deepest = 0;
      for (double v = -3; v <= 3; v += 0.25) {
        const auto y = [&](double dv) { return -window.height(0, (v + dv) * size_); };
        const double d = y(0) - 0.5 * (y(2.5) + y(-2.5));
        if (d > depth) depth = d, v_deepest = v;
      }
      return std::pair{depth, window.point(0, v_deepest * size_)};
    };
    double low = 15, high = 34;
    while (high - low > 1e-3) {
      const double middle = 0.5 * (low + high);
      (deepest(middle).first > 0.3 * size_ ? low : high) = middle;
    }
    return deepest(low).second;
  }

  const PosedParts& parts_;
  double size_;
  std::map<std::string, Vec3> found_;
};

}  // namespace

std::map<std::string, Vec3> true_landmarks(const PosedParts& parts) {
  return LandmarkSearch(parts).all();
}

}  // namespace turgor::phantom
