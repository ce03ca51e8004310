// Large strains of the voxel solver.
#include <gtest/gtest.h>

#include "fem/voxel_bodies.hpp"
#include "fem/voxel_laws.hpp"
#include "turgor/core/parallel.hpp"
#include "turgor/fem/mesh_elasticity.hpp"

namespace turgor {
namespace {

bool low_z(const Vec3& p) {
  return p.z < 1e-9;
}

ElasticBody body_with(ElasticLaw law, double ratio = 0.45, double youngs_modulus_mpa = 0.0145) {
  ElasticBody body;
  body.materials[0] = {youngs_modulus_mpa, ratio, 1e-3, law, 0};
  if (law == ElasticLaw::mooney_rivlin) body.materials[0].c20_mpa = 0.1 * youngs_modulus_mpa;
  return body;
}

/// All laws side by side, in blocks of eight cubes too.
ElasticBody all_laws(std::size_t cubes) {
  ElasticBody body;
  body.materials.clear();
  for (const ElasticLaw law : kElasticLaws) body.materials.push_back(body_with(law, 0.4, 1).materials[0]);
  const RandomStream random(5);
  for (std::size_t c = 0; c < cubes; ++c) {
    body.material.push_back(static_cast<std::uint8_t>(5 * random.uniform(2 * c)));
    body.modulus_factor.push_back(0.5 + random.uniform(2 * c + 1));
  }
  return body;
}

Result<VoxelElasticity> prepared(const SolidMesh& solid, const ElasticBody& body,
                                 const ElasticSupports& supports, double relative_residual = 1e-8) {
  Context context;
  VoxelElasticityOptions options;
  options.relative_residual = relative_residual;
  auto fem = VoxelElasticity::prepare(solid, body, supports, options, context);
  EXPECT_TRUE(fem) << fem.error().message();
  return fem;
}

ElasticSolution solved_large(const SolidMesh& solid, const ElasticBody& body, const ElasticSupports& supports,
                             const ElasticLoad& load, double relative_residual = 1e-8) {
  Context context;
  const auto fem = prepared(solid, body, supports, relative_residual);
  if (!fem) return {};
  auto s = fem->solve(load, context);
  EXPECT_TRUE(s) << s.error().message();
  if (!s) return {};
  EXPECT_TRUE(s->converged) << s->relative_residual << " " << s->newton_steps << " " << s->iterations;
  return *std::move(s);
}

// The second derivatives of the cubes' energy under a displacement, and curvatures along directions.
class Curvature {
 public:
  Curvature(const SolidMesh& solid, const ElasticBody& body, const std::vector<Vec3>& u)
      : numbering_(*detail::VoxelNumbering::of(solid)), laws_(numbering_, body, solid.spacing) {
    std::vector<double> values(numbering_.rows.values(), 0);
    numbering_.scatter(u, values);
    matrices_.resize(laws_.matrices_size());
    laws_.linearise(values.data(), matrices_);
  }
  std::size_t convexify() { return laws_.convexify(matrices_); }
  [[nodiscard]] double along(const std::vector<Vec3>& direction) const {
    std::vector<double> in(numbering_.rows.values(), 0), out(in.size());
    numbering_.scatter(direction, in);
    laws_.apply(matrices_, in.data(), out.data(), [](std::size_t, std::size_t, std::size_t) {});
    double sum = 0;
    for (std::size_t i = 0; i < in.size(); ++i) sum += in[i] * out[i];
    return sum;
  }

