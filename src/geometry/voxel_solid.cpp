// From voxels to tetrahedra. Corners of cubes are bits of a grid of their own; the number of a point is the
// count of bits before it.
#include "turgor/geometry/voxel_solid.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <limits>

#include "turgor/core/index.hpp"
#include "turgor/core/parallel.hpp"

namespace turgor {
namespace {

using Word = std::uint64_t;

/// Corner c of a cube lies at x = c & 1, y = c >> 1 & 1, z = c >> 2. In an even cube the corners with one or
/// three bits are cut off, in an odd one, its mirror image along x, the others. The first four tetrahedra lie
/// at corners 1, 2, 4, 7 (mirrored: 0, 3, 5, 6), the last in the middle.
using Corners = std::array<int, 8>;
constexpr int kSplit[2][5][4] = {
    {{0, 1, 3, 5}, {0, 3, 2, 6}, {0, 5, 6, 4}, {3, 6, 5, 7}, {0, 5, 3, 6}},
    {{1, 2, 0, 4}, {1, 3, 2, 7}, {1, 7, 4, 5}, {2, 4, 7, 6}, {1, 2, 4, 7}},
};
/// Sides towards -x, +x, -y, +y, -z, +z, anticlockwise seen from outside, from a corner with one or three
/// bits.
constexpr int kSides[6][4] = {{4, 6, 2, 0}, {1, 3, 7, 5}, {1, 5, 4, 0},
                              {2, 6, 7, 3}, {2, 3, 1, 0}, {4, 5, 7, 6}};
/// Which of an even cube's tetrahedra cuts off a corner.
constexpr int kCut[8] = {-1, 0, 1, -1, 2, -1, -1, 3};

Word bit_before(const Word* row, int w) {
  return w > 0 ? row[w - 1] >> 63 : 0;
}

/// The corners of all cubes.
struct CornerGrid {
  VoxelGrid used;
  std::vector<int> first;  ///< number of each word's first point

  [[nodiscard]] int number(std::size_t row, int i) const {
    const std::size_t word = row + at(i / 64);
    return first[word] + std::popcount(used.bits[word] & ((Word{1} << (i % 64)) - 1));
  }
};

/// Combines the four rows of voxels around a row of corners.
template <class Combine>
Word around(const VoxelGrid& voxels, int j, int k, int w, Word outside, Combine combine) {
  Word result = 0;
  bool begun = false;
  for (const int dk : {-1, 0}) {
    for (const int dj : {-1, 0}) {
      Word both = outside;
      if (j + dj >= 0 && k + dk >= 0 && j + dj < voxels.size[1] && k + dk < voxels.size[2]) {
        const Word* row = voxels.row(j + dj, k + dk);
        both = combine(row[w], (row[w] << 1) | bit_before(row, w));
      }
      result = begun ? combine(result, both) : both;
      begun = true;
    }
  }
  return result;
}
Word corner_word(const VoxelGrid& voxels, int j, int k, int w) {
  return around(voxels, j, k, w, 0, [](Word a, Word b) { return a | b; });
}
/// Corners with voxels all around.
Word inner_word(const VoxelGrid& voxels, int j, int k, int w) {
  return around(voxels, j, k, w, 0, [](Word a, Word b) { return a & b; });
}

/// Running sums, from zero; the total comes last.
std::vector<std::int64_t> offsets_of(const std::vector<std::int64_t>& counts) {
  std::vector<std::int64_t> offsets(counts.size() + 1);
  for (std::size_t i = 0; i < counts.size(); ++i) offsets[i + 1] = offsets[i] + counts[i];
  return offsets;
}

template <class Body>
void for_each_slab(int slabs, Body body) {
  parallel_for(at(slabs), 1, [&](std::size_t begin, std::size_t end) {
    for (std::size_t k = begin; k < end; ++k) body(static_cast<int>(k));
  });
}

CornerGrid corners_of(const VoxelGrid& voxels) {
  CornerGrid corners{VoxelGrid({voxels.size[0], voxels.size[1] + 1, voxels.size[2] + 1}), {}};
  corners.first.resize(corners.used.bits.size());
  const int slabs = corners.used.size[2], rows = corners.used.size[1];
  std::vector<std::int64_t> counts(at(slabs));
  for_each_slab(slabs, [&](int k) {
    for (int j = 0; j < rows; ++j) {
      Word* row = corners.used.row(j, k);
      for (int w = 0; w < voxels.words; ++w)
        row[w] = corner_word(voxels, j, k, w), counts[at(k)] += std::popcount(row[w]);
    }
  });
  const std::vector<std::int64_t> offsets = offsets_of(counts);
  for_each_slab(slabs, [&](int k) {
    auto next = static_cast<int>(offsets[at(k)]);
    const std::size_t begin = corners.used.row_offset(0, k), end = begin + at(rows) * at(voxels.words);
    for (std::size_t w = begin; w < end; ++w)
      corners.first[w] = next, next += std::popcount(corners.used.bits[w]);
  });
  return corners;
}

void place_points(const VoxelGrid& voxels, const CornerGrid& corners, SolidMesh& solid) {
  for_each_slab(corners.used.size[2], [&](int k) {
    for (int j = 0; j < corners.used.size[1]; ++j) {
      const Vec3 start = voxels.lower + Vec3{0, j * voxels.spacing, k * voxels.spacing};
      const std::size_t row = corners.used.row_offset(j, k);
      for (int w = 0; w < voxels.words; ++w) {
        const Word inner = inner_word(voxels, j, k, w);
        std::size_t p = at(corners.first[row + at(w)]);
        for (Word left = corners.used.bits[row + at(w)]; left != 0; left &= left - 1, ++p) {
          const int bit = std::countr_zero(left);
          solid.points[p] = {start.x + (64 * w + bit) * voxels.spacing, start.y, start.z};
          solid.on_surface[p] = static_cast<std::uint8_t>(((inner >> bit) & 1) ^ 1);
        }
      }
    }
  });
}

/// What is written slab by slab.
class SolidWriter {
 public:
  SolidWriter(const VoxelGrid& voxels, const CornerGrid& corners, SolidMesh& solid)
      : voxels_(voxels), corners_(corners), solid_(solid) {}

