#include "dynamics/box_tree.hpp"

#include <algorithm>
#include <numeric>

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
  Box3 box;
  for (int i = begin; i < end; ++i) box.extend(centres[at(items_[at(i)])]);
  const Vec3 size = box.size();
  const int axis = size.x >= size.y && size.x >= size.z ? 0 : size.y >= size.z ? 1 : 2;
  const int middle = begin + (end - begin) / 2;
  std::nth_element(items_.begin() + begin, items_.begin() + middle, items_.begin() + end, [&](int a, int b) {
    const double xa = centres[at(a)][axis], xb = centres[at(b)][axis];
    return xa < xb || (xa == xb && a < b);
  });
  split(centres, begin, middle);
  nodes_[self].second = static_cast<int>(nodes_.size());
  split(centres, middle, end);
}

}  // namespace turgor
