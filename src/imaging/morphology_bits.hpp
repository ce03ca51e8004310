// Dilation of bit masks, 64 voxels at a time.
#pragma once

#include "imaging/bit_volume.hpp"

namespace turgor::detail {

/// Set where any of the 27 voxels around (and with) a voxel is set.
BitVolume dilate_box(const BitVolume& bits);

/// Rows (j + dj, k + dk) that a ball around a voxel of row (j, k) reaches, and how many voxels to either
/// side.
struct BallRow {
  int dj, dk, width;
};
/// Sorted by falling width. Voxel centres at a distance of exactly `radius_mm` belong to the ball.
std::vector<BallRow> ball_rows(const Vec3& spacing, double radius_mm);
/// Set where any voxel of the ball around a voxel is set.
BitVolume dilate_rows(const BitVolume& bits, const std::vector<BallRow>& ball);

}  // namespace turgor::detail
