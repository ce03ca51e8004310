// A fine surface that follows a solid by frames at the solid's surface points: Morris (2006), section 4.2.
#pragma once

#include <memory>
#include <span>

#include "turgor/core/error.hpp"
#include "turgor/geometry/solid_mesh.hpp"
#include "turgor/geometry/tri_mesh.hpp"

namespace turgor {

/// Each point of the skin is p = Σ wᵢ (vᵢ + Rᵢ oᵢ): the nearest surface points vᵢ of the solid, weighted by
/// inverse squared distance at rest, each with a frame Rᵢ of its averaged normal and its first edge, in which
/// the offset oᵢ stays. Rest and rigid motions come out to double precision; what is bound is otherwise held
/// in single precision, which costs 1e-7 of how far the frames disagree. Immutable, cheap to copy; the same
/// bits for any number of threads.
class SolidSkin {
 public:
  static constexpr int kNeighbours = 5;  ///< as in the paper
  static constexpr int kMostNeighbours = 64;

  /// `neighbours`: nearest surface points of the solid to each point of the skin, of equally far ones the
  /// lower number, 1 to kMostNeighbours; fewer where the solid has fewer. A point of the skin that lies on
  /// one of them takes it alone. Errors: an invalid skin; a solid without surface; other numbers of
  /// neighbours; coordinates not finite or beyond 1e30 mm.
  static Result<SolidSkin> bind(const SolidMesh& solid, const TriMesh& skin, int neighbours = kNeighbours);

  /// Where the skin's points lie, mm, and its unit normals there, for the solid's positions, one a point of
  /// the solid. `normals` may be empty: then none are made. They are those at rest, angle-weighted, turned by
  /// the frames with the same weights: on the bunny nearer to the truth than the normals of the moved
  /// triangles (docs/models.md, "Skins of solids"). Where they cancel, the normal of the nearest frame.
  void apply(std::span<const Vec3> solid_positions, std::span<Vec3> positions, std::span<Vec3> normals) const;
  [[nodiscard]] std::size_t point_count() const;

 private:
  struct Bound;
  explicit SolidSkin(std::shared_ptr<const Bound> bound);
  std::shared_ptr<const Bound> bound_;
};

/// How far two ways to carry the same surface differ.
struct SkinDifference {
  double mean_mm = 0, root_mean_square_mm = 0, greatest_mm = 0;
  int greatest_at = 0;               ///< point, the first of several
  double mean_normal_angle_deg = 0;  ///< over the points where both have a normal
};
/// Errors: other numbers of points; none; an invalid surface.
Result<SkinDifference> difference(const TriMesh& a, const TriMesh& b);

}  // namespace turgor
