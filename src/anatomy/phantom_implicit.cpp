#include "anatomy/implicit.hpp"

#include <algorithm>
#include <array>
#include <utility>

namespace turgor::implicit {
namespace {

// Faster than std::hypot, which guards against overflows that cannot happen here.
double norm(double a, double b) {
  return std::sqrt(a * a + b * b);
}

// The exact distance: the nearest surface point is x_i = r_i² p_i / (t + r_i²), where t is the largest root
// of S(t) = Σ (r_i p_i / (t + r_i²))² = 1. 1/√S is concave and rises, nearly straight, so Newton's steps on
// it never pass the root from the left, and lead to its left from the right.
class Ellipsoid final : public Shape {
 public:
  Ellipsoid(const Vec3& centre, const Vec3& radii, const Mat3& axes)
      : centre_(centre),
        squares_{radii.x * radii.x, radii.y * radii.y, radii.z * radii.z},
        radii_(radii),
        axes_(axes.transposed()),
        least_(std::min({radii.x, radii.y, radii.z})) {}
  double distance(const Vec3& p) const override {
    const Vec3 q = axes_ * (p - centre_);
    const Vec3 rq{radii_.x * std::abs(q.x), radii_.y * std::abs(q.y), radii_.z * std::abs(q.z)};
    // Each term alone reaches 1 here, so the root lies to the right; the last keeps off the pole.
    const double left =
        std::max({rq.x - squares_.x, rq.y - squares_.y, rq.z - squares_.z, 1e-12 - least_ * least_});
    double t = std::max(left, 0.0);
    for (int i = 0; i < 60; ++i) {
      const Vec3 n{1 / (t + squares_.x), 1 / (t + squares_.y), 1 / (t + squares_.z)};
      const double a = rq.x * n.x, b = rq.y * n.y, c = rq.z * n.z;
      const double aa = a * a, bb = b * b, cc = c * c, sum = aa + bb + cc;
      const double fall = aa * n.x + bb * n.y + cc * n.z;
      const double next = fall > 0 ? std::max(t + (std::sqrt(sum) - 1) * sum / fall, left) : left;
      const double change = std::abs(next - t);
      t = next;
      // The steps' lengths square: what the next would add is far below a nanometre.
      if (!(change > 1e-5 * (least_ * least_ + t))) break;
    }
    const double a = q.x / (t + squares_.x), b = q.y / (t + squares_.y), c = q.z / (t + squares_.z);
    const double gap = std::sqrt(a * a + b * b + c * c);
    // Deep inside, on the disc between the focal points, the nearest point leaves the formula: the pole's own
    // radius.
    return t <= 1e-9 - least_ * least_ ? deep(q) : t * gap;
  }
  Knot bound() const override { return {centre_, std::max({radii_.x, radii_.y, radii_.z}) + 1e-6}; }

 private:
  // Points of the plane across the shortest axis whose nearest point lies off that plane.
  double deep(const Vec3& q) const {
    double flat = 0, room = 1;
    for (int a = 0; a < 3; ++a) {
      const double spread = squares_[a] - least_ * least_;
      if (spread <= 1e-9) continue;
      const double x = squares_[a] * q[a] / spread;
      flat += (q[a] - x) * (q[a] - x);
      room -= x * x / squares_[a];
    }
    return -std::sqrt(flat + least_ * least_ * std::max(room, 0.0));
  }
  Vec3 centre_, squares_, radii_;
  Mat3 axes_;
  double least_;
};

class RoundedBox final : public Shape {
 public:
  RoundedBox(const Vec3& centre, const Vec3& half, double radius, const Mat3& axes)
      : centre_(centre),
        core_(half - Vec3{radius, radius, radius}),
        radius_(radius),
        axes_(axes.transposed()) {}
  double distance(const Vec3& p) const override {
    const Vec3 q = axes_ * (p - centre_);
    const Vec3 d{std::abs(q.x) - core_.x, std::abs(q.y) - core_.y, std::abs(q.z) - core_.z};
    const Vec3 out{std::max(d.x, 0.0), std::max(d.y, 0.0), std::max(d.z, 0.0)};
    return length(out) + std::min(std::max({d.x, d.y, d.z}), 0.0) - radius_;
  }
  Knot bound() const override { return {centre_, length(core_) + radius_ + 1e-6}; }

