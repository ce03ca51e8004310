#include "turgor/imaging/voxel_box.hpp"

#include <limits>

#include "imaging/bit_volume.hpp"

namespace turgor {

VoxelBox bounding_box(const LabelVolume& mask, int margin) {
  if (!detail::is_whole(mask)) return {};
  constexpr int most = std::numeric_limits<int>::max();
  const VoxelBox nothing{{most, most, most}, {-1, -1, -1}};
  const detail::BitVolume bits = detail::pack_nonzero(mask);
  VoxelBox box = nothing;
  for (std::size_t r = 0; r < bits.rows(); ++r) {
    const std::uint64_t* row = bits.row(r);
    int first = most, last = -1;
    for (int w = 0; w < bits.words; ++w) {
      if (!row[w]) continue;
      first = std::min(first, 64 * w + std::countr_zero(row[w]));
      last = 64 * w + 63 - std::countl_zero(row[w]);
    }
    if (last < 0) continue;
    const Index3 low{first, static_cast<int>(r % static_cast<std::size_t>(bits.size[1])),
                     static_cast<int>(r / static_cast<std::size_t>(bits.size[1]))};
    const Index3 high{last, low[1], low[2]};
    for (std::size_t a = 0; a < 3; ++a) {
      box.lower[a] = std::min(box.lower[a], low[a]);
      box.upper[a] = std::max(box.upper[a], high[a]);
    }
  }
  if (box.empty()) return {};
  for (std::size_t a = 0; a < 3; ++a) {
    box.lower[a] -= margin;
    box.upper[a] += margin;
  }
  return clipped(box, mask.grid);
}

}  // namespace turgor
