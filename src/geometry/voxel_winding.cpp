// Generalised winding numbers (Jacobson, Kavan and Sorkine-Hornung 2013) of voxel centres; far triangles are
// taken together as one dipole (Barill et al. 2018, "Fast winding numbers for soups and clouds").
#include <algorithm>
#include <bit>
#include <cmath>
#include <numbers>
#include <numeric>
#include <utility>

#include "geometry/median_split.hpp"
#include "geometry/voxel_fill.hpp"
#include "turgor/core/parallel.hpp"

namespace turgor::detail {
namespace {

constexpr int kLeaf = 8;    ///< triangles
constexpr double kFar = 3;  ///< radii from which a node counts as one dipole

/// A box of triangles; its right child follows its left one's descendants.
struct Node {
  Vec3 centre, area;  ///< weighted by area; sum of area vectors
  double radius = 0;
  int begin = 0, end = 0, right = -1;  ///< triangles; -1 for a leaf
};

/// Solid angle of a triangle seen from the origin (van Oosterom and Strackee 1983).
double solid_angle(const Vec3& a, const Vec3& b, const Vec3& c) {
  const double x = length(a), y = length(b), z = length(c);
  const double under = x * y * z + dot(a, b) * z + dot(b, c) * x + dot(c, a) * y;
  return 2 * std::atan2(dot(a, cross(b, c)), under);
}

class WindingTree {
 public:
  explicit WindingTree(const TriMesh& mesh) : mesh_(mesh), order_(mesh.triangles.size()) {
    std::iota(order_.begin(), order_.end(), 0);
    build(0, static_cast<int>(order_.size()));
  }
  [[nodiscard]] double operator()(const Vec3& q) const { return sum(0, q) / (4 * std::numbers::pi); }

 private:
  [[nodiscard]] const Vec3& corner(int triangle, std::size_t c) const {
    return mesh_.points[static_cast<std::size_t>(mesh_.triangles[static_cast<std::size_t>(triangle)][c])];
  }
  [[nodiscard]] Vec3 middle(int triangle) const {
    return (corner(triangle, 0) + corner(triangle, 1) + corner(triangle, 2)) / 3;
  }
  [[nodiscard]] int item(int i) const { return order_[static_cast<std::size_t>(i)]; }

  void measure(Node& node) const {
    double weight = 0;
    Vec3 mean;
    for (int i = node.begin; i < node.end; ++i) {
      const int t = item(i);
      const Vec3 area = cross(corner(t, 1) - corner(t, 0), corner(t, 2) - corner(t, 0)) * 0.5;
      node.area += area;
      node.centre += middle(t) * length(area), weight += length(area);
      mean += middle(t);
    }
    node.centre = weight > 0 ? node.centre / weight : mean / (node.end - node.begin);
    for (int i = node.begin; i < node.end; ++i) {
      for (std::size_t c = 0; c < 3; ++c)
        node.radius = std::max(node.radius, distance(corner(item(i), c), node.centre));
    }
  }
  void build(int begin, int end) {
    const std::size_t me = nodes_.size();
    nodes_.emplace_back();
    nodes_[me].begin = begin, nodes_[me].end = end;
    measure(nodes_[me]);
    if (end - begin <= kLeaf) return;
    const std::span items =
        std::span(order_).subspan(static_cast<std::size_t>(begin), static_cast<std::size_t>(end - begin));
    const int half =
        begin + static_cast<int>(detail::split_at_median(items, [&](int t) { return middle(t); }));
    build(begin, half);
    nodes_[me].right = static_cast<int>(nodes_.size());
    build(half, end);
  }
  [[nodiscard]] double sum(int n, const Vec3& q) const {  // NOLINT(misc-no-recursion): depth is log2 n
    const Node& node = nodes_[static_cast<std::size_t>(n)];
    const Vec3 to = node.centre - q;
    const double squared = squared_length(to);
    if (squared > kFar * kFar * node.radius * node.radius)
      return dot(to, node.area) / (squared * std::sqrt(squared));
    if (node.right >= 0) return sum(n + 1, q) + sum(node.right, q);
    double angle = 0;
    for (int i = node.begin; i < node.end; ++i)
      angle += solid_angle(corner(item(i), 0) - q, corner(item(i), 1) - q, corner(item(i), 2) - q);
    return angle;
  }

