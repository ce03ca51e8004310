// Meshes of each kind of element for the tests of fem.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <functional>
#include <vector>

#include "turgor/core/index.hpp"
#include "turgor/fem/mesh_elasticity.hpp"

namespace turgor {

enum class ElementKind { hexahedra, prisms, tetrahedra };
inline constexpr std::array kElementKinds = {ElementKind::hexahedra, ElementKind::prisms,
                                             ElementKind::tetrahedra};

inline const char* name_of(ElementKind kind) {
  constexpr const char* names[] = {"hexahedra", "prisms", "tetrahedra"};
  return names[static_cast<int>(kind)];
}

/// Adds the cube of these corners (as of a hexahedron) whole, as two prisms, or as Kuhn's six tetrahedra.
inline void add_cube(ElementMesh& mesh, ElementKind kind, const std::array<int, 8>& c) {
  if (kind == ElementKind::hexahedra) {
    mesh.hexahedra.push_back(c);
  } else if (kind == ElementKind::prisms) {
    mesh.prisms.push_back({c[0], c[1], c[2], c[4], c[5], c[6]});
    mesh.prisms.push_back({c[0], c[2], c[3], c[4], c[6], c[7]});
  } else {
    constexpr int paths[6][2] = {{1, 2}, {2, 3}, {3, 7}, {7, 4}, {4, 5}, {5, 1}};
    for (const auto& path : paths) mesh.tetrahedra.push_back({c[0], c[at(path[0])], c[at(path[1])], c[6]});
  }
}

/// A box of cubes n, each unit vertex (0 to 1) taken to a place.
inline ElementMesh box_mesh(ElementKind kind, const Index3& n,
                            const std::function<Vec3(const Vec3&)>& place) {
  ElementMesh mesh;
  const auto number = [&](int i, int j, int k) { return (k * (n[1] + 1) + j) * (n[0] + 1) + i; };
  for (int k = 0; k <= n[2]; ++k)
    for (int j = 0; j <= n[1]; ++j)
      for (int i = 0; i <= n[0]; ++i)
        mesh.points.push_back(place(
            {static_cast<double>(i) / n[0], static_cast<double>(j) / n[1], static_cast<double>(k) / n[2]}));
  for (int k = 0; k < n[2]; ++k)
    for (int j = 0; j < n[1]; ++j)
      for (int i = 0; i < n[0]; ++i)
        add_cube(mesh, kind,
                 {number(i, j, k), number(i + 1, j, k), number(i + 1, j + 1, k), number(i, j + 1, k),
                  number(i, j, k + 1), number(i + 1, j, k + 1), number(i + 1, j + 1, k + 1),
                  number(i, j + 1, k + 1)});
  return mesh;
}
inline ElementMesh box_mesh(ElementKind kind, const Index3& n, const Vec3& size) {
  return box_mesh(kind, n, [&](const Vec3& p) { return Vec3{p.x * size.x, p.y * size.y, p.z * size.z}; });
}

using Held = std::array<bool, 3>;
inline constexpr Held kAll{true, true, true};

/// Holds the points where `where` is true, displaced as `moved` says.
inline void hold(
    std::vector<NodeSupport>& supports, const ElementMesh& mesh,
    const std::function<bool(const Vec3&)>& where, Held held,
    const std::function<Vec3(const Vec3&)>& moved = [](const Vec3&) { return Vec3{}; }) {
  for (std::size_t p = 0; p < mesh.points.size(); ++p)
    if (where(mesh.points[p])) supports.push_back({static_cast<int>(p), held, moved(mesh.points[p])});
}

/// Holds the points whose coordinate along the axis is 0.
inline void hold_base(std::vector<NodeSupport>& supports, const ElementMesh& mesh, int axis) {
  hold(
      supports, mesh, [=](const Vec3& p) { return p[axis] < 1e-9; }, kAll);
}

/// Holds both ends of a body along the axis, its base and its far end, which is moved.
inline void hold_ends(std::vector<NodeSupport>& supports, const ElementMesh& mesh, int axis,
                      const Vec3& moved) {
  hold_base(supports, mesh, axis);
  double far = 0;
  for (const Vec3& p : mesh.points) far = std::max(far, p[axis]);
  hold(
      supports, mesh, [=](const Vec3& p) { return p[axis] > far - 1e-9; }, kAll,
      [=](const Vec3&) { return moved; });
}

/// The planes x = 0, y = 0 and z = 0 slide.
inline std::vector<NodeSupport> symmetry_planes(const ElementMesh& mesh) {
  std::vector<NodeSupport> supports;
  for (std::size_t p = 0; p < mesh.points.size(); ++p) {
    const Vec3& x = mesh.points[p];
    const Held held{x.x < 1e-9, x.y < 1e-9, x.z < 1e-9};
    if (held[0] || held[1] || held[2]) supports.push_back({static_cast<int>(p), held, {}});
  }
  return supports;
}

inline ElasticBody body_of(const ElasticMaterial& material) {
  return {{material}, {}, {}};
}

}  // namespace turgor
