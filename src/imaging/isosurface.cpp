#include "turgor/imaging/isosurface.hpp"

#include <bit>
#include <cmath>

#include "imaging/bit_volume.hpp"
#include "imaging/marching_table.hpp"
#include "imaging/morphology_bits.hpp"

namespace turgor {
namespace {

using detail::BitVolume;
using detail::for_each_bit;
using Word = std::uint64_t;

// The order of work is that of Flying Edges (Schroeder, Maynard and Geveci 2015): rows are classified,
// counted, and after a prefix sum every row writes its own points and triangles. Here a row's classification
// is one bit a voxel, so the crossings of 64 edges are one exclusive or, and a point's number is the count of
// set bits before its edge.

/// A point is kept this far (in voxels) from the ends of its edge, so that a voxel exactly at the level does
/// not collapse the triangles around it.
constexpr double kEndGap = 1.0 / 128;

/// Points and triangles that a row owns: the crossings on the edges which leave its voxels in the direction
/// of growing i, j and k, and the triangles of the cells which have these voxels as their lowest corner.
struct RowOffsets {
  int x = 0, y = 0, z = 0, triangles = 0;
};

/// Four rows around a row of cells, and the words that follow from them.
struct CellRow {
  const Word* row[4];  ///< at (j, k), (j + 1, k), (j, k + 1), (j + 1, k + 1)
  int cells;

  CellRow(const BitVolume& bits, int j, int k)
      : row{bits.row(bits.row_index(j, k)), bits.row(bits.row_index(j + 1, k)),
            bits.row(bits.row_index(j, k + 1)), bits.row(bits.row_index(j + 1, k + 1))},
        cells(bits.size[0] - 1) {}

  /// Bits i (`here`) and i + 1 (`there`) of the four rows, at place i.
  struct Words {
    Word here[4], there[4];
    [[nodiscard]] Word active() const {
      const Word any = here[0] | here[1] | here[2] | here[3] | there[0] | there[1] | there[2] | there[3];
      const Word all = here[0] & here[1] & here[2] & here[3] & there[0] & there[1] & there[2] & there[3];
      return any & ~all;
    }
    [[nodiscard]] std::size_t case_number(int i) const {
      Word number = 0;
      for (int r = 0; r < 4; ++r) {
        number |= ((here[r] >> i & 1) | (there[r] >> i & 1) << 1) << (2 * r);
      }
      return static_cast<std::size_t>(number);
    }
  };
  [[nodiscard]] Words words(int w) const {
    Words result;
    for (int r = 0; r < 4; ++r) {
      result.here[r] = row[r][w];
      result.there[r] = row[r][w] >> 1 | row[r][w + 1] << 63;
    }
    return result;
  }
  [[nodiscard]] Word cell_mask(int w) const { return detail::low_bits(std::min(64, cells - 64 * w)); }
  [[nodiscard]] int word_count() const { return (cells + 63) / 64; }
};

RowOffsets count_row(const BitVolume& bits, int j, int k) {
  RowOffsets count;
  const Index3 n = bits.size;
  const Word* row = bits.row(bits.row_index(j, k));
  const Word* next_j = j + 1 < n[1] ? bits.row(bits.row_index(j + 1, k)) : nullptr;
  const Word* next_k = k + 1 < n[2] ? bits.row(bits.row_index(j, k + 1)) : nullptr;
  for (int w = 0; w + 1 < bits.words; ++w) {
    const Word mask = detail::low_bits(std::clamp(n[0] - 1 - 64 * w, 0, 64));
    count.x += std::popcount((row[w] ^ (row[w] >> 1 | row[w + 1] << 63)) & mask);
    if (next_j) count.y += std::popcount(row[w] ^ next_j[w]);
    if (next_k) count.z += std::popcount(row[w] ^ next_k[w]);
  }
  if (!next_j || !next_k) return count;
  const detail::MarchingTable& table = detail::marching_table();
  const CellRow cells(bits, j, k);
  for (int w = 0; w < cells.word_count(); ++w) {
    const CellRow::Words words = cells.words(w);
    for_each_bit(words.active() & cells.cell_mask(w), 0,
                 [&](int i) { count.triangles += table[words.case_number(i)].triangles; });
  }
  return count;
}

/// Per row the numbers of its first points on edges along i, j, k and of its first triangle; one more entry
/// at the end holds the totals (points in `x`).
std::vector<RowOffsets> number_rows(const BitVolume& bits) {
  std::vector<RowOffsets> rows(bits.rows() + 1);
  parallel_for(bits.rows(), detail::row_grain(bits.size[0]), [&](std::size_t begin, std::size_t end) {
    for (std::size_t r = begin; r < end; ++r) {
      const auto ny = static_cast<std::size_t>(bits.size[1]);
      rows[r] = count_row(bits, static_cast<int>(r % ny), static_cast<int>(r / ny));
    }
  });
  RowOffsets next;
  for (RowOffsets& row : rows) {
    const RowOffsets count = row;
    row = {next.x, next.x + count.x, next.x + count.x + count.y, next.triangles};
    next.x = row.z + count.z;
    next.triangles += count.triangles;
  }
  return rows;
}

void write_triangles(const BitVolume& bits, const std::vector<RowOffsets>& rows, int j, int k, Index3* out) {
  const std::size_t ny = static_cast<std::size_t>(bits.size[1]), r = bits.row_index(j, k);
  const CellRow cells(bits, j, k);
  const detail::MarchingTable& table = detail::marching_table();
  // Numbers of the points on the edges of the present word: along i on the four rows, along j at k and k + 1,
  // along k at j and j + 1.
  int base[8] = {rows[r].x, rows[r + 1].x,  rows[r + ny].x, rows[r + ny + 1].x,
                 rows[r].y, rows[r + ny].y, rows[r].z,      rows[r + 1].z};
  for (int w = 0; w < cells.word_count(); ++w) {
    const CellRow::Words words = cells.words(w);
    const Word mask = cells.cell_mask(w);
    const Word* b = words.here;
    const Word crossed[8] = {(b[0] ^ words.there[0]) & mask,
                             (b[1] ^ words.there[1]) & mask,
                             (b[2] ^ words.there[2]) & mask,
                             (b[3] ^ words.there[3]) & mask,
                             b[0] ^ b[1],
                             b[2] ^ b[3],
                             b[0] ^ b[2],
                             b[1] ^ b[3]};
    for_each_bit(words.active() & mask, 0, [&](int i) {
      int number[8], edge[12];
      for (int s = 0; s < 8; ++s) number[s] = base[s] + std::popcount(crossed[s] & detail::low_bits(i));
      for (int s = 0; s < 4; ++s) edge[s] = number[s];
      for (int s = 4; s < 8; ++s) {
        edge[2 * s - 4] = number[s];
        edge[2 * s - 3] = number[s] + static_cast<int>(crossed[s] >> i & 1);
      }
      const detail::MarchingCase& cell = table[words.case_number(i)];
      for (int t = 0; t < cell.triangles; ++t) {
        const std::uint8_t* e = &cell.edges[3 * static_cast<std::size_t>(t)];
        *out++ = {edge[e[0]], edge[e[1]], edge[e[2]]};
      }
    });
    for (int s = 0; s < 8; ++s) base[s] += std::popcount(crossed[s]);
  }
}

/// Voxel steps in patient space, and where bit (0, 0, 0) lies.
struct Frame {
  Vec3 origin, step[3];

