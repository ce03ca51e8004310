// The energy of a body on a lattice to second order about a state, contacts as they are, and the step to its
// minimum: conjugate gradients with a multigrid cycle, begun anew where contacts open or close. Internal.
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

class VoxelStep {
 public:
  VoxelStep(const VoxelProblem& problem, Context& context);
  /// First of all, where a solution is yet to be found: a cycle for the contacts that are closed in the state
  /// that it begins with.
  Result<void> meet(const VoxelState& state);
  [[nodiscard]] bool has_cycle() const { return cycle_ != nullptr; }
  /// Where there is one.
  [[nodiscard]] const VoxelLevel& finest() const { return cycle_->level(0); }
  /// Second derivatives at the state, which is referred to, and a cycle for them; no step.
  Result<void> linearise(const VoxelState& state);
  /// To be called where `step()` has been changed; the norm of what is left of the state's residual.
  double begin();
  /// Goes on until that is `target` long; or iterations run out, the energy has no minimum that way, or, of
  /// laws that are not linear, a component of the step is farther than `reach`, mm.
  Result<void> minimise(double target, double reach);
  /// Of the step: its second derivatives times it, of what is held too.
  void bend(std::vector<double>& forces) { multiply(step_, forces, nullptr); }
  [[nodiscard]] std::vector<double>& step() { return step_; }
  [[nodiscard]] int iterations() const { return iterations_; }

 private:
  enum class Stop { reached, contacts, curved, idle };
  Result<Stop> conjugate_gradients(double target, double reach);
  void multiply(const std::vector<double>& in, std::vector<double>& out, std::vector<double>* products);
  [[nodiscard]] double precondition();
  template <class T>
  void warp_nodes(bool back, std::vector<T>& values) const;
  [[nodiscard]] std::size_t differing(std::vector<NodePlane>& planes) const;
  Result<void> prepare_cycle();
  void list_holding();
  [[nodiscard]] double mismatch() const;
  [[nodiscard]] double farthest() const;
  Result<void> touch();

  const VoxelProblem& problem_;
  Context& context_;
  const VoxelState* state_ = nullptr;
  VoxelLaws::Matrices matrices_;  // second derivatives of the laws
  std::vector<Mat3> warp_;        // of each node: the cycle is for the body at rest; empty: none
  std::vector<double> slope_;     // of each contact, as conjugate gradients see it
  std::optional<VoxelMultigrid> own_cycle_;
  const VoxelMultigrid* cycle_;  // null: none yet
  std::optional<VoxelMultigrid::Work> work_;
  std::vector<LatticeContact> holding_;  // stiffness: along the normal, of plane and body
  std::vector<double> step_, left_, direction_, image_;
  double left_norm_ = 0;
  bool convex_ = false;  // the matrices have been made so
  int iterations_ = 0;
};

}  // namespace turgor::detail
