// Blocks of voxels: work on the part of a volume that matters.
#pragma once

#include <algorithm>

#include "turgor/imaging/volume.hpp"

namespace turgor {

/// Voxels lower ≤ index ≤ upper on every axis.
struct VoxelBox {
  Index3 lower{0, 0, 0};
  Index3 upper{-1, -1, -1};

  [[nodiscard]] bool empty() const {
    return lower[0] > upper[0] || lower[1] > upper[1] || lower[2] > upper[2];
  }
  [[nodiscard]] Index3 size() const {
    return {upper[0] - lower[0] + 1, upper[1] - lower[1] + 1, upper[2] - lower[2] + 1};
  }
  bool operator==(const VoxelBox&) const = default;
};

/// The part of a box that lies in the grid.
inline VoxelBox clipped(VoxelBox box, const Grid& grid) {
  for (std::size_t a = 0; a < 3; ++a) {
    box.lower[a] = std::max(box.lower[a], 0);
    box.upper[a] = std::min(box.upper[a], grid.size[a] - 1);
  }
  return box;
}

/// The smallest box with all non-zero voxels, `margin` voxels wider on each side but within the volume. Empty
/// where the mask is.
VoxelBox bounding_box(const LabelVolume& mask, int margin = 0);

/// A copy of the box's voxels at the same place in the patient. The box is clipped first; where nothing is
/// left the result is a volume without voxels.
template <class T>
Volume<T> crop(const Volume<T>& volume, const VoxelBox& wanted) {
  const VoxelBox box = clipped(wanted, volume.grid);
  Volume<T> part;
  if (box.empty()) return part;
  part.grid = volume.grid;
  part.grid.size = box.size();
  part.grid.origin =
      volume.grid.to_patient({double(box.lower[0]), double(box.lower[1]), double(box.lower[2])});
  part.voxels.reserve(part.grid.voxel_count());
  for (int k = box.lower[2]; k <= box.upper[2]; ++k) {
    for (int j = box.lower[1]; j <= box.upper[1]; ++j) {
      const auto row =
          volume.voxels.begin() + static_cast<std::ptrdiff_t>(volume.grid.offset(box.lower[0], j, k));
      part.voxels.insert(part.voxels.end(), row, row + part.grid.size[0]);
    }
  }
  return part;
}

/// Writes a cropped part back: voxel (0, 0, 0) of `part` goes to `lower`. What lies outside the volume is
/// left out.
template <class T>
void paste(Volume<T>& volume, const Volume<T>& part, const Index3& lower) {
  if (part.voxels.size() != part.grid.voxel_count()) return;
  VoxelBox box{lower, {}};
  for (std::size_t a = 0; a < 3; ++a) box.upper[a] = lower[a] + part.grid.size[a] - 1;
  box = clipped(box, volume.grid);
  for (int k = box.lower[2]; k <= box.upper[2]; ++k) {
    for (int j = box.lower[1]; j <= box.upper[1]; ++j) {
      for (int i = box.lower[0]; i <= box.upper[0]; ++i) {
        volume.at(i, j, k) = part.at(i - lower[0], j - lower[1], k - lower[2]);
      }
    }
  }
}

}  // namespace turgor