 private:
  Vec3 centre_, core_;
  double radius_;
  Mat3 axes_;
};

class HalfSpace final : public Shape {
 public:
  explicit HalfSpace(const Plane& plane) : plane_(plane) {}
  double distance(const Vec3& p) const override { return plane_.signed_distance(p); }

 private:
  Plane plane_;
};

// The pieces of the Catmull–Rom spline through `count` ≥ 2 knots, `pieces` per interval, each as the
// coefficients of powers of its own parameter, 0 to 1. Beyond its ends the curve is taken to go on straight.
template <class T, class At>
std::vector<std::array<T, 4>> cubic_pieces(std::size_t count, int pieces, const At& at) {
  std::vector<std::array<T, 4>> out;
  for (std::size_t i = 0; i + 1 < count; ++i) {
    const T b = at(i), c = at(i + 1);
    const T a = i == 0 ? b * 2.0 - c : at(i - 1), d = i + 2 == count ? c * 2.0 - b : at(i + 2);
    const T k1 = (c - a) * 0.5, k2 = a - b * 2.5 + c * 2.0 - d * 0.5, k3 = (b - c) * 1.5 + (d - a) * 0.5;
    const double w = 1.0 / pieces;
    for (int s = 0; s < pieces; ++s) {
      const double f = s * w;
      out.push_back({b + (k1 + (k2 + k3 * f) * f) * f, (k1 + (k2 * 2.0 + k3 * (3 * f)) * f) * w,
                     (k2 + k3 * (3 * f)) * (w * w), k3 * (w * w * w)});
    }
  }
  return out;
}

struct Ball {
  Vec3 p;
  double r;
  friend Ball operator+(const Ball& a, const Ball& b) { return {a.p + b.p, a.r + b.r}; }
  friend Ball operator-(const Ball& a, const Ball& b) { return {a.p - b.p, a.r - b.r}; }
  friend Ball operator*(const Ball& a, double s) { return {a.p * s, a.r * s}; }
};

// The ball of radius r(t) about the curve c(t) nearest to p: the least |p − c(t)| − r(t), found on each piece
// of the curve by Newton's method from the chord's foot.
class Sweep final : public Shape {
 public:
  Sweep() = default;
  Sweep(const std::vector<Knot>& knots, int pieces) {
    for (const auto& cubic : cubic_pieces<Ball>(knots.size(), pieces, [&](std::size_t i) {
           return Ball{knots[i].point, knots[i].radius};
         })) {
      pieces_.push_back(Piece(cubic));
    }
  }
  double distance(const Vec3& p) const override {
    double least = std::numeric_limits<double>::infinity();
    for (const Piece& piece : pieces_) {
      const double clear = least + piece.ball.r;
      if (clear < 0 || squared_length(p - piece.ball.p) > clear * clear) continue;
      least = std::min(least, piece.distance(p));
    }
    return least;
  }
  Knot bound() const override {
    Box3 box;
    for (const Piece& piece : pieces_) box.extend(piece.ball.p);
    double radius = 0;
    for (const Piece& piece : pieces_) {
      radius = std::max(radius, turgor::distance(box.centre(), piece.ball.p) + piece.ball.r);
    }
    return {box.centre(), radius + 1e-6};
  }
  ShapePtr shortened(const Vec3& centre, double radius) const override {
    const double reach = distance(centre) + 2 * radius + 1e-9;
    auto out = std::make_shared<Sweep>();
    for (const Piece& piece : pieces_) {
      if (piece.distance(centre) <= reach) out->pieces_.push_back(piece);
    }
    return out->pieces_.size() < pieces_.size() ? out : nullptr;
  }

