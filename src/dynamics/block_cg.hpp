// Conjugate gradients for the stiffness matrix of a network, preconditioned by symmetric Gauss-Seidel over
// clusters of points.
//
// Rows come in clusters of up to four points that couple strongly: the columns of layered tissue, whose thin
// layers make them far stiffer along than across. Scaled by the Cholesky factors of the clusters' diagonal
// blocks the matrix is A = L + 1 + Lᵀ + R: L below the diagonal within consecutive pieces of the rows
// (domains), R between domains. With the preconditioner (1 + L)(1 + L)ᵀ the preconditioned operator needs no
// product with A beside the two triangular solves (Eisenstat 1981):
//
//     t = (1 + L)⁻ᵀ p,    (1 + L)⁻¹ A (1 + L)⁻ᵀ p = t + (1 + L)⁻¹ (p − t + R t)
//
// so an iteration costs one pass over the blocks. These are kept in single precision, which halves that pass:
// the answer is a step of Newton's method, whose residual is measured in double precision. Domains run in
// parallel; their number depends on the size alone, so the bits do not depend on the threads.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

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
  double reduction = 1;  ///< ‖r‖ / ‖b‖ reached
};

/// wᵢ wⱼ S added between all pairs of some rows: what holds the weighted mean of their points.
struct CoupledStiffness {
  std::vector<int> rows;
  std::vector<double> weights;
  Mat3 stiffness;  ///< S, symmetric, positive semi-definite, N/mm
};

class BlockCg {
 public:
  static constexpr int kClusterPoints = 4, kClusterSize = 3 * kClusterPoints;

  /// `cluster_offsets`: first row of each cluster, and the number of rows; clusters have 1 to kClusterPoints
  /// rows.
  BlockCg(const StiffnessMatrix& matrix, std::vector<int> cluster_offsets);

  /// Takes over the values of the matrix it was made for, with `damping` times the mean of its diagonal added
  /// to the diagonal. `coupled` joins the matrix but not its preconditioner: it costs a few iterations.
  /// False where a diagonal block is not positive definite.
  bool factor(const StiffnessMatrix& matrix, double damping, std::span<const CoupledStiffness> coupled = {});

  /// Solves to ‖r‖ ≤ tolerance ‖b‖ in the norm of the preconditioner. `x` is filled whatever the outcome:
  /// every iterate of conjugate gradients is a direction of descent of the energy.
  CgResult solve(std::span<const Vec3> b, double tolerance, int max_iterations, const Context& context,
                 std::span<Vec3> x);

 private:
  // Blocks of pairs of clusters, twelve by twelve numbers by columns, one cluster's row after the other in
  // the order in which a solve needs them: the rows of the upper part descend, so that it too reads memory
  // forwards.
  struct Part {
    bool descending = false;
    int clusters = 0;
    std::vector<int> offsets, columns, entry_offsets;
    std::vector<float> blocks;

    [[nodiscard]] int row(int cluster) const { return descending ? clusters - 1 - cluster : cluster; }
    [[nodiscard]] int begin(int cluster) const { return offsets[row(cluster)]; }
    [[nodiscard]] int end(int cluster) const { return offsets[row(cluster) + 1]; }
  };
  // A 3×3 block of the matrix and its place, in points, within a pair's block.
  struct Entry {
    int block;
    std::int16_t row, column;
  };
  using Dense = std::array<double, kClusterSize * kClusterSize>;  // by columns
  // The part of one cluster in one coupled term: Σ wᵢ W eᵢ for each axis.
  struct Coupling {
    int cluster, term;
    std::array<double, 3 * kClusterSize> columns;
  };

  void make_domains();
  template <class Belongs>
  void make_part(const StiffnessMatrix& matrix, Part& part, Belongs&& belongs);
  bool factor_cluster(const StiffnessMatrix& matrix, int cluster, double shift);
  void scale_row(const StiffnessMatrix& matrix, Part& part, int cluster) const;
  [[nodiscard]] int clusters() const { return static_cast<int>(cluster_offsets_.size()) - 1; }
  void couple(std::span<const CoupledStiffness> coupled);
  void pull_coupled();
  void forward(std::size_t domain, std::span<const double> right_hand_side, std::span<double> out) const;
  void backward(std::size_t domain, std::span<const double> right_hand_side, std::span<double> out) const;
  double start(std::size_t domain, std::span<const Vec3> b);
  [[nodiscard]] double apply(std::size_t domain);
  double step(std::size_t domain, double alpha);
  void finish(std::span<Vec3> x) const;

  std::vector<int> cluster_offsets_, cluster_of_row_;
  std::vector<int> bounds_, domain_of_cluster_;  // of the domains, in clusters
  Part lower_, upper_, outer_;
  std::vector<Entry> entries_;          // of the pairs of all parts
  std::vector<Dense> inverse_factors_;  // W = C⁻¹ of each diagonal block C Cᵀ
  std::vector<Coupling> couplings_;     // by rising cluster
  std::vector<Mat3> coupled_stiffness_;
  std::vector<Vec3> coupled_force_;  // of each term, at the present direction
  std::vector<double> residual_, direction_, solved_, image_,
      solution_;  // twelve a cluster, zero beyond its points
};

}  // namespace turgor
