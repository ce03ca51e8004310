// The spring network of layered tissue.
#pragma once

#include <vector>

#include "turgor/anatomy/layered_tissue.hpp"
#include "turgor/tissue/network.hpp"

namespace turgor {

/// Young's modulus of each layer in MPa, outermost first, and Poisson's ratio of all.
/// Defaults: skin 35 kPa (in-vivo aspiration, Luboz et al. 2014: 31 to 42 kPa); SMAS with superficial fat 2.4
/// kPa (6 c10, c10 = 400 Pa, Barbarino et al. 2011); deep tissue 15 kPa (Nazari et al. 2010). Tissues with
/// another number of layers take the last value for the layers beyond.
struct TissueMaterial {
  std::vector<double> young_mpa{0.035, 0.0024, 0.015};
  double poisson = 0.45;             ///< 0.25 (springs alone) up to 0.49; beyond, prisms lock
  double inversion_guard_mpa = 0.1;  ///< of the volume elements, see VolumeElement
  double density_g_mm3 = 1.04e-3;    ///< Nazari et al. 2010
  /// Law of the springs within each layer, outermost first; as with the moduli the last goes for those
  /// beyond.
  std::vector<SpringLaw> laws{SpringLaw::linear};
};

/// Membrane springs along the edges of each sheet, vertical ones down the columns, two diagonals over each
/// edge between sheets (Pieper 1989, section 5.6), and volume elements in every prism. A spring's stiffness
/// is 6 E V / L0 for its share V of the volume about it: springs of evenly spread directions then have the
/// modulus E and Poisson's ratio 1/4 (Cauchy's relation); the volume elements add what is missing of the bulk
/// modulus.
Result<SpringNetwork> make_network(const LayeredTissue& tissue, const TissueMaterial& material);

/// How many springs make_network() joins the points with.
int spring_count(const LayeredTissue& tissue);

/// Springs as the paper counts them (Duysak and Zhang 2005, section 4): membranes on all sheets but the
/// innermost, and columns. With three sheets this reproduces its ratio of springs to points.
Result<SpringNetwork> make_chain_network(const LayeredTissue& tissue);

}  // namespace turgor
