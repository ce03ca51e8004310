// A hierarchy of boxes over moving items: split once by where they lay, the boxes fitted again as they move.
// Unlike a grid it minds neither one large face among small ones nor a point that crosses the world in a
// step.
#pragma once

#include <span>
#include <vector>

#include "turgor/core/index.hpp"
#include "turgor/math/vec.hpp"

namespace turgor {

inline bool overlap(const Box3& a, const Box3& b) {
  return a.lower.x <= b.upper.x && b.lower.x <= a.upper.x && a.lower.y <= b.upper.y &&
         b.lower.y <= a.upper.y && a.lower.z <= b.upper.z && b.lower.z <= a.upper.z;
}

class BoxTree {
 public:
  /// Items are numbered as their centres.
  explicit BoxTree(std::span<const Vec3> centres);

  /// Fills `boxes`, one for each node, from box_of(item).
  template <class BoxOf>
  void fit(std::vector<Box3>& boxes, BoxOf&& box_of) const {
    boxes.assign(nodes_.size(), {});
    for (std::size_t n = nodes_.size(); n-- > 0;) {
      const Node& node = nodes_[n];
      const auto add = [&](const Box3& b) { boxes[n].extend(b.lower), boxes[n].extend(b.upper); };
      if (node.is_leaf()) {
        for (int i = node.begin; i < node.end; ++i) add(box_of(items_[at(i)]));
      } else {
        add(boxes[n + 1]), add(boxes[at(node.second)]);
      }
    }
  }

  /// visit(item) for those of all leaves whose box meets `box`, always in the same order.
  template <class Visit>
  void visit(std::span<const Box3> boxes, const Box3& box, Visit&& visit) const {
    int stack[64];  // halves: no deeper than the bits of an int
    int top = 0;
    if (!nodes_.empty()) stack[top++] = 0;
    while (top > 0) {
      const int n = stack[--top];
      if (!overlap(boxes[at(n)], box)) continue;
      const Node& node = nodes_[at(n)];
      if (node.is_leaf()) {
        for (int i = node.begin; i < node.end; ++i) visit(items_[at(i)]);
      } else {
        stack[top++] = node.second;
        stack[top++] = n + 1;
      }
    }
  }

 private:
  struct Node {
    int begin, end;  // of items
    int second;      // child, the first being the next node; 0: a leaf
    [[nodiscard]] bool is_leaf() const { return second == 0; }
  };
  void split(std::span<const Vec3> centres, int begin, int end);

  std::vector<Node> nodes_;  // parents before children
  std::vector<int> items_;
};

}  // namespace turgor
