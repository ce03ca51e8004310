#include "world/face_solve.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "turgor/core/index.hpp"
#include "turgor/core/parallel.hpp"
#include "turgor/fem/voxel_elasticity.hpp"
#include "turgor/geometry/voxel_solid.hpp"
#include "turgor/tissue/solid.hpp"
#include "world/face_skin.hpp"
#include "world/face_supports.hpp"
#include "world/solve_round.hpp"

namespace turgor {
namespace {

/// How far a round goes.
enum class Round { by_hooke, roughly, precisely };
constexpr double kHookeResidual = 1e-2, kRoughResidual = 0.1;
/// Quickest of 2 to 8 on the phantom's face.
constexpr int kSmoothingSteps = 4;
/// At 0.03 points of the skin are 0.014 mm from where they come to rest.
constexpr double kUsableResidual = 0.03;

std::vector<Vec3> positions_of(const FaceSolid& face, std::span<const Vec3> displacement_mm) {
  std::vector<Vec3> out(face.mesh.points.begin(), face.mesh.points.end());
  for (std::size_t n = 0; n < out.size(); ++n) out[n] += displacement_mm[n];
  return out;
}

std::vector<Vec3> displacement_of(const FaceSolid& face, std::span<const Vec3> positions) {
  std::vector<Vec3> out(positions.begin(), positions.end());
  for (std::size_t n = 0; n < out.size(); ++n) out[n] -= face.mesh.points[n];
  return out;
}

/// Morris's tetrahedra of the same cubes.
class TetraFace {
 public:
  static Result<TetraFace> prepare(const FaceSolid& face, const CubeOptions& options,
                                   const EquilibriumOptions& equilibrium) {
    TetraFace out(face, equilibrium);
    const std::vector<Vec3>& rest = out.network_.rest;
    TURGOR_TRY(Solid solid, make_solid({face.mesh.tetrahedra.begin(), face.mesh.tetrahedra.end()},
                                       static_cast<int>(rest.size()), face.mesh.spacing));
    // Five tetrahedra a cube lock nearer to incompressibility.
    constexpr double greatest_ratio = 0.45;
    SolidMaterial material;
    material.poissons_ratio = std::min(options.material.poissons_ratio, greatest_ratio);
    material.youngs_modulus_mpa = 2 * options.material.shear_modulus() * (1 + material.poissons_ratio);
    material.density_g_mm3 = options.material.density_g_mm3;
    const std::array each{stiffness_of(material)};
    TURGOR_CHECK(set_stiffness(solid, rest, each));
    out.network_.mass_g.assign(rest.size(), 0.0);
    add_mass(solid, rest, material.density_g_mm3, out.network_.mass_g);
    out.springs_ = static_cast<int>(solid.edges.size());
    out.network_.solids.push_back(std::move(solid));
    return out;
  }

  Result<EquilibriumResult> solve(const FaceSupports& supports, std::vector<Contact> contacts,
                                  const std::vector<Vec3>* start, Round round, Context& context) {
    network_.contacts = std::move(contacts);
    PrescribedMotion motion;
    for (const NodeSupport& s : supports.held()) {
      if (s.displacement_mm == Vec3{}) {
        motion.fixed.push_back(s.node);
      } else {
        motion.moved.push_back(s.node);
        motion.positions.push_back(network_.rest[at(s.node)] + s.displacement_mm);
      }
    }
    EquilibriumOptions options = equilibrium_;
    if (round != Round::precisely)
      options.relative_residual = std::max(options.relative_residual, kHookeResidual);
    return solve_equilibrium(network_, motion, options, context, start);
  }
  [[nodiscard]] int springs() const { return springs_; }
  [[nodiscard]] static Round after_hooke() { return Round::precisely; }

 private:
  TetraFace(const FaceSolid& face, const EquilibriumOptions& equilibrium) : equilibrium_(equilibrium) {
    network_.rest.assign(face.mesh.points.begin(), face.mesh.points.end());
  }
  EquilibriumOptions equilibrium_;
  SpringNetwork network_;
  int springs_ = 0;
};

/// The cubes by the constitutive law.
class ElasticFace {
 public:
  ElasticFace(const FaceSolid& face, const CubeOptions& options) : face_(face), options_(options) {
    body_.materials = {options.material};
  }

  Result<EquilibriumResult> solve(const FaceSupports& supports, std::vector<Contact> contacts,
                                  const std::vector<Vec3>* start, Round round, Context& context) {
    VoxelElasticityOptions options;
    options.relative_residual = round == Round::by_hooke  ? kHookeResidual
                                : round == Round::roughly ? kRoughResidual
                                                          : options_.relative_residual;
    options.smoothing_steps = kSmoothingSteps;
    // Where nodes slide to is found by Hooke's law, at a fraction of the cost.
    body_.materials.front().law = round == Round::by_hooke ? ElasticLaw::linear : options_.material.law;
    TURGOR_TRY(const VoxelElasticity system,
               VoxelElasticity::prepare(face_.mesh, body_, {supports.held(), std::move(contacts)}, options,
                                        context));
    const std::vector<Vec3> from = start != nullptr ? displacement_of(face_, *start) : std::vector<Vec3>{};
    TURGOR_TRY(const ElasticSolution solution, system.solve({}, context, from));
    if (round == Round::precisely) {
      TURGOR_TRY(stress_, system.stress(solution.displacement_mm));
    }
    EquilibriumResult out;
    out.positions = positions_of(face_, solution.displacement_mm);
    out.relative_residual = solution.relative_residual;
    out.energy_nmm = solution.strain_energy_nmm;
    out.newton_steps = solution.newton_steps;
    out.linear_iterations = solution.iterations;
    out.converged = solution.converged;
    double reaction = 0;
    for (const Vec3& r : solution.reaction_n) reaction += squared_length(r);
    out.reaction_n = std::sqrt(reaction);
    return out;
  }
  [[nodiscard]] const std::vector<ElementStress>& stress() const { return stress_; }
  [[nodiscard]] Round after_hooke() const {
    return options_.material.law == ElasticLaw::linear ? Round::precisely : Round::roughly;
  }

