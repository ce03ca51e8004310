#include <array>

#include "anatomy/phantom_shapes.hpp"

namespace turgor::phantom {

using implicit::Shape;
using implicit::Side;

namespace {

enum class Kind { incisor, canine, premolar, molar };

/// Sizes in mm; place of the middle of the edge or chewing surface in plan.
struct ToothPlan {
  Kind kind;
  double x, y;
  double width, depth;  ///< along the arch, across it
  double crown, root;   ///< heights
  double lean;          ///< the root's tip lies this far to the inside of the edge
};

constexpr std::array<ToothPlan, 7> upper_plan{{
    {Kind::incisor, 4.35, -91.2, 8.5, 7.0, 10.5, 13, 9},
    {Kind::incisor, 11.6, -88.4, 6.6, 6.4, 9.2, 13, 8},
    {Kind::canine, 17.3, -83.0, 7.7, 7.8, 10.2, 16, 5},
    {Kind::premolar, 21.0, -76.2, 7.0, 8.8, 8.2, 13, 1.5},
    {Kind::premolar, 23.6, -69.6, 6.8, 8.8, 7.8, 13, 1},
    {Kind::molar, 25.8, -61.2, 10.2, 10.6, 7.2, 12, 0},
    {Kind::molar, 27.6, -51.2, 9.8, 10.4, 6.8, 11, 0},
}};
constexpr std::array<ToothPlan, 7> lower_plan{{
    {Kind::incisor, 2.75, -88.2, 5.4, 5.8, 9.0, 12, 7.5},
    {Kind::incisor, 8.3, -86.8, 5.9, 6.0, 9.2, 13, 7},
    {Kind::canine, 14.1, -83.0, 6.8, 7.4, 10.2, 15, 5},
    {Kind::premolar, 18.2, -77.2, 7.0, 7.8, 8.4, 13, 0.5},
    {Kind::premolar, 21.0, -70.6, 7.1, 8.0, 8.0, 13, 0},
    {Kind::molar, 23.6, -61.9, 10.9, 10.0, 7.4, 12, -1},
    {Kind::molar, 25.9, -51.5, 10.4, 9.8, 7.0, 11, -1},
}};

// One tooth: a section that is a rounded rectangle, its two half sizes changing from the root's tip over the
// neck to the edge, closed by a rounded cap.
class Tooth final : public Shape {
 public:
  /// `up` is +1 where the crown points upwards.
  Tooth(const ToothPlan& plan, const Vec3& edge, double tangent, double up)
      : plan_(plan), edge_(edge), cosine_(std::cos(tangent)), sine_(std::sin(tangent)), up_(up) {}

  double distance(const Vec3& p) const override {
    const double h = up_ * (p.z - edge_.z);  // ≤ 0 in the tooth
    const double down = -h / (plan_.crown + plan_.root);
    const double x = p.x - edge_.x, y = p.y - edge_.y;
    const double m = x * cosine_ + y * sine_;  // along the arch
    double b = -x * sine_ + y * cosine_;       // to the inside
    b -= plan_.lean * std::clamp(down, -0.2, 1.2);
    const double s = std::clamp(-h / plan_.crown, 0.0, 1.0);
    const double t = std::clamp((-h - plan_.crown) / plan_.root, 0.0, 1.0);
    double a = 0, c = 0;
    sizes(s, t, a, c);
    const double r = 0.75 * std::min(a, c);
    const double u = std::abs(m) - a + r, v = std::abs(b) - c + r;
    const double side =
        std::sqrt(square(std::max(u, 0.0)) + square(std::max(v, 0.0))) + std::min(std::max(u, v), 0.0) - r;
    const double cap = std::max(h + cusp(m, b), -h - plan_.crown - plan_.root);
    const double round = plan_.kind == Kind::incisor ? 0.5 : 1.1;
    const double e = side + round, g = cap + round;
    return std::sqrt(square(std::max(e, 0.0)) + square(std::max(g, 0.0))) + std::min(std::max(e, g), 0.0) -
           round;
  }
  implicit::Knot bound() const override {
    const double half = 0.5 * (plan_.crown + plan_.root);
    const double across = std::abs(plan_.lean) + 0.5 * (plan_.width + plan_.depth) + 1;
    return {edge_ - Vec3{0, 0, up_ * half}, half + across};
  }
  double lipschitz() const override { return 2.2; }

