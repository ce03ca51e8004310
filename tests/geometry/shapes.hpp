// Surfaces with known measures.
#pragma once

#include <cmath>
#include <map>
#include <numbers>

#include "turgor/core/random.hpp"
#include "turgor/geometry/tri_mesh.hpp"

namespace turgor::testing {

/// Box with two triangles a side.
inline TriMesh box(const Vec3& lower, const Vec3& upper) {
  TriMesh mesh;
  for (int i = 0; i < 8; ++i) {
    mesh.points.push_back({i & 1 ? upper.x : lower.x, i & 2 ? upper.y : lower.y, i & 4 ? upper.z : lower.z});
  }
  mesh.triangles = {{0, 2, 1}, {1, 2, 3}, {4, 5, 6}, {5, 7, 6}, {0, 1, 4}, {1, 5, 4},
                    {2, 6, 3}, {3, 6, 7}, {0, 4, 2}, {2, 4, 6}, {1, 3, 5}, {3, 7, 5}};
  return mesh;
}

/// Every triangle into four, new points placed by `place(midpoint)`.
template <class Place>
TriMesh quartered(const TriMesh& mesh, Place&& place) {
  TriMesh fine{mesh.points, {}};
  std::map<std::pair<int, int>, int> middle;
  const auto mid = [&](int a, int b) {
    const auto [entry, fresh] = middle.try_emplace(std::minmax(a, b), static_cast<int>(fine.points.size()));
    if (fresh)
      fine.points.push_back(
          place((fine.points[static_cast<std::size_t>(a)] + fine.points[static_cast<std::size_t>(b)]) * 0.5));
    return entry->second;
  };
  for (const Index3& t : mesh.triangles) {
    const int ab = mid(t[0], t[1]), bc = mid(t[1], t[2]), ca = mid(t[2], t[0]);
    for (const Index3& n : {Index3{t[0], ab, ca}, {t[1], bc, ab}, {t[2], ca, bc}, {ab, bc, ca}})
      fine.triangles.push_back(n);
  }
  return fine;
}

/// Octahedron refined `levels` times onto the sphere: 8 * 4^levels triangles.
inline TriMesh sphere(double radius, int levels, const Vec3& centre = {}) {
  TriMesh mesh;
  mesh.points = {{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}};
  mesh.triangles = {{0, 2, 4}, {2, 1, 4}, {1, 3, 4}, {3, 0, 4}, {2, 0, 5}, {1, 2, 5}, {3, 1, 5}, {0, 3, 5}};
  for (int i = 0; i < levels; ++i) mesh = quartered(mesh, [](const Vec3& p) { return normalized(p); });
  for (Vec3& p : mesh.points) p = centre + p * radius;
  return mesh;
}

/// Torus about the z axis.
inline TriMesh torus(double major, double minor, int around, int across) {
  TriMesh mesh;
  for (int i = 0; i < around; ++i) {
    for (int j = 0; j < across; ++j) {
      const double a = 2 * std::numbers::pi * i / around, b = 2 * std::numbers::pi * j / across;
      const double r = major + minor * std::cos(b);
      mesh.points.push_back({r * std::cos(a), r * std::sin(a), minor * std::sin(b)});
      const int p = i * across + j, q = i * across + (j + 1) % across;
      const int s = (i + 1) % around * across + j, t = (i + 1) % around * across + (j + 1) % across;
      mesh.triangles.push_back({p, s, t});
      mesh.triangles.push_back({p, t, q});
    }
  }
  return mesh;
}

/// Flat square [0, size]^2 in z = 0, facing up.
inline TriMesh sheet(int cells, double size) {
  TriMesh mesh;
  for (int j = 0; j <= cells; ++j) {
    for (int i = 0; i <= cells; ++i) mesh.points.push_back({size * i / cells, size * j / cells, 0});
  }
  for (int j = 0; j < cells; ++j) {
    for (int i = 0; i < cells; ++i) {
      const int p = j * (cells + 1) + i, q = p + cells + 1;
      mesh.triangles.push_back({p, p + 1, q + 1});
      mesh.triangles.push_back({p, q + 1, q});
    }
  }
  return mesh;
}

inline TriMesh reversed(TriMesh mesh) {
  for (Index3& t : mesh.triangles) std::swap(t[1], t[2]);
  return mesh;
}

/// Points moved by normal noise.
inline TriMesh noisy(TriMesh mesh, double sigma, std::uint64_t seed) {
  const RandomStream random(seed);
  for (std::size_t i = 0; i < mesh.points.size(); ++i) {
    for (std::uint64_t k = 0; k < 3; ++k)
      mesh.points[i][static_cast<int>(k)] += sigma * random.normal(3 * i + k);
  }
  return mesh;
}

inline Vec3 random_direction(const RandomStream& random, std::uint64_t i) {
  return normalized(Vec3{random.normal(3 * i), random.normal(3 * i + 1), random.normal(3 * i + 2)});
}

/// Smallest doubled area of a triangle.
inline double least_area(const TriMesh& mesh) {
  double least = 1e300;
  for (const Index3& t : mesh.triangles) least = std::min(least, length(triangle_normal(mesh, t)));
  return least;
}

}  // namespace turgor::testing
