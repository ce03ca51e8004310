// Smoothing, reduction and cutting of surfaces.
#pragma once

#include <functional>
#include <vector>

#include "turgor/core/context.hpp"
#include "turgor/geometry/tri_mesh.hpp"

namespace turgor {

/// Taubin's λ|μ smoothing (1995): does not shrink. Boundary points stay. Deterministic, parallel.
/// `pass_band` in (0, 2): smaller is smoother; `iterations` pairs of steps.
TriMesh smooth(TriMesh mesh, int iterations = 10, double pass_band = 0.1);

/// Reduces to `target_triangles` by edge collapse with quadric error (meshoptimizer), reaching the number asked for
/// where topology allows; keeps the surface manifold, oriented and its boundary loops on their course.
/// `error` (optional) receives the largest deviation estimated, mm. Unused points are dropped.
TriMesh decimate(const TriMesh& mesh, int target_triangles, double* error = nullptr);

/// The part of a surface on the positive side of `plane` (dot(n,p) > offset). Triangles are cut exactly at the
/// plane; where `cap` is set the section of a closed surface is closed with triangles in the plane.
/// Points nearer than `snap_mm` to the plane are treated as on it, so no slivers arise.
TriMesh clip(const TriMesh& mesh, const Plane& plane, bool cap, double snap_mm = 1e-6);

/// Splits triangles that cross `plane` wherever `in_patch(point)` holds, and duplicates the points on the plane
/// there, so that the two sides come apart: a slit. The ends of the slit stay joined.
/// `side_of_point` receives for each point -1 / +1 on the duplicated rims (negative / positive side), else 0;
/// `twin` for each rim point its duplicate on the other rim, else -1. `snap_mm`: points nearer to the plane are
/// moved onto it.
TriMesh cut_slit(const TriMesh& mesh, const Plane& plane, const std::function<bool(const Vec3&)>& in_patch,
                 double snap_mm, std::vector<int>* side_of_point = nullptr, std::vector<int>* twin = nullptr);

}  // namespace turgor
