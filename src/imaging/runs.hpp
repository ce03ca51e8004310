// Runs of set bits in rows, joined into face-connected components.
#pragma once

#include "imaging/bit_volume.hpp"

namespace turgor::detail {

/// Set bits begin … end - 1 of one row.
struct Run {
  int begin, end;
};

/// All runs of a mask, row by row, and which component each belongs to.
struct ConnectedRuns {
  Index3 size{0, 0, 0};
  std::vector<std::size_t> row_begin;  ///< first run of each row; one more entry than rows
  std::vector<Run> runs;
  std::vector<int> component;      ///< per run: 1, 2, … by falling number of voxels, ties by first voxel
  std::vector<std::size_t> sizes;  ///< voxels of component 1, 2, …

  [[nodiscard]] std::size_t rows() const { return row_begin.size() - 1; }
  /// Component at a voxel, 0 where its bit is clear.
  [[nodiscard]] int component_at(int i, int j, int k) const;
};

/// Components by union-find over runs (as in He, Chao and Suzuki 2008); faces connect, edges and corners do
/// not.
ConnectedRuns connect_runs(const BitVolume& bits);

/// Writes value(run number) into the voxels of each run; other voxels keep theirs.
template <class T, class Value>
void paint_runs(const ConnectedRuns& connected, Volume<T>& volume, Value&& value) {
  const auto n = static_cast<std::size_t>(connected.size[0]);
  parallel_for(connected.rows(), row_grain(connected.size[0]), [&](std::size_t begin, std::size_t end) {
    for (std::size_t r = begin; r < end; ++r) {
      for (std::size_t run = connected.row_begin[r]; run < connected.row_begin[r + 1]; ++run) {
        T* row = volume.voxels.data() + r * n;
        std::fill(row + connected.runs[run].begin, row + connected.runs[run].end, value(run));
      }
    }
  });
}

}  // namespace turgor::detail