 private:
  struct Piece {
    std::array<Ball, 4> k;  // coefficients of powers of t, 0 to 1 along the piece
    Vec3 chord;             // divided by its squared length
    Ball ball;              // holds the piece
    explicit Piece(const std::array<Ball, 4>& cubic) : k(cubic) {
      const Vec3 d = k[1].p + k[2].p + k[3].p;
      chord = d / std::max(squared_length(d), 1e-12);
      // A point of the cubic lies within half the length of its control polygon of the middle of its ends.
      const Vec3 first = k[1].p / 3.0, second = (k[1].p + k[2].p) / 3.0, third = d - first - second;
      ball.p = k[0].p + d * 0.5;
      ball.r = 0.5 * (length(first) + length(second) + length(third)) + k[0].r + std::abs(k[1].r) +
               std::abs(k[2].r) + std::abs(k[3].r) + 1e-9;
    }
    double distance(const Vec3& p) const {
      const Vec3 from = p - k[0].p;
      double t = std::clamp(dot(from, chord), 0.0, 1.0);
      for (int i = 0; i < 3; ++i) {
        const Vec3 d = from - (k[1].p + (k[2].p + k[3].p * t) * t) * t;
        const Vec3 c1 = k[1].p + (k[2].p * 2.0 + k[3].p * (3 * t)) * t, c2 = k[2].p * 2.0 + k[3].p * (6 * t);
        const double r1 = k[1].r + (2 * k[2].r + 3 * k[3].r * t) * t, r2 = 2 * k[2].r + 6 * k[3].r * t;
        const double gap = std::sqrt(squared_length(d)) + 1e-12, speed = squared_length(c1),
                     forward = dot(d, c1);
        const double slope = forward + r1 * gap;
        const double bend = speed - dot(d, c2) - r2 * gap + r1 * forward / gap;
        // Near the centres of curvature the second derivative fails; then a cautious step.
        const double next = std::clamp(t + slope / std::max(bend, 0.3 * speed + 1e-12), 0.0, 1.0);
        const bool there = std::abs(next - t) < 1e-8;
        t = next;
        if (there) break;
      }
      const Vec3 d = from - (k[1].p + (k[2].p + k[3].p * t) * t) * t;
      return std::sqrt(squared_length(d)) - (k[0].r + (k[1].r + (k[2].r + k[3].r * t) * t) * t);
    }
  };
  std::vector<Piece> pieces_;
};

struct Post {
  double x, y, z, h, t;
  friend Post operator+(const Post& a, const Post& b) {
    return {a.x + b.x, a.y + b.y, a.z + b.z, a.h + b.h, a.t + b.t};
  }
  friend Post operator-(const Post& a, const Post& b) {
    return {a.x - b.x, a.y - b.y, a.z - b.z, a.h - b.h, a.t - b.t};
  }
  friend Post operator*(const Post& a, double s) { return {a.x * s, a.y * s, a.z * s, a.h * s, a.t * s}; }
};

// The section at the point of the plan's curve nearest to p, found on each piece by Newton's method.
class Wall final : public Shape {
 public:
  Wall(const std::vector<WallKnot>& knots, double roundness, int pieces) : roundness_(roundness) {
    const auto cubics = cubic_pieces<Post>(knots.size(), pieces, [&](std::size_t i) {
      const WallKnot& k = knots[i];
      return Post{k.x, k.y, k.z, k.half_height, k.half_thickness};
    });
    double steepest = 0;
    for (const auto& k : cubics) {
      pieces_.push_back(Piece(k));
      for (const double t : {0.0, 0.5, 1.0}) {
        const Post step = k[1] + (k[2] * 2.0 + k[3] * (3 * t)) * t;
        steepest = std::max(steepest,
                            (std::abs(step.z) + std::abs(step.h) + std::abs(step.t)) / norm(step.x, step.y));
      }
    }
    lipschitz_ = std::sqrt(1 + steepest * steepest) + 0.15;
  }
  double distance(const Vec3& p) const override {
    double least = std::numeric_limits<double>::infinity();
    for (const Piece& piece : pieces_) {
      const double clear = least + piece.ball.r;
      if (clear < 0 || squared_length(p - piece.ball.p) > clear * clear) continue;
      least = std::min(least, piece.distance(p, roundness_));
    }
    return least;
  }
  double lipschitz() const override { return lipschitz_; }
  Knot bound() const override {
    Box3 box;
    double reach = 0;
    for (const Piece& piece : pieces_) {
      for (const double t : {0.0, 0.25, 0.5, 0.75, 1.0}) {
        const Post post = piece.at(t);
        box.extend({post.x, post.y, post.z});
        reach = std::max(reach, norm(post.h, post.t));
      }
    }
    return {box.centre(), 0.5 * length(box.size()) + reach + 1};
  }
  ShapePtr shortened(const Vec3& centre, double radius) const override {
    const double reach = distance(centre) + 2 * radius * lipschitz_ + 1e-9;
    auto out = std::make_shared<Wall>(*this);
    std::erase_if(out->pieces_,
                  [&](const Piece& piece) { return piece.distance(centre, roundness_) > reach; });
    return out->pieces_.size() < pieces_.size() ? out : nullptr;
  }

