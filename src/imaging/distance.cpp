#include <algorithm>
#include <cmath>
#include <limits>

#include "imaging/bit_volume.hpp"
#include "turgor/imaging/segmentation.hpp"

namespace turgor {
namespace {

constexpr float kFar = std::numeric_limits<float>::infinity();

/// Columns that are gathered and transformed together, so that memory is read in whole cache lines.
constexpr int kLanes = 16;
/// Up to this many voxels the plain minimum over a window, 8 voxels an instruction, is quicker than the
/// envelope.
constexpr int kWidestWindow = 12;

/// Squared distance along i to the nearest set voxel of the row.
void distance_along_row(const std::uint8_t* mask, int n, float step, float* out) {
  int since = n;
  bool seen = false;
  for (int i = 0; i < n; ++i) {
    if (mask[i]) seen = true, since = 0;
    out[i] = seen ? static_cast<float>(since) : kFar;
    ++since;
  }
  float ahead = kFar;
  for (int i = n - 1; i >= 0; --i) {
    ahead = mask[i] ? 0 : ahead + 1;
    const float d = std::min(out[i], ahead) * step;
    out[i] = d * d;
  }
}

/// Lower envelope of the parabolas f[q] + (step (p - q))² (Felzenszwalb and Huttenlocher 2012, algorithm 1).
/// `f` and `out` have the given stride; the scratch arrays hold n and n + 1 numbers.
struct Envelope {
  std::vector<int> apex;
  std::vector<float> height, from;

  explicit Envelope(int n) : apex(static_cast<std::size_t>(n)), height(apex.size()), from(apex.size() + 1) {}

