// Which constants of a network share a parameter: groups of them, each on a grid over the body.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "turgor/calibration/forward_model.hpp"
#include "turgor/calibration/parameter_grid.hpp"
#include "turgor/tissue/network.hpp"

namespace turgor {

struct ParameterGroup {
  std::string name, unit;
  double guess = 1;  ///< of each parameter, > 0
};

/// Parameters ascend by group, then by node, x fastest.
struct GroupedParameters {
  std::vector<FitParameter> parameters;
  std::vector<int> group;         ///< of each parameter
  std::vector<Vec3> position_mm;  ///< of its node
  ParameterWeights weights;       ///< rows are the network's constants
};

/// Where the element of each constant (NetworkConstants) lies at rest: the mean of its corners.
std::vector<Vec3> places_of_constants(const SpringNetwork& network);

/// `group_of_constant`: one for each, or −1 for a constant that stays as it is. The grid spans the places of
/// all others; where a node has no influence on a group it has no parameter. Bounds lie a factor
/// `bound_factor` > 1 to both sides of the guess. Errors: another number of groups, or out of range; a guess
/// or factor that cannot be used; those of make_parameter_grid().
Result<GroupedParameters> make_grouped_parameters(const SpringNetwork& network,
                                                  std::span<const int> group_of_constant,
                                                  const std::vector<ParameterGroup>& groups,
                                                  const Index3& nodes, double bound_factor = 1000);

}  // namespace turgor
