// A body, loads on it and a constitutive reference, made ready for calibrate(); and what its result means for
// the body: Morris (2006), section 3.
#pragma once

#include <array>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "turgor/calibration/calibrate.hpp"
#include "turgor/core/context.hpp"
#include "turgor/fem/elasticity.hpp"
#include "turgor/geometry/solid_mesh.hpp"
#include "turgor/geometry/voxel_solid.hpp"
#include "turgor/tissue/solid.hpp"
#include "turgor/world/parameter_groups.hpp"
#include "turgor/world/solid_constants.hpp"

namespace turgor {

/// Places of a body at rest: those within all that is given, with a millionth of a cube to spare; of nothing
/// given all of them.
struct RestRegion {
  std::optional<Box3> box;
  std::optional<Vec3> centre;  ///< of a sphere
  double radius_mm = 0;
  std::optional<Plane> beyond;  ///< on the side that its normal points to, and on the plane
  std::optional<Vec3> nearest;  ///< the one of them that is nearest to this point
  std::string where;            ///< of its declaration, for errors

  [[nodiscard]] bool contains(const Vec3& p, double margin_mm) const;
};

/// The cubes of a closed surface.
struct SurfaceBody {
  TriMesh surface;
  VoxelOptions voxels;
};
/// Cubes that fill a box; a side becomes the nearest whole number of them, at least one.
struct BoxBody {
  Box3 box;
  double spacing_mm = 1;
};
using CalibrationBody = std::variant<SurfaceBody, BoxBody>;

/// One of the forces that make up a load.
struct CalibrationForce {
  enum class Kind : std::uint8_t {
    force,         ///< N in all, shared evenly by the region's points of the surface
    traction,      ///< MPa, on the sides of cubes whose corners are all in the region
    pressure,      ///< MPa against those sides, `vector.x`
    displacement,  ///< mm, prescribed for the region's points
  };
  Kind kind = Kind::force;
  Vec3 vector;
  RestRegion region;
};
struct CalibrationLoad {
  std::string name;
  bool held_out = false;  ///< only measured: how the constants carry over
  std::vector<CalibrationForce> forces;
  std::string where;  ///< of its declaration, for errors
};

struct ReferenceRegion {
  ElasticMaterial material;
  RestRegion region;  ///< of cubes' centres; later ones go before earlier ones
};

/// Tetrahedra that keep lengths, areas and volumes (world/solid_fit.hpp): fitted are their stiffnesses in MPa
/// at the nodes of a grid over the body.
struct TetrahedraModel {
  Index3 grid{1, 1, 1};
  bool proportional = false;        ///< as in SolidFitOptions
  SolidMaterial guess;              ///< uniform, by stiffness_of(): the uncalibrated model
  double low = 0.01, high = 100;    ///< bounds, times the guess
  double relative_residual = 1e-7;  ///< of equilibria
};

/// Loads made up to probe what those given leave still (Morris 2006, section 5.2). Candidates are forces on
/// patches of the free surface, into the body, at points farthest from each other. One after another is taken
/// that adds most to the sum over all points of the greatest displacement under any load, each load's scaled
/// to 1 at its largest: greedy, so at least 1 − 1/e of the best choice of as many (Nemhauser et al. 1978).
/// Displacements are those of the reference's materials under Hooke's law.
struct ProbeOptions {
  int loads = 0;
  bool held_out = false;
  int candidates = 48;
  double depth = 0.05;  ///< of the largest displacement, times the body's longest side
};

struct CalibrationOptions {
  CalibrationBody body = BoxBody{{{0, 0, 0}, {10, 10, 10}}, 1};
  std::vector<RestRegion> held;
  std::vector<CalibrationLoad> loads;
  ProbeOptions probes;
  std::vector<ReferenceRegion> reference;
  TetrahedraModel model;
  FitOptions fit;
  std::optional<Vec3> seen_from;  ///< direction to the viewer of the report's pictures
};

/// A load on the points of the body, and the reference's answer to it.
struct PreparedLoad {
  std::string name;
  bool held_out = false;
  bool probe = false;
  std::vector<Vec3> force_n;  ///< of each point
  std::vector<NodeSupport> displaced;
  std::vector<Vec3> reference;    ///< where each point comes to rest, mm
  std::vector<Vec3> reaction_n;   ///< on each displaced point
  double reference_residual = 0;  ///< of its solution
};

/// Everything before the search. Movable; what problem() returns points into it.
class CalibrationCase {
 public:
  /// Errors, at the place of the declaration: a region without points; nothing held; no load that is fitted;
  /// a load without forces; a measure of forces without prescribed displacements; those of voxelise(),
  /// VoxelElasticity, make_solid_fit() and make_forward_model(). Cancelled.
  static Result<CalibrationCase> prepare(CalibrationOptions options, Context& context);

  [[nodiscard]] const CalibrationOptions& options() const { return options_; }
  [[nodiscard]] const SolidMesh& mesh() const { return mesh_; }
  [[nodiscard]] const ElasticBody& reference_body() const { return body_; }
  [[nodiscard]] const std::vector<int>& held() const { return held_; }  ///< points, ascending
  [[nodiscard]] const std::vector<PreparedLoad>& loads() const { return loads_; }
  /// Elements of the model, with the constants that 1 MPa everywhere gives.
  [[nodiscard]] const Solid& elements() const { return elements_; }
  [[nodiscard]] const GroupedParameters& grouped() const { return parameters_; }
  [[nodiscard]] const CalibrationProblem& problem() const { return problem_; }
  [[nodiscard]] SolidConstants stiffness(std::span<const double> parameters) const;
  /// The guess, one for each parameter.
  [[nodiscard]] std::vector<double> guess() const;

 private:
  class ReferenceSolver;

  CalibrationCase() = default;
  Result<void> find_held();
  Result<void> place_loads();
  Result<void> solve_references(ReferenceSolver& solver, Context& context);
  Result<void> add_probes(ReferenceSolver& solver, Context& context);
  Result<void> make_model();
  [[nodiscard]] ReferenceLoad reference_load(const PreparedLoad& load) const;

  CalibrationOptions options_;
  SolidMesh mesh_;
  ElasticBody body_;
  std::vector<int> held_;
  std::vector<PreparedLoad> loads_;
  Solid elements_;
  GroupedParameters parameters_;
  std::unique_ptr<ForwardModel> model_;
  CalibrationProblem problem_;
};

/// Where the points of the body come to rest under one load; empty where they do not.
struct LoadShapes {
  std::vector<Vec3> guess, calibrated;
};
struct CalibrationOutcome {
  Fit fit;
  std::vector<LoadShapes> loads;  ///< in the order of the case's
  SolidConstants stiffness;       ///< calibrated
};
/// Errors: cancelled; a model that fails for another reason than not coming to rest.
Result<CalibrationOutcome> outcome_of(const CalibrationCase& problem, Fit fit, Context& context);

/// Whether soft and hard regions are found: over the edges, the correlation of the logarithms of k_d and of
/// the reference's modulus around each (mean over the tetrahedra that share it). Nothing where either is
/// uniform.
std::optional<double> modulus_correlation(const CalibrationCase& problem, const SolidConstants& stiffness);

}  // namespace turgor