 private:
  static double square(double v) { return v * v; }
  void sizes(double s, double t, double& a, double& c) const {
    const double w = 0.5 * plan_.width - 0.05, d = 0.5 * plan_.depth;
    const double belly = s * (1 - s) * 4;
    switch (plan_.kind) {
      case Kind::incisor:
        a = w * (1 - 0.2 * s * s), c = 0.7 + (d - 0.7) * std::pow(s, 0.8);
        break;
      case Kind::canine:
        a = w * (0.82 - 0.16 * s + 0.18 * belly), c = 1.6 + (d - 1.6) * std::pow(s, 0.7);
        break;
      case Kind::premolar:
      case Kind::molar:
        a = w * (0.94 - 0.12 * s + 0.06 * belly), c = d * (0.84 + 0.02 * s + 0.14 * belly);
        break;
    }
    const double taper = 1 - 0.6 * t * t;
    a *= taper, c *= taper;
  }
  // Height by which the cap lies below the highest cusp.
  double cusp(double m, double b) const {
    const double u = m / (0.5 * plan_.width), v = b / (0.5 * plan_.depth);
    switch (plan_.kind) {
      case Kind::incisor:
        return 0.25 * u * u + 0.5 * v * v;
      case Kind::canine:
        return 1.6 * (std::sqrt(u * u + 0.05) - 0.22);
      case Kind::premolar:
        return 1.2 * std::exp(-6 * v * v) + 0.4 * u * u;
      case Kind::molar:
        return 1.2 * std::exp(-8 * v * v) + 0.6 * std::exp(-14 * u * u) * (1 - std::exp(-8 * v * v));
    }
    return 0;
  }

  ToothPlan plan_;
  Vec3 edge_;
  double cosine_, sine_, up_;
};

constexpr std::size_t count = 7;
using Arch = std::array<ToothPlan, count>;

Vec3 edge_of(const ToothPlan& t, double gap) {
  return {t.x, t.y, occlusal_height(t.y) - gap};
}

// Direction of the arch at a tooth, from the midline backwards; across the midline at the first.
double tangent(const Arch& plan, std::size_t i) {
  const ToothPlan& t = plan[i];
  const double x0 = i == 0 ? -t.x : plan[i - 1].x, y0 = i == 0 ? t.y : plan[i - 1].y;
  const ToothPlan& next = plan[std::min(i + 1, count - 1)];
  return std::atan2(next.y - y0, next.x - x0);
}

Field arch(const Arch& plan, double gap, double up) {
  Field f;
  for (std::size_t i = 0; i < count; ++i) {
    f.join(std::make_shared<Tooth>(plan[i], edge_of(plan[i], gap), tangent(plan, i), up), 0, Side::sharp);
  }
  return f;
}

// Bone grows around each root from a little below the neck to beyond its tip.
std::vector<ShapePtr> sockets(const Arch& plan, double gap, double up) {
  std::vector<ShapePtr> out;
  for (std::size_t i = 0; i < count; ++i) {
    const ToothPlan& t = plan[i];
    const double angle = tangent(plan, i), length = t.crown + t.root;
    const auto on_axis = [&](double depth) {
      const double inwards = t.lean * depth / length;
      return edge_of(t, gap) + Vec3{-std::sin(angle) * inwards, std::cos(angle) * inwards, -up * depth};
    };
    const double neck = 0.2 * (t.width + t.depth) + 0.8;
    out.push_back(implicit::sweep({{on_axis(t.crown + 0.8 * neck), neck},
                                   {on_axis(t.crown + 0.6 * t.root), 0.8 * neck},
                                   {on_axis(length - 1), 0.55 * neck}},
                                  1));
  }
  return out;
}

}  // namespace

Field upper_teeth(const Fit&) {
  return arch(upper_plan, 0, -1);
}
std::vector<ShapePtr> upper_sockets() {
  return sockets(upper_plan, 0, -1);
}
std::vector<ShapePtr> lower_sockets(const Fit& fit) {
  return sockets(lower_plan, fit.occlusal_gap, 1);
}
Field lower_teeth(const Fit& fit) {
  return arch(lower_plan, fit.occlusal_gap, 1);
}

}  // namespace turgor::phantom
