#include "geometry/voxel_fill.hpp"

#include <cstddef>

namespace turgor::detail {
namespace {

using Word = std::uint64_t;

/// Bit i of the result is the sum, modulo 2, of bits 0 to i.
Word running_parity(Word w) {
  for (int step = 1; step < 64; step *= 2) w ^= w << step;
  return w;
}

/// Spreads set bits upwards, into bits that may be entered from the bit below.
Word spread_up(Word set, Word enter) {
  for (int step = 1; step < 64; step *= 2) set |= enter & (set << step), enter &= enter << step;
  return set;
}
Word spread_down(Word set, Word enter) {
  for (int step = 1; step < 64; step *= 2) set |= enter & (set >> step), enter &= enter >> step;
  return set;
}

/// One row of the flood, which takes over what its neighbours hold.
class Flood {
 public:
  Flood(const CrossedLinks& links, VoxelGrid& reached) : links_(links), grid_(reached) {}

  /// Pulls from the rows before (or after) this one along y and z, then spreads along x. True where it grew.
  bool step(int j, int k, bool forward) {
    const auto words = static_cast<std::size_t>(grid_.words);
    const std::size_t here = grid_.row_offset(j, k);
    const std::size_t down = words, back = words * static_cast<std::size_t>(grid_.size[1]);
    bool grew = false;
    if (forward) {
      if (j > 0) grew |= pull(here, here - down, links_.any[1].data() + here - down);
      if (k > 0) grew |= pull(here, here - back, links_.any[2].data() + here - back);
    } else {
      if (j + 1 < grid_.size[1]) grew |= pull(here, here + down, links_.any[1].data() + here);
      if (k + 1 < grid_.size[2]) grew |= pull(here, here + back, links_.any[2].data() + here);
    }
    if (grew) spread(here);
    return grew;
  }

  /// Along x, in the row whose words begin at `here`.
  void spread(std::size_t here) {
    const auto words = static_cast<std::size_t>(grid_.words);
    const Word* crossed = links_.any[0].data() + here;
    Word* set = grid_.bits.data() + here;
    Word wall = 1, carry = 0;  // between this word's first bit and the last of the word before
    for (std::size_t w = 0; w < words; ++w) {
      const Word enter = ~((crossed[w] << 1) | wall);
      set[w] = spread_up(set[w] | (carry & ~wall), enter);
      wall = crossed[w] >> 63, carry = set[w] >> 63;
    }
    carry = 0;
    for (std::size_t w = words; w-- > 0;) {
      const Word enter = ~crossed[w];
      set[w] = spread_down(set[w] | ((carry << 63) & enter), enter);
      carry = set[w] & 1;
    }
  }

 private:
  bool pull(std::size_t here, std::size_t from, const Word* crossed) {
    Word grown = 0;
    for (std::size_t w = 0; w < static_cast<std::size_t>(grid_.words); ++w) {
      const Word now = grid_.bits[here + w] | (grid_.bits[from + w] & ~crossed[w]);
      grown |= now ^ grid_.bits[here + w];
      grid_.bits[here + w] = now;
    }
    return grown != 0;
  }
  const CrossedLinks& links_;
  VoxelGrid& grid_;
};

/// Whether the links from each row to the one `stride` words on are odd just where the rows differ.
bool agree(const std::vector<Word>& odd, const VoxelGrid& inside, std::size_t stride) {
  Word wrong = 0;
  for (std::size_t w = 0; w + stride < inside.bits.size(); ++w)
    wrong |= odd[w] ^ inside.bits[w] ^ inside.bits[w + stride];
  return wrong == 0;
}

}  // namespace

bool fill_by_parity(const CrossedLinks& links, VoxelGrid& inside) {
  const auto words = static_cast<std::size_t>(inside.words);
  Word wrong = 0;
  for (std::size_t row = 0; row < inside.bits.size(); row += words) {
    Word carry = 0;
    for (std::size_t w = row; w < row + words; ++w) {
      const Word parity = running_parity(links.odd[0][w]) ^ (0 - carry);
      inside.bits[w] = (parity << 1) | carry;
      carry = parity >> 63;
    }
    wrong |= carry;
  }
  // The link from a slab's last row to the next slab's first one joins two empty rows of the rim.
  return wrong == 0 && agree(links.odd[1], inside, words) &&
         agree(links.odd[2], inside, words * static_cast<std::size_t>(inside.size[1]));
}

VoxelGrid flood_outside(const CrossedLinks& links, VoxelGrid seeds) {
  std::fill_n(seeds.row(0, 0), seeds.words, ~Word{0});
  Flood flood(links, seeds);
  const int rows = seeds.size[1], slabs = seeds.size[2];
  for (int k = 0; k < slabs; ++k)
    for (int j = 0; j < rows; ++j) flood.spread(seeds.row_offset(j, k));
  for (bool grew = true; grew;) {
    grew = false;
    for (int k = 0; k < slabs; ++k)
      for (int j = 0; j < rows; ++j) grew |= flood.step(j, k, true);
    for (int k = slabs - 1; k >= 0; --k)
      for (int j = rows - 1; j >= 0; --j) grew |= flood.step(j, k, false);
  }
  return seeds;
}

}  // namespace turgor::detail
