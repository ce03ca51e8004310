// What SurfaceContact prepares once. Internal to the module.
#pragma once

#include <vector>

#include "dynamics/box_tree.hpp"
#include "turgor/dynamics/surface_contact.hpp"
#include "turgor/tissue/network_energy.hpp"

namespace turgor {

struct SurfaceContact::Parts {
  struct Body {
    int first_face, last_face;
    BoxTree tree;  // of its faces, numbered from first_face
  };
  static constexpr std::size_t kChunk = 128;  // points searched for by one thread at a time

  ContactModel model;
  std::vector<Vec3> rest;
  std::vector<double> inverse_mass;
  std::vector<Index3> faces;      // of all surfaces
  std::vector<int> face_surface;  // of each
  std::vector<Body> bodies;
  std::vector<int> points;                // of all surfaces
  std::vector<int> surface;               // of each of them
  std::vector<Vec3> face_normal, normal;  // at rest, of faces and of each of the points
  std::vector<int> slot;                  // of every point of the network among them, −1: none
  NetworkEnergy::Incidence faces_around;  // of each of them: 3 · face + corner

  [[nodiscard]] std::size_t chunks() const { return (points.size() + kChunk - 1) / kChunk; }
  [[nodiscard]] double margin() const { return model.thickness_mm; }
  /// Σ weight²/mass: the inverse of the mass that the touch moves.
  template <class Points, class Weights>
  [[nodiscard]] double softness(const Points& p, const Weights& weights) const {
    double sum = 0;
    for (std::size_t i = 0; i < 4; ++i) sum += weights[i] * weights[i] * inverse_mass[at(p[i])];
    return sum;
  }
};

/// Σ weights[i] x[points[i]]: of a touch the point relative to the face.
inline Vec3 relative(const std::array<int, 4>& points, const std::array<double, 4>& weights,
                     std::span<const Vec3> x) {
  Vec3 sum;
  for (std::size_t i = 0; i < 4; ++i) sum += x[at(points[i])] * weights[i];
  return sum;
}

/// Normal of a triangle, twice its area long.
inline Vec3 area_vector(const Vec3& a, const Vec3& b, const Vec3& c) {
  return cross(b - a, c - a);
}

}  // namespace turgor
