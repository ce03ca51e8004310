#include <algorithm>
#include <array>
#include <cstring>

#include "imaging/bit_volume.hpp"
#include "turgor/imaging/filter.hpp"

namespace turgor {
namespace {

/// Sixteen voxels side by side; the compiler makes one instruction of each minimum and maximum.
constexpr int kLanes = 16;
using Lanes = std::int16_t __attribute__((vector_size(2 * kLanes)));

inline void sort_pair(Lanes& a, Lanes& b) {
  const Lanes low = a < b ? a : b;
  b = a < b ? b : a;
  a = low;
}

/// Brings the smallest of Count values to the front and the largest to the end.
template <int Count>
inline void extremes_to_ends(Lanes* v) {
  for (int i = 0; i < Count / 2; ++i) sort_pair(v[i], v[Count - 1 - i]);
  for (int i = 1; i < (Count + 1) / 2; ++i) sort_pair(v[0], v[i]);
  for (int i = Count / 2; i < Count - 1; ++i) sort_pair(v[i], v[Count - 1]);
}

/// Forgetful selection: among more than half of the values, neither the smallest nor the largest can be the
/// median; they are dropped and the next value takes part. Entry `Next` of the 27 enters in place of the
/// smallest; the largest is forgotten by shortening the list.
template <int Count>
inline void select_median(Lanes* v, const Lanes* waiting, Lanes& median) {
  extremes_to_ends<Count>(v);
  if constexpr (Count == 3) {
    median = v[1];
  } else {
    v[0] = *waiting;
    select_median<Count - 1>(v, waiting + 1, median);
  }
}

/// Rows of voxels with one more at either end (the end voxel again) and room for whole vectors.
class PaddedRows {
 public:
  PaddedRows(int row_length, int rows)
      : length_(row_length),
        stride_(static_cast<std::size_t>((row_length + kLanes - 1) / kLanes * kLanes + 2)),
        values_(stride_ * static_cast<std::size_t>(rows)) {}

  void set(int row, const std::int16_t* from) {
    std::int16_t* to = values_.data() + static_cast<std::size_t>(row) * stride_;
    to[0] = from[0];
    std::copy_n(from, length_, to + 1);
    std::fill(to + 1 + length_, to + stride_, from[length_ - 1]);
  }
  /// Voxels i - 1 … of the row, for i = 0 at the row's first voxel.
  void load(int row, int i, Lanes& lanes) const {
    std::memcpy(&lanes, values_.data() + static_cast<std::size_t>(row) * stride_ + i, sizeof lanes);
  }

 private:
  int length_;
  std::size_t stride_;
  std::vector<std::int16_t> values_;
};

void filter_row(const PaddedRows& rows, int length, std::int16_t* out) {
  for (int i = 0; i < length; i += kLanes) {
    Lanes values[27];
    for (int r = 0; r < 9; ++r) {
      for (int d = 0; d < 3; ++d) rows.load(r, i + d, values[3 * r + d]);
    }
    Lanes median;
    select_median<15>(values, values + 15, median);
    std::memcpy(out + i, &median,
                static_cast<std::size_t>(std::min(kLanes, length - i)) * sizeof(std::int16_t));
  }
}

}  // namespace

CtVolume median_filter(const CtVolume& volume) {
  CtVolume result;
  result.grid = volume.grid;
  result.voxels.resize(volume.voxels.size());
  if (!detail::is_whole(volume)) return result;
  const Index3 n = volume.grid.size;
  const auto rows = static_cast<std::size_t>(n[1]) * static_cast<std::size_t>(n[2]);
  parallel_for(rows, detail::row_grain(n[0]), [&](std::size_t begin, std::size_t end) {
    PaddedRows around(n[0], 9);
    for (std::size_t r = begin; r < end; ++r) {
      const int j = static_cast<int>(r % static_cast<std::size_t>(n[1]));
      const int k = static_cast<int>(r / static_cast<std::size_t>(n[1]));
      // The three columns of rows are used in a circle; only the new one is read, except at the start of a
      // slice.
      const bool start = r == begin || j == 0;
      for (int dj = start ? -1 : 1; dj <= 1; ++dj) {
        for (int dk = -1; dk <= 1; ++dk) {
          const int jj = std::clamp(j + dj, 0, n[1] - 1), kk = std::clamp(k + dk, 0, n[2] - 1);
          around.set((j + dj + 3) % 3 * 3 + dk + 1, volume.voxels.data() + volume.grid.offset(0, jj, kk));
        }
      }
      filter_row(around, n[0], result.voxels.data() + volume.grid.offset(0, j, k));
    }
  });
  return result;
}

}  // namespace turgor