  /// `cell` and `side` are the slab's first cube and first surface triangle.
  void slab(int k, std::int64_t cell, std::int64_t side) {
    for (int j = 0; j < voxels_.size[1]; ++j) {
      for (int w = 0; w < voxels_.words; ++w) {
        const Word set = voxels_.row(j, k)[w];
        if (set == 0) continue;
        split(set, w, j, k, cell);
        cover(set, w, j, k, cell, side);
        cell += std::popcount(set);
      }
    }
  }
  /// The set bits whose neighbour on a side is not.
  [[nodiscard]] std::array<Word, 6> bare(Word set, int w, int j, int k) const {
    const Word* row = voxels_.row(j, k);
    const Word next = w + 1 < voxels_.words ? row[w + 1] << 63 : 0;
    // Voxels of the rim are empty, so every set one has rows around it.
    return {set & ~((row[w] << 1) | bit_before(row, w)),
            set & ~((row[w] >> 1) | next),
            set & ~voxels_.row(j - 1, k)[w],
            set & ~voxels_.row(j + 1, k)[w],
            set & ~voxels_.row(j, k - 1)[w],
            set & ~voxels_.row(j, k + 1)[w]};
  }

 private:
  [[nodiscard]] Corners corners_at(int i, int j, int k) const {
    Corners c{};
    for (int r = 0; r < 4; ++r) {
      c[at(2 * r)] = corners_.number(corners_.used.row_offset(j + (r & 1), k + (r >> 1)), i);
      c[at(2 * r + 1)] = c[at(2 * r)] + 1;  // both ends of a cube's edge are used
    }
    return c;
  }
  template <int odd>
  static void split_cube(const Corners& c, std::array<int, 4>* to) {
    for (std::size_t t = 0; t < 5; ++t)
      for (std::size_t n = 0; n < 4; ++n) to[t][n] = c[at(kSplit[odd][t][n])];
  }
  /// Run by run of set bits: along a run all numbers rise by one.
  void split(Word set, int w, int j, int k, std::int64_t cell) {
    std::array<int, 4>* to = solid_.tetrahedra.data() + 5 * cell;
    while (set != 0) {
      const int begin = std::countr_zero(set), length = std::countr_one(set >> begin);
      const int i = 64 * w + begin;
      Corners c = corners_at(i, j, k);
      for (int n = 0; n < length; ++n, to += 5) {
        if ((i + n + j + k) % 2 == 0) {
          split_cube<0>(c, to);
        } else {
          split_cube<1>(c, to);
        }
        for (int& p : c) ++p;
      }
      set &= begin + length == 64 ? 0 : ~Word{0} << (begin + length);
    }
  }
  void cover(Word set, int w, int j, int k, std::int64_t cell, std::int64_t& side) {
    const std::array<Word, 6> open = bare(set, w, j, k);
    for (Word left = open[0] | open[1] | open[2] | open[3] | open[4] | open[5]; left != 0; left &= left - 1) {
      const int bit = std::countr_zero(left), i = 64 * w + bit;
      const Corners c = corners_at(i, j, k);
      const std::int64_t here = cell + std::popcount(set & ((Word{1} << bit) - 1));
      for (std::size_t s = 0; s < 6; ++s) {
        if (((open[s] >> bit) & 1) != 0) cover_side(kSides[s], c, (i + j + k) % 2, here, side), side += 2;
      }
    }
  }
  /// Two triangles, each the outside of the tetrahedron at its corner that the diagonal leaves out.
  void cover_side(const int (&quad)[4], const Corners& c, int odd, std::int64_t cell, std::int64_t side) {
    for (int half = 0; half < 2; ++half) {
      const auto corner = [&](int n) { return quad[(odd + 2 * half + n) % 4]; };
      const std::size_t to = static_cast<std::size_t>(side + half);
      solid_.surface_triangles[to] = {c[at(corner(0))], c[at(corner(1))], c[at(corner(3))]};
      solid_.surface_cells[to] = static_cast<int>(5 * cell) + kCut[corner(0) ^ odd];
    }
  }