 private:
  struct Piece {
    std::array<Post, 4> k;
    Ball ball;  // holds the piece
    explicit Piece(const std::array<Post, 4>& cubic) : k(cubic) {
      // As of a sweep's piece, and the section's corners.
      const auto length_of = [](const Post& v) { return length(Vec3{v.x, v.y, v.z}); };
      const Post d = k[1] + k[2] + k[3], first = k[1] * (1.0 / 3), second = (k[1] + k[2]) * (1.0 / 3);
      const double corner =
          norm(k[0].h, k[0].t) + norm(k[1].h, k[1].t) + norm(k[2].h, k[2].t) + norm(k[3].h, k[3].t);
      ball.p = Vec3{k[0].x, k[0].y, k[0].z} + Vec3{d.x, d.y, d.z} * 0.5;
      ball.r = 0.5 * (length_of(first) + length_of(second) + length_of(d - first - second)) + corner + 1e-9;
    }
    [[nodiscard]] Post at(double t) const { return k[0] + (k[1] + (k[2] + k[3] * t) * t) * t; }
    [[nodiscard]] double distance(const Vec3& p, double roundness) const {
      const Post d = k[1] + k[2] + k[3];
      double t =
          std::clamp(((p.x - k[0].x) * d.x + (p.y - k[0].y) * d.y) / (d.x * d.x + d.y * d.y), 0.0, 1.0);
      for (int i = 0; i < 3; ++i) {
        const Post c = at(t), c1 = k[1] + (k[2] * 2.0 + k[3] * (3 * t)) * t, c2 = k[2] * 2.0 + k[3] * (6 * t);
        const double x = p.x - c.x, y = p.y - c.y, speed = c1.x * c1.x + c1.y * c1.y;
        const double bend = speed - x * c2.x - y * c2.y;
        t = std::clamp(t + (x * c1.x + y * c1.y) / std::max(bend, 0.3 * speed), 0.0, 1.0);
      }
      const Post c = at(t);
      const double r = roundness * std::min(c.h, c.t);
      const double u = norm(p.x - c.x, p.y - c.y) - c.t + r, v = std::abs(p.z - c.z) - c.h + r;
      return norm(std::max(u, 0.0), std::max(v, 0.0)) + std::min(std::max(u, v), 0.0) - r;
    }
  };
  std::vector<Piece> pieces_;
  double roundness_, lipschitz_;
};

struct Flat {
  double u, v;
  friend Flat operator+(const Flat& a, const Flat& b) { return {a.u + b.u, a.v + b.v}; }
  friend Flat operator-(const Flat& a, const Flat& b) { return {a.u - b.u, a.v - b.v}; }
  friend Flat operator*(const Flat& a, double s) { return {a.u * s, a.v * s}; }
};

class Plate final : public Shape {
 public:
  Plate(const Vec3& origin, const Mat3& axes, const std::vector<OutlinePoint>& outline, double half_thickness,
        double radius, int pieces)
      : origin_(origin), axes_(axes.transposed()), half_(half_thickness), radius_(radius) {
    // The closed curve: its knots once around, with one more at either end to set the tangents.
    const std::size_t count = outline.size();
    const auto knot = [&](std::size_t i) {
      const OutlinePoint& o = outline[(i + count - 1) % count];
      return Flat{o.u, o.v};
    };
    const auto cubics = cubic_pieces<Flat>(count + 3, pieces, knot);
    std::vector<Flat> corners;
    const auto lead = static_cast<std::size_t>(pieces);
    for (std::size_t i = lead; i + lead < cubics.size(); ++i) corners.push_back(cubics[i][0]);
    double area = 0;
    for (std::size_t i = 0, j = corners.size() - 1; i < corners.size(); j = i++) {
      area += corners[j].u * corners[i].v - corners[i].u * corners[j].v;
    }
    if (area < 0) std::reverse(corners.begin(), corners.end());
    const std::size_t n = corners.size();
    const auto normal = [&](std::size_t i) {  // of the edge from corner i on, outwards
      const Flat e = corners[(i + 1) % n] - corners[i];
      return Flat{e.v, -e.u} * (1 / norm(e.u, e.v));
    };
    for (std::size_t i = 0; i < n; ++i) {
      const Flat e = corners[(i + 1) % n] - corners[i];
      edges_.push_back({corners[i], e, 1 / (e.u * e.u + e.v * e.v), normal(i),
                        normal((i + n - 1) % n) + normal(i), normal(i) + normal((i + 1) % n)});
    }
  }
  double distance(const Vec3& p) const override {
    const Vec3 q = axes_ * (p - origin_);
    const double a = outline_distance(q.x, q.y) + radius_, b = std::abs(q.z) - half_ + radius_;
    return norm(std::max(a, 0.0), std::max(b, 0.0)) + std::min(std::max(a, b), 0.0) - radius_;
  }
  Knot bound() const override {
    double reach = 0;
    for (const Edge& edge : edges_) reach = std::max(reach, norm(edge.from.u, edge.from.v));
    return {origin_, norm(reach, half_) + 1e-6};
  }
  ShapePtr shortened(const Vec3& centre, double radius) const override {
    const Vec3 q = axes_ * (centre - origin_);
    const double reach = std::abs(outline_distance(q.x, q.y)) + 2 * radius + 1e-9;
    auto out = std::make_shared<Plate>(*this);
    std::erase_if(out->edges_, [&](const Edge& edge) {
      const Flat d = edge.offset(q.x, q.y).second;
      return d.u * d.u + d.v * d.v > reach * reach;
    });
    return out->edges_.size() < edges_.size() ? out : nullptr;
  }

