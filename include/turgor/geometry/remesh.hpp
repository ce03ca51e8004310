// Even triangles of a chosen size on a given surface.
#pragma once

#include <functional>

#include "turgor/core/context.hpp"
#include "turgor/geometry/tri_mesh.hpp"

namespace turgor {

/// Edge length wanted at a point, mm; must be positive.
using SizingField = std::function<double(const Vec3&)>;

/// Isotropic remeshing after Botsch and Kobbelt (2004): edges longer than 4/3 of the size are split, shorter
/// than 4/5 collapsed, flipped towards equal angles, and points relaxed along the surface and put back on it.
/// The result is manifold where the input is, lies on the input, and keeps its boundary. Deterministic.
/// Errors: cancelled.
Result<TriMesh> remesh_isotropic(const TriMesh& mesh, const SizingField& size_mm, int rounds,
                                 Context& context);

}  // namespace turgor