  const TriMesh& mesh_;
  std::vector<int> order_;
  std::vector<Node> nodes_;
};

/// Word w of the bits moved by `stride` words along the grid, or by one bit for stride 0: each voxel gets its
/// neighbour's. Rows and slabs follow one another, with empty voxels between.
std::uint64_t from_next(const std::vector<std::uint64_t>& bits, std::size_t w, std::size_t stride) {
  if (stride > 0) return w + stride < bits.size() ? bits[w + stride] : 0;
  return (bits[w] >> 1) | (w + 1 < bits.size() ? bits[w + 1] << 63 : 0);
}
std::uint64_t from_last(const std::vector<std::uint64_t>& bits, std::size_t w, std::size_t stride) {
  if (stride > 0) return w >= stride ? bits[w - stride] : 0;
  return (bits[w] << 1) | (w > 0 ? bits[w - 1] >> 63 : 0);
}

/// Winding numbers are asked for near the surface and along the soap film across its openings only: elsewhere
/// they pass a half nowhere, being harmonic.
class WindingFill {
 public:
  WindingFill(const TriMesh& surface, const CrossedLinks& links, const VoxelGrid& like,
              const Context& context)
      : winding_(surface), links_(links), known_(like), inside_(like), context_(context) {
    const auto words = static_cast<std::size_t>(like.words);
    strides_ = {0, words, words * static_cast<std::size_t>(like.size[1])};
  }
  VoxelGrid operator()() {
    for (std::vector<std::uint64_t> ends = ends_of(links_.any); ask(neighbourhood(ends));) ends = film();
    // Everything else is as what it hangs together with.
    CrossedLinks walls = links_;
    VoxelGrid outside(known_.size);
    for (std::size_t w = 0; w < outside.bits.size(); ++w) {
      outside.bits[w] = known_.bits[w] & ~inside_.bits[w];
      for (std::size_t a = 0; a < 3; ++a)
        walls.any[a][w] |= inside_.bits[w] ^ from_next(inside_.bits, w, strides_[a]);
    }
    outside = flood_outside(walls, std::move(outside));
    for (std::size_t w = 0; w < outside.bits.size(); ++w)
      inside_.bits[w] |= ~(outside.bits[w] | known_.bits[w]);
    return std::move(inside_);
  }

 private:
  using Bits = std::vector<std::uint64_t>;
  /// The voxels at either end of links.
  [[nodiscard]] Bits ends_of(const std::array<Bits, 3>& links) const {
    Bits ends(known_.bits.size());
    for (std::size_t w = 0; w < ends.size(); ++w)
      for (std::size_t a = 0; a < 3; ++a) ends[w] |= links[a][w] | from_last(links[a], w, strides_[a]);
    return ends;
  }
  /// The voxels and their six neighbours.
  [[nodiscard]] Bits neighbourhood(const Bits& bits) const {
    Bits around = bits;
    for (std::size_t w = 0; w < bits.size(); ++w)
      for (const std::size_t s : strides_) around[w] |= from_last(bits, w, s) | from_next(bits, w, s);
    return around;
  }
  /// Ends of links that nothing crosses, between inside and outside.
  [[nodiscard]] Bits film() const {
    std::array<Bits, 3> links{Bits(known_.bits.size()), Bits(known_.bits.size()), Bits(known_.bits.size())};
    for (std::size_t w = 0; w < known_.bits.size(); ++w) {
      for (std::size_t a = 0; a < 3; ++a) {
        links[a][w] = (inside_.bits[w] ^ from_next(inside_.bits, w, strides_[a])) & known_.bits[w] &
                      from_next(known_.bits, w, strides_[a]) & ~links_.any[a][w];
      }
    }
    return ends_of(links);
  }
  /// Finds the winding numbers of those not yet known. False where there are none.
  bool ask(const Bits& wanted) {
    const auto words = static_cast<std::size_t>(known_.words);
    const auto rows = static_cast<std::size_t>(known_.size[1]);
    std::vector<std::uint8_t> asked(wanted.size() / words);
    parallel_for(asked.size(), 16, [&](std::size_t begin, std::size_t end) {
      for (std::size_t w = begin * words; w < end * words; ++w) {
        const std::uint64_t fresh = wanted[w] & ~known_.bits[w];
        if (fresh == 0) continue;
        if (context_.cancelled()) return;
        const std::size_t row = w / words;
        asked[row] = 1;
        known_.bits[w] |= fresh;
        for (std::uint64_t left = fresh; left != 0; left &= left - 1) {
          const int i = static_cast<int>(64 * (w % words)) + std::countr_zero(left);
          const auto j = static_cast<int>(row % rows), k = static_cast<int>(row / rows);
          const Vec3 voxel{i + 0.5, j + 0.5, k + 0.5};
          // A surface that faces inwards as a whole is taken as it was meant.
          if (std::abs(winding_(known_.lower + voxel * known_.spacing)) > 0.5)
            inside_.bits[w] |= left & (0 - left);
        }
      }
    });
    return std::find(asked.begin(), asked.end(), 1) != asked.end();
  }

  WindingTree winding_;
  const CrossedLinks& links_;
  VoxelGrid known_, inside_;
  const Context& context_;
  std::array<std::size_t, 3> strides_{};
};

}  // namespace

void fill_by_winding(const TriMesh& surface, const CrossedLinks& links, VoxelGrid& inside,
                     const Context& context) {
  inside = WindingFill(surface, links, inside, context)();
}

}  // namespace turgor::detail
