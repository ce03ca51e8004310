#include "fem/voxel_rows.hpp"

#include <algorithm>

namespace turgor::detail {
namespace {

// Cells worth a task of their own.
constexpr std::size_t kCellsPerTask = 1500;

constexpr int floor_block(int x) {
  return x & ~(kBlockCells - 1);
}
constexpr int ceil_block(int x) {
  return floor_block(x + kBlockCells - 1);
}

}  // namespace

VoxelRows::VoxelRows(const Index3& box, const std::vector<CellSpan>& spans, std::size_t present,
                     const std::vector<std::size_t>& extra_nodes)
    : cells(box) {
  const int rows_y = cells[1] + 1;
  const auto span_at = [&](int j, int k) {
    if (j < 0 || k < 0 || j >= cells[1] || k >= cells[2]) return CellSpan{};
    return spans[static_cast<std::size_t>(k) * static_cast<std::size_t>(cells[1]) +
                 static_cast<std::size_t>(j)];
  };
  for (const CellSpan& s : spans) {
    CellRow row{cell_count, floor_block(s.first), floor_block(s.first)};
    if (s.end > s.first) row.end = ceil_block(s.end);
    cell_count += static_cast<std::size_t>(row.end - row.first);
    cell_rows.push_back(row);
  }
  std::size_t offset = 0;
  for (int k = 0; k <= cells[2]; ++k) {
    planes.push_back(offset);
    for (int j = 0; j < rows_y; ++j) {
      int first = cells[0], end = 0;
      for (const CellSpan s : {span_at(j - 1, k - 1), span_at(j, k - 1), span_at(j - 1, k), span_at(j, k)}) {
        if (s.end <= s.first) continue;
        first = std::min(first, s.first), end = std::max(end, s.end + 1);
      }
      NodeRow row{offset, 0, 0};
      if (end > 0) row.first = floor_block(first), row.count = ceil_block(end) - row.first;
      offset += 3 * static_cast<std::size_t>(row.count);
      node_rows.push_back(row);
    }
    extras.push_back(offset);
    if (!extra_nodes.empty()) offset += 3 * extra_nodes[static_cast<std::size_t>(k)];
    offset += kBlockCells;
  }
  planes.push_back(offset);
  const std::size_t layer =
      std::max<std::size_t>(1, present / static_cast<std::size_t>(std::max(1, cells[2])));
  const std::size_t layers = std::max<std::size_t>(2, (kCellsPerTask + layer - 1) / layer);
  slab = static_cast<int>(std::min(layers, static_cast<std::size_t>(std::max(1, cells[2]))));
}

}  // namespace turgor::detail
