// Lines in space as thin round rods, so that surfaces hide them as they would a thread.
#pragma once

#include <algorithm>
#include <array>
#include <map>
#include <span>

#include "turgor/geometry/polyhedron.hpp"

namespace turgor::render_detail {

/// Rods by colour: one mesh for all lines of a colour keeps pictures of many thousand lines quick.
class RodSet {
 public:
  /// Of that radius up to the origin, and thicker beyond in proportion to the depth, so that far lines do not
  /// break up between the rays. `depth`: along the view, over the eye's distance; zero for parallel rays.
  RodSet(double radius, const Vec3& depth) : radius_(radius), depth_(depth) {}

  /// A rod along each segment between `points`; those of no length are left out.
  /// They are `width` times as thick as usual.
  void add(std::span<const Vec3> points, std::span<const Edge> segments, const Vec3f& colour, double width);
  [[nodiscard]] const std::map<std::array<float, 3>, TriMesh>& by_colour() const { return meshes_; }

 private:
  [[nodiscard]] double radius_at(const Vec3& p) const {
    return radius_ * (1 + std::max(0.0, dot(p, depth_)));
  }

  double radius_;
  Vec3 depth_;
  std::map<std::array<float, 3>, TriMesh> meshes_;
};

}  // namespace turgor::render_detail
