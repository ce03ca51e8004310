// How an equilibrium moves with the stiffness of its elements: at rest f(x, p) = 0, so K ∂x/∂p = ∂f/∂p with
// the exact stiffness K, and by the adjoint method λᵀ ∂f/∂p with K λ = the seed. K is factored once,
// directly; every answer after that costs two triangular solves.
#pragma once

#include <array>
#include <memory>
#include <span>
#include <vector>

#include "turgor/core/context.hpp"
#include "turgor/dynamics/equilibrium.hpp"
#include "turgor/tissue/network.hpp"

namespace turgor {

/// Places of the constants in a network: those of its springs, volumes and areas, then of each of its solids
/// the edges, triangles and tetrahedra. One number each, that the constant goes with.
struct NetworkConstants {
  explicit NetworkConstants(const SpringNetwork& network);
  std::size_t springs = 0, volumes = 0, areas = 0;  ///< where each kind ends
  std::vector<std::array<std::size_t, 3>> solids;   ///< where edges, triangles, tetrahedra of each end
  [[nodiscard]] std::size_t count() const { return solids.empty() ? areas : solids.back()[2]; }
};
/// Multiplies the constants; the inversion guard of a volume goes with its modulus. `factors`: of
/// NetworkConstants::count(), ≥ 0.
void scale_constants(SpringNetwork& network, std::span<const double> factors);

/// Of one constant, by relative · its value.
struct ConstantChange {
  int constant = 0;
  double relative = 0;
};

/// Every member is const and may be called from several threads; the same bits on any number of them.
class EquilibriumSensitivity {
 public:
  /// At `positions`, an equilibrium of `network` under `motion` (held points) and `loads`. Factors K once;
  /// where a contact, a barrier or a grab is about to take hold or let go, K is that of the present side.
  /// Errors: K is singular or not positive definite there (ErrorKind::not_converged); a network, loads,
  /// motion or positions that cannot be used; cancelled.
  static Result<EquilibriumSensitivity> prepare(const SpringNetwork& network, const PrescribedMotion& motion,
                                                const Loads& loads, std::span<const Vec3> positions,
                                                Context& context);
  EquilibriumSensitivity(EquilibriumSensitivity&&) noexcept;
  EquilibriumSensitivity& operator=(EquilibriumSensitivity&&) noexcept;
  ~EquilibriumSensitivity();

  /// Change of the positions when every constant c changes by change[c] · its value (per unit). Of all
  /// points, zero at held ones.
  [[nodiscard]] std::vector<Vec3> along(std::span<const double> change) const;
  /// The same for each of several changes that touch some constants, several at a time.
  [[nodiscard]] std::vector<std::vector<Vec3>> along_each(
      std::span<const std::vector<ConstantChange>> changes) const;
  /// Change of the reaction at each point, N: of the force that holds it against the network's own, where the
  /// constants change by `change` and the positions by `shift`.
  [[nodiscard]] std::vector<Vec3> reactions_along(std::span<const ConstantChange> change,
                                                  std::span<const Vec3> shift) const;
  /// For each constant: seed · ∂x/∂(its logarithm) + reaction_seed · ∂(reactions)/∂(its logarithm), by point;
  /// without a reaction seed the first alone. One solve for all.
  [[nodiscard]] std::vector<double> adjoint(std::span<const Vec3> seed,
                                            std::span<const Vec3> reaction_seed = {}) const;

 private:
  struct Parts;
  explicit EquilibriumSensitivity(std::unique_ptr<Parts> parts);
  std::unique_ptr<Parts> parts_;
};

}  // namespace turgor
