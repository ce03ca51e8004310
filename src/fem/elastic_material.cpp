#include "turgor/fem/elastic_material.hpp"

#include <fmt/format.h>

#include <Eigen/Eigenvalues>
#include <cmath>

namespace turgor {

std::string_view name_of(ElasticLaw law) {
  constexpr std::array<std::string_view, kElasticLaws.size()> names = {
      "linear", "corotational", "st_venant_kirchhoff", "neo_hookean", "mooney_rivlin"};
  const auto number = static_cast<std::size_t>(law);
  return number < names.size() ? names[number] : "unknown";
}

Result<void> check(const ElasticMaterial& m) {
  const auto bad = [](std::string what, std::string remedy) {
    return Error{ErrorKind::bad_input, std::move(what), "elastic material", std::move(remedy)};
  };
  // Beyond these the moduli leave what numbers can hold.
  if (!(m.youngs_modulus_mpa > 1e-30) || !(m.youngs_modulus_mpa < 1e30)) {
    return bad(fmt::format("Young's modulus is {:g} MPa", m.youngs_modulus_mpa), "It must lie above 0");
  }
  if (!(m.poissons_ratio > -1) || !(m.poissons_ratio < 0.5) || !(1 - 2 * m.poissons_ratio > 1e-9) ||
      !(1 + m.poissons_ratio > 1e-9)) {
    return bad(fmt::format("Poisson's ratio is {:g}", m.poissons_ratio),
               "It must lie between -1 and 0.5; for what hardly changes its volume take 0.49 to 0.499");
  }
  if (!(m.density_g_mm3 >= 0) || !(m.density_g_mm3 < 1e30))
    return bad(fmt::format("the density is {:g} g/mm³", m.density_g_mm3), "It must be 0 or more");
  if (!(m.c20_mpa >= 0) || !(m.c20_mpa < 1e30))
    return bad(fmt::format("c20 is {:g} MPa", m.c20_mpa), "It must be 0 or more");
  if (static_cast<std::size_t>(m.law) >= kElasticLaws.size())
    return bad(fmt::format("there is no law {}", static_cast<int>(m.law)), "Name one of those there are");
  return {};
}

SymmetricTensor stress_of(const SymmetricTensor& e, const ElasticMaterial& material) {
  const double two_mu = 2 * material.shear_modulus(), pressure = material.lame_lambda() * e.trace();
  return {two_mu * e.xx + pressure,
          two_mu * e.yy + pressure,
          two_mu * e.zz + pressure,
          two_mu * e.xy,
          two_mu * e.yz,
          two_mu * e.zx};
}

double von_mises(const SymmetricTensor& s) {
  const double xy = s.xx - s.yy, yz = s.yy - s.zz, zx = s.zz - s.xx;
  return std::sqrt(0.5 * (xy * xy + yz * yz + zx * zx) + 3 * (s.xy * s.xy + s.yz * s.yz + s.zx * s.zx));
}

std::array<double, 3> principal_values(const SymmetricTensor& t) {
  Eigen::Matrix3d m;
  m << t.xx, t.xy, t.zx, t.xy, t.yy, t.yz, t.zx, t.yz, t.zz;
  const Eigen::Vector3d values =
      Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(m, Eigen::EigenvaluesOnly).eigenvalues();
  return {values[2], values[1], values[0]};
}

}  // namespace turgor