 private:
  const FaceSolid& face_;
  CubeOptions options_;
  ElasticBody body_;
  std::vector<ElementStress> stress_;
};

/// Solves, and lays the planes of the bone anew where nodes have slid, until they no longer enter it: first
/// by Hooke's law, at a fraction of the cost, then roughly, then to the residual asked for.
template <class System>
Result<EquilibriumResult> settle(System& system, Solver solver, FaceSupports& supports, double* deepest_mm,
                                 Context& context) {
  constexpr int max_rounds = 10, hooke_rounds = 4;
  constexpr double bearable_mm = 0.25;
  EquilibriumResult result;
  std::vector<Vec3> points = supports.start();
  Round kind = Round::by_hooke;
  for (int round = 0; round < max_rounds; ++round) {
    const int steps = result.newton_steps, iterations = result.linear_iterations;
    TURGOR_TRY(result, system.solve(supports, supports.contacts(points), round > 0 ? &points : nullptr, kind,
                                    context));
    result.newton_steps += steps, result.linear_iterations += iterations;
    TURGOR_CHECK(check_usable(solver, result, kUsableResidual));
    points = result.positions;
    const std::vector<double> depths = supports.depths(points);
    *deepest_mm = depths.empty() ? 0 : *std::max_element(depths.begin(), depths.end());
    const bool settled = *deepest_mm < bearable_mm;
    if (settled && kind == Round::precisely) break;
    if (round > 0 && round + 1 < max_rounds) supports.pin(points, bearable_mm);
    if (settled || round + 1 >= hooke_rounds)
      kind = kind == Round::by_hooke ? system.after_hooke() : Round::precisely;
  }
  return result;
}

/// Cubes with a corner at which they are turned inside out.
int inverted_cubes(const FaceSolid& face, const std::vector<Vec3>& positions) {
  const std::vector<std::array<int, 8>> cubes = hexahedra(face.mesh);
  int inverted = 0;
  for (const auto& cube : cubes) {
    const auto p = [&](std::size_t n) -> const Vec3& { return positions[at(cube[n % 8])]; };
    bool bad = false;
    for (std::size_t n = 0; n < 4; ++n) {
      const std::size_t next = (n + 1) % 4, last = (n + 3) % 4;
      bad = bad || signed_volume(p(n), p(next), p(last), p(n + 4)) <= 0;
      bad = bad || signed_volume(p(n + 4), p(last + 4), p(next + 4), p(n)) <= 0;
    }
    inverted += bad ? 1 : 0;
  }
  return inverted;
}

int inverted_tetrahedra(const FaceSolid& face, const std::vector<Vec3>& x) {
  return static_cast<int>(std::count_if(
      face.mesh.tetrahedra.begin(), face.mesh.tetrahedra.end(),
      [&](const auto& t) { return signed_volume(x[at(t[0])], x[at(t[1])], x[at(t[2])], x[at(t[3])]) <= 0; }));
}

}  // namespace

Result<void> solve_cubes(const PatientCase& patient, Solver solver, const CubeOptions& options,
                         const EquilibriumOptions& equilibrium, Prediction& prediction, Context& context) {
  TURGOR_CHECK(check(options.material));
  const auto start = Clock::now();
  auto field = std::make_shared<CubeField>();
  TURGOR_TRY(field->face, build_face_solid(patient.head(), patient.tissue(), options.spacing_mm, context));
  const FaceSolid& face = field->face;
  TURGOR_TRY(FaceSupports supports, FaceSupports::find(patient, face));
  EquilibriumResult& result = prediction.equilibrium;
  if (solver == Solver::solid) {
    TURGOR_TRY(TetraFace system, TetraFace::prepare(face, options, equilibrium));
    prediction.setup_seconds = seconds_since(start);
    TURGOR_TRY(result, settle(system, solver, supports, &prediction.deepest_contact_mm, context));
    prediction.springs = system.springs();
    prediction.volumes = static_cast<int>(face.mesh.tetrahedra.size());
    prediction.inverted = inverted_tetrahedra(face, result.positions);
  } else {
    ElasticFace system(face, options);
    prediction.setup_seconds = seconds_since(start);
    TURGOR_TRY(result, settle(system, solver, supports, &prediction.deepest_contact_mm, context));
    for (const ElementStress& s : system.stress())
      field->von_mises_mpa.push_back(static_cast<float>(von_mises(s.stress_mpa)));
    prediction.volumes = face.cubes();
    prediction.inverted = inverted_cubes(face, result.positions);
  }
  prediction.solve_seconds = seconds_since(start) - prediction.setup_seconds;
  prediction.points = static_cast<int>(face.mesh.points.size());
  field->displacement_mm = displacement_of(face, std::exchange(result.positions, {}));
  const std::vector<Vec3> shift = carry_skin(face, patient.tissue(), field->displacement_mm);
  prediction.surface_points = patient.tissue().surface.points;
  for (std::size_t c = 0; c < shift.size(); ++c) prediction.surface_points[c] += shift[c];
  prediction.cubes = std::move(field);
  return {};
}

}  // namespace turgor
