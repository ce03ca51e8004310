// Soft bodies of voxels with springs along the edges of their tetrahedra, for tests and benchmarks of
// contact.
#pragma once

#include <algorithm>
#include <array>
#include <vector>

#include "turgor/dynamics/time_stepper.hpp"
#include "turgor/geometry/voxel_solid.hpp"

namespace turgor::support {

struct Block {
  Index3 cells{2, 2, 2};
  double spacing = 2;  ///< mm
  Vec3 lower;          ///< before it is turned
  RigidTransform place{};
  bool mobile = true;
  double modulus_mpa = 0.05;
  double density = 1e-3;  ///< g/mm³
  bool self = false;
  std::vector<Index3> left_out = {};  ///< cells
};

/// Number of the first point of a body added to a model, of the cubes of a lattice.
inline int add_body(MotionModel& model, const SolidMesh& solid, const Block& block) {
  auto& net = model.network;
  const int first = static_cast<int>(net.rest.size());
  for (const Vec3& p : solid.points) net.rest.push_back(block.place.point(p));
  net.mass_g.resize(net.rest.size());
  model.mobile.resize(net.rest.size(), block.mobile ? 1 : 0);
  std::vector<std::array<int, 2>> edges;
  for (const auto& t : solid.tetrahedra) {
    VolumeElement v;
    for (int i = 0; i < 4; ++i) {
      v.p[i] = first + t[i];
      for (int j = 0; j < i; ++j)
        edges.push_back({first + std::min(t[i], t[j]), first + std::max(t[i], t[j])});
    }
    v.rest_volume_mm3 = signed_volume(net.rest[v.p[0]], net.rest[v.p[1]], net.rest[v.p[2]], net.rest[v.p[3]]);
    v.modulus_mpa = 2 * block.modulus_mpa;
    v.inversion_guard_mpa = 20 * block.modulus_mpa;
    for (const int p : v.p) net.mass_g[p] += v.rest_volume_mm3 / 4 * block.density;
    net.volumes.push_back(v);
  }
  std::sort(edges.begin(), edges.end());
  edges.erase(std::unique(edges.begin(), edges.end()), edges.end());
  for (const auto& [a, b] : edges) {
    const double length = distance(net.rest[a], net.rest[b]);
    net.springs.push_back({a, b, length, block.modulus_mpa * block.spacing * block.spacing / 2,
                           SpringLaw::hookean, SpringKind::membrane});
  }
  ContactSurface surface;
  surface.self = block.self;
  for (const Index3& t : solid.surface_triangles)
    surface.triangles.push_back({first + t[0], first + t[1], first + t[2]});
  if (!model.contact) model.contact.emplace();
  model.contact->surfaces.push_back(surface);
  return first;
}

/// The same of a block.
inline int add_block(MotionModel& model, const Block& block) {
  VoxelGrid grid(Index3{block.cells[0] + 2, block.cells[1] + 2, block.cells[2] + 2});
  grid.spacing = block.spacing;
  grid.lower = block.lower - Vec3{1, 1, 1} * block.spacing;
  for (int k = 0; k < block.cells[2]; ++k)
    for (int j = 0; j < block.cells[1]; ++j)
      for (int i = 0; i < block.cells[0]; ++i)
        if (std::find(block.left_out.begin(), block.left_out.end(), Index3{i, j, k}) == block.left_out.end())
          grid.set(i + 1, j + 1, k + 1);
  const auto solid = solid_of(grid);
  return solid ? add_body(model, *solid, block) : -1;
}

/// From `first` up to `last`.
inline double mass(const MotionModel& model, int first, int last) {
  double sum = 0;
  for (int p = first; p < last; ++p) sum += model.network.mass_g[p];
  return sum;
}
inline Vec3 mean(const MotionModel& model, const std::vector<Vec3>& x, int first, int last) {
  Vec3 sum;
  for (int p = first; p < last; ++p) sum += x[p] * model.network.mass_g[p];
  return sum / mass(model, first, last);
}
inline Vec3 momentum(const MotionModel& model, const std::vector<Vec3>& v) {
  Vec3 sum;
  for (std::size_t p = 0; p < v.size(); ++p) sum += v[p] * model.network.mass_g[p];
  return sum;
}

}  // namespace turgor::support
