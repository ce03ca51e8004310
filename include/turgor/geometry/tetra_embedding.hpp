// Points carried along by the tetrahedra they lie in: barycentric embedding.
#pragma once

#include <array>
#include <span>
#include <vector>

#include "turgor/core/error.hpp"
#include "turgor/math/vec.hpp"

namespace turgor {

/// Each target is written as Σ wᵢ xᵢ of the corners of the tetrahedron that holds it, or of the nearest one,
/// whose weights then are not all positive; of several the one of the lowest number. Affine motions are
/// carried over exactly. Immutable; the same bits for any number of threads.
class TetraEmbedding {
 public:
  struct Place {
    int tetrahedron = -1;
    std::array<double, 4> weights{};  ///< add up to 1
    double outside_mm = 0;            ///< distance to that tetrahedron; 0 within, weights above −1e-9
  };

  /// Tetrahedra may face either way. Flat ones, whose six volumes are less than 1e-9 of the cube of their
  /// longest edge, hold no target. Errors: no tetrahedra, or flat ones only; an index out of range;
  /// coordinates not finite or beyond 1e30 mm.
  static Result<TetraEmbedding> bind(std::span<const Vec3> points,
                                     std::span<const std::array<int, 4>> tetrahedra,
                                     std::span<const Vec3> targets);

  /// Fills `out`, one for each target, from values at the points (positions, velocities, …): both must be as
  /// long as at `bind`.
  void apply(std::span<const Vec3> values, std::span<Vec3> out) const;
  [[nodiscard]] const std::vector<Place>& places() const { return places_; }
  /// Corners of the tetrahedron of each place.
  [[nodiscard]] const std::vector<std::array<int, 4>>& corners() const { return corners_; }

 private:
  std::vector<Place> places_;
  std::vector<std::array<int, 4>> corners_;
};

}  // namespace turgor
