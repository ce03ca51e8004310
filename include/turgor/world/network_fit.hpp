// A spring network, layered or of tetrahedra, as a model whose constants are fitted: parameters multiply the
// constants of its elements through weights.
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "turgor/calibration/forward_model.hpp"
#include "turgor/calibration/parameter_grid.hpp"
#include "turgor/dynamics/equilibrium.hpp"
#include "turgor/dynamics/prescribed_motion.hpp"
#include "turgor/tissue/network.hpp"

namespace turgor {

struct NetworkLoad {
  std::string name;
  PrescribedMotion motion;
  Loads loads;
  /// How the body comes to rest where contacts are laid anew as it slides, which stay in the network: its
  /// derivatives hold those planes. Empty: solve_equilibrium().
  using Rest =
      std::function<Result<EquilibriumResult>(SpringNetwork& network, const EquilibriumOptions& options,
                                              const std::vector<Vec3>* start, Context& context)>;
  Rest rest = {};
};

/// Each of the network's constants (NetworkConstants) is its own value times the weighted value of the
/// parameters: rows of `weights` are constants; logarithms are interpolated where `logarithmic`. A row
/// without entries leaves its constant as it is.
struct NetworkFit {
  SpringNetwork network;
  std::vector<NetworkLoad> loads;
  ParameterWeights weights;
  bool logarithmic = false;
  std::vector<int> points;  ///< compared; empty: all
  /// Points whose reactions are summed to measured forces, three components a group: forces that hold them
  /// against the network.
  std::vector<std::vector<int>> force_groups;
  /// What comes to rest at all does so in ten or twenty Newton steps as a rule; what takes more than these
  /// counts as failed, or a search over wide bounds would spend its time there.
  EquilibriumOptions options{.max_newton_steps = 60};
};

/// Parameters are finite and ≥ 0, above 0 where logarithmic; derivatives ask for constants above 0. A run
/// starts from rest, or from where the one `near` it ended. Constants alone tell where a body rests: damping
/// is no parameter. Errors: a network, motion, load or option that cannot be used; weights that are not of
/// its constants; points that it does not have.
Result<std::unique_ptr<ForwardModel>> make_forward_model(NetworkFit fit);

}  // namespace turgor
