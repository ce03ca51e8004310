// Objects of a scene: what stands in a world, where, and what it looks like (Pieper 1989, section 4.2).
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "turgor/geometry/polyhedron.hpp"

namespace turgor {

/// p ↦ origin + linear (p − origin) + translation: rotation and scaling about the local origin, which a
/// translation carries along.
struct ObjectTransform {
  Mat3 linear;  ///< columns are the images of the axes
  Vec3 translation;
  Vec3 origin;  ///< in the object's own coordinates

  [[nodiscard]] Vec3 point(const Vec3& p) const { return origin + linear * (p - origin) + translation; }
  [[nodiscard]] Vec3 direction(const Vec3& d) const { return linear * d; }
  bool operator==(const ObjectTransform& other) const {
    return linear.c == other.linear.c && translation == other.translation && origin == other.origin;
  }
};

/// Of an eye at the object's origin that looks along its −z axis with +y up, as glTF has it.
struct CameraLens {
  double fov_deg = 35;  ///< vertical opening angle; 0: orthographic
  double height = 1;    ///< of the picture at the target, where orthographic
  double target_distance = 1;
};
/// Shines along the object's −z axis.
struct Light {
  Vec3f colour{1, 1, 1};
  double strength = 1;
};
/// Heights over a grid in the object's own coordinates: sample (i, j) at (i, j, height) with the spacing 1;
/// the transform gives it size and place (Pieper 1989, section 5.2.3).
struct DepthMap {
  int columns = 0, rows = 0;    ///< ≥ 2 each
  std::vector<double> heights;  ///< row by row
};

enum class Shading { faceted, smooth };
struct Optics {
  Shading shading = Shading::smooth;
  Vec3f diffuse{0.8f, 0.8f, 0.8f};    ///< linear RGB
  Vec3f highlight{0.3f, 0.3f, 0.3f};  ///< colour of the highlight, linear RGB
  double specular = 32;               ///< exponent of the highlight (Phong), ≥ 0
  std::optional<Vec3f> wire;          ///< draw the edges too, in this colour
  double line_width = 1;              ///< of lines and edges: times what the picture draws them with, > 0
  bool curved = false;                ///< draw the smooth surface of the polygons (Catmull and Clark 1978)
  double opacity = 1;                 ///< 0 to 1
};

using Description = std::variant<Polyhedron, CameraLens, Light, DepthMap>;
enum class ObjectKind { polyhedron, camera, light, depth_map };

struct Object {
  std::string name;  ///< unique in a scene
  std::string file;  ///< it came from; empty for objects made here
  Description description;
  ObjectTransform transform;
  bool visible = true;
  bool triangulated = false;  ///< polygons are drawn as triangles
  Optics optics;

  [[nodiscard]] ObjectKind kind() const { return static_cast<ObjectKind>(description.index()); }
};
/// "polyhedron", "camera", "light", "depth map".
std::string_view name_of(ObjectKind kind);

/// Errors: an invalid polyhedron or depth map; numbers that are not finite or out of the ranges above.
Result<void> validate(const Object& object);
Result<void> validate(const Optics& optics);
/// The same bits, field by field.
bool same_description(const Description& a, const Description& b);

/// In world coordinates; empty without points. A camera or light is the point (0, 0, 0) of its own.
Box3 world_box(const Object& object);
struct BoundingSphere {
  Vec3 centre;
  double radius = 0;
};
/// About the middle of the world's bounding box; radius 0 without points.
BoundingSphere world_sphere(const Object& object);
/// The object's +z and +y axes in the world, unit length (zero for a transform that flattens them).
struct Orientation {
  Vec3 normal, up;
};
Orientation orientation(const Object& object);
/// The polygons of a polyhedron in world coordinates, turned over where the transform mirrors, so that they
/// still face outwards; a depth map as a grid of quadrilaterals; empty for others.
Polyhedron world_polyhedron(const Object& object);
/// The eight corners and six faces of a box.
Polyhedron box_polyhedron(const Box3& box);

/// Rotation by the angles about x, then y, then z, degrees.
Mat3 rotation_xyz(const Vec3& angles_deg);
/// Bakes the transform into the description: `harden`. A depth map becomes a polyhedron; cameras and lights
/// keep their transform. Errors: coordinates that are not finite; the object stays as it is.
Result<void> harden(Object& object);

}  // namespace turgor
