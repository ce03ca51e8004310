// The prisms between two layers of flesh, and the tetrahedra at their corners. Internal to the module.
//
//   d───f   each corner with its two neighbours in the layer and the one across: six over a triangle, eight
//   │╲ ╱│   over a quadrilateral. None favours a diagonal, and where all are positive no corner of the prism
//   │ e │   is turned over.
//   a─│─c
//    ╲│╱
//     b
#pragma once

#include <array>

#include "turgor/anatomy/flesh.hpp"

namespace turgor::detail {

/// The polygons that prisms stand on: triangles and convex quadrilaterals; other polygons in triangles.
Polyhedron prism_bases(const Flesh& flesh);

/// Calls visit(four sample numbers) for each corner tetrahedron of the prism over `base` above `layer`;
/// positive volume where the corner is not turned over.
template <class Visit>
void visit_corners(const Flesh& flesh, std::span<const int> base, int layer, Visit&& visit) {
  const std::size_t n = base.size();
  for (std::size_t i = 0; i < n; ++i) {
    const int before = base[(i + n - 1) % n], here = base[i], after = base[(i + 1) % n];
    visit(std::array{flesh.sample(layer, here), flesh.sample(layer, after), flesh.sample(layer, before),
                     flesh.sample(layer + 1, here)});
    visit(std::array{flesh.sample(layer + 1, here), flesh.sample(layer + 1, before),
                     flesh.sample(layer + 1, after), flesh.sample(layer, here)});
  }
}

}  // namespace turgor::detail