 private:
  struct Edge {
    Flat from, step;
    double per_square;
    Flat normal, normal_from, normal_to;  // outwards: of the edge, of its ends
    // Position along the edge, 0 to 1, of the nearest point, and the way from there.
    [[nodiscard]] std::pair<double, Flat> offset(double u, double v) const {
      const Flat w{u - from.u, v - from.v};
      const double t = std::clamp((w.u * step.u + w.v * step.v) * per_square, 0.0, 1.0);
      return {t, w - step * t};
    }
  };
  // Inside and outside are told apart at the nearest edge, so that far edges need not be known.
  double outline_distance(double u, double v) const {
    double least = std::numeric_limits<double>::infinity(), side = 1;
    for (const Edge& edge : edges_) {
      const auto [t, d] = edge.offset(u, v);
      const double squared = d.u * d.u + d.v * d.v;
      if (squared >= least) continue;
      least = squared;
      const Flat& n = t <= 0 ? edge.normal_from : t >= 1 ? edge.normal_to : edge.normal;
      side = d.u * n.u + d.v * n.v;
    }
    return side < 0 ? -std::sqrt(least) : std::sqrt(least);
  }
  Vec3 origin_;
  Mat3 axes_;
  std::vector<Edge> edges_;
  double half_, radius_;
};

class Offset final : public Shape {
 public:
  Offset(ShapePtr shape, double by) : shape_(std::move(shape)), by_(by) {}
  double distance(const Vec3& p) const override { return shape_->distance(p) - by_; }
  Knot bound() const override {
    const Knot inner = shape_->bound();
    return {inner.point, inner.radius + by_};
  }
  double lipschitz() const override { return shape_->lipschitz(); }
  ShapePtr shortened(const Vec3& centre, double radius) const override {
    ShapePtr inner = shape_->shortened(centre, radius);
    return inner ? std::make_shared<Offset>(std::move(inner), by_) : nullptr;
  }

