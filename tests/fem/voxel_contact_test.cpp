// Contacts of the voxel solver, under Hooke's law.
#include <gtest/gtest.h>

#include <Eigen/Dense>

#include "fem/voxel_bodies.hpp"
#include "turgor/core/parallel.hpp"
#include "turgor/fem/mesh_elasticity.hpp"

namespace turgor {
namespace {

ElasticSolution solved_with(const SolidMesh& solid, const ElasticBody& body, const ElasticSupports& supports,
                            const ElasticLoad& load, double relative_residual = 1e-9) {
  Context context;
  VoxelElasticityOptions options;
  options.relative_residual = relative_residual;
  const auto fem = VoxelElasticity::prepare(solid, body, supports, options, context);
  EXPECT_TRUE(fem) << fem.error().message();
  if (!fem) return {};
  auto solution = fem->solve(load, context);
  EXPECT_TRUE(solution) << solution.error().message();
  if (!solution) return {};
  EXPECT_TRUE(solution->converged) << solution->relative_residual << " " << solution->iterations;
  return *std::move(solution);
}

// A linear displacement that planes hold at the surface, each by the part of the exact force along its
// normal; the rest, which planes cannot give, is the load.
TEST(VoxelContact, TiltedPlanesHoldALinearDisplacement) {
  const SolidMesh solid = irregular_body();
  const auto linear = [](const Vec3& p) {
    return Vec3{-0.02 * p.x + 0.004 * p.y, -0.03 * p.y, -0.01 * p.z + 0.006 * p.x};
  };
  std::vector<Vec3> exact;
  for (const Vec3& p : solid.points) exact.push_back(linear(p));
  for (const double ratio : {0.3, 0.49}) {
    const ElasticBody body = body_of(1, ratio);
    const auto force = mesh_forces(hexahedra_of(solid), body, exact);
    ASSERT_TRUE(force);
    for (const double angle : {30.0, 45.0}) {
      for (const double stiffness : {0.05, 1e3, 1e6}) {
        ElasticSupports supports;
        ElasticLoad load;
        for (std::size_t p = 0; p < solid.points.size(); ++p) {
          if (solid.on_surface[p] == 0) continue;
          const Vec3 n = rotation(normalized(Vec3{1, 2, 3}), radians(angle)).c[p % 3];
          const double push = dot(n, force->force_n[p]);
          const Vec3 away = push < 0 ? -n : n;
          load.forces.push_back({static_cast<int>(p), force->force_n[p] - n * push});
          supports.contacts.push_back({static_cast<int>(p), away,
                                       dot(away, solid.points[p] + exact[p]) + std::abs(push) / stiffness,
                                       stiffness, stiffness});
        }
        const ElasticSolution s = solved_with(solid, body, supports, load);
        EXPECT_LT(distance(s.displacement_mm, exact), 1e-6 * norm(exact)) << angle << " " << stiffness;
        std::printf("    nu %g, %g degrees, k %g: %d iterations, %d steps, error %.2g\n", ratio, angle,
                    stiffness, s.iterations, s.newton_steps,
                    distance(s.displacement_mm, exact) / norm(exact));
        EXPECT_LE(s.iterations, 120);
      }
    }
  }
}

// A block whose four sides are steps of 45° under uniform pressure: every node of the steps is pushed along
// the normal of its side, so frictionless planes at 45° press it evenly together.
TEST(VoxelContact, StepsAt45DegreesArePressedEvenly) {
  constexpr int n = 9;
  const SolidMesh solid = voxel_body({2 * n, 2 * n, 3}, 1, [](int i, int j, int) {
    return std::abs(i + 0.5 - n) + std::abs(j + 0.5 - n) <= n;
  });
  const double strain = 0.01;
  const ElasticBody body = body_of(1, 0.45);
  std::vector<Vec3> exact;
  for (const Vec3& p : solid.points) exact.push_back((p - Vec3{n, n, 1.5}) * -strain);
  const auto force = mesh_forces(hexahedra_of(solid), body, exact);
  ASSERT_TRUE(force);
  ElasticSupports supports;
  ElasticLoad load;
  constexpr double k = 1e3;
  for (std::size_t p = 0; p < solid.points.size(); ++p) {
    const Vec3 f = force->force_n[p], x = solid.points[p];
    const int node = static_cast<int>(p);
    if (std::abs(f.z) > 1e-9) load.forces.push_back({node, {0, 0, f.z}});
    const Vec3 side{f.x, f.y, 0};
    if (length(side) < 1e-9) continue;
    const Vec3 normal = normalized(side);
    if (std::abs(std::abs(normal.x) - std::sqrt(0.5)) > 1e-9) {  // tips, where two sides meet
      load.forces.push_back({node, side});
      continue;
    }
    supports.contacts.push_back({node, normal, dot(normal, x + exact[p]) + length(side) / k, k, 0});
  }
  for (std::size_t p = 0; p < solid.points.size(); ++p)
    if (solid.points[p].z < 1e-9)
      supports.nodes.push_back({static_cast<int>(p), {false, false, true}, exact[p]});
  const ElasticSolution s = solved_with(solid, body, supports, load);
  EXPECT_LT(distance(s.displacement_mm, exact), 1e-4 * norm(exact));
  for (const Contact& c : supports.contacts)
    EXPECT_GE(dot(c.normal, s.reaction_n[static_cast<std::size_t>(c.point)]), 0);
}

TEST(VoxelContact, StiffPlanesBothWaysAreSlidingSupports) {
  const SolidMesh solid = voxel_box({14, 10, 12}, 0.5);
  const ElasticBody body = body_of(0.015, 0.45, 1e-3);
  ElasticLoad load;
  load.gravity_mm_ms2 = {0.003, 0.002, -0.00981};
  ElasticSupports planes, supports;
  for (int axis = 0; axis < 3; ++axis) {
    Vec3 n;
    n[axis] = 1;
    for (const auto& s : supports_where(solid, [&](const Vec3& p) { return p[axis] < 1e-9; },
                                        {axis == 0, axis == 1, axis == 2})) {
      supports.nodes.push_back(s);
      if (axis < 2)
        planes.nodes.push_back(s);
      else
        planes.contacts.push_back({s.node, n, 0, 100, 100});  // a cube's stiffness is 0.0075
    }
  }
  const ElasticSolution held = solved_with(solid, body, supports, load, 1e-8);
  const ElasticSolution pressed = solved_with(solid, body, planes, load, 1e-8);
  EXPECT_LT(distance(held.displacement_mm, pressed.displacement_mm), 2e-4 * norm(held.displacement_mm));
  EXPECT_LE(pressed.iterations, held.iterations + 3);
}

struct Pressed {
  SolidMesh solid = voxel_box({6, 6, 3}, 1);
  ElasticSupports supports;
  ElasticBody body = body_of(1, 0.4);

