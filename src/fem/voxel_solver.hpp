// Equilibrium of a body on a lattice: Newton's method on the energy, each step by conjugate gradients with a
// multigrid cycle. For Hooke's law without contacts that is one linear system. Internal.
#pragma once

#include <optional>
#include <vector>

#include "fem/voxel_problem.hpp"
#include "turgor/core/context.hpp"

namespace turgor::detail {

/// Displacements and what they cause, over the values of the lattice's rows.
struct VoxelState {
  std::vector<double> u;
  std::vector<double> internal;  ///< gradient of the strain energy
  std::vector<double> residual;  ///< load + contacts − internal, 0 where held
  double strain_energy = 0, potential = 0;
  double norm = 0;           ///< of the residual
  double reference = 0;      ///< norm of reactions, contact forces and load together
  std::size_t inverted = 0;  ///< cubes that have no energy: above 0 there is no state
};

class VoxelSolver {
 public:
  VoxelSolver(const VoxelProblem& problem, std::vector<double> force, Context& context);
  /// `start`: values to begin from, or empty.
  Result<ElasticSolution> solve(const std::vector<double>& start);

 private:
  void evaluate(VoxelState& state) const;
  [[nodiscard]] bool is_linear() const { return problem_.contacts.empty() && problem_.laws == nullptr; }
  Result<ElasticSolution> solve_large(const std::vector<double>& start);
  Result<double> predict(double part);
  Result<void> linearise();
  void multiply(const std::vector<double>& in, std::vector<double>& out, std::vector<double>* products);
  [[nodiscard]] double forcing() const;
  Result<bool> correct(double relative);
  [[nodiscard]] double rounding() const;
  Result<void> prepare_cycle();
  template <class T>
  void warp_nodes(bool back, std::vector<T>& values) const;
  void list_holding();
  [[nodiscard]] double precondition();
  Result<void> conjugate_gradients(double target);
  [[nodiscard]] double mismatch() const;
  bool line_search();
  void move_to(double t);
  [[nodiscard]] ElasticSolution solution() const;

  const VoxelProblem& problem_;
  std::vector<double> force_;
  Context& context_;
  VoxelState state_, trial_;
  VoxelLaws::Matrices matrices_;  // second derivatives of the laws
  std::vector<Mat3> warp_;        // of each node: the cycle is for the body at rest; empty: none
  bool warps_ = true;
  std::vector<double> slope_;  // of each contact, as the present step sees it
  std::optional<VoxelMultigrid> own_cycle_;
  const VoxelMultigrid* cycle_;
  VoxelMultigrid::Work work_;
  std::vector<LatticeContact> holding_;                  // stiffness: along the normal, of plane and body
  std::vector<double> step_, left_, direction_, image_;  // of conjugate gradients
  double left_norm_ = 0, norm_before_ = 0;
  int iterations_ = 0, newton_steps_ = 0;
  std::size_t turned_over_ = 0;  // most cubes of any state tried
  double whole_ = 0, target_ = 0;
};

}  // namespace turgor::detail
