// Smoothing, reduction and cutting of surfaces.
#pragma once

#include <functional>
#include <vector>

#include "turgor/core/context.hpp"
#include "turgor/geometry/tri_mesh.hpp"

namespace turgor {

/// Taubin's λ|μ smoothing (Taubin 1995, A signal processing approach to fair surface design, section 4): does
/// not shrink. Boundary points stay. Deterministic, parallel. `pass_band` in (0, 2): smaller is smoother;
/// `iterations` pairs of steps.
TriMesh smooth(TriMesh mesh, int iterations = 10, double pass_band = 0.1);

/// Laplacian smoothing of values given per point: each step moves a value by `factor` in (0, 1] towards the
/// mean of its neighbours. Points with `fixed` set keep their value (empty: none is fixed). Deterministic,
/// parallel.
std::vector<double> smooth_field(const TriMesh& mesh, std::vector<double> values,
                                 const std::vector<bool>& fixed = {}, int iterations = 10,
                                 double factor = 0.5);

/// Moves the points of triangles that are turned against their surroundings (folds that smoothing or
/// reduction left) to the middle of their neighbours until none is, at most `rounds` times. Boundary points
/// stay. Returns the number of triangles still turned.
int unfold(TriMesh& mesh, int rounds = 30);

/// Reduces to `target_triangles` by edge collapse with quadric error (meshoptimizer), reaching the number
/// asked for where topology allows (at most so many, usually within half a per cent below); keeps the surface
/// manifold, oriented and its boundary loops on their course. Points keep their places, so convex parts
/// shrink by the depth of the chords. Where thin parts fall together the sheets are parted: no edge of more
/// than two triangles, no triangle twice, and what was closed stays closed. `error` (optional) receives the
/// largest deviation estimated, mm. Unused points are dropped.
TriMesh decimate(const TriMesh& mesh, int target_triangles, double* error = nullptr);

/// The part of a surface on the positive side of `plane` (dot(n,p) > offset). Triangles are cut exactly at
/// the plane; where `cap` is set the section of a closed surface is closed with triangles in the plane (any
/// number of loops, nested to any depth; the result is closed, manifold and oriented as the surface was).
/// Points nearer than `snap_mm` to the plane are moved onto it, so no slivers arise. Triangles wholly in the
/// plane belong to no side.
TriMesh clip(const TriMesh& mesh, const Plane& plane, bool cap, double snap_mm = 1e-6);

/// Splits triangles that cross `plane` wherever `in_patch(point)` holds, and duplicates the points on the
/// plane there, so that the two sides come apart: a slit. The ends of the slit stay joined. `side_of_point`
/// receives for each point -1 / +1 on the duplicated rims (negative / positive side), else 0; `twin` for each
/// rim point its duplicate on the other rim, else -1. `snap_mm`: points of the patch nearer to the plane are
/// moved onto it, unless a triangle would turn over or lie flat in it. Points of `mesh` keep their numbers
/// (those on the plane stay with the positive rim); cut points follow, then the duplicates of the negative
/// rim. A slit may have several pieces; one that reaches the boundary of the surface is open there, one that
/// closes on itself parts the surface.
TriMesh cut_slit(const TriMesh& mesh, const Plane& plane, const std::function<bool(const Vec3&)>& in_patch,
                 double snap_mm, std::vector<int>* side_of_point = nullptr, std::vector<int>* twin = nullptr);

}  // namespace turgor
