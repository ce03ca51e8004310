// What the constraints between objects have in common. Internal to the scene.
#pragma once

#include "turgor/world/scene.hpp"

namespace turgor {

inline Node object_node(int id) {
  return {Node::Kind::object, id};
}
/// The id must exist. Errors: a transform that is not finite.
Result<void> move_object(Scene& scene, int id, const ObjectTransform& transform);
/// Serves the constraint once, then adds it; its error where that fails.
Result<std::string> add_served(Scene& scene, Constraint constraint);

}  // namespace turgor
