// Objects that show tissue: made once, given a new shape afterwards. Internal to the scene.
#pragma once

#include <string>
#include <utility>

#include "turgor/world/scene.hpp"

namespace turgor {

/// Of the surface that a solid carries, and of that of its tetrahedra.
inline std::string skin_drawing_of_solid(const std::string& solid) {
  return "skin.solid." + solid;
}
inline std::string mesh_drawing_of_solid(const std::string& solid) {
  return "mesh.solid." + solid;
}

/// A new shape for the object of that name; where there is none it is made, with these looks.
inline Result<void> show_drawing(Scene& scene, const std::string& name, Polyhedron shape,
                                 const Optics& optics) {
  const int id = scene.id_of(name);
  if (id >= 0) {
    scene.set_description(id, std::move(shape));
    return {};
  }
  Object object;
  object.name = name;
  object.description = std::move(shape);
  object.optics = optics;
  TURGOR_TRY([[maybe_unused]] const int added, scene.add_object(std::move(object)));
  return {};
}

}  // namespace turgor
