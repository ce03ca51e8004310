// What a scene has come to, as JSON.
#include <nlohmann/json.hpp>

#include "turgor/commands/session.hpp"
#include "turgor/world/flesh_objects.hpp"

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
                 {"muscles", muscles(scene.specimen)},
                 {"collisions", collisions(scene)}};
  return out.dump(2);
}

}  // namespace turgor
