// From a plan to the predicted face.
#pragma once

#include <array>
#include <memory>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "turgor/core/context.hpp"
#include "turgor/dynamics/chain.hpp"
#include "turgor/dynamics/equilibrium.hpp"
#include "turgor/fem/elasticity.hpp"
#include "turgor/world/face_solid.hpp"
#include "turgor/world/layered_fit.hpp"
#include "turgor/world/patient_case.hpp"

namespace turgor {

enum class Solver : std::uint8_t {
  chain,    ///< mass-spring chain (Duysak and Zhang 2005)
  network,  ///< layered spring network in static equilibrium (Pieper 1989)
  solid,    ///< cubes as tetrahedra that keep lengths, areas and volumes (Morris 2006)
  fem,      ///< the same cubes by a constitutive law
};
inline constexpr std::array kSolvers = {Solver::chain, Solver::network, Solver::solid, Solver::fem};
std::string_view name_of(Solver solver);

/// The face as cubes, of `solid` and `fem`.
struct CubeOptions {
  double spacing_mm = 2.0;
  /// One tissue for the whole face: skin is thinner than a cube. Mooney-Rivlin of Nazari et al. (2010).
  ElasticMaterial material = ElasticMaterial::mooney_rivlin(0.0025, 0.001175, 0.49);
  double relative_residual = 2e-2;  ///< of `fem`; above 0. Leaves 0.02 mm on the skin (docs/benchmarks.md)
};

struct SolverOptions {
  ChainParameters chain;
  EquilibriumOptions equilibrium;  ///< of `network` and `solid`
  CubeOptions cubes;
  LayerFactors factors;  ///< of `network`: what calibration has found
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

/// The cubes of a face after surgery.
struct CubeField {
  FaceSolid face;                     ///< before surgery
  std::vector<Vec3> displacement_mm;  ///< of each node
  std::vector<float> von_mises_mpa;   ///< of each cube
};

struct Prediction {
  Solver solver = Solver::network;
  std::vector<Vec3> tissue_points;   ///< the layered tissue's points after surgery; of `chain` and `network`
  std::vector<Vec3> surface_points;  ///< those of its skin, LayeredTissue::surface, by any solver
  std::shared_ptr<const CubeField> cubes;  ///< of `solid` and `fem`
  TriMesh skin;                            ///< triangles and order of points as PatientCase::skin()
  std::vector<float> displacement_mm;      ///< per point of skin
  std::vector<LandmarkShift> landmarks;
  std::vector<SoftToHard> ratios;  ///< where the bone moved by more than half a millimetre
  int inverted = 0;                ///< prisms, tetrahedra or cubes turned inside out
  double deepest_contact_mm = 0;   ///< how far free inner ends or nodes still reach into bone; not of `chain`
  double largest_stretch = 1;      ///< of the skin's edges, new over old length
  int points = 0, springs = 0, volumes = 0;  ///< volumes: tetrahedra of `network` and `solid`, cubes of `fem`
  double setup_seconds = 0, solve_seconds = 0;
  /// Not of `chain`; its positions are moved to tissue_points or cubes.
  EquilibriumResult equilibrium;
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
/// Over points that move by more than 0.1 mm in either; `within`, where the patient's skin was before
/// surgery, limits it to a part of the face.
SkinDistance compare(const Prediction& a, const Prediction& b, const std::vector<bool>& within = {});
/// The lower third of the face (below the base of the nose) and the lips, where the landmarks show them: by
/// name, for each point of the patient's skin.
std::vector<std::pair<std::string, std::vector<bool>>> skin_parts(const PatientCase& patient);
/// The same for other points before surgery.
std::vector<std::pair<std::string, std::vector<bool>>> parts_of_face(const PatientCase& patient,
                                                                     const std::vector<Vec3>& points);
inline constexpr std::string_view kLowerThird = "lower_third";

}  // namespace turgor
