// What the commands about objects do.
#include <fmt/format.h>

#include "session_state.hpp"
#include "turgor/core/file.hpp"
#include "turgor/world/flesh_objects.hpp"
#include "turgor/world/solid_objects.hpp"

namespace turgor::commands {
namespace {

Result<void> instance_object(SessionState& s, const Invocation& c) {
  TURGOR_TRY(Object object, load_object(c.word("file"), {s.options.search_paths}, s.context));
  if (c.given("name")) object.name = c.word("name");
  TURGOR_TRY([[maybe_unused]] const int id, s.scene.add_object(std::move(object)));
  return {};
}

Result<void> save_object(SessionState& s, const Invocation& c) {
  TURGOR_TRY(const int id, s.scene.require(c.word("object")));
  return write_file(c.path("file"), object_text(*s.scene.find(id)));
}

Result<void> edit_xform(SessionState& s, const Invocation& c) {
  TURGOR_TRY(const int id, s.scene.require(c.word("object")));
  const ObjectTransform& present = s.scene.find(id)->transform;
  ObjectTransform next;
  next.origin = c.given("origin") ? triple(c, "origin") : present.origin;
  if (c.given("s")) {
    const Vec3 scale = triple(c, "s");
    next.linear = Mat3{{Vec3{scale.x, 0, 0}, Vec3{0, scale.y, 0}, Vec3{0, 0, scale.z}}};
  }
  if (c.given("r")) next.linear = rotation_xyz(triple(c, "r")) * next.linear;
  if (c.given("t")) next.translation = triple(c, "t");
  if (c.flag("relative")) {
    next.linear = next.linear * present.linear;
    next.translation += present.translation;
  }
  bool sound = is_within_reach(next.translation) && is_within_reach(next.origin);
  for (const Vec3& column : next.linear.c) sound = sound && is_within_reach(column);
  if (!sound) return c.error("the transform is out of range", "Give smaller numbers");
  s.scene.set_transform(id, next);
  return {};
}

Result<void> harden_object(SessionState& s, const Invocation& c) {
  TURGOR_TRY(const int id, s.scene.require(c.word("object")));
  return s.scene.harden(id);
}

Result<void> colors(SessionState& s, const Invocation& c) {
  TURGOR_TRY(const int id, s.scene.require(c.word("object")));
  Optics optics = s.scene.find(id)->optics;
  if (c.flag("faceted")) optics.shading = Shading::faceted, optics.curved = false;
  if (c.flag("smooth")) optics.shading = Shading::smooth;
  if (c.flag("curved")) optics.curved = true;
  if (c.flag("flat")) optics.curved = false;
  if (c.given("diff")) optics.diffuse = colour_triple(c, "diff");
  if (c.given("high")) optics.highlight = colour_triple(c, "high");
  if (c.given("spec")) optics.specular = c.number("spec");
  if (c.given("wire")) optics.wire = colour_triple(c, "wire");
  if (c.flag("no_wire")) optics.wire.reset();
  if (c.given("line_width")) optics.line_width = c.number("line_width");
  if (c.given("opacity")) optics.opacity = c.number("opacity");
  s.scene.set_optics(id, optics);
  return {};
}

Result<void> visible(SessionState& s, const Invocation& c) {
  TURGOR_TRY(const int id, s.scene.require(c.word("object")));
  const bool present = s.scene.find(id)->visible;
  s.scene.set_visible(id, c.flag("on") || (!c.flag("off") && !present));
  return update_solid_objects(s.scene);  // those hidden so far have old shapes
}

Result<void> triangulate(SessionState& s, const Invocation& c) {
  TURGOR_TRY(const int id, s.scene.require(c.word("object")));
  s.scene.set_triangulated(id, true);
  return {};
}

Result<void> delete_object(SessionState& s, const Invocation& c) {
  TURGOR_TRY([[maybe_unused]] const int id, s.scene.require(c.word("object")));
  if (is_drawing(s.scene.specimen, c.word("object"))) {
    return c.error(fmt::format("'{}' is drawn as long as there is what it shows", c.word("object")),
                   "Hide it: visible NAME -off");
  }
  s.scene.remove_object(c.word("object"));
  return update_collisions(s.scene);
}

// ---- list ----

void list_objects(const SessionState& s) {
  for (const auto& [id, object] : s.scene.objects()) {
    const Box3 box = world_box(object);
    s.say(fmt::format("{:<28} {:<10} {} [{:.4g} {:.4g} {:.4g}, {:.4g} {:.4g} {:.4g}]", object.name,
                      name_of(object.kind()), object.visible ? "shown " : "hidden", box.lower.x, box.lower.y,
                      box.lower.z, box.upper.x, box.upper.y, box.upper.z));
  }
}

void list_tissue(const SessionState& s) {
  for (const FleshMeasures& m : measure(s.scene.specimen)) {
    s.say(fmt::format(
        "{}: {} samples, {} springs, {} prisms ({} inverted), thickness {:.4g} ({:.4g} to {:.4g})", m.name,
        m.samples, m.springs, m.prisms, m.inverted, m.thickness, m.least_thickness, m.greatest_thickness));
    if (m.rest_opening > 0)
      s.say(fmt::format("  opening {:.4g} of {:.4g} at rest", m.opening, m.rest_opening));
    for (const auto& ear : m.dog_ears)
      s.say(fmt::format("  dog-ear {:.4g} high at ({:.4g} {:.4g} {:.4g})", ear.height, ear.at.x, ear.at.y,
                        ear.at.z));
  }
}

void list_solids(const SessionState& s) {
  for (const SolidMeasures& m : measure_solids(s.scene.specimen)) {
    s.say(fmt::format("{}: {} points ({} held), {} tetrahedra ({} inverted), volume {:.6g} of {:.6g}", m.name,
                      m.points, m.fixed, m.tetrahedra, m.inverted, m.volume, m.rest_volume));
  }
}

void list_grabs(const SessionState& s) {
  for (const NamedGrab& grab : s.scene.specimen.grabs()) {
    const Vec3 force = s.scene.specimen.force_of(grab);
    s.say(fmt::format("{:<16} {} samples of {}, force {:.4g} ({:.4g} {:.4g} {:.4g})", grab.name,
                      grab.samples.size(),
                      s.scene.specimen.bodies()[static_cast<std::size_t>(grab.body)].name, length(force),
                      force.x, force.y, force.z));
  }
}

void list_muscles(const SessionState& s) {
  for (const Muscle& muscle : s.scene.specimen.muscles()) {
    for (const Fibre& fibre : muscle.fibres) {
      s.say(fmt::format("{:<16} length {:.4g} of {:.4g}, rest scale {:.4g}, tension {:.4g}", muscle.name,
                        s.scene.specimen.length(fibre), fibre.original_length, fibre.scale,
                        s.scene.specimen.tension(fibre)));
    }
  }
}

Result<void> list(SessionState& s, const Invocation& c) {
  const std::string& what = c.word("what");
  if (what == "objects") list_objects(s);
  if (what == "tissue") list_tissue(s), list_solids(s);
  if (what == "grabs") list_grabs(s);
  if (what == "muscles") list_muscles(s);
  if (what == "constraints") {
    for (const Constraint& k : s.scene.constraints.constraints())
      s.say(fmt::format("{:<16} {}", k.name, k.arguments));
  }
  if (what == "worlds") {
    for (const World& w : s.scene.worlds) {
      std::string line = w.name + (w.name == s.scene.current_world ? " (current):" : ":");
      for (const std::string& name : w.objects) line += ' ' + name;
      s.say(line);
    }
  }
  if (what == "viewports") {
    for (const Viewport& v : s.scene.screen.viewports) {
      s.say(fmt::format("{:<16} [{} {} {} {}] camera {}, world {}, {}{}", v.name, v.left, v.bottom, v.right,
                        v.top, v.camera, v.world, v.style == DrawStyle::wire ? "wire" : "shaded",
                        v.stereo ? ", stereo" : ""));
    }
  }
  return {};
}

}  // namespace

std::span<const NamedHandler> object_handlers() {
  static constexpr NamedHandler table[] = {{"instance_object", instance_object},
                                           {"save_object", save_object},
                                           {"edit_xform", edit_xform},
                                           {"harden", harden_object},
                                           {"colors", colors},
                                           {"visible", visible},
                                           {"triangulate", triangulate},
                                           {"delete_object", delete_object},
                                           {"list", list}};
  return table;
}

}  // namespace turgor::commands