  // A ball from above, against a block that is held below.
  explicit Pressed(double depth, double stiffness, double adhesion = 0) {
    supports.nodes = supports_where(solid, [](const Vec3& p) { return p.z < 1e-9; });
    const Vec3 centre{2.8, 3.1, 3 + 3 - depth};
    for (std::size_t p = 0; p < solid.points.size(); ++p) {
      const Vec3 x = solid.points[p];
      if (x.z < 2.9) continue;
      const Vec3 n = normalized(x - centre);
      supports.contacts.push_back({static_cast<int>(p), n, dot(n, centre) + 3, stiffness, adhesion});
    }
  }
};

// The same by dense factors of whatever set is closed.
std::vector<Vec3> dense_solution(const Pressed& c) {
  const std::size_t points = c.solid.points.size();
  const auto n = static_cast<Eigen::Index>(3 * points);
  Eigen::MatrixXd stiffness(n, n);
  const ElementMesh mesh = hexahedra_of(c.solid);
  for (Eigen::Index i = 0; i < n; ++i) {
    std::vector<Vec3> unit(points);
    unit[static_cast<std::size_t>(i / 3)][static_cast<int>(i % 3)] = 1;
    const auto column = mesh_forces(mesh, c.body, unit);
    for (Eigen::Index j = 0; j < n; ++j)
      stiffness(j, i) = column->force_n[static_cast<std::size_t>(j / 3)][static_cast<int>(j % 3)];
  }
  for (const NodeSupport& s : c.supports.nodes)
    for (int a = 0; a < 3; ++a) {
      const Eigen::Index i = 3 * s.node + a;
      stiffness.row(i).setZero(), stiffness.col(i).setZero();
      stiffness(i, i) = 1;
    }
  std::vector<double> slope(c.supports.contacts.size(), 0);
  Eigen::VectorXd u = Eigen::VectorXd::Zero(n);
  for (int round = 0; round < 50; ++round) {
    Eigen::MatrixXd k = stiffness;
    Eigen::VectorXd f = Eigen::VectorXd::Zero(n);
    bool changed = false;
    for (std::size_t i = 0; i < slope.size(); ++i) {
      const Contact& contact = c.supports.contacts[i];
      const Eigen::Vector3d m(contact.normal.x, contact.normal.y, contact.normal.z);
      const Vec3& x = c.solid.points[static_cast<std::size_t>(contact.point)];
      const double offset = contact.offset_mm - dot(contact.normal, x);
      const double d = m.dot(u.segment<3>(3 * contact.point)) - offset;
      const double now = d > 0 ? contact.adhesion_n_mm : contact.stiffness_n_mm;
      changed = changed || now != slope[i];
      slope[i] = now;
      k.block<3, 3>(3 * contact.point, 3 * contact.point) += now * m * m.transpose();
      f.segment<3>(3 * contact.point) += now * offset * m;
    }
    if (round > 0 && !changed) break;
    u = k.ldlt().solve(f);
  }
  std::vector<Vec3> out;
  for (std::size_t p = 0; p < points; ++p) {
    const auto i = static_cast<Eigen::Index>(3 * p);
    out.push_back({u[i], u[i + 1], u[i + 2]});
  }
  return out;
}

TEST(VoxelContact, BallOpensAndClosesContacts) {
  for (const double stiffness : {0.2, 1e3}) {
    for (const double adhesion : {0.0, 0.1}) {
      const Pressed c(0.4, stiffness, adhesion);
      const ElasticSolution s = solved_with(c.solid, c.body, c.supports, {});
      const auto expected = dense_solution(c);
      EXPECT_LT(distance(s.displacement_mm, expected), 1e-7 * norm(expected));
      int closed = 0;
      Vec3 total;
      for (const Contact& k : c.supports.contacts) {
        const auto p = static_cast<std::size_t>(k.point);
        const double gap = dot(k.normal, c.solid.points[p] + s.displacement_mm[p]) - k.offset_mm;
        const double force = dot(k.normal, s.reaction_n[p]);
        closed += gap <= 0 ? 1 : 0;
        if (adhesion == 0) {
          EXPECT_GE(force, 0);
          EXPECT_EQ(gap > 0, force == 0);
          EXPECT_GE(gap, -1 / stiffness);
        }
        EXPECT_LT(length(s.reaction_n[p] - k.normal * force), 1e-12 * (1 + std::abs(force)));
      }
      for (const Vec3& r : s.reaction_n) total += r;
      EXPECT_LT(length(total), 1e-6);
      EXPECT_GT(closed, 4);
      EXPECT_LT(closed, 49);
      EXPECT_GT(s.newton_steps, 0);
      std::printf("    k %g, adhesion %g: %d closed, %d iterations, %d steps\n", stiffness, adhesion, closed,
                  s.iterations, s.newton_steps);
    }
  }
}

// A ball of flesh in a socket of bone that it slides in: normals in all directions, a thousand times stiffer
// than a cube.
TEST(VoxelContact, CurvedBoneCostsLittleMore) {
  for (const int n : {16, 28}) {
    const Vec3 middle = Vec3{1, 1, 1} * (0.5 * n);
    const SolidMesh solid = voxel_body({n, n, n}, 1, [&](int i, int j, int k) {
      return length(Vec3{i + 0.5, j + 0.5, k + 0.5} - middle) < 0.5 * n;
    });
    const ElasticBody body = body_of(0.015, 0.45, 1e-3);
    ElasticSupports fixed, sliding;
    for (std::size_t p = 0; p < solid.points.size(); ++p) {
      const Vec3 x = solid.points[p];
      if (solid.on_surface[p] == 0 || x.z > 0.55 * n) continue;
      const int node = static_cast<int>(p);
      fixed.nodes.push_back({node, {true, true, true}, {}});
      const Vec3 normal = normalized(middle - x);
      if (x.x < 0.2 * n)
        sliding.nodes.push_back(fixed.nodes.back());
      else
        sliding.contacts.push_back({node, normal, dot(normal, x), 10, 0});
    }
    ElasticLoad load;
    load.gravity_mm_ms2 = {0.004, 0.002, -0.00981};
    const ElasticSolution without = solved_with(solid, body, fixed, load, 1e-6);
    const ElasticSolution with = solved_with(solid, body, sliding, load, 1e-6);
    std::printf("    %d across: %d iterations, fixed %d; %d steps\n", n, with.iterations, without.iterations,
                with.newton_steps);
    // Each step, with what is then closed, takes one at least.
    EXPECT_LE(with.iterations - with.newton_steps, 2 * without.iterations);
  }
}

TEST(VoxelContact, PlanesMove) {
  Pressed c(0.3, 1e3);
  Context context;
  VoxelElasticityOptions options;
  options.relative_residual = 1e-9;
  auto fem = VoxelElasticity::prepare(c.solid, c.body, c.supports, options, context);
  ASSERT_TRUE(fem);
  const auto before = fem->solve({}, context);
  ASSERT_TRUE(before);
  const Pressed deeper(0.45, 1e3);
  ASSERT_TRUE(fem->set_contacts(deeper.supports.contacts));
  const auto after = fem->solve({}, context, before->displacement_mm);
  ASSERT_TRUE(after && after->converged);
  const auto anew = solved_with(deeper.solid, deeper.body, deeper.supports, {});
  EXPECT_LT(distance(after->displacement_mm, anew.displacement_mm), 1e-6 * norm(anew.displacement_mm));
  auto other = c.supports.contacts;
  std::swap(other[0], other[1]);
  EXPECT_FALSE(fem->set_contacts(other));
  other.pop_back();
  EXPECT_FALSE(fem->set_contacts(other));
}

TEST(VoxelContact, SameBitsOnAnyNumberOfThreads) {
  const Pressed c(0.4, 1e3);
  set_thread_count(1);
  const ElasticSolution one = solved_with(c.solid, c.body, c.supports, {});
  set_thread_count(2);
  const ElasticSolution two = solved_with(c.solid, c.body, c.supports, {});
  set_thread_count(0);
  EXPECT_TRUE(one.displacement_mm == two.displacement_mm);
  EXPECT_TRUE(one.reaction_n == two.reaction_n);
}

TEST(VoxelContact, BadContactsAreErrors) {
  Context context;
  const SolidMesh box = voxel_box({3, 3, 3}, 1);
  const auto base = supports_where(box, [](const Vec3& p) { return p.z < 1e-9; });
  const double nan = std::nan("");
  const auto fails = [&](const std::vector<Contact>& contacts) {
    return !VoxelElasticity::prepare(box, body_of(1, 0.3), {base, contacts}, {}, context);
  };
  EXPECT_FALSE(fails({{63, {0, 0, 1}, 0, 1, 0}}));
  EXPECT_TRUE(fails({{64, {0, 0, 1}, 0, 1, 0}}));
  EXPECT_TRUE(fails({{63, {0, 0, 2}, 0, 1, 0}}));
  EXPECT_TRUE(fails({{63, {0, 0, nan}, 0, 1, 0}}));
  EXPECT_TRUE(fails({{63, {0, 0, 1}, nan, 1, 0}}));
  EXPECT_TRUE(fails({{63, {0, 0, 1}, 0, -1, 0}}));
  EXPECT_TRUE(fails({{63, {0, 0, 1}, 0, 1, 1e308}}));
  EXPECT_TRUE(fails({{63, {0, 0, 1}, 0, 1, 0}, {63, {0, 1, 0}, 0, 1, 0}}));
}

}  // namespace
}  // namespace turgor