  Frame(const Grid& grid, int pad)
      : origin(grid.to_patient({double(-pad), double(-pad), double(-pad)})),
        step{grid.direction.c[0] * grid.spacing.x, grid.direction.c[1] * grid.spacing.y,
             grid.direction.c[2] * grid.spacing.z} {}
};

/// Writes the points of one row; fraction(i, j, k, axis) is where the level lies between a bit and the next.
template <class Fraction>
void write_points(const BitVolume& bits, const Frame& frame, int j, int k, Vec3* out, Fraction&& fraction) {
  const Index3 n = bits.size;
  const Vec3 start = frame.origin + frame.step[1] * double(j) + frame.step[2] * double(k);
  const Word* row = bits.row(bits.row_index(j, k));
  const auto write = [&](int axis, auto&& crossed) {
    for (int w = 0; w + 1 < bits.words; ++w) {
      for_each_bit(crossed(w), 64 * w, [&](int i) {
        *out++ = start + frame.step[0] * double(i) + frame.step[axis] * fraction(i, j, k, axis);
      });
    }
  };
  write(0, [&](int w) {
    const Word mask = detail::low_bits(std::clamp(n[0] - 1 - 64 * w, 0, 64));
    return (row[w] ^ (row[w] >> 1 | row[w + 1] << 63)) & mask;
  });
  for (int axis = 1; axis < 3; ++axis) {
    if ((axis == 1 ? j : k) + 1 == n[static_cast<std::size_t>(axis)]) continue;
    const Word* next = bits.row(axis == 1 ? bits.row_index(j + 1, k) : bits.row_index(j, k + 1));
    write(axis, [&](int w) { return row[w] ^ next[w]; });
  }
}

/// The surface between set and clear bits. `value(offset, inside)` is the field at a voxel of the volume;
/// crossings into the frame of a padded bit volume lie half a voxel outside.
template <class Value>
TriMesh surface_of_bits(const BitVolume& bits, const Grid& grid, int pad, double level, Value&& value) {
  TriMesh mesh;
  const std::vector<RowOffsets> rows = number_rows(bits);
  mesh.points.resize(static_cast<std::size_t>(rows.back().x));
  mesh.triangles.resize(static_cast<std::size_t>(rows.back().triangles));
  const Frame frame(grid, pad);
  const std::size_t strides[3] = {1, grid.offset(0, 1, 0), grid.offset(0, 0, 1)};
  const auto fraction = [&](int i, int j, int k, int axis) {
    const int along = axis == 0 ? i : axis == 1 ? j : k;
    if (pad && (along == 0 || along == bits.size[static_cast<std::size_t>(axis)] - 2)) return 0.5;
    const std::size_t here = grid.offset(i - pad, j - pad, k - pad);
    const bool inside = bits.test(i, j, k);
    const double a = value(here, inside), b = value(here + strides[axis], !inside);
    return std::clamp((level - a) / (b - a), kEndGap, 1 - kEndGap);
  };
  parallel_for(bits.rows(), detail::row_grain(bits.size[0]), [&](std::size_t begin, std::size_t end) {
    for (std::size_t r = begin; r < end; ++r) {
      const RowOffsets &first = rows[r], &next = rows[r + 1];
      const auto ny = static_cast<std::size_t>(bits.size[1]);
      const int j = static_cast<int>(r % ny), k = static_cast<int>(r / ny);
      if (next.x > first.x) write_points(bits, frame, j, k, mesh.points.data() + first.x, fraction);
      if (next.triangles > first.triangles) {
        write_triangles(bits, rows, j, k, mesh.triangles.data() + first.triangles);
      }
    }
  });
  return mesh;
}

}  // namespace

TriMesh isosurface(const CtVolume& volume, double level, bool close_at_border) {
  if (!detail::is_whole(volume) || !std::isfinite(level)) return {};
  const int pad = close_at_border ? 1 : 0;
  const std::int16_t* voxels = volume.voxels.data();
  return surface_of_bits(detail::pack_at_least(volume, level, pad), volume.grid, pad, level,
                         [voxels](std::size_t offset, bool) { return double(voxels[offset]); });
}

TriMesh isosurface(const LabelVolume& mask, double level, bool close_at_border) {
  if (!detail::is_whole(mask) || !std::isfinite(level)) return {};
  const int pad = close_at_border ? 1 : 0;
  return surface_of_bits(detail::pack_nonzero(mask, pad), mask.grid, pad, level,
                         [](std::size_t, bool inside) { return inside ? 1.0 : 0.0; });
}

TriMesh isosurface_within(const CtVolume& volume, double level, const LabelVolume& mask, std::uint8_t label,
                          std::int16_t outside_value, bool close_at_border) {
  if (!detail::is_whole(volume) || !detail::is_whole(mask) || volume.grid.size != mask.grid.size) return {};
  const BitVolume near = detail::dilate_box(detail::pack_equal(mask, label));
  CtVolume masked = volume;
  const int n = volume.grid.size[0];
  parallel_for(near.rows(), detail::row_grain(n), [&](std::size_t begin, std::size_t end) {
    for (std::size_t r = begin; r < end; ++r) {
      const Word* row = near.row(r);
      const std::uint8_t* labels = mask.voxels.data() + r * static_cast<std::size_t>(n);
      std::int16_t* values = masked.voxels.data() + r * static_cast<std::size_t>(n);
      for (int i = 0; i < n; ++i) {
        const bool other_body = labels[i] != 0 && labels[i] != label;
        if (other_body || !(row[i / 64] >> (i % 64) & 1)) values[i] = outside_value;
      }
    }
  });
  return isosurface(masked, level, close_at_border);
}

TriMesh isosurface_of_label(const CtVolume& volume, double level, const LabelVolume& mask, std::uint8_t label,
                            bool close_at_border) {
  if (!detail::is_whole(volume) || !detail::is_whole(mask) || volume.grid.size != mask.grid.size) return {};
  if (!std::isfinite(level)) return {};
  const int pad = close_at_border ? 1 : 0;
  const std::int16_t* voxels = volume.voxels.data();
  return surface_of_bits(detail::pack_equal(mask, label, pad), volume.grid, pad, level,
                         [voxels, level](std::size_t offset, bool inside) {
                           const double above = double(voxels[offset]) - level;
                           // One unit at least on either side, so that two voxels at the level still have a
                           // middle.
                           const double away = std::max(std::abs(above), 1.0);
                           return level + (inside ? away : -away);
                         });
}

}  // namespace turgor
