// Solids of a scene and their drawings: what `voxelize` makes (Morris 2006, sections 2 and 4.2).
#pragma once

#include <string>
#include <vector>

#include "turgor/geometry/solid_remesh.hpp"
#include "turgor/world/scene.hpp"

namespace turgor {

/// Fills the closed surface of an object, where it stands in the world, with tetrahedra, and adds them to the
/// scene's tissue under the object's name. The object is hidden; "skin.solid.NAME" shows its surface as the
/// solid carries it, in the object's looks, and "mesh.solid.NAME" (hidden) that of the tetrahedra. Errors: no
/// such polyhedron; those of make_solid_part().
Result<void> voxelize_object(Scene& scene, const std::string& source, const SolidOptions& options,
                             const Context& context);

/// Shapes of all drawings as the solids lie now.
Result<void> update_solid_objects(Scene& scene);
/// Attached samples on their way to where their objects are, in `duration`; at once for 0. Grabs that follow
/// an object get their targets. What held on to objects that are gone is let go.
void update_holds(Scene& scene, double duration);

/// A point of the world in the frame of an object's pose. Errors: the object is flat.
Result<Vec3> place_in_frame(const Scene& scene, int object, const Vec3& point);

/// A new mesh for a solid that has deformed, made in the background while it moves on (Morris 2006, sections
/// 2 and 5.1).
struct RemeshTask {
  std::string solid;
  int due = 0;   ///< the frame that begins with the new mesh, so that a replay has it at the same time
  TriMesh skin;  ///< as it stood at the start
  BackgroundRemesh work;
};
/// `frames` from now it is due. Errors: no such solid.
Result<RemeshTask> start_remesh(const Scene& scene, const std::string& solid, int resolution, int frames);
/// Waits for the work where it is not ready, and puts the new mesh in. Errors: those of remesh_solid(); the
/// solid is gone, or another one.
Result<void> finish_remesh(Scene& scene, RemeshTask& task);

/// Numbers of one solid as it stands.
struct SolidMeasures {
  std::string name;
  int points = 0, tetrahedra = 0, inverted = 0, fixed = 0;
  double volume = 0, rest_volume = 0;
  Box3 box;
  double greatest_displacement = 0, greatest_speed = 0;
};
std::vector<SolidMeasures> measure_solids(const Specimen& specimen);

}  // namespace turgor
