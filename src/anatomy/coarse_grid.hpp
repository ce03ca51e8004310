// Coarse copies of voxel masks, for questions that need no detail.
#pragma once

#include <cmath>
#include <cstdint>

#include "turgor/core/parallel.hpp"
#include "turgor/imaging/voxel_box.hpp"

namespace turgor {

inline double voxel_ml(const Grid& grid) {
  return grid.spacing.x * grid.spacing.y * grid.spacing.z * 1e-3;
}

/// The box widened by `margin_mm` on every side, as far as the volume goes.
inline VoxelBox widened(VoxelBox box, double margin_mm, const Grid& grid) {
  for (std::size_t a = 0; a < 3; ++a) {
    const int margin = static_cast<int>(std::ceil(margin_mm / grid.spacing[static_cast<int>(a)]));
    box.lower[a] -= margin;
    box.upper[a] += margin;
  }
  return clipped(box, grid);
}

/// Grid of cells of about `cell_mm`, each a whole number of voxels; its points are the centres of the cells.
struct CoarseGrid {
  Grid grid;
  Index3 factor{1, 1, 1};
  [[nodiscard]] int voxels_per_cell() const { return factor[0] * factor[1] * factor[2]; }
};
inline CoarseGrid coarse_grid(const Grid& fine, double cell_mm) {
  CoarseGrid coarse{fine, {1, 1, 1}};
  Vec3 shift;
  for (int a = 0; a < 3; ++a) {
    const auto i = static_cast<std::size_t>(a);
    coarse.factor[i] = std::max(1, static_cast<int>(std::lround(cell_mm / fine.spacing[a])));
    coarse.grid.size[i] = (fine.size[i] + coarse.factor[i] - 1) / coarse.factor[i];
    coarse.grid.spacing[a] = fine.spacing[a] * coarse.factor[i];
    shift[a] = 0.5 * (coarse.factor[i] - 1);
  }
  coarse.grid.origin = fine.to_patient(shift);
  return coarse;
}

/// Number of voxels of each cell for which is_inside(value) holds.
template <class T, class Test>
Volume<std::uint16_t> count_in_cells(const Volume<T>& volume, const CoarseGrid& coarse, Test&& is_inside) {
  Volume<std::uint16_t> counts(coarse.grid);
  const Grid& g = volume.grid;
  parallel_for(static_cast<std::size_t>(coarse.grid.size[2]), 1, [&](std::size_t begin, std::size_t end) {
    for (int kc = static_cast<int>(begin); kc < static_cast<int>(end); ++kc) {
      const int k_end = std::min(g.size[2], (kc + 1) * coarse.factor[2]);
      for (int k = kc * coarse.factor[2]; k < k_end; ++k) {
        for (int j = 0; j < g.size[1]; ++j) {
          const T* row = volume.voxels.data() + g.offset(0, j, k);
          std::uint16_t* cells = counts.voxels.data() + coarse.grid.offset(0, j / coarse.factor[1], kc);
          for (int i = 0, c = 0, f = 0; i < g.size[0]; ++i) {
            if (is_inside(row[i])) ++cells[c];
            if (++f == coarse.factor[0]) f = 0, ++c;
          }
        }
      }
    }
  });
  return counts;
}

}  // namespace turgor
