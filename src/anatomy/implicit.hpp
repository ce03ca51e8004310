// Smooth implicit shapes: signed distances (mm, negative inside), and fields that combine them with smooth
// joins and cuts. A field can be evaluated by parts of space, each part knowing the few shapes that matter
// there.
#pragma once

#include <cstdint>
#include <limits>
#include <memory>
#include <vector>

#include "turgor/math/vec.hpp"

namespace turgor::implicit {

struct Knot {
  Vec3 point;
  double radius;
};

/// A shape with a distance that is zero on its surface and has gradient of length 1 there.
class Shape {
 public:
  virtual ~Shape() = default;
  [[nodiscard]] virtual double distance(const Vec3& p) const = 0;
  /// |distance(p) − distance(q)| ≤ lipschitz() |p − q| everywhere.
  [[nodiscard]] virtual double lipschitz() const { return 1; }
  /// A ball such that distance(p) ≥ |p − centre| − radius; of infinite radius where the shape has none.
  [[nodiscard]] virtual Knot bound() const;
  /// A cheaper shape with the same distances in the ball, bit for bit; null where there is none.
  [[nodiscard]] virtual std::shared_ptr<const Shape> shortened(const Vec3& centre, double radius) const;
};
using ShapePtr = std::shared_ptr<const Shape>;

/// min(a, b), rounded over |a − b| < k by a cubic: twice continuously differentiable, at most k/6 below
/// min(a, b).
[[nodiscard]] inline double smooth_min(double a, double b, double k) {
  const double lower = a < b ? a : b;
  const double h = k - (a < b ? b - a : a - b);
  return h > 0 ? lower - h * h * h / (6 * k * k) : lower;
}
[[nodiscard]] inline double smooth_max(double a, double b, double k) {
  return -smooth_min(-a, -b, k);
}
/// 0 below `from`, 1 above `to`, twice continuously differentiable between (`to` may be below `from`).
[[nodiscard]] double smooth_step(double from, double to, double x);

/// Exact; `axes` holds its principal directions as columns.
ShapePtr ellipsoid(const Vec3& centre, const Vec3& radii, const Mat3& axes = {});
ShapePtr rounded_box(const Vec3& centre, const Vec3& half, double radius, const Mat3& axes = {});
ShapePtr half_space(const Plane& inside_below);

/// A ball rolled along a smooth curve (Catmull and Rom) through the knots, its radius interpolated likewise.
/// Each knot interval is searched in `pieces`, enough where each bends by less than about 30°.
ShapePtr sweep(const std::vector<Knot>& knots, int pieces = 2);

struct WallKnot {
  double x, y;  ///< plan
  double z;     ///< middle of the height
  double half_height, half_thickness;
};
/// An upright wall along a smooth curve in plan, its section a rectangle rounded by the fraction `roundness`
/// of the smaller half size.
ShapePtr wall(const std::vector<WallKnot>& knots, double roundness, int pieces = 2);

struct OutlinePoint {
  double u, v;
};
/// A plate: the smooth closed outline in the plane of the first two columns of `axes` through `origin`, of
/// thickness 2 `half_thickness` along the third, edges rounded by `radius`.
ShapePtr plate(const Vec3& origin, const Mat3& axes, const std::vector<OutlinePoint>& outline,
               double half_thickness, double radius, int pieces = 6);

/// The shape grown by `by` (shrunk where negative).
ShapePtr offset(ShapePtr shape, double by);
/// The shape carried by a rigid motion.
ShapePtr moved(ShapePtr shape, const RigidTransform& motion);

/// How a step sees the two sides of the head.
enum class Side : std::uint8_t {
  whole,  ///< as it is
  both,   ///< on the left and, mirrored, on the right; smooth across the midplane (x ↦ √(x² + 1))
  sharp,  ///< the same with x ↦ |x|, for shapes that stay clear of the midplane
};

/// Shapes combined one after another.
class Field {
 public:
  Field& join(ShapePtr shape, double blend = 0, Side side = Side::whole);
  Field& cut(ShapePtr shape, double blend = 0, Side side = Side::whole);
  /// Only what also lies in `shape`.
  Field& keep(ShapePtr shape, double blend = 0, Side side = Side::whole);

  [[nodiscard]] double value(const Vec3& p) const;
  [[nodiscard]] double lipschitz() const { return lipschitz_; }
  [[nodiscard]] std::size_t size() const { return steps_.size(); }
  /// The steps that can matter anywhere in the ball: there the value is the same, bit for bit.
  [[nodiscard]] Field shortened(const Vec3& centre, double radius) const;
  /// As Shape::bound.
  [[nodiscard]] Knot bound() const;

 private:
  enum class Operation : std::uint8_t { join, cut, keep };
  struct Step {
    ShapePtr shape;
    double blend;
    Operation operation;
    Side side;
    Knot bound;
  };
  struct Views;  // the point as each Side sees it
  Field& add(Operation operation, ShapePtr shape, double blend, Side side);
  [[nodiscard]] static double apply(const Step& step, double value, const Views& views);

  std::vector<Step> steps_;
  double lipschitz_ = 1;
  // Before the first step nothing is inside; −∞ where the steps left out made everything so.
  double start_ = std::numeric_limits<double>::infinity();
};

/// A field as one shape of another field.
ShapePtr group(Field field);

/// The same values as the field's own, faster: inside `box` each cell evaluates only the steps that can
/// matter in it.
class IndexedField {
 public:
  IndexedField() = default;
  IndexedField(Field field, const Box3& box, double cell_mm);

  [[nodiscard]] double value(const Vec3& p) const;
  [[nodiscard]] double lipschitz() const { return field_.lipschitz(); }
  /// Bound of the change of value() per mm within `radius` around p, often tighter.
  [[nodiscard]] double lipschitz(const Vec3& p, double radius) const;
  /// As Field::shortened.
  [[nodiscard]] Field shortened(const Vec3& centre, double radius) const;
  /// As Shape::bound.
  [[nodiscard]] Knot bound() const;

 private:
  [[nodiscard]] const Field& at(const Vec3& p) const;
  struct Branch;  // what one root cell becomes
  void split(const Index3& from, int edge, const Field& parent, Branch& branch) const;
  [[nodiscard]] std::size_t cell(const Index3& at) const;

  Field field_;
  Box3 box_;
  double cell_mm_ = 1;
  Index3 cells_{0, 0, 0};
  std::vector<Field> parts_;            // cells far from the surface share one
  std::vector<std::uint32_t> part_of_;  // of each cell
};

}  // namespace turgor::implicit