 private:
  detail::VoxelNumbering numbering_;
  detail::VoxelLaws laws_;
  detail::VoxelLaws::Matrices matrices_;
};

TEST(VoxelLargeStrain, CubesThatBendDownwardsAreMadeConvex) {
  // Pressed to half its height without a way to the sides: shear then pays.
  const SolidMesh solid = voxel_box({4, 3, 2}, 0.5);
  const ElasticBody body = body_with(ElasticLaw::neo_hookean, 0.49, 1);
  std::vector<Vec3> pressed(solid.points.size()), turned(pressed);
  for (std::size_t p = 0; p < pressed.size(); ++p) {
    const Vec3& x = solid.points[p];
    pressed[p] = Vec3{0, 0, -0.5 * x.z};
    turned[p] = cross(Vec3{0, 1, 0}, x + pressed[p]);
  }
  Curvature curvature(solid, body, pressed);
  ASSERT_LT(curvature.along(turned), 0);
  EXPECT_EQ(curvature.convexify(), 24U);
  EXPECT_GT(curvature.along(turned), 0);
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    std::vector<Vec3> direction(pressed.size());
    const RandomStream random(seed);
    for (std::size_t p = 0; p < direction.size(); ++p)
      for (std::size_t a = 0; a < 3; ++a) direction[p][static_cast<int>(a)] = random.uniform(3 * p + a) - 0.5;
    EXPECT_GT(curvature.along(direction), 0) << seed;
  }
}

TEST(VoxelLargeStrain, ConvexCubesStayAsTheyAre) {
  const SolidMesh solid = voxel_box({5, 4, 3}, 0.5);
  for (const ElasticLaw law : kElasticLaws) {
    std::vector<Vec3> stretched(solid.points.size());
    for (std::size_t p = 0; p < stretched.size(); ++p) stretched[p] = solid.points[p] * 0.1;
    Curvature curvature(solid, body_with(law), stretched);
    const double before = curvature.along(stretched);
    EXPECT_EQ(curvature.convexify(), 0U) << name_of(law);
    EXPECT_EQ(curvature.along(stretched), before) << name_of(law);
  }
}

TEST(VoxelLargeStrain, ForcesAreThoseOfTheMesh) {
  const SolidMesh solid = irregular_body();
  const auto u = random_displacement(solid.points.size(), 0.15);
  const auto mesh = hexahedra_of(solid);
  std::vector<ElasticBody> bodies{all_laws(mesh.hexahedra.size())};
  for (const ElasticLaw law : kElasticLaws) bodies.push_back(body_with(law));
  for (const ElasticBody& body : bodies) {
    const auto fem = prepared(solid, body, {supports_where(solid, low_z), {}});
    ASSERT_TRUE(fem);
    const auto ours = fem->internal_forces(u);
    const auto theirs = mesh_forces(mesh, body, u);
    ASSERT_TRUE(ours && theirs);
    EXPECT_LT(distance(*ours, theirs->force_n), 1e-12 * norm(theirs->force_n));
  }
}

TEST(VoxelLargeStrain, IsWhatTheDirectSolverFinds) {
  const SolidMesh solid = voxel_body({6, 5, 7}, 0.5, [](int i, int j, int k) {
    return !(i == 2 && j == 2) && !(k == 3 && j > 3) && !(i > 4 && k < 2);
  });
  ElasticLoad load;
  load.gravity_mm_ms2 = {0.02, 0, -0.03};
  for (const ElasticLaw law : kElasticLaws) {
    for (const double ratio : {0.3, 0.49}) {
      const ElasticBody body = body_with(law, ratio);
      ElasticSupports supports{supports_where(solid, low_z), {}};
      for (NodeSupport s : supports_where(solid, [](const Vec3& p) { return p.z > 3.4; })) {
        s.displacement_mm = {0.6, 0.2, -0.7};
        supports.nodes.push_back(s);
      }
      const Vec3 n = normalized(Vec3{1, 0, 0.3});
      for (const auto& s :
           supports_where(solid, [](const Vec3& p) { return p.x < 1e-9 && p.z > 0.4 && p.z < 2.6; }))
        supports.contacts.push_back(
            {s.node, n, dot(n, solid.points[static_cast<std::size_t>(s.node)]) + 0.2, 5, 0});
      const ElasticSolution s = solved_large(solid, body, supports, load);
      Context context;
      const auto direct = solve_mesh(hexahedra_of(solid), body, supports, load, {}, context);
      ASSERT_TRUE(direct) << direct.error().message();
      EXPECT_TRUE(direct->converged);
      EXPECT_LT(distance(s.displacement_mm, direct->displacement_mm), 1e-5 * norm(direct->displacement_mm));
      EXPECT_LT(distance(s.reaction_n, direct->reaction_n), 1e-5 * norm(direct->reaction_n));
      EXPECT_NEAR(s.strain_energy_nmm, direct->strain_energy_nmm, 1e-6 * direct->strain_energy_nmm);
      std::printf("    %s, nu %g: %d steps, %d iterations; directly %d steps; apart %.2g\n",
                  std::string(name_of(law)).c_str(), ratio, s.newton_steps, s.iterations,
                  direct->newton_steps,
                  distance(s.displacement_mm, direct->displacement_mm) / norm(direct->displacement_mm));
    }
  }
}

// Without stress under any rotation of its supports; the linear law alone is not.
TEST(VoxelLargeStrain, TurnedByARightAngleThereIsNoStress) {
  const SolidMesh solid = voxel_box({8, 5, 5}, 0.5);
  const RigidTransform turn =
      RigidTransform::rotate_about({1, 1, 1}, normalized(Vec3{1, 2, -1}), radians(90));
  for (const ElasticLaw law : kElasticLaws) {
    if (law == ElasticLaw::linear) continue;
    ElasticSupports supports{supports_where(solid, [](const Vec3& p) { return p.x < 0.3 || p.x > 3.8; }), {}};
    for (NodeSupport& s : supports.nodes) {
      const Vec3& x = solid.points[static_cast<std::size_t>(s.node)];
      s.displacement_mm = turn.point(x) - x;
    }
    Context context;
    VoxelElasticityOptions options;
    options.newton.load_steps = 4;
    const auto fem = VoxelElasticity::prepare(solid, body_with(law), supports, options, context);
    ASSERT_TRUE(fem);
    // On the way from rest the supports come nearer to one another, under which St. Venant's law buckles.
    std::vector<Vec3> start;
    const auto astray = random_displacement(solid.points.size(), 0.05);
    for (std::size_t p = 0; p < astray.size() && law == ElasticLaw::st_venant_kirchhoff; ++p)
      start.push_back(turn.point(solid.points[p]) - solid.points[p] + astray[p]);
    const auto s = fem->solve({}, context, start);
    ASSERT_TRUE(s);
    double farthest = 0;
    for (std::size_t p = 0; p < solid.points.size(); ++p)
      farthest =
          std::max(farthest, length(solid.points[p] + s->displacement_mm[p] - turn.point(solid.points[p])));
    std::printf("    %s: %d steps, %d iterations, converged %d, %.2g mm away\n",
                std::string(name_of(law)).c_str(), s->newton_steps, s->iterations, s->converged, farthest);
    EXPECT_TRUE(s->converged);
    EXPECT_LT(farthest, 1e-4);
    EXPECT_LT(s->strain_energy_nmm, 1e-8);
  }
}

// The gradient by differences of the energy, and the stiffness by differences of the gradient.
TEST(VoxelLargeStrain, ForcesAndStiffnessAreDerivatives) {
  const SolidMesh solid =
      voxel_body({9, 4, 3}, 0.5, [](int i, int j, int k) { return i != 2 || j != 1 || k != 1; });
  const auto numbering = detail::VoxelNumbering::of(solid);
  ASSERT_TRUE(numbering);
  const std::size_t n = numbering->rows.values();
  std::vector<double> u(n, 0), direction(n, 0), low(n), high(n), force(n), image(n);
  numbering->scatter(random_displacement(solid.points.size(), 0.15), u);
  auto d = random_displacement(2 * solid.points.size(), 1);
  d.erase(d.begin(), d.begin() + static_cast<std::ptrdiff_t>(solid.points.size()));
  numbering->scatter(d, direction);
  std::vector<ElasticBody> bodies{all_laws(numbering->cubes.size())};
  for (const ElasticLaw law : kElasticLaws) bodies.push_back(body_with(law));
  for (const ElasticBody& body : bodies) {
    const detail::VoxelLaws laws(*numbering, body, solid.spacing);
    const double h = 1e-4;
    const auto at = [&](double t, std::vector<double>& out) {
      std::vector<double> moved = u;
      for (std::size_t i = 0; i < n; ++i) moved[i] += t * direction[i];
      return laws.forces(moved.data(), out.data()).strain;
    };
    const double e1 = at(-h, low), e2 = at(h, high), f1 = at(-2 * h, force), f2 = at(2 * h, force);
    const auto here = laws.forces(u.data(), force.data());
    EXPECT_EQ(here.inverted, 0U);
    double slope = 0;
    for (std::size_t i = 0; i < n; ++i) slope += force[i] * direction[i];
    EXPECT_NEAR((8 * (e2 - e1) - (f2 - f1)) / (12 * h), slope, 1e-8 * std::abs(slope));
    detail::VoxelLaws::Matrices matrices(laws.matrices_size());
    laws.linearise(u.data(), matrices);
    laws.apply(matrices, direction.data(), image.data(), [](std::size_t, std::size_t, std::size_t) {});
    double error = 0, whole = 0;
    for (std::size_t i = 0; i < n; ++i) {
      const double difference = (high[i] - low[i]) / (2 * h);
      error += std::pow(image[i] - difference, 2), whole += difference * difference;
    }
    EXPECT_LT(std::sqrt(error / whole), 1e-5);  // of single precision and of the differences
  }
}

// A block stretched between sliding faces: λ along, s across with s = s(λ) from no stress across.
TEST(VoxelLargeStrain, StretchedNeoHookeanBlockIsTheClosedForm) {
  const SolidMesh solid = voxel_box({8, 4, 4}, 0.5);
  const ElasticBody body = body_with(ElasticLaw::neo_hookean, 0.45, 0.1);
  const double mu = body.materials[0].shear_modulus(), bulk = body.materials[0].bulk_modulus();
  for (const double stretch : {0.6, 1.5, 2.0}) {
    // P across = μ J^(−2/3) (s − I/(3 s)) + K (J − 1) λ s = 0, I = λ² + 2 s², J = λ s².
    const auto across = [&](double s) {
      const double j = stretch * s * s, i = stretch * stretch + 2 * s * s;
      return mu * std::pow(j, -2.0 / 3) * (s - i / (3 * s)) + bulk * (j - 1) * stretch * s;
    };
    double low = 0.1, high = 3;
    for (int step = 0; step < 100; ++step) (across((low + high) / 2) < 0 ? low : high) = (low + high) / 2;
    const double s = low, j = stretch * s * s, i = stretch * stretch + 2 * s * s;
    const double force =
        4 * (mu * std::pow(j, -2.0 / 3) * (stretch - i / (3 * stretch)) + bulk * (j - 1) * s * s);
    ElasticSupports supports;
    for (std::size_t p = 0; p < solid.points.size(); ++p) {
      const Vec3& x = solid.points[p];
      const bool far = x.x > 3.9;
      supports.nodes.push_back({static_cast<int>(p),
                                {x.x < 1e-9 || far, x.y < 1e-9, x.z < 1e-9},
                                {far ? 4 * (stretch - 1) : 0, 0, 0}});
    }
    std::erase_if(supports.nodes,
                  [](const NodeSupport& n) { return !n.held[0] && !n.held[1] && !n.held[2]; });
    const ElasticSolution solution = solved_large(solid, body, supports, {});
    double pull = 0;
    for (std::size_t p = 0; p < solid.points.size(); ++p) {
      const Vec3& x = solid.points[p];
      if (x.x > 3.9) pull += solution.reaction_n[p].x;
      EXPECT_LT(length(solution.displacement_mm[p] - Vec3{(stretch - 1) * x.x, (s - 1) * x.y, (s - 1) * x.z}),
                1e-6);
    }
    EXPECT_NEAR(pull / force, 1, 1e-6);
    Context context;
    const auto fem = prepared(solid, body, supports);
    const auto stress = fem->stress(solution.displacement_mm);
    ASSERT_TRUE(stress);
    for (const ElementStress& e : *stress) {
      EXPECT_NEAR(e.stress_mpa.xx, force / (4 * s * s), 1e-6 * std::abs(force));
      EXPECT_NEAR(e.stress_mpa.yy, 0, 1e-6 * std::abs(force));
      EXPECT_NEAR(e.strain.xx, std::log(stretch), 1e-6);
    }
  }
}

struct Pulled {
  SolidMesh solid = voxel_box({12, 12, 6}, 1);
  ElasticSupports supports;
  explicit Pulled(double far) {
    for (std::size_t p = 0; p < solid.points.size(); ++p) {
      const Vec3& x = solid.points[p];
      if (x.z > 1e-9) continue;
      const bool moves = length(x - Vec3{6, 6, 0}) < 2.5;
      if (moves || length(x - Vec3{6, 6, 0}) > 4.9)
        supports.nodes.push_back(
            {static_cast<int>(p), {true, true, true}, moves ? Vec3{0, 0.6, -0.8} * far : Vec3{}});
    }
  }
  [[nodiscard]] std::vector<Vec3> displacements() const {
    std::vector<Vec3> d;
    for (const NodeSupport& s : supports.nodes) d.push_back(s.displacement_mm);
    return d;
  }
};

TEST(VoxelLargeStrain, NearlyIncompressibleAndOnFromTheLastSolution) {
  const Pulled first(1.5), next(1.6);
  const ElasticBody body = body_with(ElasticLaw::mooney_rivlin, 0.499);
  auto fem = prepared(first.solid, body, first.supports, 1e-6);
  ASSERT_TRUE(fem);
  Context context;
  const auto s = fem->solve({}, context);
  ASSERT_TRUE(s);
  EXPECT_TRUE(s->converged);
  EXPECT_LT(s->relative_residual, 1e-6);
  ASSERT_TRUE(fem->set_displacements(next.displacements()));
  const auto after = fem->solve({}, context, s->displacement_mm);
  const auto cold = fem->solve({}, context);
  ASSERT_TRUE(after && cold);
  EXPECT_TRUE(after->converged && cold->converged);
  EXPECT_LT(distance(after->displacement_mm, cold->displacement_mm), 1e-4 * norm(cold->displacement_mm));
  EXPECT_LT(after->iterations, cold->iterations);
  std::printf("    %d steps, %d iterations; on %d, %d; anew %d, %d\n", s->newton_steps, s->iterations,
              after->newton_steps, after->iterations, cold->newton_steps, cold->iterations);
}

TEST(VoxelLargeStrain, SameBitsOnAnyNumberOfThreads) {
  const Pulled c(1.5);
  const ElasticBody body = body_with(ElasticLaw::mooney_rivlin);
  set_thread_count(1);
  const ElasticSolution one = solved_large(c.solid, body, c.supports, {}, 1e-5);
  set_thread_count(2);
  const ElasticSolution two = solved_large(c.solid, body, c.supports, {}, 1e-5);
  set_thread_count(0);
  EXPECT_TRUE(one.displacement_mm == two.displacement_mm);
  EXPECT_TRUE(one.reaction_n == two.reaction_n);
}

TEST(VoxelLargeStrain, WhatCannotBeSolvedIsSaid) {
  // Supports that pass through one another.
  const SolidMesh solid = voxel_box({4, 4, 6}, 1);
  ElasticSupports supports{supports_where(solid, low_z), {}};
  for (NodeSupport s : supports_where(solid, [](const Vec3& p) { return p.z > 5.9; })) {
    s.displacement_mm = {0, 0, -9};
    supports.nodes.push_back(s);
  }
  const auto fem = prepared(solid, body_with(ElasticLaw::neo_hookean), supports);
  ASSERT_TRUE(fem);
  Context context;
  const auto s = fem->solve({}, context);
  ASSERT_TRUE(s);
  EXPECT_FALSE(s->converged);
  EXPECT_EQ(context.notices().size(), 1U);
  for (const Vec3& u : s->displacement_mm) EXPECT_TRUE(is_finite(u));
  Context stopped({}, {}, [] { return true; });
  const auto cancelled = fem->solve({}, stopped);
  ASSERT_FALSE(cancelled);
  EXPECT_EQ(cancelled.error().kind, ErrorKind::cancelled);
  std::vector<Vec3> over(solid.points.size());
  for (std::size_t p = 0; p < over.size(); ++p) over[p].z = -2 * solid.points[p].z;
  EXPECT_FALSE(fem->internal_forces(over));
  EXPECT_FALSE(fem->stress(over));
}

}  // namespace
}  // namespace turgor
