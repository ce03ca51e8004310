// Conjugate gradients for the stiffness matrix of a network, preconditioned by an incomplete factor within domains.
//
// The rows fall into consecutive pieces, the domains. Let A = L + D + Lᵀ + R: D the diagonal blocks, L what lies below
// them within the domains, R what joins domains. The preconditioner M = (P + L) P⁻¹ (P + L)ᵀ keeps L and takes the pivots
// P that make M's diagonal blocks those of A: P_i = D_i − Σ L_ij P_j⁻¹ L_ijᵀ (the simplified incomplete factorisation,
// D-ILU). Along a column of points that couple as a chain it is exact. Scaled so that P = 1 the preconditioned operator
// needs no product with A beside the two triangular solves (Eisenstat 1981):
//
//     t = (1 + L)⁻ᵀ p,    (1 + L)⁻¹ A (1 + L)⁻ᵀ p = t + (1 + L)⁻¹ (p + (D − 2) t + R t)
//
// so an iteration costs one pass over the blocks. Domains run in parallel; their number depends on the size alone, so
// the bits do not depend on the threads.
#pragma once

#include <span>
#include <vector>

#include "dynamics/pivot.hpp"
#include "turgor/core/context.hpp"
#include "turgor/tissue/stiffness_matrix.hpp"

namespace turgor {

enum class CgOutcome {
  converged,
  iteration_limit,
  indefinite,  ///< a direction of negative curvature, or a diagonal block that is not positive definite
  cancelled,
};

struct CgResult {
  CgOutcome outcome = CgOutcome::converged;
  int iterations = 0;
};

class BlockCg {
 public:
  explicit BlockCg(const StiffnessMatrix& matrix);

  /// Takes over the values of the matrix it was made for, with `damping` times the mean of its diagonal added to the
  /// diagonal. False where a diagonal block is not positive definite.
  bool factor(const StiffnessMatrix& matrix, double damping);

  /// Solves to ‖r‖ ≤ tolerance ‖b‖ in the norm of the preconditioner. `x` is filled whatever the outcome: every
  /// iterate of conjugate gradients is a direction of descent of the energy.
  CgResult solve(std::span<const Vec3> b, double tolerance, int max_iterations, const Context& context,
                 std::span<Vec3> x);

 private:
  // One triangle of the scaled matrix, or the blocks between domains, row by row; a block is nine doubles by columns.
  struct Part {
    std::vector<int> offsets, columns, source;  // source: block of the matrix it scales
    std::vector<double> blocks;
  };
  bool make_pivots(const StiffnessMatrix& matrix, std::size_t domain, double shift);
  void scale(const StiffnessMatrix& matrix, Part& part);
  void forward(std::size_t domain, std::span<const double> right_hand_side, std::span<double> out) const;
  void backward(std::size_t domain, std::span<const double> right_hand_side, std::span<double> out) const;
  [[nodiscard]] double apply(std::size_t domain);

  int rows_;
  std::vector<int> bounds_;  // of the domains
  Part lower_, upper_, outer_;
  std::vector<double> diagonal_;  // D − 2, scaled, a block a row
  std::vector<InverseFactor> factors_;
  std::vector<double> residual_, direction_, solved_, image_, solution_;  // four doubles a row, the last 0
};

}  // namespace turgor
