#include "turgor/world/calibration_case.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "turgor/core/index.hpp"
#include "turgor/world/solid_fit.hpp"
#include "world/calibration_parts.hpp"

namespace turgor {
namespace {

constexpr double kMostCubes = 2e6;

Error bad_problem(std::string what, std::string remedy) {
  return {ErrorKind::bad_input, std::move(what), {}, std::move(remedy)};
}

Result<SolidMesh> cubes_of(const BoxBody& body) {
  Index3 count{};
  double cubes = 1;
  const bool known = std::isfinite(body.spacing_mm) && body.spacing_mm > 0;
  for (int a = 0; known && a < 3; ++a) cubes *= std::max(1.0, body.box.size()[a] / body.spacing_mm);
  if (!known || !(cubes <= kMostCubes)) {
    return bad_problem(fmt::format("a box of cubes of {:g} mm would be {:.3g} cubes", body.spacing_mm, cubes),
                       "Give a box, and cubes, of which there are at most two million");
  }
  for (int a = 0; a < 3; ++a)
    count[at(a)] = std::max(1, static_cast<int>(std::lround(body.box.size()[a] / body.spacing_mm)));
  VoxelGrid grid({count[0] + 2, count[1] + 2, count[2] + 2});
  grid.spacing = body.spacing_mm;
  grid.lower = body.box.lower - Vec3{1, 1, 1} * body.spacing_mm;
  for (int k = 1; k <= count[2]; ++k)
    for (int j = 1; j <= count[1]; ++j)
      for (int i = 1; i <= count[0]; ++i) grid.set(i, j, k);
  return solid_of(grid);
}

Result<SolidMesh> mesh_of(const CalibrationBody& body, Context& context) {
  if (const auto* box = std::get_if<BoxBody>(&body)) return cubes_of(*box);
  const auto& surface = std::get<SurfaceBody>(body);
  const Stage stage(context, "meshing");
  TURGOR_TRY(const VoxelGrid voxels, voxelise(surface.surface, surface.voxels, context));
  return solid_of(voxels);
}

Result<ElasticBody> reference_of(const std::vector<ReferenceRegion>& regions, const SolidMesh& mesh) {
  ElasticBody body;
  body.materials = {ElasticMaterial{}};
  if (regions.size() > 255) return bad_problem("there are more than 255 reference regions", "Join some");
  body.material.assign(mesh.tetrahedra.size() / 5, 0);
  for (const ReferenceRegion& r : regions) {
    if (auto valid = check(r.material); !valid) {
      Error error = valid.error();
      error.where = r.region.where;
      return error;
    }
    TURGOR_TRY(const std::vector<char> in, cubes_in(r.region, mesh));
    for (std::size_t c = 0; c < in.size(); ++c)
      if (in[c] != 0) body.material[c] = static_cast<std::uint8_t>(body.materials.size());
    body.materials.push_back(r.material);
  }
  if (std::ranges::find(body.material, 0) != body.material.end()) {
    return bad_problem("parts of the body have no reference material",
                       "Let the first reference be one without a region: it holds everywhere");
  }
  return body;
}

/// Takes what the reference answers to the load.
Result<void> set_reference(const ElasticSolution& solution, const SolidMesh& mesh, PreparedLoad& load,
                           const std::string& where) {
  if (!solution.converged) {
    return Error{ErrorKind::not_converged,
                 fmt::format("the reference does not come to rest under the load '{}'", load.name), where,
                 "Make the load smaller, or the reference stiffer"};
  }
  const auto moves = [&](const Vec3& u) { return length(u) > 1e-9 * mesh.spacing; };
  if (std::ranges::none_of(solution.displacement_mm, moves)) {
    return Error{ErrorKind::bad_input, fmt::format("the load '{}' does not move the body", load.name), where,
                 "Make its forces larger: they are N, tractions MPa"};
  }
  load.reference_residual = solution.relative_residual;
  load.reference.resize(mesh.points.size());
  for (std::size_t p = 0; p < load.reference.size(); ++p)
    load.reference[p] = mesh.points[p] + solution.displacement_mm[p];
  for (NodeSupport& s : load.displaced) load.reaction_n.push_back(solution.reaction_n[at(s.node)]);
  return {};
}

Result<std::vector<Vec3>> shape_under(const ForwardModel& model, std::span<const double> parameters,
                                      std::size_t load, Context& context) {
  auto run = model.run(parameters, load, nullptr, context);
  if (run) return (*run)->response().position_mm;
  if (run.error().kind == ErrorKind::not_converged) return std::vector<Vec3>{};
  return run.error();
}

}  // namespace

/// The reference, each way of holding it prepared once. What it is made from stays the caller's.
class CalibrationCase::ReferenceSolver {
 public:
  ReferenceSolver(const SolidMesh& mesh, const ElasticBody& body, std::span<const int> held)
      : mesh_(mesh), body_(body), held_(held) {}

