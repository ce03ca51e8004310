#include "imaging/runs.hpp"

#include <algorithm>
#include <numeric>

namespace turgor::detail {
namespace {

using Word = std::uint64_t;

/// Slices that are joined among themselves on one thread before the slabs are joined to each other.
constexpr std::size_t kSlabSlices = 8;

void find_runs(const BitVolume& bits, ConnectedRuns& out) {
  const std::size_t rows = bits.rows();
  out.size = bits.size;
  out.row_begin.assign(rows + 1, 0);
  const auto starts = [&](const Word* row, int w) {
    return row[w] & ~(row[w] << 1 | (w ? row[w - 1] >> 63 : 0));
  };
  parallel_for(rows, row_grain(bits.size[0]), [&](std::size_t begin, std::size_t end) {
    for (std::size_t r = begin; r < end; ++r) {
      int count = 0;
      for (int w = 0; w < bits.words; ++w) count += std::popcount(starts(bits.row(r), w));
      out.row_begin[r + 1] = static_cast<std::size_t>(count);
    }
  });
  std::partial_sum(out.row_begin.begin(), out.row_begin.end(), out.row_begin.begin());
  out.runs.resize(out.row_begin.back());
  parallel_for(rows, row_grain(bits.size[0]), [&](std::size_t begin, std::size_t end) {
    for (std::size_t r = begin; r < end; ++r) {
      const Word* row = bits.row(r);
      Run* first = out.runs.data() + out.row_begin[r];
      Run* last = first;
      for (int w = 0; w < bits.words; ++w) {
        for_each_bit(starts(row, w), 64 * w, [&](int i) { (first++)->begin = i; });
        // A run ends where a clear bit follows a set one; the closing zero word ends the last.
        const Word ends = ~row[w] & (row[w] << 1 | (w ? row[w - 1] >> 63 : 0));
        for_each_bit(ends, 64 * w, [&](int i) { (last++)->end = i; });
      }
    }
  });
}

/// Union-find whose root is the smallest run of a set, so a slab's trees never leave the slab's runs.
class Forest {
 public:
  explicit Forest(std::size_t count) : parent_(count) { std::iota(parent_.begin(), parent_.end(), 0); }

  void join(std::size_t a, std::size_t b) {
    const int ra = root(static_cast<int>(a)), rb = root(static_cast<int>(b));
    parent_[static_cast<std::size_t>(std::max(ra, rb))] = std::min(ra, rb);
  }
  /// After this every run names its root. Parents come before their children.
  std::vector<int> flatten() && {
    for (int& p : parent_) p = parent_[static_cast<std::size_t>(p)];
    return std::move(parent_);
  }

 private:
  int root(int run) {
    while (true) {
      int& up = parent_[static_cast<std::size_t>(run)];
      if (up == run) return run;
      up = parent_[static_cast<std::size_t>(up)];
      run = up;
    }
  }
  std::vector<int> parent_;
};

void join_rows(const ConnectedRuns& c, std::size_t row_a, std::size_t row_b, Forest& forest) {
  std::size_t a = c.row_begin[row_a], b = c.row_begin[row_b];
  while (a < c.row_begin[row_a + 1] && b < c.row_begin[row_b + 1]) {
    if (c.runs[a].begin < c.runs[b].end && c.runs[b].begin < c.runs[a].end) forest.join(a, b);
    if (c.runs[a].end < c.runs[b].end) {
      ++a;
    } else {
      ++b;
    }
  }
}

std::vector<int> find_roots(const ConnectedRuns& c) {
  Forest forest(c.runs.size());
  const auto ny = static_cast<std::size_t>(c.size[1]), nz = static_cast<std::size_t>(c.size[2]);
  parallel_for(nz, kSlabSlices, [&](std::size_t begin, std::size_t end) {
    for (std::size_t r = begin * ny; r < end * ny; ++r) {
      if (r % ny != 0) join_rows(c, r - 1, r, forest);
      if (r >= (begin + 1) * ny) join_rows(c, r - ny, r, forest);
    }
  });
  for (std::size_t k = kSlabSlices; k < nz; k += kSlabSlices) {
    for (std::size_t r = k * ny; r < (k + 1) * ny; ++r) join_rows(c, r - ny, r, forest);
  }
  return std::move(forest).flatten();
}

/// Numbers the components by falling size; roots come in order of their first voxel.
void rank_components(const std::vector<int>& roots, ConnectedRuns& c) {
  std::vector<int> index(roots.size(), -1);
  std::vector<std::size_t> voxels;
  for (std::size_t run = 0; run < roots.size(); ++run) {
    const auto root = static_cast<std::size_t>(roots[run]);
    if (root == run) {
      index[run] = static_cast<int>(voxels.size());
      voxels.push_back(0);
    }
    voxels[static_cast<std::size_t>(index[root])] +=
        static_cast<std::size_t>(c.runs[run].end - c.runs[run].begin);
  }
  std::vector<std::size_t> order(voxels.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(),
                   [&](std::size_t a, std::size_t b) { return voxels[a] > voxels[b]; });
  std::vector<int> rank(voxels.size());
  c.sizes.resize(voxels.size());
  for (std::size_t place = 0; place < order.size(); ++place) {
    rank[order[place]] = static_cast<int>(place) + 1;
    c.sizes[place] = voxels[order[place]];
  }
  c.component.resize(roots.size());
  for (std::size_t run = 0; run < roots.size(); ++run) {
    c.component[run] = rank[static_cast<std::size_t>(index[static_cast<std::size_t>(roots[run])])];
  }
}

}  // namespace

int ConnectedRuns::component_at(int i, int j, int k) const {
  const std::size_t r =
      static_cast<std::size_t>(k) * static_cast<std::size_t>(size[1]) + static_cast<std::size_t>(j);
  const auto first = runs.begin() + static_cast<std::ptrdiff_t>(row_begin[r]);
  const auto last = runs.begin() + static_cast<std::ptrdiff_t>(row_begin[r + 1]);
  const auto after =
      std::upper_bound(first, last, i, [](int value, const Run& run) { return value < run.begin; });
  if (after == first || i >= (after - 1)->end) return 0;
  return component[static_cast<std::size_t>(after - 1 - runs.begin())];
}

ConnectedRuns connect_runs(const BitVolume& bits) {
  ConnectedRuns result;
  find_runs(bits, result);
  rank_components(find_roots(result), result);
  return result;
}

}  // namespace turgor::detail
