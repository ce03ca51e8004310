// Newton's method on the potential energy of a mesh: the load in parts, each from the equilibrium before it.
// Internal.
#pragma once

#include <string>

#include "fem/mesh_equilibrium.hpp"
#include "turgor/core/context.hpp"

namespace turgor::detail {

/// Carries a body to equilibrium under the whole load.
class MeshNewton {
 public:
  MeshNewton(MeshEquilibrium& equilibrium, const MeshElasticityOptions& options, Context& context)
      : equilibrium_(equilibrium), options_(options), context_(context) {}

  struct Outcome {
    std::vector<Vec3> displacement_mm;
    int steps = 0;
    double part = 0;       ///< of the load, 1: all of it
    std::string obstacle;  ///< empty: converged
  };
  /// From `start` the whole load is tried at once. Errors: a start that turns elements over; cancelled.
  Result<Outcome> run(std::vector<Vec3> start, bool at_once);

 private:
  /// How small the norm of what is out of balance may be in this state, N.
  [[nodiscard]] double tolerance(const MeshState& state) const;
  Result<bool> reach(MeshState& state, double part);
  using Move = bool (MeshNewton::*)(MeshState& state, double part);
  Result<bool> balance(MeshState& state, double part, int most, Move move);
  bool leap(MeshState& state, double part);
  bool predict(MeshState& state, double part);
  bool descend(MeshState& state, double part);
  bool search(MeshState& state, const MeshEquilibrium::Step& step, double part);
  bool refuse(const MeshState& trial);

  MeshEquilibrium& equilibrium_;
  MeshElasticityOptions options_;
  Context& context_;
  int steps_ = 0;
  bool stable_ = true;  // the last step's stiffness was positive definite
  std::string obstacle_;
};

}  // namespace turgor::detail
