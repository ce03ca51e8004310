// Volumes and checks shared by the tests of surfaces and masks.
#pragma once

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "turgor/core/random.hpp"
#include "turgor/geometry/tri_mesh.hpp"
#include "turgor/imaging/volume.hpp"

namespace turgor::test {

inline Grid grid_of(Index3 size, Vec3 spacing = {1, 1, 1}, Vec3 origin = {}, Mat3 direction = {}) {
  return Grid{size, spacing, origin, direction};
}

/// f(point in mm) at every voxel centre, rounded to whole units.
template <class Field>
CtVolume sampled(const Grid& grid, Field&& field) {
  CtVolume volume(grid);
  for (int k = 0; k < grid.size[2]; ++k) {
    for (int j = 0; j < grid.size[1]; ++j) {
      for (int i = 0; i < grid.size[0]; ++i) {
        const double value = field(grid.to_patient({double(i), double(j), double(k)}));
        volume.at(i, j, k) = static_cast<std::int16_t>(std::lround(std::clamp(value, -32000.0, 32000.0)));
      }
    }
  }
  return volume;
}

/// Each voxel set with the given probability.
inline LabelVolume random_mask(const Grid& grid, double density, std::uint64_t seed) {
  LabelVolume mask(grid);
  const RandomStream random(seed);
  for (std::size_t v = 0; v < mask.voxels.size(); ++v) mask.voxels[v] = random.uniform(v) < density ? 1 : 0;
  return mask;
}

/// The directed edges (from, to) of all triangles, sorted.
inline std::vector<std::pair<int, int>> directed_edges(const TriMesh& mesh) {
  std::vector<std::pair<int, int>> edges;
  edges.reserve(3 * mesh.triangles.size());
  for (const Index3& t : mesh.triangles) {
    for (std::size_t a = 0; a < 3; ++a) edges.emplace_back(t[a], t[(a + 1) % 3]);
  }
  std::sort(edges.begin(), edges.end());
  return edges;
}

/// Every edge is used by exactly two triangles, in opposite directions.
inline bool is_closed_and_oriented(const TriMesh& mesh) {
  const std::vector<std::pair<int, int>> edges = directed_edges(mesh);
  std::vector<std::pair<int, int>> turned = edges;
  for (auto& [from, to] : turned) std::swap(from, to);
  std::sort(turned.begin(), turned.end());
  return !edges.empty() && edges == turned && std::adjacent_find(edges.begin(), edges.end()) == edges.end();
}

}  // namespace turgor::test
