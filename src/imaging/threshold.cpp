#include <algorithm>
#include <limits>

#include "imaging/bit_volume.hpp"
#include "turgor/imaging/segmentation.hpp"

namespace turgor {

LabelVolume threshold(const CtVolume& volume, int lower, int upper) {
  LabelVolume mask;
  mask.grid = volume.grid;
  mask.voxels.resize(volume.voxels.size());
  using Limits = std::numeric_limits<std::int16_t>;
  if (lower > upper || lower > Limits::max() || upper < Limits::min()) return mask;
  const auto low = static_cast<std::int16_t>(std::max<int>(lower, Limits::min()));
  const auto high = static_cast<std::int16_t>(std::min<int>(upper, Limits::max()));
  parallel_for(mask.voxels.size(), 1 << 16, [&](std::size_t begin, std::size_t end) {
    for (std::size_t v = begin; v < end; ++v) {
      mask.voxels[v] = volume.voxels[v] >= low && volume.voxels[v] <= high ? 1 : 0;
    }
  });
  return mask;
}

}  // namespace turgor
