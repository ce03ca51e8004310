// The free points of a network in small clusters that couple strongly, ordered so that neighbours are near.
#pragma once

#include <vector>

#include "turgor/dynamics/prescribed_motion.hpp"
#include "turgor/tissue/network_energy.hpp"

namespace turgor {

struct PointClusters {
  std::vector<int> points;   ///< all free points, cluster by cluster
  std::vector<int> offsets;  ///< first place of each cluster in `points`, and their number
};

/// Points joined by vertical springs form a cluster of at most `largest` points: the columns of layered
/// tissue. Points without vertical springs join neighbours of their kind,
/// those of a lattice in squares as a rule. Clusters follow one another breadth
/// first over springs and volumes (Cuthill and McKee 1969), so that pieces of the sequence are compact.
PointClusters cluster_free_points(const SpringNetwork& network, const NetworkEnergy& energy,
                                  const PrescribedMotion& motion, int largest);

}  // namespace turgor
