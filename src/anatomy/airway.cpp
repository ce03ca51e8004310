#include "anatomy/airway.hpp"

#include <cmath>

#include "anatomy/coarse_grid.hpp"
#include "turgor/geometry/mesh_edit.hpp"
#include "turgor/imaging/isosurface.hpp"
#include "turgor/imaging/segmentation.hpp"

namespace turgor {
namespace {

constexpr double kSmallestAirMl = 0.5;
/// Maxillary sinuses reach this far from the middle; mastoid cells and ear canals lie further out.
constexpr double kHalfBreadthMm = 48;

/// Mean place of each component's voxels.
std::vector<Vec3> centres(const Components& parts) {
  std::vector<Vec3> sums(parts.sizes.size() + 1);
  const Grid& g = parts.labels.grid;
  for (int k = 0; k < g.size[2]; ++k) {
    for (int j = 0; j < g.size[1]; ++j) {
      for (int i = 0; i < g.size[0]; ++i) {
        const std::int32_t label = parts.labels.at(i, j, k);
        if (label != 0) sums[static_cast<std::size_t>(label)] += Vec3{double(i), double(j), double(k)};
      }
    }
  }
  for (std::size_t l = 1; l < sums.size(); ++l) {
    sums[l] = g.to_patient(sums[l] / static_cast<double>(parts.sizes[l - 1]));
  }
  return sums;
}

}  // namespace

TriMesh airway_surface(const ScannedBody& body, const TissueLevels& levels, const Cranium& cranium,
                       int triangles) {
  const VoxelBox box = bounding_box(body.cavity, 2);
  if (box.empty()) return {};
  const Components parts = connected_components(crop(body.cavity, box));
  const std::vector<Vec3> where = centres(parts);
  std::vector<bool> keep(parts.sizes.size() + 1, false);
  for (std::size_t l = 1; l < keep.size(); ++l) {
    const bool large = static_cast<double>(parts.sizes[l - 1]) * voxel_ml(body.hu.grid) >= kSmallestAirMl;
    keep[l] = large && std::abs(where[l].x - cranium.centre.x) < kHalfBreadthMm &&
              where[l].y < cranium.centre.y + 20;
  }
  LabelVolume air(parts.labels.grid);
  for (std::size_t v = 0; v < air.voxels.size(); ++v) {
    air.voxels[v] = keep[static_cast<std::size_t>(parts.labels.voxels[v])] ? 1 : 0;
  }
  constexpr int kSteps = 6;
  constexpr double kPassBand = 0.2;
  TriMesh mesh = smooth(isosurface_of_label(crop(body.hu, box), levels.skin_level, air), kSteps, kPassBand);
  return static_cast<int>(mesh.triangles.size()) > triangles ? decimate(mesh, triangles) : mesh;
}

}  // namespace turgor
