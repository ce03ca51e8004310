// A solid of tetrahedra whose constants k_d, k_a and k_v are fitted (Morris 2006, sections 3.3 and 3.5).
#pragma once

#include <vector>

#include "turgor/geometry/solid_mesh.hpp"
#include "turgor/tissue/solid.hpp"
#include "turgor/world/network_fit.hpp"
#include "turgor/world/parameter_groups.hpp"

namespace turgor {

struct SolidFitOptions {
  SolidMaterial guess;         ///< what stiffness_of() starts from
  Index3 nodes{1, 1, 1};       ///< of the grid of parameters
  double bound_factor = 1000;  ///< of the bounds, to both sides of the guess
  /// k_d, k_a and k_v in one proportion throughout: a factor of all three at each node. A third of the
  /// parameters, which one load tells apart better.
  bool proportional = false;
};

/// Parameters are the stiffnesses of SolidStiffness, in MPa, at the nodes of a grid: k_d of edges, then k_a
/// of triangles, then k_v of tetrahedra, each element with the interpolated logarithm at its middle. Where
/// `proportional`, the factors at the nodes come first, then one of each. Where the closed form leaves
/// nothing for a kind, the guess is a thousandth of the largest. Damping does not change where a body rests,
/// so it is no parameter.
struct SolidFit {
  NetworkFit fit;
  GroupedParameters parameters;  ///< its weights are those of `fit`
};
/// Errors: a mesh, material or option that cannot be used.
Result<SolidFit> make_solid_fit(const SolidMesh& mesh, const SolidFitOptions& options,
                                std::vector<NetworkLoad> loads);

}  // namespace turgor
