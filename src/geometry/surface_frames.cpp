#include "geometry/surface_frames.hpp"

#include <limits>

#include "turgor/core/index.hpp"
#include "turgor/core/parallel.hpp"

namespace turgor::detail {
namespace {

/// Squared parts of a length below which a direction is rounding.
constexpr double nothing = 1e-20;
/// Squared: normals at rest that leave less than this of one of them cancel.
constexpr double cancelled = 1e-3;
/// Squared share of an edge at right angles to the normal from which it is a tangent.
constexpr double tangent = 0.01;

Vec3 doubled_area(std::span<const Vec3> positions, int point, const std::array<int, 2>& others) {
  const Vec3& p = positions[at(point)];
  return cross(positions[at(others[0])] - p, positions[at(others[1])] - p);
}

/// Whether `squared` is more than `part` of `whole`, and a number.
bool exceeds(double squared, double part, double whole) {
  return squared > part * whole && squared < std::numeric_limits<double>::infinity();
}

Lanes column_of(const Vec3& v) {
  return Lanes{v.x, v.y, v.z, 0};
}

Vec3 across(const Vec3& edge, const Vec3& normal) {
  return edge - normal * dot(edge, normal);
}

}  // namespace

bool SurfaceFrames::add(int point, std::span<const std::array<int, 2>> triangles,
                        std::span<const Vec3> positions) {
  Vec3 sum;
  double squares = 0;
  std::size_t first = triangles.size();
  for (std::size_t i = triangles.size(); i-- > 0;) {
    const Vec3 n = doubled_area(positions, point, triangles[i]);
    if (squared_length(n) > 0) first = i;
    sum += n;
    squares += squared_length(n);
  }
  if (first == triangles.size()) return false;
  const auto used =
      exceeds(squared_length(sum), cancelled, squares) ? triangles : triangles.subspan(first, 1);
  Fan fan{point, triangles[first][0], rims_.size(), rims_.size() + used.size()};
  rims_.insert(rims_.end(), used.begin(), used.end());
  const Vec3 n = normal(fan, positions);
  for (std::size_t corner = 0; corner < 2 * triangles.size(); ++corner) {
    const int other = triangles[corner / 2][corner % 2];
    const Vec3 edge = positions[at(other)] - positions[at(point)];
    if (!exceeds(squared_length(across(edge, n)), tangent, squared_length(edge))) continue;
    fan.opposite = other;
    break;
  }
  fans_.push_back(fan);
  return true;
}

SurfaceFrames SurfaceFrames::chosen(std::span<const int> which) const {
  SurfaceFrames part;
  for (const int i : which) {
    Fan fan = fans_[at(i)];
    const auto begin = rims_.begin() + static_cast<std::ptrdiff_t>(fan.begin);
    const std::size_t count = fan.end - fan.begin;
    fan.begin = part.rims_.size(), fan.end = fan.begin + count;
    part.rims_.insert(part.rims_.end(), begin, begin + static_cast<std::ptrdiff_t>(count));
    part.fans_.push_back(fan);
  }
  return part;
}

Vec3 SurfaceFrames::normal(const Fan& fan, std::span<const Vec3> positions) const {
  Vec3 sum, one;
  double squares = 0;
  for (std::size_t i = fan.begin; i < fan.end; ++i) {
    const Vec3 n = doubled_area(positions, fan.point, rims_[i]);
    const double n2 = squared_length(n);
    if (squares == 0) one = n;
    sum += n;
    squares += n2;
  }
  if (exceeds(squared_length(sum), nothing, squares)) return sum / length(sum);
  if (exceeds(squared_length(one), 0, 1)) return one / length(one);
  return {1, 0, 0};
}

void SurfaceFrames::compute(std::span<const Vec3> positions, std::span<Frame> frames) const {
  parallel_for(fans_.size(), 256, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      const Fan& fan = fans_[i];
      const Vec3 o = positions[at(fan.point)], edge = positions[at(fan.opposite)] - o;
      const Vec3 x = normal(fan, positions), part = across(edge, x);
      const Vec3 y = exceeds(squared_length(part), nothing, squared_length(edge)) ? part / length(part)
                                                                                  : any_orthogonal(x);
      const Vec3 z = cross(x, y);
      Frame& frame = frames[i];
      frame.columns[0] = column_of(x), frame.columns[1] = column_of(y), frame.columns[2] = column_of(z);
      frame.columns[3] = column_of(o);
    }
  });
}

}  // namespace turgor::detail
