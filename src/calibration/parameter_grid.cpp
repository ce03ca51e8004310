#include "turgor/calibration/parameter_grid.hpp"

#include <fmt/format.h>

#include <cstdint>
#include <limits>

#include "turgor/core/parallel.hpp"

namespace turgor {
namespace {

constexpr std::size_t at(int i) {
  return static_cast<std::size_t>(i);
}

// Where a point lies between two neighbouring nodes along one axis.
struct Cell {
  int node = 0;         // the lower one
  double fraction = 0;  // of the upper one
};

Cell cell_of(double place, double lower, double size, int nodes) {
  if (nodes == 1 || size <= 0) return {};
  const double t = (place - lower) / size * (nodes - 1);
  Cell cell;
  cell.node = std::clamp(static_cast<int>(t), 0, nodes - 2);
  cell.fraction = std::clamp(t - cell.node, 0.0, 1.0);
  // A node that only rounding would give a weight has no influence.
  constexpr double rounding = 1e-12;
  if (cell.fraction < rounding) cell.fraction = 0;
  if (cell.fraction > 1 - rounding) cell.fraction = 1;
  return cell;
}

Result<Box3> checked_box(const Index3& nodes, std::span<const Vec3> points) {
  std::int64_t total = 1;
  constexpr std::int64_t most = 1'000'000;
  for (const int count : nodes) {
    if (count < 1)
      return Error{ErrorKind::bad_input, fmt::format("a parameter grid of {} nodes along an axis", count), "",
                   "Give at least one along each"};
    total = std::min(total * count, most + 1);
  }
  if (total > most)
    return Error{ErrorKind::bad_input, "a parameter grid of more than a million nodes", "", "Give fewer"};
  if (points.empty()) return Error{ErrorKind::bad_input, "a parameter grid over no points"};
  if (points.size() > std::numeric_limits<int>::max() / 8)
    return Error{ErrorKind::bad_input, "a parameter grid over too many points"};
  Box3 box;
  for (const Vec3& p : points) {
    if (!is_finite(p)) return Error{ErrorKind::bad_input, "a parameter grid over points that are not finite"};
    box.extend(p);
  }
  if (!is_finite(box.size()))
    return Error{ErrorKind::bad_input, "a parameter grid over points too far apart"};
  return box;
}

// Rows over all nodes of the grid, x fastest.
ParameterWeights full_weights(const Index3& nodes, std::span<const Vec3> points, const Box3& box) {
  ParameterWeights out;
  out.column_count = nodes[0] * nodes[1] * nodes[2];
  const Vec3 size = box.size();
  for (const Vec3& p : points) {
    std::array<Cell, 3> cell;
    for (int a = 0; a < 3; ++a) cell[at(a)] = cell_of(p[a], box.lower[a], size[a], nodes[at(a)]);
    for (int corner = 0; corner < 8; ++corner) {
      double weight = 1;
      Index3 node{};
      for (int a = 0; a < 3; ++a) {
        const int upper = (corner >> a) & 1;
        weight *= upper != 0 ? cell[at(a)].fraction : 1 - cell[at(a)].fraction;
        node[at(a)] = cell[at(a)].node + upper;
      }
      if (weight == 0) continue;
      out.columns.push_back(node[0] + nodes[0] * (node[1] + nodes[1] * node[2]));
      out.weights.push_back(weight);
    }
    out.offsets.push_back(static_cast<int>(out.columns.size()));
  }
  return out;
}

// Along an axis with one node, the middle of the box.
Vec3 node_position(const Index3& place, const Index3& nodes, const Box3& box) {
  Vec3 position;
  for (int a = 0; a < 3; ++a) {
    const double part = nodes[at(a)] == 1 ? 0.5 : static_cast<double>(place[at(a)]) / (nodes[at(a)] - 1);
    position[a] = box.lower[a] + part * (box.upper[a] - box.lower[a]);
  }
  return position;
}

}  // namespace

void ParameterWeights::apply(std::span<const double> values, std::span<double> out) const {
  parallel_for(rows(), 4096, [&](std::size_t begin, std::size_t end) {
    for (std::size_t row = begin; row < end; ++row) {
      double sum = 0;
      for (std::size_t i = at(offsets[row]); i < at(offsets[row + 1]); ++i)
        sum += weights[i] * values[at(columns[i])];
      out[row] = sum;
    }
  });
}

Result<ParameterGrid> make_parameter_grid(const Index3& nodes, std::span<const Vec3> points) {
  TURGOR_TRY(const Box3 box, checked_box(nodes, points));
  ParameterGrid grid;
  grid.nodes = nodes;
  grid.weights = full_weights(nodes, points, box);

  std::vector<int> kept(at(grid.weights.column_count), -1);
  for (const int node : grid.weights.columns) kept[at(node)] = 0;
  for (int node = 0; node < grid.weights.column_count; ++node) {
    if (kept[at(node)] < 0) continue;
    kept[at(node)] = static_cast<int>(grid.places.size());
    const Index3 place{node % nodes[0], node / nodes[0] % nodes[1], node / nodes[0] / nodes[1]};
    grid.places.push_back(place);
    grid.positions.push_back(node_position(place, nodes, box));
  }
  for (int& column : grid.weights.columns) column = kept[at(column)];
  grid.weights.column_count = static_cast<int>(grid.places.size());
  return grid;
}

}  // namespace turgor
