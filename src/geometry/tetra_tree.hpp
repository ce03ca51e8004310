// The nearest tetrahedron to a point: a tree of boxes over tetrahedra. Internal to the module.
#pragma once

#include <array>
#include <span>
#include <vector>

#include "turgor/math/vec.hpp"

namespace turgor::detail {

/// Tetrahedra of less than `flat` times the cube of their longest edge, six volumes each, hold nothing: they
/// are left out, as barycentric coordinates mean nothing there. Queries are const and thread-safe.
class TetraTree {
 public:
  static constexpr double flat = 1e-9;

  struct Found {
    int tetrahedron = -1;
    double squared_distance = 0;  ///< 0 within
    std::array<double, 4> weights{};
  };

  TetraTree(std::span<const Vec3> points, std::span<const std::array<int, 4>> tetrahedra);

  [[nodiscard]] bool empty() const { return cells_.empty(); }
  /// The nearest tetrahedron, of several the lowest number. `hint` is where to look first, a place in the
  /// tree's own order: 0, or what the query of a point near by left there. The answer depends on it by
  /// rounding at most.
  [[nodiscard]] Found nearest(const Vec3& point, std::size_t& hint) const;

 private:
  struct Cell {
    std::array<Vec3, 4> corners;
    std::array<Vec3, 4> gradients;   ///< of the barycentric coordinates
    std::array<double, 4> heights2;  ///< squared heights over the opposite faces
    int tetrahedron = -1;
  };
  struct Node {
    Box3 box;
    int lowest = 0;  ///< least number of a tetrahedron below
  };
  struct Best;

  void build(std::size_t node, std::span<int> order, std::span<const Box3> boxes);
  void visit(std::size_t node, std::size_t begin, std::size_t end, const Vec3& point, Best& best) const;
  void improve(std::size_t at, const Vec3& point, Best& best) const;

  std::vector<Cell> cells_;
  std::vector<Node> nodes_;  ///< children of i: 2 i + 1 and 2 i + 2, each with half of its cells
};

}  // namespace turgor::detail
