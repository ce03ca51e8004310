// A scene: objects, worlds, viewports, constraints and tissue, and the frame that moves them
// (Pieper 1989, sections 4.2 to 4.4).
#pragma once

#include <map>
#include <string>
#include <vector>

#include "turgor/world/constraint_network.hpp"
#include "turgor/world/object.hpp"
#include "turgor/world/specimen.hpp"
#include "turgor/world/viewport.hpp"

namespace turgor {

/// Objects are known by name to people and by an id, never used twice, to constraints. Everything that moves
/// or reshapes an object goes through the setters, which notify the constraint network.
struct Scene {
  Scene();  ///< one world "main", one viewport "main" over the whole screen, one camera "camera" in it

  /// Posts it in the current world. Errors: the name is taken, empty or holds blanks, quotes or ';'; an
  /// invalid object; no current world.
  Result<int> add_object(Object object);
  /// Takes it from all worlds, with the constraints that depend on it or change it. False where there is
  /// none.
  bool remove_object(const std::string& name);
  [[nodiscard]] int id_of(const std::string& name) const;  ///< -1 where there is none
  [[nodiscard]] const Object* find(const std::string& name) const;
  [[nodiscard]] const Object* find(int id) const;
  [[nodiscard]] const std::map<int, Object>& objects() const { return objects_; }
  /// The object of that name, or an error that names the nearest one.
  [[nodiscard]] Result<int> require(const std::string& name) const;

  /// Each notifies those that care, where the value is a new one. The id must exist. What is not finite or
  /// invalid is left out: the object stays as it is.
  void set_transform(int id, const ObjectTransform& transform);
  void set_description(int id, Description description);
  /// Looks alone: nothing depends on them.
  void set_optics(int id, const Optics& optics);
  void set_visible(int id, bool visible);
  void set_triangulated(int id, bool triangulated);
  /// Bakes the transform into the description. Errors: no such id; those of harden(Object&).
  Result<void> harden(int id);
  /// Its transform about (0, 0, 0) after all that was hardened into it: what hangs on an object follows this.
  /// The id must exist.
  [[nodiscard]] ObjectTransform pose(int id) const;

  [[nodiscard]] World* find_world(const std::string& name);
  [[nodiscard]] const World* find_world(const std::string& name) const;
  [[nodiscard]] Viewport* find_viewport(const std::string& name);

  /// Serves what still waits, as part of the frame before; then constraints may be served again, and those
  /// on the signal are.
  void begin_frame();
  /// After the commands of a frame.
  void serve_constraints() { constraints.renormalise(*this); }
  /// End of a frame: those on the signal are served.
  void end_frame();

  ConstraintNetwork constraints;
  std::vector<World> worlds;
  std::string current_world;
  Screen screen;
  int frame = 0;    ///< frames begun
  double time = 0;  ///< of the simulation
  Specimen specimen;

 private:
  std::map<int, Object> objects_;
  std::map<int, ObjectTransform> hardened_;  // about (0, 0, 0)
  int next_id_ = 1;
};

}  // namespace turgor
