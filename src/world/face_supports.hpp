// What holds the cubes of a face under a plan, and the bone that they slide on.
#pragma once

#include <optional>
#include <vector>

#include "turgor/core/error.hpp"
#include "turgor/fem/elasticity.hpp"
#include "turgor/geometry/surface_query.hpp"
#include "turgor/world/face_solid.hpp"
#include "turgor/world/patient_case.hpp"
#include "world/tissue_motion.hpp"

namespace turgor {

/// Bones as one body to slide on: where they overlap, as after a setback, only what lies outside the others
/// counts. Directions on it are evened out over the crests and gaps of teeth.
class SlidingSurface {
 public:
  explicit SlidingSurface(const std::vector<TriMesh>& bones);

  struct Place {
    int bone;          ///< number among those given
    Vec3 normal;       ///< out of it
    double height_mm;  ///< above it; below 0 within
  };
  /// Nothing where no bone is within reach.
  [[nodiscard]] std::optional<Place> nearest(const Vec3& p, double reach_mm) const;
  [[nodiscard]] bool is_near(int bone, const Vec3& p, double reach_mm) const;

 private:
  struct Bone {
    TriMesh mesh;
    std::vector<Vec3> normals, even_normals;  // of its points
    SurfaceQuery query;
    Box3 box;
  };
  [[nodiscard]] bool within_another(std::size_t bone, const Vec3& p) const;
  std::vector<Bone> bones_;
};

/// Nodes on attached bone go with it, the rim stays; nodes over which lips and cheeks slide, and those taken
/// off the bone, stay out of the bone as far as
/// they were before the plan; the former are drawn back to their height above it.
class FaceSupports {
 public:
  /// Error: nothing moves.
  static Result<FaceSupports> find(const PatientCase& patient, const FaceSolid& face);

  [[nodiscard]] const std::vector<NodeSupport>& held() const { return held_; }
  /// Where each node may be looked for first: with the bone that it lies on.
  [[nodiscard]] std::vector<Vec3> start() const;
  /// Planes of the bone nearest to where the nodes are, by rising node.
  [[nodiscard]] std::vector<Contact> contacts(const std::vector<Vec3>& positions) const;
  /// Fixes nodes that have entered bone farther than `bearable_mm` upon its surface: where bones overlap or
  /// end in an edge, no plane is right for long.
  void pin(const std::vector<Vec3>& positions, double bearable_mm);
  /// How deep each node that slides has entered bone, mm, unsorted.
  [[nodiscard]] std::vector<double> depths(const std::vector<Vec3>& positions) const;

 private:
  struct Sliding {
    int node;
    double height_mm;  // at rest
    double area_mm2;
    bool wet;  // drawn back to the bone
    Vec3 start;
  };
  FaceSupports(const PatientCase& patient, const FaceSolid& face);
  // The bone nearest to each sliding node.
  [[nodiscard]] std::vector<std::optional<SlidingSurface::Place>> places(
      const std::vector<Vec3>& positions) const;
  void hold(const PatientCase& patient, const TissueMotion& motion);

  const FaceSolid& face_;
  double adhesion_n_mm_;
  SlidingSurface before_, after_;
  std::vector<NodeSupport> held_;
  std::vector<Sliding> sliding_;
};

}  // namespace turgor
