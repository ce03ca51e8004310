// Where the values of a lattice's nodes and cells lie: rows along x that begin and end with the body, in
// blocks of eight, so that eight neighbouring cells are worked on at once. Internal.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "turgor/math/vec.hpp"

namespace turgor::detail {

inline constexpr int kBlockCells = 8;

/// Component c of node x lies at offset + c · count + x − first.
struct NodeRow {
  std::size_t offset = 0;
  int first = 0, count = 0;  ///< multiples of eight
};

/// Cell x lies at offset + x − first.
struct CellRow {
  std::size_t offset = 0;
  int first = 0, end = 0;  ///< multiples of eight
};

/// Component c of a node is value + c · stride; stride 0: no node.
struct NodePlace {
  std::uint32_t value = 0, stride = 0;
  [[nodiscard]] std::size_t component(std::size_t c) const { return value + c * stride; }
};

/// Cells first to end − 1 of a row along x that are there, with gaps; first == end: none.
struct CellSpan {
  int first = 0, end = 0;
};

struct VoxelRows {
  Index3 cells{0, 0, 0};           ///< of the box around the body
  std::vector<NodeRow> node_rows;  ///< (j, k) at k (cells[1] + 1) + j
  std::vector<CellRow> cell_rows;  ///< (j, k) at k cells[1] + j
  /// Offset of the first value of each plane of nodes, and of the end. After its rows a plane has its extra
  /// nodes, three values each, and a block that is not used, as blocks are read one value past their end.
  std::vector<std::size_t> planes;
  std::vector<std::size_t> extras;  ///< offset of the extra nodes of each plane
  std::size_t cell_count = 0;       ///< with what fills up the blocks
  int slab = 1;                     ///< layers of cells that one task works on

  VoxelRows() = default;
  /// `spans` by rows as above; `present`: about how many cells there are; `extra_nodes` of each plane, or
  /// empty.
  VoxelRows(const Index3& box, const std::vector<CellSpan>& spans, std::size_t present,
            const std::vector<std::size_t>& extra_nodes = {});

  /// Of all three components, with what fills up the blocks: the length of vectors over the nodes.
  [[nodiscard]] std::size_t values() const { return planes.back(); }
  [[nodiscard]] const NodeRow& node_row(int j, int k) const {
    return node_rows[static_cast<std::size_t>(k) * static_cast<std::size_t>(cells[1] + 1) +
                     static_cast<std::size_t>(j)];
  }
  [[nodiscard]] const CellRow& cell_row(int j, int k) const {
    return cell_rows[static_cast<std::size_t>(k) * static_cast<std::size_t>(cells[1]) +
                     static_cast<std::size_t>(j)];
  }
  [[nodiscard]] NodePlace node(int i, int j, int k) const {
    const NodeRow& row = node_row(j, k);
    return {static_cast<std::uint32_t>(row.offset + static_cast<std::size_t>(i - row.first)),
            static_cast<std::uint32_t>(row.count)};
  }
  /// The corners of a cell, by bits x 1, y 2, z 4.
  [[nodiscard]] std::array<NodePlace, 8> corners(int i, int j, int k) const {
    std::array<NodePlace, 8> out;
    for (int c = 0; c < 8; ++c)
      out[static_cast<std::size_t>(c)] = node(i + (c & 1), j + ((c >> 1) & 1), k + (c >> 2));
    return out;
  }
  /// cell_count where there is no place for the cell.
  [[nodiscard]] std::size_t cell(int i, int j, int k) const {
    if (i < 0 || j < 0 || k < 0 || j >= cells[1] || k >= cells[2]) return cell_count;
    const CellRow& row = cell_row(j, k);
    return i < row.first || i >= row.end ? cell_count : row.offset + static_cast<std::size_t>(i - row.first);
  }
};

}  // namespace turgor::detail
