#include "geometry/tetra_tree.hpp"

#include <algorithm>
#include <bit>
#include <limits>

#include "geometry/median_split.hpp"
#include "geometry/triangle_math.hpp"
#include "turgor/core/index.hpp"
#include "turgor/core/parallel.hpp"

namespace turgor::detail {
namespace {

constexpr std::size_t leaf_size = 4;
/// Barycentric coordinates above −inside count as within, so that no point falls between two tetrahedra.
constexpr double inside = 1e-9;
/// Parts of the tree are passed by only where they lie farther by more than rounding.
constexpr double slack = 1 - 1e-12;
/// The corners of the face opposite to each corner.
constexpr std::array<std::array<std::size_t, 3>, 4> faces{{{1, 2, 3}, {0, 2, 3}, {0, 1, 3}, {0, 1, 2}}};

double squared_distance(const Box3& box, const Vec3& p) {
  double sum = 0;
  for (int i = 0; i < 3; ++i) {
    const double off = std::max({box.lower[i] - p[i], p[i] - box.upper[i], 0.0});
    sum += off * off;
  }
  return sum;
}

/// The box of all that counts as within.
Box3 box_within(const std::array<Vec3, 4>& corners) {
  Box3 box;
  for (const Vec3& p : corners) box.extend(p);
  const Vec3 size = box.size();
  const double margin = 4 * inside * std::max({size.x, size.y, size.z});
  box.lower -= {margin, margin, margin}, box.upper += {margin, margin, margin};
  return box;
}

bool is_flat(const std::array<Vec3, 4>& corners) {
  const auto& [a, b, c, d] = corners;
  const double edge2 = std::max({squared_length(b - a), squared_length(c - a), squared_length(d - a),
                                 squared_length(c - b), squared_length(d - c), squared_length(b - d)});
  return !(std::abs(dot(b - a, cross(c - a, d - a))) > TetraTree::flat * edge2 * std::sqrt(edge2));
}

std::array<Vec3, 4> barycentric_gradients(const std::array<Vec3, 4>& corners) {
  const Vec3 ab = corners[1] - corners[0], ac = corners[2] - corners[0], ad = corners[3] - corners[0];
  const Vec3 b = cross(ac, ad), c = cross(ad, ab), d = cross(ab, ac);
  const double six_volumes = dot(ab, b);
  return {-(b + c + d) / six_volumes, b / six_volumes, c / six_volumes, d / six_volumes};
}

}  // namespace

struct TetraTree::Best {
  double squared_distance = std::numeric_limits<double>::infinity();
  int tetrahedron = std::numeric_limits<int>::max();
  std::size_t cell = 0;
  std::array<double, 4> weights{};

  /// Whether something no nearer than this, of no lower number, may be better.
  [[nodiscard]] bool yields_to(double squared, int number) const {
    return squared < squared_distance || (squared == squared_distance && number < tetrahedron);
  }
};

TetraTree::TetraTree(std::span<const Vec3> points, std::span<const std::array<int, 4>> tetrahedra) {
  const auto corners_of = [&](int t) {
    std::array<Vec3, 4> corners;
    for (std::size_t k = 0; k < 4; ++k) corners[k] = points[at(tetrahedra[at(t)][k])];
    return corners;
  };
  std::vector<int> order;
  std::vector<Box3> boxes(tetrahedra.size());
  for (std::size_t t = 0; t < tetrahedra.size(); ++t) {
    const auto corners = corners_of(static_cast<int>(t));
    if (is_flat(corners)) continue;
    boxes[t] = box_within(corners);
    order.push_back(static_cast<int>(t));
  }
  if (order.empty()) return;
  nodes_.resize(2 * std::bit_ceil((order.size() + leaf_size - 1) / leaf_size) - 1);
  build(0, order, boxes);
  cells_.resize(order.size());
  parallel_for(cells_.size(), 2048, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      Cell& cell = cells_[i];
      cell.tetrahedron = order[i];
      cell.corners = corners_of(order[i]);
      cell.gradients = barycentric_gradients(cell.corners);
      for (std::size_t k = 0; k < 4; ++k) cell.heights2[k] = 1 / squared_length(cell.gradients[k]);
    }
  });
}

void TetraTree::build(std::size_t node, std::span<int> order, std::span<const Box3> boxes) {
  Node& here = nodes_[node];
  here.lowest = *std::min_element(order.begin(), order.end());
  for (const int t : order) here.box.extend(boxes[at(t)].lower), here.box.extend(boxes[at(t)].upper);
  if (2 * node + 1 >= nodes_.size()) return;
  const int axis = widest_axis(here.box.size());
  const auto key = [&](int t) { return std::pair(boxes[at(t)].lower[axis] + boxes[at(t)].upper[axis], t); };
  const auto middle = order.begin() + static_cast<std::ptrdiff_t>(order.size() / 2);
  std::nth_element(order.begin(), middle, order.end(), [&](int a, int b) { return key(a) < key(b); });
  build(2 * node + 1, {order.begin(), middle}, boxes);
  build(2 * node + 2, {middle, order.end()}, boxes);
}

void TetraTree::improve(std::size_t at, const Vec3& point, Best& best) const {
  const Cell& cell = cells_[at];
  std::array<double, 4> w{1, 0, 0, 0};
  for (std::size_t k = 1; k < 4; ++k) {
    w[k] = dot(cell.gradients[k], point - cell.corners[0]);
    w[0] -= w[k];
  }
  // The nearest point lies on a face that is seen from outside, no nearer than the plane of any such face.
  double plane2 = 0, nearest2 = std::numeric_limits<double>::infinity();
  for (std::size_t k = 0; k < 4; ++k) {
    if (w[k] < -inside) plane2 = std::max(plane2, w[k] * w[k] * cell.heights2[k]);
  }
  if (!best.yields_to(plane2 * slack, cell.tetrahedron)) return;
  if (plane2 == 0) nearest2 = 0;
  for (std::size_t k = 0; plane2 > 0 && k < 4; ++k) {
    if (w[k] >= 0) continue;
    const auto& [a, b, c] = faces[k];
    const auto close = closest_on_triangle(point, cell.corners[a], cell.corners[b], cell.corners[c]);
    nearest2 = std::min(nearest2, close.squared_distance);
  }
  if (best.yields_to(nearest2, cell.tetrahedron)) best = {nearest2, cell.tetrahedron, at, w};
}

void TetraTree::visit(std::size_t node, std::size_t begin, std::size_t end, const Vec3& point,
                      Best& best) const {
  const std::size_t left = 2 * node + 1;
  if (left >= nodes_.size()) {
    for (std::size_t i = begin; i < end; ++i) improve(i, point, best);
    return;
  }
  const std::size_t middle = begin + (end - begin) / 2;
  const auto look = [&](std::size_t child, double squared) {
    if (!best.yields_to(squared * slack, nodes_[child].lowest)) return;
    visit(child, child == left ? begin : middle, child == left ? middle : end, point, best);
  };
  const double near_left = squared_distance(nodes_[left].box, point);
  const double near_right = squared_distance(nodes_[left + 1].box, point);
  if (near_left <= near_right) {
    look(left, near_left), look(left + 1, near_right);
  } else {
    look(left + 1, near_right), look(left, near_left);
  }
}

TetraTree::Found TetraTree::nearest(const Vec3& point, std::size_t& hint) const {
  Best best;
  improve(hint, point, best);
  visit(0, 0, cells_.size(), point, best);
  hint = best.cell;
  return {best.tetrahedron, best.squared_distance, best.weights};
}

}  // namespace turgor::detail
