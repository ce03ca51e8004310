#include "turgor/geometry/tetra_embedding.hpp"

#include <fmt/format.h>

#include <cmath>

#include "geometry/length_check.hpp"
#include "geometry/tetra_tree.hpp"
#include "turgor/core/parallel.hpp"

namespace turgor {
namespace {

Result<void> check_tetrahedra(std::size_t points, std::span<const std::array<int, 4>> tetrahedra) {
  if (tetrahedra.empty())
    return Error{ErrorKind::bad_input, "the solid has no tetrahedra", "", "Give a solid to bind to"};
  for (std::size_t t = 0; t < tetrahedra.size(); ++t) {
    for (const int p : tetrahedra[t]) {
      if (p >= 0 && static_cast<std::size_t>(p) < points) continue;
      return Error{ErrorKind::bad_input, fmt::format("tetrahedron {} names point {} of {}", t, p, points), "",
                   "Repair the solid"};
    }
  }
  return {};
}

}  // namespace

Result<TetraEmbedding> TetraEmbedding::bind(std::span<const Vec3> points,
                                            std::span<const std::array<int, 4>> tetrahedra,
                                            std::span<const Vec3> targets) {
  TURGOR_CHECK(check_tetrahedra(points.size(), tetrahedra));
  TURGOR_CHECK(detail::check_lengths(points, "point"));
  TURGOR_CHECK(detail::check_lengths(targets, "target"));
  const detail::TetraTree tree(points, tetrahedra);
  if (tree.empty())
    return Error{ErrorKind::bad_input, "every tetrahedron of the solid is flat", "", "Repair the solid"};
  TetraEmbedding embedding;
  embedding.places_.resize(targets.size());
  embedding.corners_.resize(targets.size());
  parallel_for(targets.size(), 512, [&](std::size_t begin, std::size_t end) {
    std::size_t hint = 0;
    for (std::size_t i = begin; i < end; ++i) {
      const auto found = tree.nearest(targets[i], hint);
      embedding.places_[i] = {found.tetrahedron, found.weights, std::sqrt(found.squared_distance)};
      embedding.corners_[i] = tetrahedra[static_cast<std::size_t>(found.tetrahedron)];
    }
  });
  return embedding;
}

void TetraEmbedding::apply(std::span<const Vec3> values, std::span<Vec3> out) const {
  parallel_for(places_.size(), 4096, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      const auto& w = places_[i].weights;
      const auto& c = corners_[i];
      Vec3 sum;
      for (std::size_t k = 0; k < 4; ++k) sum += values[static_cast<std::size_t>(c[k])] * w[k];
      out[i] = sum;
    }
  });
}

}  // namespace turgor
