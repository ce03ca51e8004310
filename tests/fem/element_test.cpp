#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>

#include "fem/cube_element.hpp"
#include "turgor/core/random.hpp"
#include "turgor/fem/mesh_elasticity.hpp"

namespace turgor {
namespace {

using HexCorners = std::array<Vec3, 8>;
using HexMatrix = Eigen::Matrix<double, 24, 24>;

constexpr std::array<int, 8> kBits{0, 1, 3, 2, 4, 5, 7, 6};

HexCorners cube_corners(double edge) {
  HexCorners corners;
  for (std::size_t n = 0; n < 8; ++n)
    corners[n] = Vec3{edge * (kBits[n] & 1), edge * ((kBits[n] >> 1) & 1), edge * (kBits[n] >> 2)};
  return corners;
}

HexCorners distorted_corners() {
  const RandomStream random(3);
  auto corners = cube_corners(2);
  for (std::size_t n = 0; n < 8; ++n)
    for (int c = 0; c < 3; ++c)
      corners[n][c] += 0.6 * (random.uniform(3 * n + static_cast<std::size_t>(c)) - 0.5);
  return corners;
}

// The forces of each unit displacement.
HexMatrix hex_stiffness(const HexCorners& corners, const ElasticMaterial& material) {
  const ElementMesh mesh{{corners.begin(), corners.end()}, {{0, 1, 2, 3, 4, 5, 6, 7}}, {}, {}};
  HexMatrix k;
  for (int column = 0; column < 24; ++column) {
    std::vector<Vec3> u(8);
    u[static_cast<std::size_t>(column / 3)][column % 3] = 1;
    const auto forces = mesh_forces(mesh, {{material}, {}, {}}, u);
    EXPECT_TRUE(forces);
    for (int row = 0; row < 24; ++row)
      k(row, column) = forces->force_n[static_cast<std::size_t>(row / 3)][row % 3];
  }
  return k;
}

TEST(ElasticElement, TheCubesModesAreTheGaussIntegratedHexahedron) {
  for (const double ratio : {0.0, 0.3, 0.45, 0.499}) {
    const ElasticMaterial material{3, ratio, 0};
    const auto stiffness = detail::cube_stiffness(0.7);
    const auto shear = detail::matrix_of(stiffness.shear), bulk = detail::matrix_of(stiffness.bulk);
    const auto reference = hex_stiffness(cube_corners(0.7), material);
    for (int a = 0; a < 24; ++a) {
      for (int b = 0; b < 24; ++b) {
        const auto number = [](int i) { return 8 * (i % 3) + kBits[static_cast<std::size_t>(i / 3)]; };
        const auto e = static_cast<std::size_t>(24 * number(a) + number(b));
        EXPECT_NEAR(material.shear_modulus() * shear[e] + material.bulk_modulus() * bulk[e], reference(a, b),
                    1e-13 * reference.norm());
      }
    }
  }
}

TEST(ElasticElement, AMatrixOf576NumbersHas45InTheBasisOfTheModes) {
  // Eight numbers stand for 45: 9 + 3·4 + 3·5 + 9.
  const auto stiffness = detail::cube_stiffness(1);
  const auto back = detail::modes_of(detail::matrix_of(stiffness.shear));
  EXPECT_NEAR(back.axial, stiffness.shear.axial, 1e-14);
  EXPECT_NEAR(back.axial_pair, stiffness.shear.axial_pair, 1e-14);
  EXPECT_NEAR(back.bending, stiffness.shear.bending, 1e-14);
  EXPECT_NEAR(back.bending_pair, stiffness.shear.bending_pair, 1e-14);
  EXPECT_NEAR(back.shear, stiffness.shear.shear, 1e-14);
  EXPECT_NEAR(back.hourglass, stiffness.shear.hourglass, 1e-14);
  EXPECT_NEAR(back.twist, stiffness.shear.twist, 1e-14);
  EXPECT_NEAR(back.twist_pair, stiffness.shear.twist_pair, 1e-14);
}

TEST(ElasticElement, CoarseCubesKeepTheStructure) {
  auto stiffness = detail::cube_stiffness(1);
  for (int level = 0; level < 4; ++level) {
    for (const auto& modes : {stiffness.shear, stiffness.bulk}) {
      detail::CubeMatrix sum{};
      for (int child = 0; child < 8; ++child) detail::add_galerkin(detail::matrix_of(modes), child, sum);
      const auto again = detail::matrix_of(detail::modes_of(sum));
      for (std::size_t e = 0; e < sum.size(); ++e) EXPECT_NEAR(again[e], sum[e], 1e-12 * std::abs(sum[0]));
    }
    stiffness = detail::coarsened(stiffness);
  }
}

TEST(ElasticElement, RigidMotionsHaveNoEnergyAndOthersHave) {
  for (const auto& corners : {cube_corners(1.5), distorted_corners()}) {
    const auto k = hex_stiffness(corners, {2, 0.4, 0});
    for (int motion = 0; motion < 6; ++motion) {
      Eigen::Matrix<double, 24, 1> u;
      for (int n = 0; n < 8; ++n) {
        Vec3 axis;
        axis[motion % 3] = 1;
        const Vec3 v = motion < 3 ? axis : cross(axis, corners[static_cast<std::size_t>(n)]);
        u.segment<3>(3 * n) << v.x, v.y, v.z;
      }
      EXPECT_LT((k * u).norm(), 1e-12 * k.norm() * u.norm());
    }
    const Eigen::SelfAdjointEigenSolver<HexMatrix> solver(k);
    EXPECT_LT(solver.eigenvalues()[5], 1e-12 * solver.eigenvalues()[23]);
    EXPECT_GT(solver.eigenvalues()[6], 1e-3 * solver.eigenvalues()[23]);
  }
}

TEST(ElasticElement, HookesLawAndItsInvariants) {
  const ElasticMaterial steel{210000, 0.3, 7.85e-3};
  EXPECT_NEAR(steel.lame_lambda(), 121153.846, 1e-3);
  EXPECT_NEAR(steel.shear_modulus(), 80769.2308, 1e-3);
  EXPECT_NEAR(steel.bulk_modulus(), 175000, 1e-6);
  // Pulled along x: σ = E ε.
  const SymmetricTensor pulled = stress_of({1e-3, -0.3e-3, -0.3e-3, 0, 0, 0}, steel);
  EXPECT_NEAR(pulled.xx, 210, 1e-9);
  EXPECT_NEAR(pulled.yy, 0, 1e-9);
  EXPECT_NEAR(von_mises(pulled), 210, 1e-9);
  const auto principal = principal_values({1, 1, 5, 2, 0, 0});
  EXPECT_NEAR(principal[0], 5, 1e-12);
  EXPECT_NEAR(principal[1], 3, 1e-12);
  EXPECT_NEAR(principal[2], -1, 1e-12);
  EXPECT_FALSE(check(ElasticMaterial{1, 0.5, 0}));
  EXPECT_FALSE(check(ElasticMaterial{-1, 0.3, 0}));
  EXPECT_FALSE(check(ElasticMaterial{1, std::nan(""), 0}));
  EXPECT_FALSE(check(ElasticMaterial{1, 0.3, -1}));
}

}  // namespace
}  // namespace turgor
