#include "turgor/commands/problem.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <functional>
#include <map>
#include <memory>
#include <string_view>

#include "turgor/core/index.hpp"
#include "turgor/geometry/mesh_file.hpp"
#include "turgor/world/object_file.hpp"
#include "values.hpp"

namespace turgor {
namespace {

/// What a problem's flags say where it says nothing.
struct Reader {
  CalibrationOptions& options;
  bool body = false, guess = false;
  Context& context;
  FaceProblem face = {};
};
using Setting = std::function<Result<void>(const Invocation&, Reader&)>;

Index3 three_integers(const Invocation& c, std::string_view parameter) {
  const auto& n = c.all(parameter).front().integers;
  return {static_cast<int>(n[0]), static_cast<int>(n[1]), static_cast<int>(n[2])};
}

Vec3 three_numbers(const Invocation& c, std::string_view parameter) {
  const std::vector<double> n = c.numbers(parameter);
  return {n[0], n[1], n[2]};
}

/// What went wrong with the file that a parameter names.
Error told_at(const Invocation& c, const Error& error, std::string_view parameter) {
  return c.error(error.where.empty() ? error.what : error.where + ": " + error.what, error.remedy, parameter);
}

RestRegion region_of(const Invocation& c) {
  RestRegion region;
  region.where = c.place().text();
  const auto has = [&](std::string_view name) {
    if (c.command().find(name) == nullptr || !c.given(name)) return false;
    region.where = c.all(name).front().place.text();
    return true;
  };
  if (has("nearest")) region.nearest = c.point("nearest");
  if (has("plane")) region.beyond = c.plane("plane");
  if (has("sphere")) {
    const Sphere sphere = c.sphere("sphere");
    region.centre = sphere.centre, region.radius_mm = sphere.radius;
  }
  if (has("box")) region.box = c.box("box");
  return region;
}

// ---- the body ----

Result<void> set_body(const Invocation& c, Reader& r, CalibrationBody body) {
  if (r.body) return c.error("the problem has a body already", "Leave one of them out");
  r.body = true;
  r.options.body = std::move(body);
  return {};
}

VoxelOptions voxels_of(const Invocation& c) {
  VoxelOptions voxels;
  voxels.resolution = static_cast<int>(c.integer("resolution"));
  voxels.border = !c.flag("no_border");
  return voxels;
}

double longest_side(const TriMesh& surface) {
  const Vec3 size = bounds(surface).size();
  return std::max({size.x, size.y, size.z});
}

Result<void> surface_body(const Invocation& c, Reader& r) {
  auto surface = read_mesh(c.path("surface"));
  if (!surface) return told_at(c, surface.error(), "surface");
  SurfaceBody body{*std::move(surface), voxels_of(c)};
  if (c.word("fill") == "winding") body.voxels.fill = VoxelOptions::Fill::winding;
  if (c.given("width")) {
    const double longest = longest_side(body.surface);
    if (!(longest > 0)) return c.error("the surface has no extent to scale", "Give a surface of a body");
    for (Vec3& p : body.surface.points) p *= c.number("width") / longest;
  }
  return set_body(c, r, std::move(body));
}

Result<void> shape_body(const Invocation& c, Reader& r) {
  TURGOR_TRY(const Object shape, make_primitive(c.word("shape")));
  SurfaceBody body{triangulated(world_polyhedron(shape)), voxels_of(c)};
  const Box3 box = bounds(body.surface);
  const Vec3 size = three_numbers(c, "size"), own = box.size(), middle = box.centre();
  for (Vec3& p : body.surface.points)
    for (int a = 0; a < 3; ++a) p[a] = (p[a] - middle[a]) * (size[a] / own[a]);
  return set_body(c, r, std::move(body));
}

Result<void> face_body(const Invocation& c, Reader& r) {
  if (r.body) return c.error("the problem has a body already", "Leave one of them out");
  r.body = true;
  r.face.scan = c.path("scan");
  const std::string& quality = c.word("quality");
  r.face.quality = quality == "draft" ? Quality::draft : quality == "fine" ? Quality::fine : Quality::normal;
  return {};
}

// ---- loads ----

Result<void> begin_load(const Invocation& c, Reader& r) {
  auto& loads = r.options.loads;
  if (c.given("plan")) {
    auto plan = read_plan(c.path("plan"));
    if (!plan) return told_at(c, plan.error(), "plan");
    r.face.loads.push_back({c.word("name"), c.flag("held_out"), *std::move(plan), c.place().text()});
  }
  if (std::ranges::find(loads, c.word("name"), &CalibrationLoad::name) != loads.end())
    return c.error("there is a load '" + c.word("name") + "' already", "Give each load its own name", "name");
  loads.push_back({c.word("name"), c.flag("held_out"), {}, c.place().text()});
  return {};
}

Result<void> add_force(const Invocation& c, Reader& r, CalibrationForce::Kind kind) {
  if (r.options.loads.empty())
    return c.error("there is no load that this belongs to", "Begin one before it: load NAME");
  const std::string_view value = c.command().parameters.front().name;
  const bool scalar = kind == CalibrationForce::Kind::pressure;
  const Vec3 vector = scalar ? Vec3{c.number(value), 0, 0} : three_numbers(c, value);
  r.options.loads.back().forces.push_back({kind, vector, region_of(c)});
  return {};
}

Setting force_of(CalibrationForce::Kind kind) {
  return [kind](const Invocation& c, Reader& r) { return add_force(c, r, kind); };
}

Result<void> set_probes(const Invocation& c, Reader& r) {
  ProbeOptions& probes = r.options.probes;
  probes.loads = static_cast<int>(c.integer("loads"));
  probes.held_out = c.flag("held_out");
  probes.candidates = static_cast<int>(c.integer("candidates"));
  probes.depth = c.number("depth");
  return {};
}

// ---- reference, model and search ----

Result<void> add_reference(const Invocation& c, Reader& r) {
  ElasticMaterial material;
  material.law = commands::value_named(c.word("law"), kElasticLaws);
  material.youngs_modulus_mpa = c.number("modulus");
  material.poissons_ratio = c.number("poisson");
  material.c20_mpa = c.number("c20");
  if (material.c20_mpa > 0 && material.law != ElasticLaw::mooney_rivlin)
    return c.error("c20 is of the law mooney_rivlin", "Leave it out, or give -law mooney_rivlin", "c20");
  r.options.reference.push_back({material, region_of(c)});
  return {};
}

Result<void> set_tetrahedra(const Invocation& c, Reader& r) {
  TetrahedraModel& model = r.options.model;
  model.grid = three_integers(c, "grid");
  model.proportional = c.flag("proportional");
  model.relative_residual = c.number("residual");
  return {};
}

Result<void> set_layers(const Invocation& c, Reader& r) {
  r.face.model.nodes = three_integers(c, "grid");
  return {};
}

Result<void> set_guess(const Invocation& c, Reader& r) {
  SolidMaterial& guess = r.options.model.guess;
  guess.youngs_modulus_mpa = c.number("modulus");
  guess.poissons_ratio = c.number("poisson");
  guess.area_share = c.number("area_share");
  r.guess = true;
  return {};
}

FitMethod method_named(const std::string& word) {
  return commands::value_named(word, std::array{FitMethod::gauss_newton, FitMethod::gradient,
                                                FitMethod::cma_es, FitMethod::annealing});
}

Result<void> set_method(const Invocation& c, Reader& r) {
  FitOptions& fit = r.options.fit;
  fit.method = method_named(c.word("name"));
  fit.coarse_samples = static_cast<int>(c.integer("coarse"));
  fit.budget = static_cast<int>(c.integer("budget"));
  fit.chains = static_cast<int>(c.integer("chains"));
  fit.seed = static_cast<std::uint64_t>(c.integer("seed"));
  fit.regularisation = c.number("regularisation");
  return {};
}

Result<void> set_measure(const Invocation& c, Reader& r) {
  r.options.fit.measure = commands::value_named(
      c.word("what"), std::array{ErrorMeasure::distance, ErrorMeasure::shape, ErrorMeasure::force});
  return {};
}

Result<void> set_bounds(const Invocation& c, Reader& r) {
  if (!(c.number("low") < c.number("high")))
    return c.error("the bounds leave no room", "Give a low bound below the high one");
  r.options.model.low = r.face.model.low = c.number("low");
  r.options.model.high = r.face.model.high = c.number("high");
  return {};
}

const std::map<std::string_view, Setting>& settings() {
  using Kind = CalibrationForce::Kind;
  static const std::map<std::string_view, Setting> table{
      {"body surface", surface_body},
      {"body shape", shape_body},
      {"body box",
       [](const Invocation& c, Reader& r) {
         return set_body(c, r, BoxBody{c.box("box"), c.number("spacing")});
       }},
      {"body face", face_body},
      {"hold",
       [](const Invocation& c, Reader& r) -> Result<void> {
         r.options.held.push_back(region_of(c));
         return {};
       }},
      {"load", begin_load},
      {"force", force_of(Kind::force)},
      {"traction", force_of(Kind::traction)},
      {"pressure", force_of(Kind::pressure)},
      {"displace", force_of(Kind::displacement)},
      {"probe", set_probes},
      {"reference", add_reference},
      {"model tetrahedra", set_tetrahedra},
      {"model network", set_layers},
      {"guess", set_guess},
      {"bounds", set_bounds},
      {"measure", set_measure},
      {"method", set_method},
      {"view",
       [](const Invocation& c, Reader& r) -> Result<void> {
         r.options.seen_from = c.direction("from");
         return {};
       }},
  };
  return table;
}

Error missing(const Problem& problem, std::string what, std::string remedy) {
  return {ErrorKind::bad_input, std::move(what), problem.name, std::move(remedy)};
}

}  // namespace

std::string Problem::text() const {
  std::string out;
  for (const Invocation& c : commands) out += c.text() + "\n";
  return out;
}

Result<Problem> read_problem(const std::filesystem::path& path) {
  TURGOR_TRY(std::vector<Invocation> commands, parse_script(path, problem_commands()));
  return Problem{path.filename().string(), std::move(commands)};
}

Result<CalibrationOptions> calibration_options(const Problem& problem, Context& context) {
  CalibrationOptions options;
  Reader reader{options, false, false, context};
  for (const Invocation& c : problem.commands) {
    TURGOR_CHECK(context.check());
    if (c.name() == "model network" || (c.name() == "load" && c.given("plan")))
      return c.error("this is of a face only", "Begin the problem with: body face SCAN");
    TURGOR_CHECK(settings().at(c.name())(c, reader));
  }
  if (!reader.body)
    return missing(problem, "the problem has no body", "Say which: body box, shape or surface");
  if (options.reference.empty()) {
    return missing(problem, "the problem does not say what the body is made of",
                   "Add a line such as: reference -modulus 50kPa -poisson 0.45");
  }
  if (!reader.guess) {
    options.model.guess.youngs_modulus_mpa = options.reference.front().material.youngs_modulus_mpa;
    options.model.guess.poissons_ratio = 0.45;
  }
  return options;
}

bool is_face(const Problem& problem) {
  return std::ranges::any_of(problem.commands, [](const Invocation& c) { return c.name() == "body face"; });
}

Result<FaceProblem> face_problem(const Problem& problem, Context& context) {
  constexpr std::array known{"body face", "load", "model network", "reference", "bounds", "method"};
  CalibrationOptions options;
  Reader reader{options, false, false, context};
  // A search by derivatives from the network as it is.
  options.fit.coarse_samples = 0, options.fit.budget = 20, options.fit.regularisation = 1e-4;
  for (const Invocation& c : problem.commands) {
    TURGOR_CHECK(context.check());
    if (std::ranges::find(known, c.name()) == known.end())
      return c.error("a face does not take '" + std::string(c.name()) + "'",
                     "Its loads are plans: load NAME -plan PLAN");
    if (c.name() == "load" && !c.given("plan"))
      return c.error("a load of a face is a plan", "Write: load NAME -plan PLAN");
    TURGOR_CHECK(settings().at(c.name())(c, reader));
  }
  FaceProblem face = std::move(reader.face);
  if (std::ranges::all_of(face.loads, &FaceProblem::Load::held_out))
    return missing(problem, "there is no load to calibrate with",
                   "Add a line such as: load setback -plan PLAN");
  if (!options.reference.empty()) face.reference = options.reference.front().material;
  face.fit = options.fit;
  return face;
}

Result<FaceMoves> face_moves(const FaceProblem& problem, Context& context) {
  FaceMoves out;
  CaseOptions options;
  Plan all;  // settings are of the patient, and hold for every plan
  for (const FaceProblem::Load& load : problem.loads)
    all.commands.insert(all.commands.end(), load.plan.commands.begin(), load.plan.commands.end());
  apply_settings(all, problem.quality, options, out.solvers);
  if (problem.reference) out.solvers.cubes.material = *problem.reference;
  TURGOR_TRY(const PatientCase before, PatientCase::open(problem.scan, options, context));
  for (const FaceProblem::Load& load : problem.loads) {
    auto after = std::make_shared<PatientCase>(before);
    TURGOR_CHECK(apply_operations(load.plan, *after));
    auto reference = predict(*after, Solver::fem, out.solvers, context);
    if (!reference) {
      Error error = reference.error();
      if (error.kind != ErrorKind::cancelled) error.where = load.where;
      return error;
    }
    out.moves.push_back({load.name, load.held_out, std::move(after), *std::move(reference)});
  }
  return out;
}

void apply_search_flags(const Invocation& program, FitOptions& fit) {
  if (program.given("method")) fit.method = method_named(program.word("method"));
  if (program.given("budget")) fit.budget = static_cast<int>(program.integer("budget"));
  if (program.given("coarse")) fit.coarse_samples = static_cast<int>(program.integer("coarse"));
  if (program.given("chains")) fit.chains = static_cast<int>(program.integer("chains"));
  if (program.given("seed")) fit.seed = static_cast<std::uint64_t>(program.integer("seed"));
}

}  // namespace turgor