  Result<ElasticSolution> solve(const PreparedLoad& load, Context& context) {
    if (!load.displaced.empty()) {
      TURGOR_TRY(const VoxelElasticity apart, prepared(body_, load, context));
      return apart.solve(elastic_load(load), context);
    }
    TURGOR_TRY(const VoxelElasticity* const solver, undisplaced(context));
    return solver->solve(elastic_load(load), context);
  }

  /// Under Hooke's law, where no load displaces it.
  Result<const VoxelElasticity*> hooke(Context& context) {
    const auto is_linear = [](const ElasticMaterial& m) { return m.law == ElasticLaw::linear; };
    if (std::ranges::all_of(body_.materials, is_linear)) return undisplaced(context);
    if (!hooke_) {
      ElasticBody linear = body_;
      for (ElasticMaterial& m : linear.materials) m.law = ElasticLaw::linear;
      TURGOR_TRY(hooke_, prepared(linear, {}, context));
    }
    return &*hooke_;
  }

 private:
  Result<VoxelElasticity> prepared(const ElasticBody& body, const PreparedLoad& load,
                                   Context& context) const {
    return VoxelElasticity::prepare(mesh_, body, supports_of(held_, load), {}, context);
  }
  Result<const VoxelElasticity*> undisplaced(Context& context) {
    if (!undisplaced_) {
      TURGOR_TRY(undisplaced_, prepared(body_, {}, context));
    }
    return &*undisplaced_;
  }