  const VoxelGrid& voxels_;
  const CornerGrid& corners_;
  SolidMesh& solid_;
};

}  // namespace

Result<SolidMesh> solid_of(const VoxelGrid& voxels) {
  const CornerGrid corners = corners_of(voxels);
  SolidMesh solid;
  solid.spacing = voxels.spacing;
  SolidWriter writer(voxels, corners, solid);
  std::vector<std::int64_t> cubes(at(voxels.size[2])), sides(cubes.size());
  for_each_slab(voxels.size[2], [&](int k) {
    for (int j = 0; j < voxels.size[1]; ++j) {
      for (int w = 0; w < voxels.words; ++w) {
        const Word set = voxels.row(j, k)[w];
        if (set == 0) continue;
        cubes[at(k)] += std::popcount(set);
        for (const Word open : writer.bare(set, w, j, k)) sides[at(k)] += 2 * std::popcount(open);
      }
    }
  });
  const std::vector<std::int64_t> cells = offsets_of(cubes), faces = offsets_of(sides);
  if (cells.back() > std::numeric_limits<int>::max() / 20) {
    return Error{ErrorKind::bad_input, fmt::format("{} voxels are too many to number", cells.back()), "",
                 "Give a lower resolution"};
  }
  std::size_t points = 0;
  for (const Word word : corners.used.bits) points += at(std::popcount(word));
  solid.points.resize(points), solid.on_surface.resize(points);
  solid.tetrahedra.resize(5 * static_cast<std::size_t>(cells.back()));
  solid.surface_triangles.resize(static_cast<std::size_t>(faces.back()));
  solid.surface_cells.resize(static_cast<std::size_t>(faces.back()));
  place_points(voxels, corners, solid);
  for_each_slab(voxels.size[2], [&](int k) { writer.slab(k, cells[at(k)], faces[at(k)]); });
  return solid;
}

std::vector<std::array<int, 8>> hexahedra(const SolidMesh& solid) {
  std::vector<std::array<int, 8>> cubes(solid.tetrahedra.size() / 5);
  parallel_for(cubes.size(), 4096, [&](std::size_t begin, std::size_t end) {
    for (std::size_t c = begin; c < end; ++c) {
      std::array<int, 16> p{};
      for (std::size_t n = 0; n < 16; ++n) p[n] = solid.tetrahedra[5 * c + n / 4][n % 4];
      // Points are numbered along x, then y, then z: in rising order they are corners 0 to 7.
      std::sort(p.begin(), p.end());
      (void)std::unique(p.begin(), p.end());
      cubes[c] = {p[0], p[1], p[3], p[2], p[4], p[5], p[7], p[6]};
    }
  });
  return cubes;
}

}  // namespace turgor
