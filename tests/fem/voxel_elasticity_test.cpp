#include "turgor/fem/voxel_elasticity.hpp"

#include <gtest/gtest.h>

#include <limits>

#include "fem/voxel_bodies.hpp"
#include "turgor/core/parallel.hpp"

namespace turgor {
namespace {

bool low_z(const Vec3& p) {
  return p.z < 1e-9;
}

/// Moduli from 1 to 1000 over a body, and two Poisson's ratios.
ElasticBody mixed_body(std::size_t cubes) {
  ElasticBody body;
  body.materials = {{1, 0.3, 1e-3}, {1, 0.45, 2e-3}};
  const RandomStream random(11);
  for (std::size_t c = 0; c < cubes; ++c) {
    body.material.push_back(static_cast<std::uint8_t>(random.uniform(2 * c) < 0.3));
    body.modulus_factor.push_back(random.uniform(2 * c + 1) < 0.3 ? 1000 : 1 + random.uniform(3 * c));
  }
  return body;
}

TEST(VoxelElasticity, OperatorIsThatOfTheAssembledElements) {
  const SolidMesh solid = irregular_body();
  const ElasticBody body = mixed_body(solid.tetrahedra.size() / 5);
  Context context;
  const auto fem = VoxelElasticity::prepare(solid, body, {supports_where(solid, low_z), {}}, {}, context);
  ASSERT_TRUE(fem) << fem.error().message();
  const auto u = random_displacement(solid.points.size());
  const auto assembled = mesh_forces(hexahedra_of(solid), body, u);
  const auto ours = fem->internal_forces(u);
  ASSERT_TRUE(assembled && ours);
  EXPECT_LT(distance(*ours, assembled->force_n), 1e-13 * norm(assembled->force_n));
}

TEST(VoxelElasticity, PatchTestIsExact) {
  const SolidMesh solid = irregular_body();
  std::vector<NodeSupport> supports;
  const auto linear = [](const Vec3& p) {
    return Vec3{0.01 * p.x - 0.02 * p.y + 0.005 * p.z + 0.1, 0.03 * p.x + 0.015 * p.y - 0.01 * p.z,
                -0.02 * p.x + 0.01 * p.y + 0.025 * p.z - 0.2};
  };
  for (std::size_t p = 0; p < solid.points.size(); ++p)
    if (solid.on_surface[p] != 0)
      supports.push_back({static_cast<int>(p), {true, true, true}, linear(solid.points[p])});
  ASSERT_LT(supports.size(), solid.points.size());
  for (const double ratio : {0.0, 0.3, 0.49}) {
    const ElasticBody body = body_of(5, ratio);
    const ElasticSolution s = solved(solid, body, supports, {}, 1e-12);
    for (std::size_t p = 0; p < solid.points.size(); ++p)
      EXPECT_LT(length(s.displacement_mm[p] - linear(solid.points[p])), 1e-11);
    Context context;
    const auto fem = VoxelElasticity::prepare(solid, body, {supports, {}}, {}, context);
    const SymmetricTensor strain{0.01, 0.015, 0.025, 0.005, 0, -0.0075};
    const SymmetricTensor expected = stress_of(strain, body.materials[0]);
    const auto stress = fem->stress(s.displacement_mm);
    ASSERT_TRUE(stress);
    for (const ElementStress& e : *stress) {
      EXPECT_NEAR(e.strain.xy, strain.xy, 1e-11);
      EXPECT_NEAR(e.strain.zx, strain.zx, 1e-11);
      EXPECT_NEAR(e.stress_mpa.xx, expected.xx, 1e-8);
      EXPECT_NEAR(e.stress_mpa.zx, expected.zx, 1e-8);
    }
  }
}

TEST(VoxelElasticity, IsWhatTheDirectSolverFinds) {
  const SolidMesh solid = irregular_body();
  ElasticLoad load;
  load.gravity_mm_ms2 = {0.002, 0, -0.00981};
  load.forces = {{static_cast<int>(solid.points.size()) - 1, {0.01, -0.02, 0.005}}};
  for (const ElasticBody& body : {body_of(0.015, 0.45, 1.04e-3), mixed_body(solid.tetrahedra.size() / 5)}) {
    // Fixed below; at one side it may slide up and down and is pulled.
    std::vector<NodeSupport> supports = supports_where(solid, low_z);
    for (NodeSupport& s :
         supports_where(solid, [](const Vec3& p) { return p.x < 1e-9; }, {true, true, false})) {
      s.displacement_mm = {-0.05, 0.01, 77};
      supports.push_back(s);
    }
    const ElasticSolution s = solved(solid, body, supports, load);
    Context context;
    const auto direct = solve_mesh(hexahedra_of(solid), body, {supports, {}}, load, {}, context);
    ASSERT_TRUE(direct) << direct.error().message();
    EXPECT_LT(distance(s.displacement_mm, direct->displacement_mm), 1e-7 * norm(direct->displacement_mm));
    EXPECT_LT(distance(s.reaction_n, direct->reaction_n), 1e-7 * norm(direct->reaction_n));
    EXPECT_NEAR(s.strain_energy_nmm, direct->strain_energy_nmm, 1e-7 * direct->strain_energy_nmm);
    EXPECT_LT(s.relative_residual, 1e-9);
    EXPECT_LT(direct->relative_residual, 1e-9);
  }
}

TEST(VoxelElasticity, SupportsCarryTheLoad) {
  const SolidMesh solid = irregular_body();
  ElasticLoad load;
  load.gravity_mm_ms2 = {0, 0, -0.00981};
  load.forces = {{100, {1e-4, 0, 0}}};
  const ElasticSolution s = solved(solid, body_of(0.015, 0.45, 1.04e-3), supports_where(solid, low_z), load);
  Vec3 total;
  for (const Vec3& r : s.reaction_n) total += r;
  const double volume = static_cast<double>(solid.tetrahedra.size() / 5) * 0.125;
  EXPECT_NEAR(total.x, -1e-4, 1e-11);
  EXPECT_NEAR(total.z, volume * 1.04e-3 * 0.00981, 1e-11);
}

// Iterations do not grow with the size, as coarse lattices know the boundary.
TEST(VoxelElasticity, IterationsDoNotDependOnTheSize) {
  for (const double ratio : {0.3, 0.45}) {
    for (const int n : {8, 13, 24, 31}) {
      const SolidMesh solid = voxel_body({n, n, n}, 1.0, [&](int i, int j, int k) {
        const Vec3 p = Vec3{i + 0.5, j + 0.5, k + 0.5} / n - Vec3{0.5, 0.5, 0.5};
        return length(p) < 0.5 && !(std::abs(p.x) < 0.15 && std::abs(p.y) < 0.15);  // a ball with a hole
      });
      const double lowest = 0.3 * n;
      ElasticLoad load;
      load.gravity_mm_ms2 = {0.00981, 0, 0};
      const ElasticSolution s =
          solved(solid, body_of(0.015, ratio, 1e-3),
                 supports_where(solid, [&](const Vec3& p) { return p.z < lowest; }), load, 1e-6);
      EXPECT_LE(s.iterations, 16) << n << " " << ratio;
    }
  }
}

TEST(VoxelElasticity, StiffnessMayJumpAThousandfold) {
  constexpr int n = 20;
  const SolidMesh solid = voxel_box({n, n, n}, 1);
  const auto cubes = hexahedra(solid);
  ElasticBody layers = body_of(1, 0.3), grains = body_of(1, 0.3);
  const RandomStream random(2);
  for (std::size_t c = 0; c < cubes.size(); ++c) {
    const Vec3& p = solid.points[static_cast<std::size_t>(cubes[c][0])];
    layers.modulus_factor.push_back(static_cast<int>(p.z) % 7 < 3 ? 1000 : 1);
    grains.modulus_factor.push_back(random.uniform(c) < 0.5 ? 1000 : 1);
  }
  ElasticLoad load;
  load.forces = {{static_cast<int>(solid.points.size()) - 1, {1, 1, -1}}};
  for (const auto& body : {layers, grains}) {
    const ElasticSolution s = solved(solid, body, supports_where(solid, low_z), load, 1e-6);
    EXPECT_LE(s.iterations, 60);
  }
}

TEST(VoxelElasticity, ThinPartsAndNarrowGapsConverge) {
  // A comb: teeth one cube thick with gaps of one cube, on a thin back.
  const SolidMesh comb = voxel_body({31, 3, 24}, 1, [](int i, int, int k) { return k < 2 || i % 2 == 0; });
  ElasticLoad load;
  load.gravity_mm_ms2 = {0.00981, 0, 0};
  const ElasticBody body = body_of(1, 0.45, 1e-3);
  const auto supports = supports_where(comb, low_z);
  const ElasticSolution s = solved(comb, body, supports, load);
  EXPECT_LE(s.iterations, 150);
  Context context;
  const auto direct = solve_mesh(hexahedra_of(comb), body, {supports, {}}, load, {}, context);
  ASSERT_TRUE(direct);
  EXPECT_LT(distance(s.displacement_mm, direct->displacement_mm), 1e-5 * norm(direct->displacement_mm));
  // A wire of one by one cubes, held at one end.
  const SolidMesh wire = voxel_box({60, 1, 1}, 1);
  const auto end = supports_where(wire, [](const Vec3& p) { return p.x < 1e-9; });
  const ElasticSolution w = solved(wire, body, end, load);
  const auto exact = solve_mesh(hexahedra_of(wire), body, {end, {}}, load, {}, context);
  ASSERT_TRUE(exact);
  EXPECT_LT(distance(w.displacement_mm, exact->displacement_mm), 1e-6 * norm(exact->displacement_mm));
}

// Bending a hundred million times softer than a cube: as far as double precision goes.
TEST(VoxelElasticity, SlenderBodiesConverge) {
  for (const Index3& n : {Index3{100, 1, 1}, Index3{400, 2, 2}}) {
    const SolidMesh beam = voxel_box(n, 1);
    ElasticLoad load;
    load.gravity_mm_ms2 = {0, 0, -0.00981};
    const auto end = supports_where(beam, [](const Vec3& p) { return p.x < 1e-9; });
    const ElasticSolution s = solved(beam, body_of(1, 0.3, 1e-3), end, load, 1e-6);
    EXPECT_LE(s.iterations, 60);
    EXPECT_LT(s.relative_residual, 1e-5);
    if (n[1] < 2) continue;
    double tip = 0;
    for (const Vec3& u : s.displacement_mm) tip = std::min(tip, u.z);
    const double t = n[1], inertia = std::pow(t, 4) / 12;  // w = q L⁴ / (8 E I)
    EXPECT_NEAR(tip / (-1e-3 * 0.00981 * t * t * std::pow(n[0], 4) / (8 * inertia)), 1, 0.03);
  }
}

TEST(VoxelElasticity, SameBitsOnAnyNumberOfThreads) {
  const SolidMesh solid = voxel_body(
      {40, 30, 35}, 1, [](int i, int j, int k) { return (i / 5 + j / 6 + k / 7) % 4 != 1 || k < 3; });
  const auto supports = supports_where(solid, low_z);
  ElasticLoad load;
  load.gravity_mm_ms2 = {0.001, 0.002, -0.00981};
  const ElasticBody body = body_of(0.015, 0.45, 1e-3);
  set_thread_count(1);
  const ElasticSolution one = solved(solid, body, supports, load, 1e-5);
  set_thread_count(2);
  const ElasticSolution two = solved(solid, body, supports, load, 1e-5);
  set_thread_count(0);
  const ElasticSolution again = solved(solid, body, supports, load, 1e-5);
  EXPECT_TRUE(one.displacement_mm == two.displacement_mm);
  EXPECT_TRUE(one.displacement_mm == again.displacement_mm);
  EXPECT_TRUE(one.reaction_n == two.reaction_n);
  EXPECT_EQ(one.strain_energy_nmm, two.strain_energy_nmm);
}

TEST(VoxelElasticity, GoesOnFromAnEarlierSolution) {
  const SolidMesh solid = voxel_box({16, 16, 16}, 1);
  std::vector<NodeSupport> supports = supports_where(solid, low_z);
  const std::size_t fixed = supports.size();
  for (NodeSupport& s : supports_where(solid, [](const Vec3& p) { return p.z > 15.9; })) {
    s.displacement_mm = {0, 0, 1};
    supports.push_back(s);
  }
  Context context;
  auto fem = VoxelElasticity::prepare(solid, body_of(1, 0.45), {supports, {}}, {}, context);
  ASSERT_TRUE(fem);
  const auto before = fem->solve({}, context);
  ASSERT_TRUE(before);
  std::vector<Vec3> displacement(supports.size());
  for (std::size_t s = fixed; s < supports.size(); ++s) displacement[s] = {0.001, 0, 1.001};
  ASSERT_TRUE(fem->set_displacements(displacement));
  const auto cold = fem->solve({}, context);
  const auto warm = fem->solve({}, context, before->displacement_mm);
  ASSERT_TRUE(cold && warm);
  EXPECT_LT(warm->iterations, cold->iterations);
  EXPECT_LT(warm->relative_residual, 1e-6);
  EXPECT_LT(distance(warm->displacement_mm, cold->displacement_mm), 1e-5 * norm(cold->displacement_mm));
  // From the answer nothing is left to do.
  EXPECT_EQ(fem->solve({}, context, cold->displacement_mm)->iterations, 0);
}

TEST(VoxelElasticity, WhatIsNotHeldIsNamed) {
  Context context;
  const ElasticBody body = body_of(1, 0.3);
  const auto error_of = [&](const SolidMesh& solid, const std::vector<NodeSupport>& supports) {
    const auto fem = VoxelElasticity::prepare(solid, body, {supports, {}}, {}, context);
    return fem ? std::string() : fem.error().message();
  };
  const SolidMesh box = voxel_box({4, 4, 4}, 1);
  EXPECT_NE(error_of(box, {}).find("the body is not held"), std::string::npos) << error_of(box, {});
  // Held in z only: it slides.
  EXPECT_NE(error_of(box, supports_where(box, low_z, {false, false, true})).find("not held"),
            std::string::npos);
  // On a line it turns about it.
  const auto line = [](const Vec3& p) { return p.z < 1e-9 && p.y < 1e-9; };
  EXPECT_NE(error_of(box, supports_where(box, line)).find("turn about"), std::string::npos);
  // Two pieces, one of them loose.
  const SolidMesh two = voxel_body({9, 3, 3}, 1, [](int i, int, int) { return i < 3 || i >= 6; });
  const std::string loose = error_of(two, supports_where(two, [](const Vec3& p) { return p.x < 1e-9; }));
  EXPECT_NE(loose.find("piece 2 of 2, of 27 elements"), std::string::npos) << loose;
  EXPECT_NE(loose.find("(7.5, 1.5, 1.5)"), std::string::npos) << loose;
  // Cubes that share an edge are hinged.
  const SolidMesh hinged = voxel_body({2, 2, 1}, 1, [](int i, int j, int) { return i == j; });
  EXPECT_NE(
      error_of(hinged, supports_where(hinged, [](const Vec3& p) { return p.x < 1e-9; })).find("turn about"),
      std::string::npos);
  // Two hinges hold: a bridge of two cubes between held ones, which meet at edges.
  const SolidMesh bridge =
      voxel_body({4, 2, 1}, 1, [](int i, int j, int) { return (j == 0) == (i == 0 || i == 3); });
  EXPECT_EQ(error_of(bridge, supports_where(bridge, [](const Vec3& p) { return p.x < 1e-9 || p.x > 3.9; })),
            "");
}

TEST(VoxelElasticity, PiecesThatHoldOneAnotherAreSolved) {
  // A block on two others, which it meets at edges only.
  const SolidMesh hinged =
      voxel_body({6, 4, 2}, 1, [](int i, int j, int) { return (i >= 2 && i < 4) == (j >= 2); });
  const auto supports = supports_where(hinged, [](const Vec3& p) { return p.y < 1e-9; });
  ElasticLoad load;
  load.gravity_mm_ms2 = {0.00981, 0, 0.001};
  const ElasticSolution s = solved(hinged, body_of(1, 0.4, 1e-3), supports, load);
  Context context;
  const auto direct =
      solve_mesh(hexahedra_of(hinged), body_of(1, 0.4, 1e-3), {supports, {}}, load, {}, context);
  ASSERT_TRUE(direct);
  EXPECT_LT(distance(s.displacement_mm, direct->displacement_mm), 1e-6 * norm(direct->displacement_mm));
}

TEST(VoxelElasticity, BadInputIsAnError) {
  Context context;
  const SolidMesh box = voxel_box({3, 3, 3}, 1);
  const auto supports = supports_where(box, low_z);
  const double nan = std::nan(""), inf = std::numeric_limits<double>::infinity();
  const auto fails = [&](const SolidMesh& solid, const ElasticBody& body,
                         const std::vector<NodeSupport>& held, VoxelElasticityOptions options = {}) {
    const auto fem = VoxelElasticity::prepare(solid, body, {held, {}}, options, context);
    return !fem && !fem.error().what.empty() && !fem.error().remedy.empty();
  };
  EXPECT_TRUE(fails(SolidMesh{}, body_of(1, 0.3), supports));
  for (const double bad : {nan, inf, 1e308, -1.0, 0.0})
    EXPECT_TRUE(fails(box, body_of(bad, 0.3), supports)) << bad;
  for (const double bad : {nan, inf, 0.5, 1.0, -1.0})
    EXPECT_TRUE(fails(box, body_of(1, bad), supports)) << bad;
  ElasticBody body = body_of(1, 0.3);
  body.modulus_factor = {1, 2};
  EXPECT_TRUE(fails(box, body, supports));
  body.modulus_factor.assign(27, 1);
  body.modulus_factor[5] = nan;
  EXPECT_TRUE(fails(box, body, supports));
  body = body_of(1, 0.3);
  body.material.assign(27, 1);
  EXPECT_TRUE(fails(box, body, supports));
  body = body_of(1, 0.3);
  EXPECT_TRUE(fails(box, body, {{64, {true, true, true}, {}}}));
  EXPECT_TRUE(fails(box, body, {{-1, {true, true, true}, {}}}));
  auto moved = supports;
  moved[3].displacement_mm.y = inf;
  EXPECT_TRUE(fails(box, body, moved));
  SolidMesh bent = voxel_box({3, 3, 3}, 1);
  bent.points[20].x += 0.1;
  EXPECT_TRUE(fails(bent, body, supports));
  bent.points[20].x = nan;
  EXPECT_TRUE(fails(bent, body, supports));
  SolidMesh torn = voxel_box({3, 3, 3}, 1);
  torn.tetrahedra[7][2] = 1 << 30;
  EXPECT_TRUE(fails(torn, body, supports));
  EXPECT_TRUE(fails(box, body, supports, {0, 500, 0, {}}));
  EXPECT_TRUE(fails(box, body, supports, {1e-6, 0, 0, {}}));

  auto fem = VoxelElasticity::prepare(box, body, {supports, {}}, {}, context);
  ASSERT_TRUE(fem);
  EXPECT_FALSE(fem->solve({{{0, {nan, 0, 0}}}, {}, {}}, context));
  EXPECT_FALSE(fem->solve({{{99, {}}}, {}, {}}, context));
  EXPECT_FALSE(fem->solve({{}, {{{0, 1, 2, 99}, {}, 1}}, {}}, context));
  EXPECT_FALSE(fem->solve({{}, {{{0, 1, 2, 3}, {}, inf}}, {}}, context));
  EXPECT_FALSE(fem->solve({{}, {}, {0, 1e308, 0}}, context));
  EXPECT_FALSE(fem->solve({}, context, std::vector<Vec3>(3)));
  EXPECT_FALSE(fem->set_displacements(std::vector<Vec3>(3)));
  EXPECT_FALSE(fem->stress(std::vector<Vec3>(3)));
  EXPECT_FALSE(fem->internal_forces(std::vector<Vec3>(64, {nan, 0, 0})));
  ElementMesh hexes = hexahedra_of(box);
  EXPECT_FALSE(mesh_forces(hexes, body, std::vector<Vec3>(3)));
  EXPECT_FALSE(mesh_load(hexes, body, {{{99, {}}}, {}, {}}));
  hexes.hexahedra[4][2] = 1 << 30;
  EXPECT_FALSE(mesh_stress(hexes, body, std::vector<Vec3>(64)));
  EXPECT_FALSE(solve_mesh(hexes, body, {supports, {}}, {}, {}, context));
  hexes = hexahedra_of(box);
  std::swap(hexes.hexahedra[4][0], hexes.hexahedra[4][1]);
  EXPECT_FALSE(solve_mesh(hexes, body, {supports, {}}, {}, {}, context));
  EXPECT_FALSE(solve_mesh({}, body, {supports, {}}, {}, {}, context));
  Context stopped({}, {}, [] { return true; });
  const auto cancelled = VoxelElasticity::prepare(box, body, {supports, {}}, {}, stopped);
  ASSERT_FALSE(cancelled);
  EXPECT_EQ(cancelled.error().kind, ErrorKind::cancelled);
  // No load, no displacement.
  const auto still = fem->solve({}, context);
  ASSERT_TRUE(still);
  EXPECT_EQ(still->iterations, 0);
  EXPECT_EQ(norm(still->displacement_mm), 0);
}

TEST(VoxelElasticity, OutOfIterationsSaysSo) {
  const SolidMesh solid = voxel_box({12, 12, 12}, 1);
  Context context;
  VoxelElasticityOptions options;
  options.max_iterations = 2;
  const auto fem = VoxelElasticity::prepare(solid, body_of(1, 0.45, 1), {supports_where(solid, low_z), {}},
                                            options, context);
  ASSERT_TRUE(fem);
  const auto s = fem->solve({{}, {}, {0, 0, -1}}, context);
  ASSERT_TRUE(s);
  EXPECT_FALSE(s->converged);
  EXPECT_EQ(s->iterations, 2);
  EXPECT_EQ(context.notices().size(), 1U);
}

}  // namespace
}  // namespace turgor