  const SolidMesh& mesh_;
  const ElasticBody& body_;
  std::span<const int> held_;
  std::optional<VoxelElasticity> undisplaced_, hooke_;
};

Result<CalibrationCase> CalibrationCase::prepare(CalibrationOptions options, Context& context) {
  CalibrationCase out;
  out.options_ = std::move(options);
  TURGOR_TRY(out.mesh_, mesh_of(out.options_.body, context));
  TURGOR_TRY(out.body_, reference_of(out.options_.reference, out.mesh_));
  TURGOR_CHECK(out.find_held());
  TURGOR_CHECK(out.place_loads());
  {
    ReferenceSolver solver(out.mesh_, out.body_, out.held_);
    TURGOR_CHECK(out.solve_references(solver, context));
    if (out.options_.probes.loads > 0) TURGOR_CHECK(out.add_probes(solver, context));
  }
  if (std::ranges::none_of(out.loads_, [](const PreparedLoad& l) { return !l.held_out; })) {
    return bad_problem("there is no load to calibrate with",
                       "Declare one with load and force, or have some made up with probe");
  }
  TURGOR_CHECK(out.make_model());
  return out;
}

Result<void> CalibrationCase::find_held() {
  std::vector<char> held(mesh_.points.size());
  for (const RestRegion& region : options_.held) {
    TURGOR_TRY(const std::vector<int> points, points_in(region, mesh_, false));
    for (const int p : points) held[at(p)] = 1;
  }
  for (std::size_t p = 0; p < held.size(); ++p)
    if (held[p] != 0) held_.push_back(static_cast<int>(p));
  if (held_.empty()) return bad_problem("nothing holds the body", "Say which points are held with hold");
  if (held_.size() == held.size())
    return bad_problem("all points of the body are held", "Hold fewer of them");
  return {};
}

Result<void> CalibrationCase::place_loads() {
  for (const CalibrationLoad& load : options_.loads) {
    TURGOR_TRY(PreparedLoad placed, place_load(load, mesh_, held_));
    loads_.push_back(std::move(placed));
  }
  const bool displaces =
      std::ranges::any_of(loads_, [](const PreparedLoad& l) { return !l.held_out && !l.displaced.empty(); });
  if (options_.fit.measure == ErrorMeasure::force && !displaces) {
    return bad_problem("no force is measured: no load prescribes displacements",
                       "Add displace to a load, or measure distance");
  }
  return {};
}

Result<void> CalibrationCase::solve_references(ReferenceSolver& solver, Context& context) {
  const Stage stage(context, "reference");
  for (std::size_t l = 0; l < loads_.size(); ++l) {
    context.progress(static_cast<double>(l) / static_cast<double>(loads_.size()));
    TURGOR_TRY(const ElasticSolution solution, solver.solve(loads_[l], context));
    TURGOR_CHECK(set_reference(solution, mesh_, loads_[l], options_.loads[l].where));
  }
  return {};
}

Result<void> CalibrationCase::add_probes(ReferenceSolver& solver, Context& context) {
  std::vector<PreparedLoad> probes;
  {
    const Stage stage(context, "loads that probe");
    TURGOR_TRY(const VoxelElasticity* const hooke, solver.hooke(context));
    TURGOR_TRY(probes, probing_loads(options_.probes, mesh_, held_, *hooke, loads_, context));
  }
  for (PreparedLoad& load : probes) {
    TURGOR_TRY(const ElasticSolution solution, solver.solve(load, context));
    TURGOR_CHECK(set_reference(solution, mesh_, load, {}));
    loads_.push_back(std::move(load));
  }
  return {};
}

Result<void> CalibrationCase::make_model() {
  const TetrahedraModel& model = options_.model;
  const bool forces = options_.fit.measure == ErrorMeasure::force;
  std::vector<NetworkLoad> loads;
  std::vector<std::vector<int>> groups;
  for (const PreparedLoad& load : loads_) {
    loads.push_back(network_load(load, mesh_, held_));
    if (forces && !load.displaced.empty()) groups.push_back(loads.back().motion.moved);
  }
  const SolidFitOptions solid{.guess = model.guess, .nodes = model.grid, .proportional = model.proportional};
  TURGOR_TRY(SolidFit fit, make_solid_fit(mesh_, solid, std::move(loads)));
  fit.fit.force_groups = std::move(groups);
  fit.fit.options.relative_residual = model.relative_residual;
  elements_ = fit.fit.network.solids[0];
  parameters_ = std::move(fit.parameters);
  problem_.parameters = parameters_.parameters;
  for (FitParameter& p : problem_.parameters) p.low = model.low * p.guess, p.high = model.high * p.guess;
  for (const PreparedLoad& load : loads_) problem_.loads.push_back(reference_load(load));
  TURGOR_TRY(model_, make_forward_model(std::move(fit.fit)));
  problem_.model = model_.get();
  return {};
}

ReferenceLoad CalibrationCase::reference_load(const PreparedLoad& load) const {
  ReferenceLoad out{load.name, {load.reference, {}}, {}, !load.held_out, {}};
  out.rest_mm.assign(mesh_.points.begin(), mesh_.points.end());
  if (options_.fit.measure != ErrorMeasure::force) return out;
  for (const PreparedLoad& grouped : loads_) {
    if (grouped.displaced.empty()) continue;
    Vec3 sum;  // nothing acts on the points of another load
    if (&grouped == &load)
      for (const Vec3& r : load.reaction_n) sum += r;
    for (int a = 0; a < 3; ++a) out.reference.force_n.push_back(sum[a]);
  }
  return out;
}

std::vector<double> CalibrationCase::guess() const {
  std::vector<double> out;
  for (const FitParameter& p : problem_.parameters) out.push_back(p.guess);
  return out;
}

SolidConstants CalibrationCase::stiffness(std::span<const double> parameters) const {
  std::vector<double> logarithms, all(parameters_.weights.rows());
  for (const double p : parameters) logarithms.push_back(std::log(p));
  parameters_.weights.apply(logarithms, all);
  for (double& v : all) v = std::exp(v);
  const auto triangles = all.begin() + std::ssize(elements_.edges),
             tetrahedra = triangles + std::ssize(elements_.triangles);
  return {std::vector(all.begin(), triangles), std::vector(triangles, tetrahedra),
          std::vector(tetrahedra, all.end())};
}

Result<CalibrationOutcome> outcome_of(const CalibrationCase& problem, Fit fit, Context& context) {
  const Stage stage(context, "shapes at rest");
  CalibrationOutcome out;
  const std::vector<double> guess = problem.guess();
  for (std::size_t l = 0; l < problem.loads().size(); ++l) {
    context.progress(static_cast<double>(l) / static_cast<double>(problem.loads().size()));
    LoadShapes shapes;
    TURGOR_TRY(shapes.guess, shape_under(*problem.problem().model, guess, l, context));
    TURGOR_TRY(shapes.calibrated, shape_under(*problem.problem().model, fit.parameters, l, context));
    out.loads.push_back(std::move(shapes));
  }
  out.stiffness = problem.stiffness(fit.parameters);
  out.fit = std::move(fit);
  return out;
}

}  // namespace turgor
