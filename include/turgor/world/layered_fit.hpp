// Layered tissue whose springs and volumes are fitted by layer and kind.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "turgor/anatomy/layered_tissue.hpp"
#include "turgor/tissue/network.hpp"
#include "turgor/world/network_fit.hpp"
#include "turgor/world/parameter_groups.hpp"

namespace turgor {

struct LayeredFitOptions {
  std::vector<int> spring_layer, volume_layer;  ///< of each; empty: all of one. −1: stays as it is
  Index3 nodes{1, 1, 1};                        ///< of the grid of each group
  double bound_factor = 1000;                   ///< of the bounds, to both sides of the guess
};

/// Parameters multiply the network's constants, so the guess is 1: one for each layer and kind of springs
/// that there is (membrane, plate, vertical, diagonal, suture, fibre), then one for the volumes of each
/// layer, at each node of the grid. Areas and solids stay as they are.
struct LayeredFit {
  NetworkFit fit;
  GroupedParameters parameters;  ///< its weights are those of `fit`
};
/// Errors: a network that cannot be used; layers of another number, or below −1; those of
/// make_grouped_parameters().
Result<LayeredFit> make_layered_fit(SpringNetwork network, const LayeredFitOptions& options,
                                    std::vector<NetworkLoad> loads);
/// The same of make_network()'s network, by the layers of the tissue: that of a membrane is its sheet, that
/// of all else the one that it goes through.
Result<LayeredFit> make_layered_fit(SpringNetwork network, const LayeredTissue& tissue, const Index3& nodes,
                                    std::vector<NetworkLoad> loads);

/// Factors of the constants of make_network(), by the names of make_layered_fit()'s parameters on a grid of
/// `nodes` over the tissue. Of those not named: 1.
struct LayerFactors {
  Index3 nodes{1, 1, 1};
  std::vector<std::pair<std::string, double>> factors;
};
/// Errors: a name that the tissue does not have; a factor that is not above 0.
Result<void> scale_layers(const LayeredTissue& tissue, const LayerFactors& factors, SpringNetwork& network);

}  // namespace turgor
