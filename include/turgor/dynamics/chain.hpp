// The mass-spring chain of Duysak and Zhang (2005, section 3): moved points drag their neighbours, once each.
//
// Moved points are active. In each step every active point moves its neighbours that have not moved yet;
// these are semi-active and become the active points of the next step:
//
//       A ─────── B         u = B − A  rigid: the spring keeps its direction
//       ┊       ⋰           v = B − a  elastic: B stays
//       a ···· b            w = α u + (1 − α) v;  b = a + length · w/|w|
//
// with d = |w| − r0 and length = r0 ± d_max (1 − exp(−β |d| / r0)). docs/models.md says what the paper leaves
// open and how it is read here.
#pragma once

#include <span>
#include <vector>

#include "turgor/core/context.hpp"
#include "turgor/dynamics/prescribed_motion.hpp"
#include "turgor/tissue/network.hpp"

namespace turgor {

/// What becomes of points joined to a fixed point.
enum class FixedPoints {
  inert,  ///< as printed: fixed points never move and never act; the wave passes over them
  hold,   ///< fixed points hold the tissue across the layers above them, as bone does; see docs/models.md
};

struct ChainParameters {
  double alpha = 0.8;  ///< 0 elastic … 1 rigid: weight of the rigid movement vector, springs along the layers
  double column_alpha = 0.97;  ///< the same for vertical and diagonal springs, which join the layers
  double beta = 2.0;  ///< ≥ 0, slope of the deformation magnitude; 1/d_max passes small deformations whole
  double max_stretch = 0.5;      ///< ≥ 0, d_max when stretched, as a fraction of the rest length
  double max_compression = 0.5;  ///< 0 to below 1, d_max when compressed
  FixedPoints fixed_points = FixedPoints::hold;
  int semi_active_passes = 1;  ///< 0 to 100; rounds that bring springs within a step back to their limits
};

/// Memory of a solve, kept by the caller so that repeated solves allocate nothing. Arrays of points run in
/// the order in which the wave reaches them, so that a step works on a short contiguous piece of each;
/// `visit` alone is by point.
struct ChainWorkspace {
  /// Springs between two places of that order, side by side.
  struct Springs {
    std::vector<int> from, to;
    std::vector<double> rest_length, elastic;  // mm; 1 − α
    int size = 0;
  };
  std::vector<int> visit, order;
  std::vector<double> rest, displacement,
      correction;  // four doubles a point: x, y, z and a count of contributions
  Springs active, semi_active, held;
  int steps = 0;       ///< of the last wave
  int prescribed = 0;  ///< points it started from
  int reached = 0;     ///< points it came to
};

/// Neighbour lists prepared once for a network; solve() is then a single pass, constant cost per spring.
class ChainSolver {
 public:
  explicit ChainSolver(const SpringNetwork& network);
  /// Positions of all points after the motion. Points that no chain of springs joins to a moved point stay.
  /// Errors: an invalid network, motion or parameter.
  [[nodiscard]] Result<std::vector<Vec3>> solve(const PrescribedMotion& motion,
                                                const ChainParameters& parameters) const;
  /// The same into `positions`, without allocation once workspace and positions have grown.
  Result<void> solve(const PrescribedMotion& motion, const ChainParameters& parameters,
                     ChainWorkspace& workspace, std::vector<Vec3>& positions) const;

 private:
  struct Link {
    double rest_length;
    int neighbour;
    bool column;  // joins two layers
  };
  void renumber(const SpringNetwork& network);
  void make_links(const SpringNetwork& network);
  void prepare(ChainWorkspace& w) const;
  void start(const PrescribedMotion& motion, const ChainParameters& parameters, ChainWorkspace& w) const;
  void scan(int begin, int end, const ChainParameters& parameters, ChainWorkspace& w) const;
  void enter(int begin, int end, ChainWorkspace& w) const;

  Result<void> valid_;
  // Points are renumbered so that neighbours get near numbers, however they were numbered in the network.
  std::vector<Vec3> network_rest_, rest_;  // in the network's order, in the solver's
  std::vector<int> number_, point_;        // solver's number of a network point, and back
  std::vector<int> offsets_;
  std::vector<Link> links_;
};

}  // namespace turgor
