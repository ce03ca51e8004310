// A fine surface carried along by a coarse one: the skin that is shown by the skin that is simulated.
#pragma once

#include <array>
#include <vector>

#include "turgor/geometry/tri_mesh.hpp"

namespace turgor {

/// Binds points to a surface of far fewer triangles and carries displacements of its points over to them.
///
/// Each point p belongs to its nearest triangle and is written as p = sum w_i x_i + h sum w_i n_i + r over
/// the coarse points x_i around that triangle and their normals n_i; r is what little is left. The weights
/// w_i are those of moving least squares of first order in the tangent plane (Lancaster and Salkauskas 1981)
/// with a smooth kernel of compact support, so that the creases of the coarse surface do not show;
/// displacements are sharpened beforehand by what this averages away (one step of residual correction). A
/// constant displacement is carried over exactly, a rigid motion and a linear field nearly. Only points
/// joined to the nearest triangle by edges take part: the two rims of a slit do not pull at each other.
///
/// Immutable; the same bits for any number of threads.
class SurfaceEmbedding {
 public:
  /// `coarse` must be valid. Points up to `reach_mm` from the surface move with it wholly, beyond `reach_mm +
  /// fade_mm` not at all, between with a smooth passage.
  SurfaceEmbedding(const TriMesh& coarse, const std::vector<Vec3>& fine_points, double reach_mm,
                   double fade_mm);

  /// Displacement of each fine point, mm, for one of each coarse point, mm (as many as the coarse surface
  /// has).
  [[nodiscard]] std::vector<Vec3> displacements(const std::vector<Vec3>& coarse_displacements) const;

  struct Binding {
    int triangle = -1;   ///< nearest triangle of the coarse surface; -1 where it is out of reach
    float u = 0, v = 0;  ///< barycentrics there: (1-u-v) p0 + u p1 + v p2
    float distance = 0;  ///< mm
    float share = 0;     ///< of the displacement: 1 within reach, 0 beyond
    float height = 0;    ///< h above: offset along the interpolated normal, mm
  };
  [[nodiscard]] const std::vector<Binding>& bindings() const { return bindings_; }

 private:
  static constexpr std::size_t most_neighbours = 16;
  /// The coarse points around a triangle, its own three first; positions about their middle for single
  /// precision.
  struct Ring {
    std::array<float, most_neighbours> x{}, y{}, z{}, used{};
    std::array<int, most_neighbours> points{};
    int count = 0;
    Vec3 middle;
    std::array<float, 3> support{};  ///< kernel radius at the three corners, mm
  };
  using Weights = std::array<float, most_neighbours>;

  void build_rings();
  void bind(const std::vector<Vec3>& fine_points, double reach_mm, double fade_mm);
  struct Place;
  [[nodiscard]] Place place_of(const Vec3& point, const Binding& binding) const;
  /// (1 - s)^3 of s = squared distance along the surface by squared support, adding up to 1.
  [[nodiscard]] Weights kernel_weights(const Place& place, const Binding& binding) const;
  /// Weights and height of a point bound to its triangle.
  void weigh(const Vec3& point, Binding& binding, Weights& weights) const;
  void weigh_coarse_points();
  [[nodiscard]] Vec3 blended(const Ring& ring, const Weights& weights, const std::vector<Vec3>& values) const;

  TriMesh coarse_;
  std::vector<Vec3> normals_;
  std::vector<Ring> rings_;
  std::vector<Binding> bindings_;
  std::vector<Weights> weights_;
  std::vector<Weights> own_weights_;  ///< of the coarse points themselves
  std::vector<Binding> own_bindings_;
};

}  // namespace turgor
