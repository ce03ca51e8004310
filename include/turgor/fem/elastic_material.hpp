// Isotropic elasticity: the laws, and what stress and strain say about a point.
#pragma once

#include <array>
#include <cstdint>
#include <string_view>

#include "turgor/core/error.hpp"

namespace turgor {

/// Energies for a deformation gradient F, J = det F, ε the symmetric gradient of the displacement, R the
/// rotation of F = R S, E = ½ (FᵀF − 1), Ī1 = J^(−2/3) tr FᵀF, dev the deviator. Each splits into a part that
/// changes shape and ½ K θ², so that elements can take the mean of θ against locking:
///
///     linear                 μ dev ε : dev ε                             θ = tr ε
///     corotational           μ dev (S − 1) : dev (S − 1)                 θ = tr (S − 1)
///     st_venant_kirchhoff    μ dev E : dev E                             θ = tr E
///     neo_hookean            ½ μ (Ī1 − 3)                                θ = J − 1
///     mooney_rivlin          c10 (Ī1 − 3) + c20 (Ī1 − 3)², c10 = ½ μ     θ = J − 1
///
/// The last is the form that the face models use under that name (Nazari et al. 2010).
enum class ElasticLaw : std::uint8_t {
  linear,
  corotational,
  st_venant_kirchhoff,
  neo_hookean,
  mooney_rivlin
};
inline constexpr std::array kElasticLaws = {ElasticLaw::linear, ElasticLaw::corotational,
                                            ElasticLaw::st_venant_kirchhoff, ElasticLaw::neo_hookean,
                                            ElasticLaw::mooney_rivlin};
std::string_view name_of(ElasticLaw law);

/// No direction favoured. For small strains all laws are Hooke's.
struct ElasticMaterial {
  double youngs_modulus_mpa = 0.015;  ///< > 0; the whole face (Nazari et al. 2010)
  double poissons_ratio = 0.45;       ///< above −1, below 0.5
  double density_g_mm3 = 1.04e-3;     ///< ≥ 0; counts where there is gravity
  ElasticLaw law = ElasticLaw::linear;
  double c20_mpa = 0;  ///< ≥ 0; of mooney_rivlin, which stiffens by it

  /// μ = 2 c10.
  static ElasticMaterial mooney_rivlin(double c10_mpa, double c20_mpa, double poissons_ratio) {
    return {.youngs_modulus_mpa = 4 * c10_mpa * (1 + poissons_ratio),
            .poissons_ratio = poissons_ratio,
            .law = ElasticLaw::mooney_rivlin,
            .c20_mpa = c20_mpa};
  }
  /// μ, MPa: stress = 2 μ ε + λ tr(ε) 1.
  [[nodiscard]] double shear_modulus() const { return youngs_modulus_mpa / (2 * (1 + poissons_ratio)); }
  /// λ, MPa: Lamé's first.
  [[nodiscard]] double lame_lambda() const {
    return youngs_modulus_mpa * poissons_ratio / ((1 + poissons_ratio) * (1 - 2 * poissons_ratio));
  }
  /// K = λ + 2 μ/3, MPa.
  [[nodiscard]] double bulk_modulus() const { return youngs_modulus_mpa / (3 * (1 - 2 * poissons_ratio)); }
};

/// Errors: a modulus, ratio, constant or density outside its range or not finite.
Result<void> check(const ElasticMaterial& material);

/// A symmetric tensor: stress in MPa, or strain; off the diagonal the tensor's components, half of the
/// engineer's shear strains.
struct SymmetricTensor {
  double xx = 0, yy = 0, zz = 0, xy = 0, yz = 0, zx = 0;

  [[nodiscard]] double trace() const { return xx + yy + zz; }
  /// Sum of the products of all nine components.
  [[nodiscard]] double contract(const SymmetricTensor& b) const {
    return xx * b.xx + yy * b.yy + zz * b.zz + 2 * (xy * b.xy + yz * b.yz + zx * b.zx);
  }
};

/// Hooke's law, whatever the material's own.
SymmetricTensor stress_of(const SymmetricTensor& strain, const ElasticMaterial& material);
/// √(3/2 s:s) of the deviator s of a stress.
double von_mises(const SymmetricTensor& stress);
/// Eigenvalues, largest first.
std::array<double, 3> principal_values(const SymmetricTensor& tensor);

}  // namespace turgor
