// Voxel bodies for the tests of fem.
#pragma once

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <vector>

#include "turgor/core/random.hpp"
#include "turgor/fem/mesh_elasticity.hpp"
#include "turgor/fem/voxel_elasticity.hpp"
#include "turgor/geometry/voxel_solid.hpp"

namespace turgor {

/// The cubes (i, j, k) of a box of n that are `inside`; the lowest corner of cube (0, 0, 0) is the origin.
inline SolidMesh voxel_body(const Index3& n, double spacing,
                            const std::function<bool(int, int, int)>& inside) {
  VoxelGrid grid({n[0] + 2, n[1] + 2, n[2] + 2});
  grid.spacing = spacing;
  grid.lower = Vec3{-spacing, -spacing, -spacing};
  for (int k = 0; k < n[2]; ++k)
    for (int j = 0; j < n[1]; ++j)
      for (int i = 0; i < n[0]; ++i)
        if (inside(i, j, k)) grid.set(i + 1, j + 1, k + 1);
  auto solid = solid_of(grid);
  EXPECT_TRUE(solid) << solid.error().message();
  return solid ? *std::move(solid) : SolidMesh{};
}

inline SolidMesh voxel_box(const Index3& n, double spacing) {
  return voxel_body(n, spacing, [](int, int, int) { return true; });
}

/// A block with a tunnel, a cavity, a notch and a thin arm.
inline SolidMesh irregular_body(double spacing = 0.5) {
  return voxel_body({13, 9, 11}, spacing, [](int i, int j, int k) {
    const bool tunnel = j >= 3 && j < 5 && k >= 4 && k < 7;
    const bool cavity = i >= 8 && i < 10 && j == 6 && k >= 2 && k < 4;
    const bool notch = i == 5 && k >= 6;
    const bool arm_only = i >= 11 && !(j >= 2 && j < 4 && k >= 8 && k < 10);
    return !tunnel && !cavity && !notch && !arm_only;
  });
}

inline ElementMesh hexahedra_of(const SolidMesh& solid) {
  return {std::vector<Vec3>(solid.points.begin(), solid.points.end()), hexahedra(solid), {}, {}};
}

/// Solved directly, or fails the test.
inline ElasticSolution solved(const ElementMesh& mesh, const ElasticBody& body,
                              const ElasticSupports& supports, const ElasticLoad& load,
                              const MeshElasticityOptions& options = {}) {
  Context context;
  auto solution = solve_mesh(mesh, body, supports, load, options, context);
  EXPECT_TRUE(solution) << solution.error().message();
  if (!solution) return {};
  EXPECT_TRUE(solution->converged) << (context.notices().empty() ? "" : context.notices()[0].text);
  return *std::move(solution);
}

inline std::vector<NodeSupport> supports_where(const SolidMesh& solid,
                                               const std::function<bool(const Vec3&)>& at,
                                               std::array<bool, 3> held = {true, true, true}) {
  std::vector<NodeSupport> supports;
  for (std::size_t p = 0; p < solid.points.size(); ++p)
    if (at(solid.points[p])) supports.push_back({static_cast<int>(p), held, {}});
  return supports;
}

inline std::vector<Vec3> random_displacement(std::size_t count, double size = 1) {
  const RandomStream random(7);
  std::vector<Vec3> u(count);
  for (std::size_t i = 0; i < count; ++i)
    for (int c = 0; c < 3; ++c) u[i][c] = size * (random.uniform(3 * i + static_cast<std::size_t>(c)) - 0.5);
  return u;
}

inline double norm(const std::vector<Vec3>& v) {
  double sum = 0;
  for (const Vec3& x : v) sum += squared_length(x);
  return std::sqrt(sum);
}
inline double distance(const std::vector<Vec3>& a, const std::vector<Vec3>& b) {
  double sum = 0;
  for (std::size_t i = 0; i < a.size(); ++i) sum += squared_length(a[i] - b[i]);
  return std::sqrt(sum);
}

/// Solves, or fails the test.
inline ElasticSolution solved(const SolidMesh& solid, const ElasticBody& body,
                              const std::vector<NodeSupport>& supports, const ElasticLoad& load,
                              double relative_residual = 1e-9) {
  Context context;
  VoxelElasticityOptions options;
  options.relative_residual = relative_residual;
  const auto fem = VoxelElasticity::prepare(solid, body, {supports, {}}, options, context);
  EXPECT_TRUE(fem) << fem.error().message();
  if (!fem) return {};
  auto solution = fem->solve(load, context);
  EXPECT_TRUE(solution) << solution.error().message();
  if (!solution) return {};
  EXPECT_TRUE(solution->converged);
  return *std::move(solution);
}

inline ElasticBody body_of(double youngs_modulus_mpa, double poissons_ratio, double density_g_mm3 = 0) {
  ElasticBody body;
  body.materials = {{youngs_modulus_mpa, poissons_ratio, density_g_mm3}};
  return body;
}

}  // namespace turgor
