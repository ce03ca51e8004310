// The drawings of a flesh: objects whose points follow its samples (Pieper 1989, section 5.5.2), and what can
// be measured on it.
#pragma once

#include <string>
#include <vector>

#include "turgor/world/scene.hpp"

namespace turgor {

/// Builds layers outward from an object in the world (`flesh_out`), adds them to the scene's tissue under
/// the object's name, and makes their drawings: "skin.face.NAME" with polygons, "smas.face.NAME",
/// "bone.face.NAME" (of other numbers of layers those between bone and skin are "layer1.face.NAME" …) with
/// the springs of the layer as lines. Errors: no such polyhedron; those of flesh_out().
Result<void> flesh_out_object(Scene& scene, const std::string& source, const FleshOptions& options,
                              double viscosity);

/// `update_all_face_objects`: shapes of all drawings of tissue, muscles and sutures ("muscles.NAME") as the
/// samples lie now.
Result<void> update_flesh_objects(Scene& scene);
/// Those of muscles and sutures alone.
Result<void> update_muscle_objects(Scene& scene);
/// Whether an object of that name is drawn anew at every update.
bool is_drawing(const Specimen& specimen, const std::string& name);
/// Barriers of objects that have moved since.
Result<void> update_collisions(Scene& scene);

/// The shape of an object as a region, where it stands now. Errors: the object is not of that kind, has no
/// extent, or is not closed.
Result<Barrier> barrier_of(const Scene& scene, int object, RegionShape shape);

/// Numbers of one flesh as it stands.
struct FleshMeasures {
  std::string name;
  int samples = 0, springs = 0, prisms = 0, inverted = 0;
  Box3 skin_box;
  /// Area of the openings in the skin (closed loops of its boundary but the longest), and of the same at
  /// rest.
  double opening = 0, rest_opening = 0;
  /// Mean distance from bone layer to skin, and its least and greatest.
  double thickness = 0, least_thickness = 0, greatest_thickness = 0;
  /// Greatest height of the skin over the mean level of its outer boundary, along its mean normal at rest.
  double rise = 0;
  Vec3 rise_at;
  /// At both ends of each opening (two rim points farthest apart at rest): the greatest such height
  /// within half the opening's length of the end. Closed wounds bulge there: dog-ears (section 6.1.1).
  struct DogEar {
    Vec3 end;  ///< where the end lies now
    double height = 0;
    Vec3 at;
  };
  std::vector<DogEar> dog_ears;
  double greatest_speed = 0;  ///< of a sample
};
std::vector<FleshMeasures> measure(const Specimen& specimen);
/// Of all fleshes.
int inverted_prisms(const Specimen& specimen);
/// Deepest a sample lies in a collision's region, by collision: length; of spheres over the radius too.
struct Penetration {
  int object = 0;
  double depth = 0, radius = 0;  ///< radius 0: not a sphere
};
std::vector<Penetration> penetrations(const Specimen& specimen);

}  // namespace turgor
