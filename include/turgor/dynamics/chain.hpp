// The mass-spring chain of Duysak and Zhang (2005, section 3): moved points drag their neighbours, once each.
#pragma once

#include <vector>

#include "turgor/core/context.hpp"
#include "turgor/tissue/network.hpp"

namespace turgor {

struct ChainParameters {
  double alpha = 0.9;         ///< 0 elastic … 1 rigid: weight of the rigid movement vector
  double beta = 1.0;          ///< slope of the deformation magnitude
  double max_stretch = 0.2;   ///< d_max when stretched, as a fraction of the rest length
  double max_compression = 0.2;
};

/// What is prescribed: positions of the moved points, and the fixed points.
struct PrescribedMotion {
  std::vector<int> moved;            ///< point numbers, ascending
  std::vector<Vec3> positions;       ///< of the moved points, mm
  std::vector<int> fixed;            ///< ascending
};

/// Neighbour lists prepared once for a network; apply() is then a single pass, constant cost per spring.
class ChainSolver {
 public:
  explicit ChainSolver(const SpringNetwork& network);
  /// Positions of all points after the motion.
  [[nodiscard]] Result<std::vector<Vec3>> solve(const PrescribedMotion& motion, const ChainParameters& parameters) const;

 private:
  std::vector<Vec3> rest_;
  std::vector<int> offsets_, neighbours_;
  std::vector<double> rest_lengths_;
};

}  // namespace turgor
