// What the commands about solids do.
#include <fmt/format.h>

#include <algorithm>

#include "session_state.hpp"
#include "turgor/world/flesh_objects.hpp"
#include "turgor/world/object_constraints.hpp"
#include "turgor/world/solid_objects.hpp"

namespace turgor::commands {
namespace {

Result<void> voxelize(SessionState& s, const Invocation& c) {
  SolidOptions options;
  options.voxels.resolution = static_cast<int>(c.integer("resolution"));
  options.voxels.border = !c.flag("no_border");
  if (c.word("fill") == "winding") options.voxels.fill = VoxelOptions::Fill::winding;
  options.material.youngs_modulus_mpa = c.number("young");
  options.material.poissons_ratio = c.number("poisson");
  options.material.density_g_mm3 = c.number("density");
  if (c.word("skin") == "barycentric") options.binding = SkinBinding::barycentric;
  options.neighbours = static_cast<int>(c.integer("neighbours"));
  return voxelize_object(s.scene, c.word("object"), options, s.context);
}

Result<void> constants(SessionState& s, const Invocation& c) {
  const std::string& name = c.word("solid");
  const int body = s.scene.specimen.body_number(name);
  const auto& bodies = s.scene.specimen.bodies();
  if (body < 0 || !bodies[static_cast<std::size_t>(body)].solid)
    return c.error(fmt::format("there is no solid '{}'", name), "Make it with voxelize", "solid");
  const Solid& elements = bodies[static_cast<std::size_t>(body)].solid->elements;
  auto read = read_solid_constants(c.path("file"), elements);
  if (!read) return c.error(read.error().where + ": " + read.error().what, read.error().remedy, "file");
  TURGOR_CHECK(s.scene.specimen.set_solid_constants(name, *std::move(read)));
  s.say(fmt::format("{}: constants of {} edges, {} triangles and {} tetrahedra", name, elements.edges.size(),
                    elements.triangles.size(), elements.tetrahedra.size()));
  return {};
}

Result<void> tie(SessionState& s, const Invocation& c) {
  TURGOR_TRY(const Region region, region_of(s.scene, c));
  TURGOR_TRY(const int object, s.scene.require(c.word("object")));
  TURGOR_TRY(const int held, s.scene.specimen.attach(c.word("tissue"), region, object, s.scene.pose(object)));
  if (held == 0) s.context.notice(fmt::format("{}: nothing lies in the region: no effect", c.place().text()));
  s.say(fmt::format("{} samples move with {}", held, c.word("object")));
  return {};
}

Result<void> move_by(SessionState& s, const Invocation& c) {
  MoveBy move;
  move.shift = triple(c, "by");
  move.angle_deg = c.number("turn");
  move.axis = triple(c, "axis");
  if (c.given("about")) move.about = triple(c, "about");
  move.frames = static_cast<int>(c.integer("frames"));
  const auto name = add_object_move(s.scene, c.word("object"), move);
  if (!name) return name.error();
  s.say(*name);
  return {};
}

// ---- grabs ----

// The nearest sample of any tissue, and all of its body within the radius.
Result<NamedGrab> take_hold(const SessionState& s, const Invocation& c) {
  const Specimen& specimen = s.scene.specimen;
  const Vec3 at = triple(c, "at");
  TURGOR_TRY(const SampleRef nearest, specimen.nearest_sample(at));
  NamedGrab grab;
  grab.name = c.word("grab");
  grab.body = nearest.body;
  grab.samples.push_back(nearest.number);
  const TissueBody& body = specimen.bodies()[static_cast<std::size_t>(nearest.body)];
  for (int i = 0; i < body.count; ++i) {
    if (i != nearest.number && distance(specimen.position({nearest.body, i}), at) <= c.number("radius"))
      grab.samples.push_back(i);
  }
  for (const int i : grab.samples)
    grab.target += specimen.position({nearest.body, i}) / static_cast<double>(grab.samples.size());
  return grab;
}

Result<void> grab(SessionState& s, const Invocation& c) {
  const auto& grabs = s.scene.specimen.grabs();
  const auto found =
      std::find_if(grabs.begin(), grabs.end(), [&](const NamedGrab& g) { return g.name == c.word("grab"); });
  if (!c.given("at") && found == grabs.end())
    return c.error(fmt::format("there is no grab '{}' yet", c.word("grab")), "Say where it takes hold", "at");
  NamedGrab next;
  if (c.given("at")) {
    TURGOR_TRY(next, take_hold(s, c));
  } else {
    next = *found;
  }
  if (c.given("to")) next.target = triple(c, "to"), next.object.reset();
  if (c.given("c")) next.stiffness = c.number("c");
  if (c.given("limit")) next.limit = c.number("limit");
  if (c.given("with")) {
    TURGOR_TRY(next.object, s.scene.require(c.word("with")));
    TURGOR_TRY(next.place, place_in_frame(s.scene, *next.object, next.target));
  }
  return s.scene.specimen.set_grab(std::move(next));
}

Result<void> let_go(SessionState& s, const Invocation& c) {
  return s.scene.specimen.release(c.word("grab"));
}

Result<void> contact(SessionState& s, const Invocation& c) {
  if (c.flag("off")) return s.scene.specimen.set_contact(std::nullopt);
  return s.scene.specimen.set_contact(
      SolidContactOptions{c.number("thickness"), c.number("c"), c.number("friction"), !c.flag("no_self")});
}

Result<void> remesh(SessionState& s, const Invocation& c) {
  const auto same = [&](const RemeshTask& task) { return task.solid == c.word("solid"); };
  if (std::any_of(s.remeshing.begin(), s.remeshing.end(), same))
    return c.error(fmt::format("'{}' is being remeshed", c.word("solid")), "Wait until it is done", "solid");
  TURGOR_TRY(RemeshTask task,
             start_remesh(s.scene, c.word("solid"), static_cast<int>(c.integer("resolution")),
                          static_cast<int>(c.integer("frames"))));
  if (c.integer("frames") == 0) return finish_remesh(s.scene, task);
  s.remeshing.push_back(std::move(task));
  return {};
}

Result<void> settle(SessionState& s, const Invocation& c) {
  if (s.simulation) return c.error("a simulation runs", "Wait for its end, or interrupt it");
  EquilibriumOptions options;
  options.relative_residual = c.number("residual");
  options.max_newton_steps = static_cast<int>(c.integer("steps"));
  TURGOR_CHECK(update_collisions(s.scene));
  update_holds(s.scene, 0);
  TURGOR_TRY(const EquilibriumResult result, s.scene.specimen.settle(s.scene.time, options, s.context));
  for (int handle = 0; handle < s.scene.specimen.handle_count(); ++handle)
    s.scene.constraints.notify({Node::Kind::sample, handle});
  s.say(fmt::format("at rest after {} Newton steps; {:.3g} of the forces is left", result.newton_steps,
                    result.relative_residual));
  return {};
}

}  // namespace

std::span<const NamedHandler> solid_handlers() {
  static constexpr NamedHandler table[] = {
      {"voxelize", voxelize}, {"constants", constants}, {"tie", tie},
      {"mv_obj_by", move_by}, {"grab", grab},           {"let_go", let_go},
      {"contact", contact},   {"settle", settle},       {"remesh", remesh}};
  return table;
}

}  // namespace turgor::commands
