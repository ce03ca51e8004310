#include "fem/law_response.hpp"

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <limits>

#include "turgor/core/random.hpp"
#include "turgor/math/vec.hpp"

namespace turgor {
namespace {

using detail::contract;
using detail::law_response;
using detail::law_tangent;
using detail::LawResponse;
using Matrix = detail::Tensor<double>;

ElasticMaterial material_of(ElasticLaw law, double ratio = 0.45) {
  return {.youngs_modulus_mpa = 0.03, .poissons_ratio = ratio, .law = law, .c20_mpa = 0.02};
}

Matrix random_matrix(std::uint64_t seed, double size) {
  const RandomStream random(seed);
  return Matrix::each(
      [&](int i) { return 2 * size * (random.uniform(static_cast<std::uint64_t>(i)) - 0.5); });
}

Matrix turn_of(const Vec3& axis, double angle) {
  const Mat3 r = rotation(normalized(axis), angle);
  return Matrix::each([&](int i) { return r.c[static_cast<std::size_t>(i % 3)][i / 3]; });
}

// Gradients of displacement: moderate ones, and stretches of 60 % turned by any angle.
std::vector<Matrix> gradients() {
  std::vector<Matrix> all;
  for (std::uint64_t seed = 0; seed < 6; ++seed) all.push_back(random_matrix(seed, 0.2));
  for (std::uint64_t seed = 10; seed < 16; ++seed) {
    const Matrix shear = random_matrix(seed, 0.1);
    const double turned = static_cast<double>(seed) - 9.5;
    const Matrix stretch{{seed % 2 == 0 ? 1.6 : 0.5, 0, 0, 0, 0.8, 0, 0, 0, 1.1}};
    all.push_back(turn_of({1, 2, turned}, turned) * (stretch + shear) - Matrix::unit());
  }
  return all;
}

// Energy of shape and volume, and its derivative: K = 1, θ alone in its element.
double whole_energy(const ElasticMaterial& m, const Matrix& h) {
  const LawResponse r = law_response(m, h);
  EXPECT_TRUE(r.valid);
  return r.energy + 0.5 * m.bulk_modulus() * r.theta * r.theta;
}
Matrix whole_stress(const ElasticMaterial& m, const Matrix& h) {
  const LawResponse r = law_response(m, h);
  EXPECT_TRUE(r.valid);
  return r.stress + r.theta_gradient * (m.bulk_modulus() * r.theta);
}

TEST(LawResponse, StressIsTheDerivativeOfTheEnergy) {
  constexpr double step = 1e-5;
  for (const ElasticLaw law : kElasticLaws) {
    const ElasticMaterial m = material_of(law);
    for (const Matrix& h : gradients()) {
      const LawResponse here = law_response(m, h);
      ASSERT_TRUE(here.valid) << name_of(law);
      for (int i = 0; i < 9; ++i) {
        Matrix more = h, less = h;
        more.m[i] += step, less.m[i] -= step;
        const LawResponse a = law_response(m, more), b = law_response(m, less);
        EXPECT_NEAR((a.energy - b.energy) / (2 * step), here.stress.m[i], 1e-9) << name_of(law);
        EXPECT_NEAR((a.theta - b.theta) / (2 * step), here.theta_gradient.m[i], 1e-8) << name_of(law);
      }
    }
  }
}

TEST(LawResponse, TangentIsTheDerivativeOfTheStress) {
  constexpr double step = 1e-5, pressure = 0.04;
  for (const ElasticLaw law : kElasticLaws) {
    const ElasticMaterial m = material_of(law);
    for (const Matrix& h : gradients()) {
      const Eigen::Matrix<double, 9, 9> tangent = law_tangent(m, h, pressure);
      EXPECT_LT((tangent - tangent.transpose()).norm(), 1e-14 * tangent.norm()) << name_of(law);
      for (int i = 0; i < 9; ++i) {
        Matrix more = h, less = h;
        more.m[i] += step, less.m[i] -= step;
        const LawResponse a = law_response(m, more), b = law_response(m, less);
        for (int k = 0; k < 9; ++k) {
          const double change =
              a.stress.m[k] - b.stress.m[k] + pressure * (a.theta_gradient.m[k] - b.theta_gradient.m[k]);
          EXPECT_NEAR(change / (2 * step), tangent(k, i), 2e-8) << name_of(law);
        }
      }
    }
  }
}

TEST(LawResponse, ARotationGivesNoStressButByTheLinearLaw) {
  const Matrix h = turn_of({1, -2, 0.5}, radians(90)) - Matrix::unit();
  for (const ElasticLaw law : kElasticLaws) {
    const Matrix stress = whole_stress(material_of(law), h);
    const double size = std::sqrt(contract(stress, stress));
    if (law == ElasticLaw::linear)
      EXPECT_GT(size, 1e-2);
    else
      EXPECT_LT(size, 1e-15) << name_of(law);
  }
}

TEST(LawResponse, StressTurnsWithTheBody) {
  const Matrix r = turn_of({0.3, 1, 2}, 2.2);
  for (const ElasticLaw law : kElasticLaws) {
    if (law == ElasticLaw::linear) continue;
    for (const Matrix& h : gradients()) {
      const ElasticMaterial m = material_of(law);
      const Matrix turned = r * (h + Matrix::unit()) - Matrix::unit();
      EXPECT_NEAR(whole_energy(m, turned), whole_energy(m, h), 1e-15) << name_of(law);
      const Matrix error = whole_stress(m, turned) - r * whole_stress(m, h);
      EXPECT_LT(contract(error, error), 1e-28) << name_of(law);
    }
  }
}

TEST(LawResponse, SmallStrainsAreHookes) {
  for (const ElasticLaw law : kElasticLaws) {
    for (const double size : {1e-4, 1e-6, 1e-9}) {
      const ElasticMaterial m = material_of(law, 0.4);
      const Matrix h = random_matrix(3, size), e = h.symmetric();
      const Matrix hooke =
          e.deviator() * (2 * m.shear_modulus()) + Matrix::unit() * (m.bulk_modulus() * e.trace());
      const Matrix error = whole_stress(m, h) - hooke;
      const double relative = std::sqrt(contract(error, error) / contract(hooke, hooke));
      EXPECT_LT(relative, 10 * size + 1e-15) << name_of(law);
      EXPECT_NEAR(whole_energy(m, h) / (0.5 * contract(hooke, e)), 1, 10 * size + 1e-13) << name_of(law);
    }
  }
}

// Mooney-Rivlin pulled along x without change of volume: Cauchy stress less pressure in closed form.
TEST(LawResponse, MooneyRivlinIsTheSecondOrderPolynomialOfTheFaceModels) {
  const ElasticMaterial m = ElasticMaterial::mooney_rivlin(2.5e-3, 1.175e-3, 0.499);
  EXPECT_NEAR(m.shear_modulus(), 5e-3, 1e-18);
  for (const double stretch : {0.6, 1.3, 2.0}) {
    const double across = 1 / std::sqrt(stretch);
    const Matrix f{{stretch, 0, 0, 0, across, 0, 0, 0, across}};
    const LawResponse r = law_response(m, f - Matrix::unit());
    const double invariant = stretch * stretch + 2 / stretch;
    EXPECT_NEAR(r.energy, 2.5e-3 * (invariant - 3) + 1.175e-3 * (invariant - 3) * (invariant - 3), 1e-17);
    const double difference = r.stress.m[0] * stretch - r.stress.m[4] * across;
    EXPECT_NEAR(difference, 2 * (stretch * stretch - 1 / stretch) * (2.5e-3 + 2 * 1.175e-3 * (invariant - 3)),
                1e-16);
    EXPECT_NEAR(r.theta, 0, 1e-15);
  }
}

TEST(LawResponse, WhatIsTurnedOverOrNotFiniteIsSaidToBeInvalid) {
  const Matrix flat{{-1, 0, 0, 0, 0, 0, 0, 0, 0}}, over{{-2, 0, 0, 0, 0, 0, 0, 0, 0}};
  for (const ElasticLaw law : {ElasticLaw::neo_hookean, ElasticLaw::mooney_rivlin})
    for (const Matrix& h : {flat, over}) EXPECT_FALSE(law_response(material_of(law), h).valid);
  const double wild[] = {1e308, -1e308, 1e200, std::numeric_limits<double>::infinity(), std::nan("")};
  for (const ElasticLaw law : kElasticLaws) {
    for (const double value : wild) {
      const LawResponse r = law_response(material_of(law), Matrix{{0, value, 0, 0, 0, value, 0, 0, 0}});
      EXPECT_FALSE(r.valid) << name_of(law) << " " << value;
    }
  }
}

// The same bits in lanes of doubles as alone, and as many as floats have in lanes of floats.
template <ElasticLaw law, class T>
void expect_lanes(double tolerance) {
  constexpr int lanes = Pack<T>::lanes;
  using Scalar = typename Pack<T>::Scalar;
  const auto all = gradients();
  const Matrix df = random_matrix(77, 1);
  Scalar in[9][lanes], out[9][lanes], energy[lanes];
  for (int i = 0; i < 9; ++i)
    for (int l = 0; l < lanes; ++l) in[i][l] = static_cast<Scalar>(all[static_cast<std::size_t>(l)].m[i]);
  const auto h = detail::Tensor<T>::each([&](int i) { return load<T>(in[i]); });
  const detail::LawPoint<law, T> many(h, {detail::number<T>(0.01), detail::number<T>(0.02)});
  const auto tangent = many.tangent(
      detail::Tensor<T>::each([&](int i) { return detail::number<T>(df.m[i]); }), detail::number<T>(0.04));
  EXPECT_TRUE(many.valid());
  std::memcpy(out, tangent.m, sizeof out);
  const T of_shape = many.energy();
  std::memcpy(energy, &of_shape, sizeof energy);
  for (int l = 0; l < lanes; ++l) {
    const detail::LawPoint<law, double> one(all[static_cast<std::size_t>(l)], {0.01, 0.02});
    EXPECT_NEAR(static_cast<double>(energy[l]), one.energy(), tolerance);
    const Matrix expected = one.tangent(df, 0.04);
    for (int i = 0; i < 9; ++i) EXPECT_NEAR(static_cast<double>(out[i][l]), expected.m[i], tolerance);
  }
}

TEST(LawResponse, LanesAreTheSameAsOneByOne) {
  expect_lanes<ElasticLaw::linear, Lanes>(0);
  expect_lanes<ElasticLaw::st_venant_kirchhoff, Lanes>(0);
  expect_lanes<ElasticLaw::neo_hookean, Lanes>(0);
  expect_lanes<ElasticLaw::mooney_rivlin, Lanes>(0);
  expect_lanes<ElasticLaw::mooney_rivlin, Twin<double, 4>>(0);
  expect_lanes<ElasticLaw::linear, Floats>(1e-7);
  expect_lanes<ElasticLaw::neo_hookean, Floats>(1e-7);
  expect_lanes<ElasticLaw::mooney_rivlin, Floats>(1e-5);
  expect_lanes<ElasticLaw::mooney_rivlin, Twin<float, 8>>(1e-5);
}

TEST(LawResponse, CubeRootIsExactToRounding) {
  for (double x = 1e-6; x < 1e30; x *= 1.37)
    EXPECT_NEAR(detail::inverse_cube_root(x) * std::cbrt(x), 1, 1e-15) << x;
}

TEST(LawResponse, MaterialsOutsideTheirRangeAreRefused) {
  ElasticMaterial m;
  for (const double bad : {-1e-9, std::nan(""), std::numeric_limits<double>::infinity()}) {
    m.c20_mpa = bad;
    const auto checked = check(m);
    ASSERT_FALSE(checked);
    EXPECT_NE(checked.error().message().find("c20"), std::string::npos);
  }
  m.c20_mpa = 0;
  EXPECT_TRUE(check(m));
  m.law = static_cast<ElasticLaw>(9);
  EXPECT_FALSE(check(m));
  EXPECT_EQ(name_of(m.law), "unknown");
  for (const ElasticLaw law : kElasticLaws) EXPECT_NE(name_of(law), "unknown");
}

}  // namespace
}  // namespace turgor
