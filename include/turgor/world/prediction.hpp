// From a plan to the predicted face.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "turgor/core/context.hpp"
#include "turgor/dynamics/chain.hpp"
#include "turgor/dynamics/equilibrium.hpp"
#include "turgor/world/patient_case.hpp"

namespace turgor {

enum class Solver : std::uint8_t {
  chain,    ///< mass-spring chain (Duysak and Zhang 2005)
  network,  ///< layered spring network in static equilibrium (Pieper 1989)
};
std::string_view name_of(Solver solver);

struct SolverOptions {
  ChainParameters chain;
  EquilibriumOptions equilibrium;
};

/// Where a landmark is before and after, mm LPS.
struct LandmarkShift {
  std::string name;
  Vec3 before, after;
};

/// Movement of a soft-tissue landmark along the movement of the bone landmark under it.
struct SoftToHard {
  std::string soft, hard;
  double soft_mm = 0;  ///< component along the bone's movement
  double hard_mm = 0;  ///< length of the bone's movement
  [[nodiscard]] double ratio() const { return soft_mm / hard_mm; }
};

struct Prediction {
  Solver solver = Solver::network;
  std::vector<Vec3> tissue_points;     ///< the layered tissue's points after surgery
  TriMesh skin;                        ///< triangles and order of points as PatientCase::skin()
  std::vector<float> displacement_mm;  ///< per point of skin
  std::vector<LandmarkShift> landmarks;
  std::vector<SoftToHard> ratios;  ///< where the bone moved by more than half a millimetre
  int inverted_prisms = 0;
  double deepest_contact_mm = 0;  ///< of `network`: how far free inner ends still reach into bone
  double largest_stretch = 1;     ///< of the skin's edges, new over old length
  int points = 0, springs = 0, volumes = 0;
  double setup_seconds = 0, solve_seconds = 0;
  EquilibriumResult equilibrium;  ///< of `network`; its positions are moved to tissue_points
};

/// Errors: nothing moves; bone comes through the skin, or the skin is stretched beyond what skin bears (names
/// the segment); the equilibrium is not reached.
Result<Prediction> predict(const PatientCase& patient, Solver solver, const SolverOptions& options,
                           Context& context);

/// Distance between two predictions over the skin, mm.
struct SkinDistance {
  double mean = 0, percentile_95 = 0, greatest = 0;
  int points = 0;
};
/// Over points that move by more than 0.1 mm in either; `below_z` (LPS) limits it to the lower face.
SkinDistance compare(const Prediction& a, const Prediction& b, double below_z = 1e9);

}  // namespace turgor
