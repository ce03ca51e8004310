#include <algorithm>
#include <cmath>

#include "imaging/bit_volume.hpp"
#include "imaging/morphology_bits.hpp"
#include "turgor/imaging/segmentation.hpp"

namespace turgor {
namespace detail {
namespace {

using Word = std::uint64_t;

/// Each set bit of a row also sets its two neighbours.
void widen_row(std::vector<Word>& row) {
  Word before = 0;
  for (std::size_t w = 0; w < row.size(); ++w) {
    const Word here = row[w], after = w + 1 < row.size() ? row[w + 1] : 0;
    row[w] = here | here << 1 | before >> 63 | here >> 1 | after << 63;
    before = here;
  }
}

/// The rows are taken widest first: what is gathered so far widens by one voxel for each step down in width,
/// so a row entered at width w has been widened w times at the end.
void dilate_row(const BitVolume& bits, const std::vector<BallRow>& ball, int j, int k, std::vector<Word>& row,
                Word* out) {
  std::fill(row.begin(), row.end(), 0);
  const auto used = static_cast<std::size_t>(bits.words - 1);
  int width = ball.front().width;
  bool any = false;
  for (const BallRow& offset : ball) {
    for (; width > offset.width; --width) {
      if (any) widen_row(row);
    }
    const int jj = j + offset.dj, kk = k + offset.dk;
    if (jj < 0 || kk < 0 || jj >= bits.size[1] || kk >= bits.size[2]) continue;
    const Word* from = bits.row(bits.row_index(jj, kk));
    Word seen = 0;
    for (std::size_t w = 0; w < used; ++w) {
      row[w] |= from[w];
      seen |= from[w];
    }
    any = any || seen != 0;
  }
  for (; any && width > 0; --width) widen_row(row);
  for (std::size_t w = 0; w < used; ++w) {
    out[w] = row[w] & low_bits(std::clamp(bits.size[0] - 64 * static_cast<int>(w), 0, 64));
  }
}

}  // namespace

std::vector<BallRow> ball_rows(const Vec3& spacing, double radius_mm) {
  // A relative allowance, so that a radius of three voxels reaches the third whatever the rounding.
  const double limit = radius_mm * radius_mm * (1 + 1e-6);
  const int reach_j = static_cast<int>(std::sqrt(limit) / spacing.y);
  const int reach_k = static_cast<int>(std::sqrt(limit) / spacing.z);
  std::vector<BallRow> rows;
  for (int dk = -reach_k; dk <= reach_k; ++dk) {
    for (int dj = -reach_j; dj <= reach_j; ++dj) {
      const double y = dj * spacing.y, z = dk * spacing.z, rest = limit - y * y - z * z;
      if (rest >= 0) rows.push_back({dj, dk, static_cast<int>(std::sqrt(rest) / spacing.x)});
    }
  }
  std::stable_sort(rows.begin(), rows.end(),
                   [](const BallRow& a, const BallRow& b) { return a.width > b.width; });
  return rows;
}

BitVolume dilate_rows(const BitVolume& bits, const std::vector<BallRow>& ball) {
  BitVolume result(bits.size);
  parallel_for(bits.rows(), row_grain(bits.size[0]), [&](std::size_t begin, std::size_t end) {
    std::vector<Word> row(static_cast<std::size_t>(bits.words));
    for (std::size_t r = begin; r < end; ++r) {
      const auto ny = static_cast<std::size_t>(bits.size[1]);
      dilate_row(bits, ball, static_cast<int>(r % ny), static_cast<int>(r / ny), row, result.row(r));
    }
  });
  return result;
}

BitVolume dilate_box(const BitVolume& bits) {
  std::vector<BallRow> box;
  for (int dk = -1; dk <= 1; ++dk) {
    for (int dj = -1; dj <= 1; ++dj) box.push_back({dj, dk, 1});
  }
  return dilate_rows(bits, box);
}

namespace {

/// Up to here going through the rows of the ball is quicker than the distance transform.
constexpr std::size_t kMostBallRows = 2000;

BitVolume dilate_bits(const BitVolume& bits, const Grid& grid, double radius_mm) {
  // A ball that covers the volume from any voxel needs no more rows than the volume has.
  const Vec3 extent{grid.size[0] * grid.spacing.x, grid.size[1] * grid.spacing.y,
                    grid.size[2] * grid.spacing.z};
  const double radius = std::min(radius_mm, length(extent));
  const double rows = 3.2 * radius * radius / (grid.spacing.y * grid.spacing.z);
  if (rows <= static_cast<double>(kMostBallRows)) return dilate_rows(bits, ball_rows(grid.spacing, radius));
  const Volume<float> distance = distance_to(unpack(bits, grid), radius * 1.01);
  const auto limit = static_cast<float>(radius * (1 + 5e-7));
  return pack(distance, 0, [limit](float d) { return d <= limit; });
}

}  // namespace
}  // namespace detail

LabelVolume dilate(const LabelVolume& mask, double radius_mm) {
  if (!detail::is_whole(mask)) return mask;
  const detail::BitVolume bits = detail::pack_nonzero(mask);
  if (!(radius_mm > 0)) return detail::unpack(bits, mask.grid);
  return detail::unpack(detail::dilate_bits(bits, mask.grid, radius_mm), mask.grid);
}

LabelVolume erode(const LabelVolume& mask, double radius_mm) {
  if (!detail::is_whole(mask)) return mask;
  const detail::BitVolume bits = detail::pack_nonzero(mask);
  if (!(radius_mm > 0)) return detail::unpack(bits, mask.grid);
  const detail::BitVolume outside = detail::dilate_bits(detail::complement(bits), mask.grid, radius_mm);
  return detail::unpack(detail::complement(outside), mask.grid);
}

LabelVolume close_gaps(const LabelVolume& mask, double radius_mm) {
  if (!detail::is_whole(mask)) return mask;
  const detail::BitVolume bits = detail::pack_nonzero(mask);
  if (!(radius_mm > 0)) return detail::unpack(bits, mask.grid);
  const detail::BitVolume grown = detail::dilate_bits(bits, mask.grid, radius_mm);
  const detail::BitVolume outside = detail::dilate_bits(detail::complement(grown), mask.grid, radius_mm);
  return detail::unpack(detail::complement(outside), mask.grid);
}

LabelVolume open_gaps(const LabelVolume& mask, double radius_mm) {
  if (!detail::is_whole(mask)) return mask;
  const detail::BitVolume bits = detail::pack_nonzero(mask);
  if (!(radius_mm > 0)) return detail::unpack(bits, mask.grid);
  const detail::BitVolume outside = detail::dilate_bits(detail::complement(bits), mask.grid, radius_mm);
  return detail::unpack(detail::dilate_bits(detail::complement(outside), mask.grid, radius_mm), mask.grid);
}

}  // namespace turgor
