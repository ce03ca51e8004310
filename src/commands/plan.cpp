#include "turgor/commands/plan.hpp"

#include <functional>
#include <map>
#include <string_view>

#include "turgor/surgery/operations.hpp"
#include "values.hpp"

namespace turgor {
namespace {

// ---- settings ----

struct Settings {
  CaseOptions& patient;
  SolverOptions& solvers;
};
using Setting = std::function<void(const Invocation&, Settings&)>;

std::size_t layer_number(const std::string& name) {
  return name == "skin" ? 0 : name == "smas" ? 1 : 2;
}

void set_material(const Invocation& c, TissueMaterial& material) {
  const std::size_t layer = layer_number(c.word("layer"));
  if (c.given("modulus")) material.young_mpa.at(layer) = c.number("modulus");
  if (!c.given("law")) return;
  material.laws.resize(3, material.laws.back());
  material.laws[layer] = commands::law_named(c.word("law"));
}

void set_chain(const Invocation& c, ChainParameters& chain) {
  if (c.given("alpha")) chain.alpha = c.number("alpha");
  if (c.given("column_alpha")) chain.column_alpha = c.number("column_alpha");
  if (c.given("beta")) chain.beta = c.number("beta");
  if (c.given("max_stretch")) chain.max_stretch = c.number("max_stretch");
  if (c.given("max_compression")) chain.max_compression = c.number("max_compression");
  if (c.given("semi_active_passes"))
    chain.semi_active_passes = static_cast<int>(c.integer("semi_active_passes"));
  if (c.given("fixed_points")) {
    chain.fixed_points = c.word("fixed_points") == "hold" ? FixedPoints::hold : FixedPoints::inert;
  }
}

void set_network(const Invocation& c, EquilibriumOptions& equilibrium, TissueMaterial& material) {
  if (c.given("residual")) equilibrium.relative_residual = c.number("residual");
  if (c.given("max_steps")) equilibrium.max_newton_steps = static_cast<int>(c.integer("max_steps"));
  if (c.given("load_steps")) equilibrium.load_steps = static_cast<int>(c.integer("load_steps"));
  if (c.given("poisson")) material.poisson = c.number("poisson");
}

void set_cubes(const Invocation& c, CubeOptions& cubes) {
  ElasticMaterial& material = cubes.material;
  if (c.given("spacing")) cubes.spacing_mm = c.number("spacing");
  if (c.given("modulus")) material.youngs_modulus_mpa = c.number("modulus");
  if (c.given("c20")) material.c20_mpa = c.number("c20");
  if (c.given("poisson")) material.poissons_ratio = c.number("poisson");
  if (c.given("residual")) cubes.relative_residual = c.number("residual");
  if (c.given("law")) material.law = commands::value_named(c.word("law"), kElasticLaws);
}

void set_surfaces(const Invocation& c, HeadOptions& head) {
  if (c.given("skin")) head.skin_triangles = static_cast<int>(c.integer("skin"));
  if (c.given("bone")) head.bone_triangles = static_cast<int>(c.integer("bone"));
  if (c.given("smoothing")) head.smoothing = c.number("smoothing");
}

void set_layers(const Invocation& c, TissueOptions& tissue) {
  tissue.thickness_mm = c.numbers("thickness");
  if (c.given("fractions")) tissue.fractions = c.numbers("fractions");
}

void set_vestibule(const Invocation& c, CaseOptions& patient) {
  if (c.given("distance")) patient.tissue.release_near_teeth_mm = c.number("distance");
  if (c.given("adhesion")) patient.contact.adhesion_n_mm = c.number("adhesion");
}

const std::map<std::string_view, Setting>& settings() {
  static const std::map<std::string_view, Setting> table{
      {"landmark",
       [](const Invocation& c, Settings& s) {
         s.patient.landmark_corrections.emplace_back(c.word("name"), c.point("point"));
       }},
      {"bone_threshold",
       [](const Invocation& c, Settings& s) {
         s.patient.head.bone_threshold_hu = static_cast<int>(c.number("level"));
         s.patient.head.refine_bone_threshold = !c.flag("fixed");
       }},
      {"surfaces", [](const Invocation& c, Settings& s) { set_surfaces(c, s.patient.head); }},
      {"occlusal_plane",
       [](const Invocation& c, Settings& s) { s.patient.head.occlusal_plane = c.plane("plane"); }},
      {"midsagittal_plane",
       [](const Invocation& c, Settings& s) { s.patient.midsagittal = c.plane("plane"); }},
      {"centre",
       [](const Invocation& c, Settings& s) {
         auto& tissue = s.patient.tissue;
         (c.word("which") == "upper" ? tissue.upper_centre : tissue.lower_centre) = c.point("point");
       }},
      {"lip_level", [](const Invocation& c, Settings& s) { s.patient.tissue.lip_level_mm = c.number("z"); }},
      {"bone_level",
       [](const Invocation& c, Settings& s) { s.patient.tissue.bone_level_mm = c.number("z"); }},
      {"layers", [](const Invocation& c, Settings& s) { set_layers(c, s.patient.tissue); }},
      {"tissue_points", [](const Invocation& c,
                           Settings& s) { s.patient.tissue.columns = static_cast<int>(c.integer("count")); }},
      {"undermining",
       [](const Invocation& c, Settings& s) { s.patient.contact.undermining_mm = c.number("distance"); }},
      {"vestibule", [](const Invocation& c, Settings& s) { set_vestibule(c, s.patient); }},
      {"material", [](const Invocation& c, Settings& s) { set_material(c, s.patient.material); }},
      {"solver chain", [](const Invocation& c, Settings& s) { set_chain(c, s.solvers.chain); }},
      {"solver network",
       [](const Invocation& c, Settings& s) { set_network(c, s.solvers.equilibrium, s.patient.material); }},
      {"solver fem", [](const Invocation& c, Settings& s) { set_cubes(c, s.solvers.cubes); }},
  };
  return table;
}

// ---- operations ----

using Operation = std::function<Result<void>(const Invocation&, PatientCase&)>;

SegmentMove segment_move(const Invocation& c, std::string_view left = "left") {
  const auto number = [&](std::string_view name) {
    return c.command().find(name) != nullptr && c.given(name) ? c.number(name) : 0.0;
  };
  return {number("forward"),       number("up"),          number(left), radians(number("pitch")),
          radians(number("roll")), radians(number("yaw"))};
}

Patient patient_of(const PatientCase& patient) {
  return {patient.head(), patient.landmarks()};
}

Result<void> cut(const Invocation& c, PatientCase& patient) {
  CutRegion region;
  for (const Argument& plane : c.all("plane")) region.planes.push_back(to_plane(plane));
  if (c.given("box")) region.add_box(c.box("box"));
  return patient.bones().osteotomy(c.word("segment"), c.word("of"), region);
}

Result<void> turn(const Invocation& c, PatientCase& patient) {
  const std::string& name = c.word("segment");
  if (c.given("axis")) {
    const Axis axis = c.axis("axis");
    return patient.bones().move(
        name, RigidTransform::rotate_about(axis.point, axis.direction, radians(c.number("angle"))));
  }
  const int i = patient.bones().find(name);
  Vec3 pivot{};
  if (i >= 0) {
    const BoneSegment& s = patient.bones().segments()[static_cast<std::size_t>(i)];
    pivot = s.motion.point(bounds(s.surface).centre());
  }
  if (c.given("about")) pivot = c.point("about");
  return patient.bones().move(name, to_transform(segment_move(c), patient_axes(patient.head()), pivot));
}

Result<void> attachment(const Invocation& c, PatientCase& patient, bool attach) {
  AttachmentEdit edit{attach, c.word("bone"), {}, {}};
  if (c.given("box")) edit.box = c.box("box");
  if (c.given("sphere")) {
    const Sphere sphere = c.sphere("sphere");
    edit.ball = {sphere.centre, sphere.radius};
  }
  return patient.edit_attachment(edit);
}

Result<void> cheekbone(const Invocation& c, PatientCase& patient) {
  const Side side = c.word("side") == "left" ? Side::left : Side::right;
  return zygoma(patient.bones(), patient_of(patient), side, segment_move(c, "out"));
}

const std::map<std::string_view, Operation>& operations() {
  static const std::map<std::string_view, Operation> table{
      {"osteotomy", cut},
      {"move",
       [](const Invocation& c, PatientCase& p) {
         return p.bones().move(c.word("segment"), RigidTransform::translate(c.offset("by")));
       }},
      {"rotate", turn},
      {"attach", [](const Invocation& c, PatientCase& p) { return attachment(c, p, true); }},
      {"release", [](const Invocation& c, PatientCase& p) { return attachment(c, p, false); }},
      {"open_mouth",
       [](const Invocation& c, PatientCase& p) {
         return open_mouth(p.bones(), patient_of(p), radians(c.number("angle")));
       }},
      {"setback",
       [](const Invocation& c, PatientCase& p) {
         return sagittal_split(p.bones(), patient_of(p), -c.number("amount"));
       }},
      {"advance",
       [](const Invocation& c, PatientCase& p) {
         return sagittal_split(p.bones(), patient_of(p), c.number("amount"));
       }},
      {"genioplasty", [](const Invocation& c,
                         PatientCase& p) { return genioplasty(p.bones(), patient_of(p), segment_move(c)); }},
      {"le_fort_1", [](const Invocation& c,
                       PatientCase& p) { return le_fort_1(p.bones(), patient_of(p), segment_move(c)); }},
      {"le_fort_2", [](const Invocation& c,
                       PatientCase& p) { return le_fort_2(p.bones(), patient_of(p), segment_move(c)); }},
      {"le_fort_3", [](const Invocation& c,
                       PatientCase& p) { return le_fort_3(p.bones(), patient_of(p), segment_move(c)); }},
      {"zygoma", cheekbone},
  };
  return table;
}

// The command's place, unless the error already has a better one.
Error placed(Error error, const Invocation& command) {
  if (error.where.empty()) error.where = command.place().text();
  return error;
}

}  // namespace

std::string Plan::text() const {
  std::string out;
  for (const Invocation& c : commands) out += c.text() + "\n";
  return out;
}

Result<Plan> read_plan(const std::filesystem::path& path) {
  TURGOR_TRY(std::vector<Invocation> commands, parse_script(path, plan_commands()));
  return Plan{path.filename().string(), std::move(commands)};
}

void apply_settings(const Plan& plan, Quality quality, CaseOptions& options, SolverOptions& solvers) {
  if (quality == Quality::draft) {
    options.head.skin_triangles = 25'000;
    options.head.bone_triangles = 40'000;
    options.tissue.columns = 1400;
    solvers.cubes.spacing_mm = 3.0;
  } else if (quality == Quality::fine) {
    options.head.skin_triangles = 150'000;
    options.head.bone_triangles = 250'000;
    options.tissue.columns = 6000;
    solvers.cubes.spacing_mm = 1.5;
  }
  Settings s{options, solvers};
  for (const Invocation& c : plan.commands) {
    const auto found = settings().find(c.name());
    if (found != settings().end()) found->second(c, s);
  }
}

void apply_solver_flags(const Invocation& program, CaseOptions& options, SolverOptions& solvers) {
  set_chain(program, solvers.chain);
  set_network(program, solvers.equilibrium, options.material);
}

Result<void> apply_operations(const Plan& plan, PatientCase& patient) {
  for (const Invocation& c : plan.commands) {
    const auto found = operations().find(c.name());
    if (found == operations().end()) continue;
    if (auto done = found->second(c, patient); !done) return placed(done.error(), c);
  }
  return {};
}

}  // namespace turgor
