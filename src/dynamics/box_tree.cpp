#include "dynamics/box_tree.hpp"

#include <numeric>

#include "geometry/median_split.hpp"

namespace turgor {
namespace {

constexpr int kLeaf = 4;

}  // namespace

BoxTree::BoxTree(std::span<const Vec3> centres) : items_(centres.size()) {
  std::iota(items_.begin(), items_.end(), 0);
  if (!items_.empty()) split(centres, 0, static_cast<int>(items_.size()));
}

void BoxTree::split(std::span<const Vec3> centres, int begin, int end) {
  const std::size_t self = nodes_.size();
  nodes_.push_back({begin, end, 0});
  if (end - begin <= kLeaf) return;
  const std::span items = std::span(items_).subspan(at(begin), at(end - begin));
  const int middle =
      begin + static_cast<int>(detail::split_at_median(items, [&](int i) { return centres[at(i)]; }));
  split(centres, begin, middle);
  nodes_[self].second = static_cast<int>(nodes_.size());
  split(centres, middle, end);
}

}  // namespace turgor
