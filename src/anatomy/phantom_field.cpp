#include <iterator>
#include <utility>

#include "anatomy/implicit.hpp"
#include "turgor/core/parallel.hpp"

namespace turgor::implicit {

struct Field::Views {
  Vec3 whole, both, sharp;
  explicit Views(const Vec3& p)
      : whole(p), both{std::sqrt(p.x * p.x + 1), p.y, p.z}, sharp{std::abs(p.x), p.y, p.z} {}
  [[nodiscard]] const Vec3& of(Side side) const {
    return side == Side::whole ? whole : side == Side::both ? both : sharp;
  }
};

Field& Field::add(Operation operation, ShapePtr shape, double blend, Side side) {
  lipschitz_ = std::max(lipschitz_, shape->lipschitz());
  const Knot bound = shape->bound();
  steps_.push_back({std::move(shape), blend, operation, side, bound});
  return *this;
}
Field& Field::join(ShapePtr shape, double blend, Side side) {
  return add(Operation::join, std::move(shape), blend, side);
}
Field& Field::cut(ShapePtr shape, double blend, Side side) {
  return add(Operation::cut, std::move(shape), blend, side);
}
Field& Field::keep(ShapePtr shape, double blend, Side side) {
  return add(Operation::keep, std::move(shape), blend, side);
}

double Field::apply(const Step& step, double value, const Views& views) {
  const Vec3& p = views.of(step.side);
  // Where the shape's bound alone keeps it clear of the value it need not be evaluated; no bit changes.
  if (step.operation != Operation::keep) {
    const double clear =
        step.blend + (step.operation == Operation::join ? value : -value) + step.bound.radius;
    if (clear < 0 || squared_length(p - step.bound.point) > clear * clear) return value;
  }
  const double d = step.shape->distance(p);
  switch (step.operation) {
    case Operation::join:
      return smooth_min(value, d, step.blend);
    case Operation::cut:
      return smooth_max(value, -d, step.blend);
    case Operation::keep:
      return smooth_max(value, d, step.blend);
  }
  return value;
}

namespace {

// The smallest ball around two.
Knot around(const Knot& a, const Knot& b) {
  const double apart = distance(a.point, b.point);
  if (apart + b.radius <= a.radius) return a;
  if (apart + a.radius <= b.radius) return b;
  const double radius = 0.5 * (apart + a.radius + b.radius);
  return {a.point + (b.point - a.point) * ((radius - a.radius) / apart), radius};
}

}  // namespace

// Cuts and keeps only take away; each join adds a ball, grown by what the blend can add.
Knot Field::bound() const {
  Knot all{{0, 0, 0}, -1};
  for (const Step& step : steps_) {
    if (step.operation != Operation::join) continue;
    Knot ball = step.bound;
    if (step.side != Side::whole) {
      // Both sides: a ball in the midplane around the two.
      ball.radius += std::abs(ball.point.x) + 1;
      ball.point.x = 0;
    }
    if (!std::isfinite(ball.radius)) return ball;
    if (all.radius < 0) {
      all = ball;
      continue;
    }
    all = around(all, ball);
    all.radius += step.blend / 6;
  }
  // A tape that starts from everything has no bound; rounding is given some room.
  if (all.radius < 0 || start_ < 0) return {{0, 0, 0}, std::numeric_limits<double>::infinity()};
  all.radius += 1e-6;
  return all;
}

double Field::value(const Vec3& p) const {
  const Views views(p);
  double value = start_;
  for (const Step& step : steps_) value = apply(step, value, views);
  return value;
}

// A join (or cut) whose operand stays clear of the value by more than its blend does nothing, or does all and
// makes what went before needless.
Field Field::shortened(const Vec3& centre, double radius) const {
  const Views views(centre);
  Field out;
  out.start_ = start_;
  double value = start_, steepest = 0;
  for (const Step& step : steps_) {
    const bool joins = step.operation == Operation::join;
    const Vec3& seen = views.of(step.side);
    const double d =
        step.operation == Operation::cut ? -step.shape->distance(seen) : step.shape->distance(seen);
    const double slack = step.blend + radius * (step.shape->lipschitz() + steepest) + 1e-9;
    const double lead = joins ? value - d : d - value;  // by how much the operand wins
    if (lead < -slack) continue;
    if (lead > slack) {
      out.steps_.clear();
      out.lipschitz_ = 1;
      out.start_ = joins ? std::numeric_limits<double>::infinity() : -std::numeric_limits<double>::infinity();
    }
    const ShapePtr shape = step.shape->shortened(seen, radius);
    out.add(step.operation, shape ? shape : step.shape, step.blend, step.side);
    value = joins ? smooth_min(value, d, step.blend) : smooth_max(value, d, step.blend);
    steepest = std::max(steepest, step.shape->lipschitz());
  }
  return out;
}

namespace {
// A cell's steps hold this far around it, mm, so that its bound of the slope does too.
constexpr double cell_margin = 4;
// Cells whose surface is farther than this, mm, are not divided further.
constexpr double far_mm = 8;
}  // namespace

std::size_t IndexedField::cell(const Index3& at) const {
  return (static_cast<std::size_t>(at[2]) * static_cast<std::size_t>(cells_[1]) +
          static_cast<std::size_t>(at[1])) *
             static_cast<std::size_t>(cells_[0]) +
         static_cast<std::size_t>(at[0]);
}

struct IndexedField::Branch {
  std::vector<Field> parts;
  std::vector<std::pair<std::size_t, std::uint32_t>> part_of;  // cell, part
};

void IndexedField::split(const Index3& from, int edge, const Field& parent, Branch& branch) const {
  for (std::size_t a = 0; a < 3; ++a) {
    if (from[a] >= cells_[a]) return;
  }
  const double half = 0.5 * edge * cell_mm_, radius = half * std::sqrt(3.0) + cell_margin;
  const Vec3 centre =
      box_.lower + Vec3{from[0] * cell_mm_, from[1] * cell_mm_, from[2] * cell_mm_} + Vec3{half, half, half};
  Field part = parent.shortened(centre, radius);
  if (edge == 1 || std::abs(part.value(centre)) > part.lipschitz() * radius + far_mm) {
    for (int k = from[2]; k < std::min(from[2] + edge, cells_[2]); ++k) {
      for (int j = from[1]; j < std::min(from[1] + edge, cells_[1]); ++j) {
        for (int i = from[0]; i < std::min(from[0] + edge, cells_[0]); ++i) {
          branch.part_of.emplace_back(cell({i, j, k}), static_cast<std::uint32_t>(branch.parts.size()));
        }
      }
    }
    branch.parts.push_back(std::move(part));
    return;
  }
  const int step = edge / 2;
  for (int child = 0; child < 8; ++child) {
    split({from[0] + (child & 1) * step, from[1] + (child >> 1 & 1) * step, from[2] + (child >> 2) * step},
          step, part, branch);
  }
}

IndexedField::IndexedField(Field field, const Box3& box, double cell_mm)
    : field_(std::move(field)), box_(box), cell_mm_(cell_mm) {
  constexpr int root = 8;
  Index3 roots{};
  for (int a = 0; a < 3; ++a) {
    const auto i = static_cast<std::size_t>(a);
    roots[i] = static_cast<int>(std::ceil(box.size()[a] / (cell_mm * root)));
    cells_[i] = roots[i] * root;
  }
  std::vector<Branch> branches(static_cast<std::size_t>(roots[0]) * static_cast<std::size_t>(roots[1]) *
                               static_cast<std::size_t>(roots[2]));
  parallel_for(branches.size(), 1, [&](std::size_t begin, std::size_t end) {
    for (std::size_t r = begin; r < end; ++r) {
      const auto i = static_cast<int>(r);
      split({i % roots[0] * root, i / roots[0] % roots[1] * root, i / roots[0] / roots[1] * root}, root,
            field_, branches[r]);
    }
  });
  part_of_.resize(static_cast<std::size_t>(cells_[0]) * static_cast<std::size_t>(cells_[1]) *
                  static_cast<std::size_t>(cells_[2]));
  for (Branch& branch : branches) {
    const auto first = static_cast<std::uint32_t>(parts_.size());
    for (const auto& [cell, part] : branch.part_of) part_of_[cell] = first + part;
    std::move(branch.parts.begin(), branch.parts.end(), std::back_inserter(parts_));
  }
}

const Field& IndexedField::at(const Vec3& p) const {
  const Vec3 q = (p - box_.lower) / cell_mm_;
  if (!(q.x >= 0 && q.y >= 0 && q.z >= 0 && q.x < cells_[0] && q.y < cells_[1] && q.z < cells_[2]))
    return field_;
  return parts_[part_of_[cell({static_cast<int>(q.x), static_cast<int>(q.y), static_cast<int>(q.z)})]];
}

double IndexedField::value(const Vec3& p) const {
  return at(p).value(p);
}

double IndexedField::lipschitz(const Vec3& p, double radius) const {
  return radius <= cell_margin ? at(p).lipschitz() : field_.lipschitz();
}

Field IndexedField::shortened(const Vec3& centre, double radius) const {
  return (radius <= cell_margin ? at(centre) : field_).shortened(centre, radius);
}

}  // namespace turgor::implicit
