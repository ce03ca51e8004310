// Shells that overlap are joined, nested ones are cavities.
#include <algorithm>
#include <bit>
#include <cstdlib>
#include <map>
#include <numeric>
#include <utility>

#include "geometry/voxel_fill.hpp"
#include "turgor/core/index.hpp"

namespace turgor::detail {
namespace {

/// A crossing of a row of voxels, between `voxel` and the next.
struct RowCrossing {
  std::size_t row;         // offset of its words
  int voxel, shell, step;  // step +1 where the surface faces along x
};

/// The shell of each triangle: joined through points at one place.
std::vector<int> shells_of(const Lattice& lattice) {
  std::vector<int> root(lattice.points.size());
  std::iota(root.begin(), root.end(), 0);
  const auto find = [&](int p) {
    while (root[at(p)] != p) p = root[at(p)] = root[at(root[at(p)])];
    return p;
  };
  for (const auto& [a, b] : coinciding_points(lattice)) root[at(find(a))] = find(b);
  for (const Index3& t : lattice.triangles)
    root[at(find(t[0]))] = find(t[1]), root[at(find(t[1]))] = find(t[2]);
  std::vector<int> shells(lattice.triangles.size());
  for (std::size_t t = 0; t < shells.size(); ++t) shells[t] = find(lattice.triangles[t][0]);
  return shells;
}

std::vector<RowCrossing> row_crossings(const Lattice& lattice, const VoxelGrid& grid) {
  const std::vector<int> shells = shells_of(lattice);
  const LineCrossings<0> along_x(lattice);
  std::vector<RowCrossing> all;
  for (std::size_t t = 0; t < shells.size(); ++t) {
    along_x(lattice.triangles[t], [&](const Index3& at, bool forward) {
      all.push_back({grid.row_offset(at[1], at[2]), at[0], shells[t], forward ? 1 : -1});
    });
  }
  std::sort(all.begin(), all.end(), [](const RowCrossing& a, const RowCrossing& b) {
    return std::pair(a.row, a.voxel) < std::pair(b.row, b.voxel);
  });
  return all;
}

/// How often each shell has been crossed on the way along a row, and the sum of the crossings' signs.
struct Passed {
  int count = 0, sum = 0;
};
using RowState = std::map<int, Passed>;

void pass(RowState& state, const RowCrossing& crossing) {
  Passed& passed = state[crossing.shell];
  ++passed.count, passed.sum += crossing.step;
}

/// In how many others each shell lies wholly: at every crossing of it their inside is on either hand.
class Nesting {
 public:
  explicit Nesting(const std::vector<RowCrossing>& crossings) {
    for (auto c = crossings.begin(); c != crossings.end();) {
      RowState state;
      for (const std::size_t row = c->row; c != crossings.end() && c->row == row;)
        c = link(c, crossings, state);
    }
    for (const auto& [pair, count] : within_) {
      const auto back = within_.find({pair.second, pair.first});
      const bool mutual = back != within_.end() && back->second == total_[pair.second];
      if (count == total_[pair.first] && !mutual) ++depth_[pair.first];
    }
  }
  [[nodiscard]] bool is_cavity(int shell) const {
    const auto found = depth_.find(shell);
    return found != depth_.end() && found->second % 2 == 1;
  }

 private:
  using Iterator = std::vector<RowCrossing>::const_iterator;
  /// Passes all crossings of one link.
  Iterator link(Iterator first, const std::vector<RowCrossing>& crossings, RowState& state) {
    RowState before = state;
    Iterator last = first;
    for (; last != crossings.end() && last->row == first->row && last->voxel == first->voxel; ++last)
      pass(state, *last);
    for (Iterator c = first; c != last; ++c) {
      ++total_[c->shell];
      for (const auto& [other, after] : state) {
        if (other != c->shell && (after.count % 2 == 1 || before[other].count % 2 == 1))
          ++within_[{c->shell, other}];
      }
    }
    std::erase_if(state, [](const auto& entry) { return entry.second.count % 2 == 0; });
    return last;
  }
  std::map<std::pair<int, int>, int> within_;
  std::map<int, int> total_, depth_;
};

/// Bodies less cavities that hold the place. A shell that turns twice about it overlaps itself there.
bool is_inside(const RowState& state, const Nesting& nesting) {
  int bodies = 0;
  for (const auto& [shell, passed] : state) {
    if (passed.count % 2 == 1 || std::abs(passed.sum) >= 2) bodies += nesting.is_cavity(shell) ? -1 : 1;
  }
  return bodies > 0;
}

}  // namespace

void resolve_shells(const Lattice& lattice, const VoxelGrid& doubtful, VoxelGrid& inside) {
  const std::vector<RowCrossing> crossings = row_crossings(lattice, doubtful);
  const Nesting nesting(crossings);
  for (auto c = crossings.begin(); c != crossings.end();) {
    const std::size_t row = c->row;
    RowState state;
    for (int w = 0; w < doubtful.words; ++w) {
      for (std::uint64_t left = doubtful.bits[row + at(w)]; left != 0; left &= left - 1) {
        const int voxel = 64 * w + std::countr_zero(left);
        for (; c != crossings.end() && c->row == row && c->voxel < voxel; ++c) pass(state, *c);
        if (is_inside(state, nesting)) inside.bits[row + at(w)] |= left & (0 - left);
      }
    }
    while (c != crossings.end() && c->row == row) ++c;
  }
}

}  // namespace turgor::detail
