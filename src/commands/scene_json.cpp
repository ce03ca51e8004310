// What a scene has come to, as JSON.
#include <nlohmann/json.hpp>

#include "turgor/commands/session.hpp"
#include "turgor/world/flesh_objects.hpp"
#include "turgor/world/solid_objects.hpp"

namespace turgor {
namespace {

using nlohmann::json;

json triple(const Vec3& v) {
  return {v.x, v.y, v.z};
}

json tissue(const Specimen& specimen) {
  json all = json::array();
  for (const FleshMeasures& m : measure(specimen)) {
    json out{{"name", m.name},
             {"samples", m.samples},
             {"springs", m.springs},
             {"prisms", m.prisms},
             {"inverted_prisms", m.inverted},
             {"thickness",
              {{"mean", m.thickness}, {"least", m.least_thickness}, {"greatest", m.greatest_thickness}}},
             {"skin_box", {triple(m.skin_box.lower), triple(m.skin_box.upper)}},
             {"rise", {{"height", m.rise}, {"at", triple(m.rise_at)}}},
             {"greatest_speed", m.greatest_speed}};
    if (m.rest_opening > 0) out["opening"] = {{"area", m.opening}, {"at_rest", m.rest_opening}};
    for (const auto& ear : m.dog_ears) {
      out["dog_ears"].push_back({{"end", triple(ear.end)}, {"height", ear.height}, {"at", triple(ear.at)}});
    }
    all.push_back(std::move(out));
  }
  return all;
}

json solids(const Specimen& specimen) {
  json all = json::array();
  for (const SolidMeasures& m : measure_solids(specimen)) {
    all.push_back({{"name", m.name},
                   {"points", m.points},
                   {"held_points", m.fixed},
                   {"tetrahedra", m.tetrahedra},
                   {"inverted_tetrahedra", m.inverted},
                   {"volume", m.volume},
                   {"rest_volume", m.rest_volume},
                   {"box", {triple(m.box.lower), triple(m.box.upper)}},
                   {"greatest_displacement", m.greatest_displacement},
                   {"greatest_speed", m.greatest_speed}});
  }
  return all;
}

json grabs(const Specimen& specimen) {
  json all = json::array();
  for (const NamedGrab& grab : specimen.grabs()) {
    const Vec3 force = specimen.force_of(grab);
    all.push_back({{"name", grab.name}, {"force", length(force)}, {"direction", triple(normalized(force))}});
  }
  return all;
}

json contacts(const Specimen& specimen) {
  std::vector<std::string> names;
  for (const TissueBody& body : specimen.bodies()) {
    if (body.solid) names.push_back(body.name);
  }
  json all = json::array();
  const ContactMeasures measures = specimen.contact_measures();
  for (const auto& pair : measures.pairs) {
    all.push_back(
        {{"between", {names[static_cast<std::size_t>(pair.a)], names[static_cast<std::size_t>(pair.b)]}},
         {"points", pair.contacts},
         {"force", pair.normal_n}});
  }
  return {{"pairs", std::move(all)}, {"greatest_depth", measures.deepest_mm}};
}

json muscles(const Specimen& specimen) {
  json all = json::array();
  for (const Muscle& muscle : specimen.muscles()) {
    json fibres = json::array();
    for (const Fibre& f : muscle.fibres) {
      fibres.push_back({{"length", specimen.length(f)},
                        {"original_length", f.original_length},
                        {"scale", f.scale},
                        {"tension", specimen.tension(f)}});
    }
    all.push_back({{"name", muscle.name}, {"fibres", std::move(fibres)}});
  }
  return all;
}

json collisions(const Scene& scene) {
  json all = json::array();
  for (const Penetration& p : penetrations(scene.specimen)) {
    const Object* object = scene.find(p.object);
    json out{{"object", object == nullptr ? "" : object->name}, {"greatest_depth", p.depth}};
    if (p.radius > 0) out["radius"] = p.radius;
    all.push_back(std::move(out));
  }
  return all;
}

}  // namespace

std::string scene_json(const Scene& scene) {
  const json out{{"time", scene.time},
                 {"frames", scene.frame},
                 {"springs", scene.specimen.spring_count()},
                 {"tissue", tissue(scene.specimen)},
                 {"solids", solids(scene.specimen)},
                 {"grabs", grabs(scene.specimen)},
                 {"contact", contacts(scene.specimen)},
                 {"muscles", muscles(scene.specimen)},
                 {"collisions", collisions(scene)}};
  return out.dump(2);
}

}  // namespace turgor