 private:
  ShapePtr shape_;
  double by_;
};

class Moved final : public Shape {
 public:
  Moved(ShapePtr shape, const RigidTransform& back) : shape_(std::move(shape)), back_(back) {}
  double distance(const Vec3& p) const override { return shape_->distance(back_.point(p)); }
  Knot bound() const override {
    const Knot inner = shape_->bound();
    return {back_.inverse().point(inner.point), inner.radius + 1e-6};
  }
  double lipschitz() const override { return shape_->lipschitz(); }
  ShapePtr shortened(const Vec3& centre, double radius) const override {
    ShapePtr inner = shape_->shortened(back_.point(centre), radius);
    return inner ? std::make_shared<Moved>(std::move(inner), back_) : nullptr;
  }

 private:
  ShapePtr shape_;
  RigidTransform back_;
};

class Group final : public Shape {
 public:
  explicit Group(Field field) : field_(std::move(field)) {}
  double distance(const Vec3& p) const override { return field_.value(p); }
  Knot bound() const override { return field_.bound(); }
  double lipschitz() const override { return field_.lipschitz(); }
  ShapePtr shortened(const Vec3& centre, double radius) const override {
    return std::make_shared<Group>(field_.shortened(centre, radius));
  }

 private:
  Field field_;
};

}  // namespace

Knot Shape::bound() const {
  return {{0, 0, 0}, std::numeric_limits<double>::infinity()};
}
std::shared_ptr<const Shape> Shape::shortened(const Vec3&, double) const {
  return nullptr;
}

double smooth_step(double from, double to, double x) {
  const double t = std::clamp((x - from) / (to - from), 0.0, 1.0);
  return t * t * t * (t * (t * 6 - 15) + 10);
}

ShapePtr ellipsoid(const Vec3& centre, const Vec3& radii, const Mat3& axes) {
  return std::make_shared<Ellipsoid>(centre, radii, axes);
}
ShapePtr rounded_box(const Vec3& centre, const Vec3& half, double radius, const Mat3& axes) {
  return std::make_shared<RoundedBox>(centre, half, radius, axes);
}
ShapePtr half_space(const Plane& inside_below) {
  return std::make_shared<HalfSpace>(inside_below);
}
ShapePtr sweep(const std::vector<Knot>& knots, int pieces) {
  return std::make_shared<Sweep>(knots, pieces);
}
ShapePtr wall(const std::vector<WallKnot>& knots, double roundness, int pieces) {
  return std::make_shared<Wall>(knots, roundness, pieces);
}
ShapePtr plate(const Vec3& origin, const Mat3& axes, const std::vector<OutlinePoint>& outline,
               double half_thickness, double radius, int pieces) {
  return std::make_shared<Plate>(origin, axes, outline, half_thickness, radius, pieces);
}
ShapePtr offset(ShapePtr shape, double by) {
  return std::make_shared<Offset>(std::move(shape), by);
}
ShapePtr moved(ShapePtr shape, const RigidTransform& motion) {
  return std::make_shared<Moved>(std::move(shape), motion.inverse());
}
ShapePtr group(Field field) {
  return std::make_shared<Group>(std::move(field));
}

}  // namespace turgor::implicit
