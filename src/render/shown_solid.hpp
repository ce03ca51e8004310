// The surface of a solid as pictures show it: the skin that it was made of, or its own sides, creased where
// they meet at an angle. Internal to render.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "turgor/geometry/solid_mesh.hpp"
#include "turgor/geometry/tetra_embedding.hpp"
#include "turgor/geometry/tri_mesh.hpp"

namespace turgor::render_detail {

class ShownSolid {
 public:
  /// `skin`: shown in place of the solid's own sides, carried by its tetrahedra; or null.
  static Result<ShownSolid> create(const SolidMesh& solid, const TriMesh* skin);

  /// Values at the solid's points (positions, colours) at the shown points.
  [[nodiscard]] std::vector<Vec3> carried(std::span<const Vec3> values) const;
  /// The same for numbers.
  [[nodiscard]] std::vector<double> carried(std::span<const double> values) const;
  [[nodiscard]] TriMesh shape(std::span<const Vec3> positions) const {
    return {carried(positions), triangles_};
  }

 private:
  std::optional<TetraEmbedding> skin_;
  std::vector<int> source_;  ///< point of the skin or the solid that each shown point copies
  std::vector<Index3> triangles_;
};

}  // namespace turgor::render_detail