  void transform(const float* f, int n, int stride, float step, float* out) {
    const float step2 = step * step;
    int last = -1;
    for (int q = 0; q < n; ++q) {
      const float fq = f[q * stride];
      if (fq == kFar) continue;
      float start = -kFar;
      for (; last >= 0; --last) {
        const int p = apex[static_cast<std::size_t>(last)];
        // Where the parabolas of p and q are equally high, in voxels.
        start = 0.5F * ((fq - height[static_cast<std::size_t>(last)]) / (step2 * static_cast<float>(q - p)) +
                        static_cast<float>(q + p));
        if (start > from[static_cast<std::size_t>(last)]) break;
        start = -kFar;
      }
      ++last;
      apex[static_cast<std::size_t>(last)] = q;
      height[static_cast<std::size_t>(last)] = fq;
      from[static_cast<std::size_t>(last)] = start;
    }
    if (last < 0) {
      for (int p = 0; p < n; ++p) out[p * stride] = kFar;
      return;
    }
    from[static_cast<std::size_t>(last) + 1] = kFar;
    std::size_t v = 0;
    for (int p = 0; p < n; ++p) {
      while (from[v + 1] < static_cast<float>(p)) ++v;
      const float d = static_cast<float>(p - apex[v]) * step;
      out[p * stride] = height[v] + d * d;
    }
  }
};

/// One block of columns: `lanes` neighbours along i, n voxels `stride` apart.
struct ColumnBlock {
  float* first;
  int lanes, n;
  std::size_t stride;
};

void transform_by_envelope(const ColumnBlock& block, float step, std::vector<float>& buffer,
                           Envelope& envelope) {
  buffer.resize(static_cast<std::size_t>(block.n * kLanes));
  bool any = false, all = true;
  for (int q = 0; q < block.n; ++q) {
    const float* row = block.first + static_cast<std::size_t>(q) * block.stride;
    for (int l = 0; l < block.lanes; ++l) {
      buffer[static_cast<std::size_t>(q * kLanes + l)] = row[l];
      any = any || row[l] != kFar;
      all = all && row[l] == 0;
    }
  }
  if (!any || all) return;
  for (int l = 0; l < block.lanes; ++l)
    envelope.transform(buffer.data() + l, block.n, kLanes, step, buffer.data() + l);
  for (int q = 0; q < block.n; ++q) {
    std::copy_n(buffer.data() + q * kLanes, block.lanes,
                block.first + static_cast<std::size_t>(q) * block.stride);
  }
}

void transform_by_window(const ColumnBlock& block, float step, int window, std::vector<float>& buffer) {
  buffer.assign(static_cast<std::size_t>((block.n + 2 * window) * kLanes), kFar);
  for (int q = 0; q < block.n; ++q) {
    std::copy_n(block.first + static_cast<std::size_t>(q) * block.stride, block.lanes,
                buffer.data() + (q + window) * kLanes);
  }
  for (int q = 0; q < block.n; ++q) {
    float least[kLanes];
    std::copy_n(buffer.data() + (q + window) * kLanes, kLanes, least);
    for (int d = 1; d <= window; ++d) {
      const float offset = static_cast<float>(d) * step, height = offset * offset;
      const float* before = buffer.data() + (q + window - d) * kLanes;
      const float* after = buffer.data() + (q + window + d) * kLanes;
      for (int l = 0; l < kLanes; ++l) least[l] = std::min(least[l], std::min(before[l], after[l]) + height);
    }
    std::copy_n(least, block.lanes, block.first + static_cast<std::size_t>(q) * block.stride);
  }
}

/// Transforms all columns along one axis (1 or 2) in place. Parabolas further than `max_mm` do not matter.
void transform_axis(Volume<float>& squared, int axis, double max_mm) {
  const Index3 n = squared.grid.size;
  const int length = n[static_cast<std::size_t>(axis)], across = axis == 1 ? n[2] : n[1];
  const auto step = static_cast<float>(squared.grid.spacing[axis]);
  const double reach = std::ceil(max_mm / squared.grid.spacing[axis]);
  const bool windowed = reach <= std::min(kWidestWindow, length);
  const std::size_t stride = axis == 1 ? squared.grid.offset(0, 1, 0) : squared.grid.offset(0, 0, 1);
  const std::size_t blocks = static_cast<std::size_t>((n[0] + kLanes - 1) / kLanes);
  parallel_for(static_cast<std::size_t>(across) * blocks, blocks, [&](std::size_t begin, std::size_t end) {
    std::vector<float> buffer;
    Envelope envelope(length);
    for (std::size_t b = begin; b < end; ++b) {
      const int line = static_cast<int>(b / blocks), i = static_cast<int>(b % blocks) * kLanes;
      const std::size_t offset =
          axis == 1 ? squared.grid.offset(i, 0, line) : squared.grid.offset(i, line, 0);
      const ColumnBlock block{squared.voxels.data() + offset, std::min(kLanes, n[0] - i), length, stride};
      if (windowed) {
        transform_by_window(block, step, static_cast<int>(reach), buffer);
      } else {
        transform_by_envelope(block, step, buffer, envelope);
      }
    }
  });
}

}  // namespace

Volume<float> distance_to(const LabelVolume& mask, double max_mm) {
  Volume<float> distance;
  distance.grid = mask.grid;
  distance.voxels.resize(mask.voxels.size());
  if (!detail::is_whole(mask)) return distance;
  max_mm = std::max(max_mm, 0.0);
  const Index3 n = mask.grid.size;
  const auto row_length = static_cast<std::size_t>(n[0]);
  const auto rows = static_cast<std::size_t>(n[1]) * static_cast<std::size_t>(n[2]);
  parallel_for(rows, detail::row_grain(n[0]), [&](std::size_t begin, std::size_t end) {
    for (std::size_t r = begin; r < end; ++r) {
      distance_along_row(mask.voxels.data() + r * row_length, n[0], static_cast<float>(mask.grid.spacing.x),
                         distance.voxels.data() + r * row_length);
    }
  });
  if (n[1] > 1) transform_axis(distance, 1, max_mm);
  if (n[2] > 1) transform_axis(distance, 2, max_mm);
  const auto limit = static_cast<float>(max_mm);
  parallel_for(distance.voxels.size(), 1 << 16, [&](std::size_t begin, std::size_t end) {
    for (std::size_t v = begin; v < end; ++v)
      distance.voxels[v] = std::min(std::sqrt(distance.voxels[v]), limit);
  });
  return distance;
}

}  // namespace turgor
