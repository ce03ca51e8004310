// Isotropic linear elasticity: Hooke's law, and what stress and strain say about a point.
#pragma once

#include <array>

#include "turgor/core/error.hpp"

namespace turgor {

/// Small strains, no direction favoured.
struct ElasticMaterial {
  double youngs_modulus_mpa = 0.015;  ///< > 0; the whole face (Nazari et al. 2010)
  double poissons_ratio = 0.45;       ///< above −1, below 0.5
  double density_g_mm3 = 1.04e-3;     ///< ≥ 0; counts where there is gravity

  /// μ, MPa: stress = 2 μ ε + λ tr(ε) 1.
  [[nodiscard]] double shear_modulus() const { return youngs_modulus_mpa / (2 * (1 + poissons_ratio)); }
  /// λ, MPa: Lamé's first.
  [[nodiscard]] double lame_lambda() const {
    return youngs_modulus_mpa * poissons_ratio / ((1 + poissons_ratio) * (1 - 2 * poissons_ratio));
  }
  /// K = λ + 2 μ/3, MPa.
  [[nodiscard]] double bulk_modulus() const { return youngs_modulus_mpa / (3 * (1 - 2 * poissons_ratio)); }
};

/// Errors: a modulus, ratio or density outside its range or not finite.
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

SymmetricTensor stress_of(const SymmetricTensor& strain, const ElasticMaterial& material);
/// √(3/2 s:s) of the deviator s of a stress.
double von_mises(const SymmetricTensor& stress);
/// Eigenvalues, largest first.
std::array<double, 3> principal_values(const SymmetricTensor& tensor);

}  // namespace turgor
