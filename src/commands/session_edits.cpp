// What the commands do that edit tissue region by region (Pieper 1989, section 6.2).
#include <fmt/format.h>

#include "session_state.hpp"
#include "turgor/world/flesh_objects.hpp"

namespace turgor::commands {
namespace {

Result<void> told(const SessionState& s, const Invocation& c, const Result<int>& changed, const char* what) {
  if (!changed) return changed.error();
  if (*changed == 0)
    s.context.notice(fmt::format("{}: nothing lies in the region: no effect", c.place().text()));
  s.say(fmt::format("{} {}", *changed, what));
  return {};
}

Result<void> grow(SessionState& s, const Invocation& c) {
  TURGOR_TRY(const Region region, region_of(s.scene, c));
  return told(s, c, s.scene.specimen.scale_growth(c.word("flesh"), region, c.number("by")), "samples");
}
Result<void> shrink(SessionState& s, const Invocation& c) {
  TURGOR_TRY(const Region region, region_of(s.scene, c));
  return told(s, c, s.scene.specimen.scale_growth(c.word("flesh"), region, 1 / c.number("by")), "samples");
}
Result<void> stiffen(SessionState& s, const Invocation& c) {
  TURGOR_TRY(const Region region, region_of(s.scene, c));
  return told(s, c, s.scene.specimen.scale_stiffness(c.word("tissue"), region, c.number("by")), "samples");
}
Result<void> remove(SessionState& s, const Invocation& c) {
  TURGOR_TRY(const Region region, region_of(s.scene, c));
  return told(s, c, s.scene.specimen.remove(c.word("flesh"), region), "columns");
}
Result<void> fix(SessionState& s, const Invocation& c) {
  TURGOR_TRY(const Region region, region_of(s.scene, c));
  return told(s, c, s.scene.specimen.set_mobile(c.word("tissue"), region, c.flag("free")), "samples");
}
Result<void> volume(SessionState& s, const Invocation& c) {
  const double modulus = c.number("modulus"),
               guard = c.given("guard") ? c.number("guard") : kGuardShare * modulus;
  return told(s, c, s.scene.specimen.set_volume(c.word("flesh"), modulus, guard), "polygons");
}
Result<std::vector<Vec3>> langer_of(const Invocation& c) {
  if (!c.given("langer_map")) return std::vector{triple(c, "langer")};
  TURGOR_TRY(const std::vector<double> n, read_numbers(c.word("langer_map")));
  if (n.size() % 3 != 0)
    return c.error("the map holds no triples of numbers", "Give three for each vertex", "langer_map");
  std::vector<Vec3> lines;
  for (std::size_t i = 0; i < n.size(); i += 3) lines.push_back({n[i], n[i + 1], n[i + 2]});
  return lines;
}

Result<void> skin(SessionState& s, const Invocation& c) {
  SkinLayer skin;
  skin.collagen = c.number("collagen");
  skin.transition_along = c.number("transition");
  skin.transition_across = c.number("transition_across");
  skin.anisotropy = c.number("anisotropy");
  skin.rest_strain = c.number("rest_strain");
  TURGOR_TRY(skin.langer, langer_of(c));
  const std::vector<double> pairs = c.numbers("relaxation");
  if (pairs.size() % 2 != 0)
    return c.error("the last share has no time", "Give pairs of share and time", "relaxation");
  for (std::size_t i = 0; i < pairs.size(); i += 2) skin.relaxation.at(i / 2) = {pairs[i], pairs[i + 1]};
  return s.scene.specimen.set_skin(c.word("flesh"), std::move(skin));
}

Result<void> refine(SessionState& s, const Invocation& c) {
  std::optional<RefinementOptions> options;
  if (!c.flag("off")) {
    options = RefinementOptions{c.number("above"), c.number("below"), static_cast<int>(c.integer("levels"))};
  }
  const auto changed = s.scene.specimen.refine(c.word("flesh"), options);
  if (!changed) return changed.error();
  return {};
}

}  // namespace

Result<Region> region_of(const Scene& scene, const Invocation& c) {
  Region region;
  if (c.given("inside")) {
    TURGOR_TRY(const int object, scene.require(c.word("inside")));
    TURGOR_TRY(const Barrier closed, barrier_of(scene, object, RegionShape::mesh));
    region.inside = closed.mesh;
  }
  if (c.given("box")) region.box = c.box("box");
  if (c.given("sphere")) {
    const Sphere sphere = c.sphere("sphere");
    region.centre = sphere.centre;
    region.radius = sphere.radius;
  }
  region.layer = static_cast<int>(c.integer("layer"));
  return region;
}

std::span<const NamedHandler> edit_handlers() {
  static constexpr NamedHandler table[] = {{"grow", grow},     {"shrink", shrink}, {"stiffen", stiffen},
                                           {"remove", remove}, {"fix", fix},       {"volume", volume},
                                           {"refine", refine}, {"make_skin", skin}};
  return table;
}

}  // namespace turgor::commands
