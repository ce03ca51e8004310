// Frames that turn with the surface about its points: Morris (2006), section 4.2. Internal to the module.
#pragma once

#include <array>
#include <span>
#include <vector>

#include "math/lanes.hpp"
#include "turgor/math/vec.hpp"

namespace turgor::detail {

/// p ↦ x F_x + y F_y + z F_z + w o, by columns; the fourth row is not used.
struct Frame {
  Lanes columns[4];

  [[nodiscard]] Vec3 column(std::size_t c) const { return {columns[c][0], columns[c][1], columns[c][2]}; }
};

/// Which of the surface's triangles and edges make the frame at each of some points.
class SurfaceFrames {
 public:
  /// Adds the point's frame, if it has one: F_x is the averaged normal of its triangles; F_y the part at
  /// right angles to it of its first edge that has one of a tenth of its length; F_z = F_x × F_y. Where the
  /// normals cancel, as where two cubes touch, the first triangle's is taken alone. `triangles` turned so
  /// that each begins with the point, as the other two corners; `positions` at rest.
  bool add(int point, std::span<const std::array<int, 2>> triangles, std::span<const Vec3> positions);

  [[nodiscard]] std::size_t size() const { return fans_.size(); }
  [[nodiscard]] int point(std::size_t i) const { return fans_[i].point; }
  /// Keeps those listed, in that order.
  [[nodiscard]] SurfaceFrames chosen(std::span<const int> which) const;

  /// Orthonormal whatever the positions, as long as they are numbers: what has no direction takes some other.
  void compute(std::span<const Vec3> positions, std::span<Frame> frames) const;

 private:
  struct Fan {
    int point = 0, opposite = 0;
    std::size_t begin = 0, end = 0;  ///< of rims_
  };
  [[nodiscard]] Vec3 normal(const Fan& fan, std::span<const Vec3> positions) const;

  std::vector<Fan> fans_;
  std::vector<std::array<int, 2>> rims_;
};

}  // namespace turgor::detail
