#include "turgor/geometry/graded_solid.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>

#include "turgor/core/index.hpp"
#include "turgor/core/parallel.hpp"

namespace turgor {
namespace {

/// Directions that the surface faces in, by the level-1 cells that it passes: boxes of unit normals.
class Facing {
 public:
  Facing(const TriMesh& surface, const VoxelGrid& voxels, int levels) {
    Index3 size = voxels.size;
    for (int l = 0; l < levels; ++l) {
      for (int& n : size) n = (n + 1) / 2;
      levels_.push_back({size, std::vector<Box3>(at(size[0]) * at(size[1]) * at(size[2]))});
    }
    for (const Index3& t : surface.triangles) add(surface, t, voxels);
    for (std::size_t l = 1; l < levels_.size(); ++l) gather(levels_[l - 1], levels_[l]);
  }
  /// Whether the surface passes the cell, or one that touches it, and all its normals there lie within a box
  /// of that diagonal: no edge, no fold, no other side of a thin part.
  [[nodiscard]] bool smooth(int level, const Index3& c, double diagonal) const {
    const Level& l = levels_[at(level - 1)];
    Box3 all;
    for (int k = c[2] - 1; k <= c[2] + 1; ++k)
      for (int j = c[1] - 1; j <= c[1] + 1; ++j)
        for (int i = c[0] - 1; i <= c[0] + 1; ++i)
          if (l.holds({i, j, k})) join(all, l.normals[l.offset({i, j, k})]);
    return !all.empty() && length(all.size()) <= diagonal;
  }

 private:
  struct Level {
    Index3 size{};
    std::vector<Box3> normals;
    [[nodiscard]] bool holds(const Index3& c) const {
      for (std::size_t a = 0; a < 3; ++a)
        if (c[a] < 0 || c[a] >= size[a]) return false;
      return true;
    }
    [[nodiscard]] std::size_t offset(const Index3& c) const {
      return (at(c[2]) * at(size[1]) + at(c[1])) * at(size[0]) + at(c[0]);
    }
  };
  static void join(Box3& to, const Box3& from) {
    if (!from.empty()) to.extend(from.lower), to.extend(from.upper);
  }
  void add(const TriMesh& surface, const Index3& t, const VoxelGrid& voxels) {
    const Vec3 normal = normalized(triangle_normal(surface, t));
    if (squared_length(normal) == 0) return;
    Level& level = levels_[0];
    const double edge = 2 * voxels.spacing;
    const auto place = [&](int p) { return (surface.points[at(p)] - voxels.lower) / edge; };
    Box3 box;
    for (const int p : t) box.extend(place(p));
    Index3 low{}, high{};
    for (int a = 0; a < 3; ++a) {
      low[at(a)] = std::max(0, static_cast<int>(std::floor(box.lower[a])));
      high[at(a)] = std::min(level.size[at(a)] - 1, static_cast<int>(std::floor(box.upper[a])));
    }
    const Vec3 on = place(t[0]);
    for (int k = low[2]; k <= high[2]; ++k)
      for (int j = low[1]; j <= high[1]; ++j)
        for (int i = low[0]; i <= high[0]; ++i)
          // Its plane passes the ball about the cell.
          if (std::abs(dot(normal, Vec3{i + 0.5, j + 0.5, k + 0.5} - on)) < 0.87)
            level.normals[level.offset({i, j, k})].extend(normal);
  }
  static void gather(const Level& fine, Level& coarse) {
    for (int k = 0; k < fine.size[2]; ++k)
      for (int j = 0; j < fine.size[1]; ++j)
        for (int i = 0; i < fine.size[0]; ++i)
          join(coarse.normals[coarse.offset({i / 2, j / 2, k / 2})], fine.normals[fine.offset({i, j, k})]);
  }
  std::vector<Level> levels_;
};

/// Which cells of each level of the octree are not split further. Level l has cells of 2^l voxels.
class Octree {
 public:
  /// With `facing`, cells join along the surface too where it is smooth to `diagonal`; there they take in all
  /// voxels of theirs, which are set.
  Octree(VoxelGrid& voxels, int levels, const std::vector<Box3>& fine, const Facing* facing = nullptr,
         double diagonal = 0)
      : voxels_(voxels), facing_(facing), diagonal_(diagonal) {
    levels_.push_back({voxels.size, {}, {}});
    for (int l = 1; l <= levels; ++l) add_level(fine);
  }
  [[nodiscard]] int top() const { return static_cast<int>(levels_.size()) - 1; }
  [[nodiscard]] const Index3& size(int level) const { return levels_[at(level)].size; }
  /// Whether the cell lies wholly in one leaf of its level or a coarser one. At level 0: inside the solid.
  [[nodiscard]] bool whole(int level, const Index3& c) const {
    return holds(level, c) && (level == 0 ? voxel(c) : levels_[at(level)].whole[offset(level, c)] != 0);
  }
  /// Nothing of the solid lies in it.
  [[nodiscard]] bool empty(int level, const Index3& c) const {
    return !holds(level, c) || (level == 0 ? !voxel(c) : levels_[at(level)].any[offset(level, c)] == 0);
  }
  [[nodiscard]] bool leaf(int level, const Index3& c) const {
    return whole(level, c) && (level == top() || !whole(level + 1, {c[0] / 2, c[1] / 2, c[2] / 2}));
  }

 private:
  struct Level {
    Index3 size{};
    std::vector<std::uint8_t> whole, any;
  };
  [[nodiscard]] bool voxel(const Index3& c) const { return voxels_.test(c[0], c[1], c[2]); }
  [[nodiscard]] bool holds(int level, const Index3& c) const {
    for (std::size_t a = 0; a < 3; ++a)
      if (c[a] < 0 || c[a] >= levels_[at(level)].size[a]) return false;
    return true;
  }
  [[nodiscard]] std::size_t offset(int level, const Index3& c) const {
    const Index3& n = levels_[at(level)].size;
    return (at(c[2]) * at(n[1]) + at(c[1])) * at(n[0]) + at(c[0]);
  }
  template <class Body>
  void for_each_cell(int level, Body body) {
    const Index3& n = size(level);
    parallel_for(at(n[2]), 1, [&](std::size_t begin, std::size_t) {
      for (Index3 c{0, 0, static_cast<int>(begin)}; c[1] < n[1]; ++c[1])
        for (c[0] = 0; c[0] < n[0]; ++c[0]) body(c);
    });
  }
  template <class Visit>
  static void for_each_child(const Index3& c, Visit visit) {
    for (int n = 0; n < 8; ++n)
      visit(Index3{2 * c[0] + (n & 1), 2 * c[1] + (n >> 1 & 1), 2 * c[2] + (n >> 2)});
  }
  void add_level(const std::vector<Box3>& fine) {
    const int l = top() + 1;
    levels_.emplace_back();
    for (std::size_t a = 0; a < 3; ++a) levels_.back().size[a] = (size(l - 1)[a] + 1) / 2;
    const std::size_t cells = at(size(l)[0]) * at(size(l)[1]) * at(size(l)[2]);
    levels_.back().whole.resize(cells), levels_.back().any.resize(cells);
    for_each_cell(l, [&](const Index3& c) {
      bool any = false;
      for_each_child(c, [&](const Index3& child) { any = any || !empty(l - 1, child); });
      levels_[at(l)].any[offset(l, c)] = static_cast<std::uint8_t>(any);
    });
    for_each_cell(l, [&](const Index3& c) {
      levels_[at(l)].whole[offset(l, c)] = static_cast<std::uint8_t>(may_join(l, c) && !meets(l, c, fine));
    });
    // All that may join do so at once: what is set for one leaves the others as they were.
    Index3 c{};
    for (c[2] = 0; c[2] < size(l)[2]; ++c[2])
      for (c[1] = 0; c[1] < size(l)[1]; ++c[1])
        for (c[0] = 0; c[0] < size(l)[0]; ++c[0])
          if (whole(l, c)) for_each_child(c, [&](const Index3& child) { set(l - 1, child); });
  }
  /// The cell and all within it.
  void set(int l, const Index3& c) {
    if (l == 0) {
      voxels_.set(c[0], c[1], c[2]);
    } else if (!whole(l, c)) {
      levels_[at(l)].whole[offset(l, c)] = levels_[at(l)].any[offset(l, c)] = 1;
      for_each_child(c, [&](const Index3& child) { set(l - 1, child); });
    }
  }
  /// Its eight cells of the level below and the ring around them are whole, so that no cell that it touches
  /// is more than one level finer, and outside is not near. Along smooth parts of the surface some may be
  /// empty.
  [[nodiscard]] bool may_join(int l, const Index3& c) const {
    if (empty(l, c)) return false;
    bool outside = false;
    for (int k = -1; k <= 2; ++k) {
      for (int j = -1; j <= 2; ++j) {
        for (int i = -1; i <= 2; ++i) {
          const Index3 near{2 * c[0] + i, 2 * c[1] + j, 2 * c[2] + k};
          if (whole(l - 1, near)) continue;
          if (facing_ == nullptr || !empty(l - 1, near)) return false;
          outside = true;
        }
      }
    }
    return !outside || (within_rim(l, c) && facing_->smooth(l, c, diagonal_));
  }
  /// Leaves the outermost voxels empty.
  [[nodiscard]] bool within_rim(int l, const Index3& c) const {
    for (std::size_t a = 0; a < 3; ++a)
      if ((c[a] << l) < 1 || ((c[a] + 1) << l) > voxels_.size[a] - 1) return false;
    return true;
  }
  [[nodiscard]] bool meets(int l, const Index3& c, const std::vector<Box3>& boxes) const {
    const double edge = std::ldexp(voxels_.spacing, l);
    const Vec3 low = voxels_.lower + Vec3{1.0 * c[0], 1.0 * c[1], 1.0 * c[2]} * edge;
    return std::any_of(boxes.begin(), boxes.end(), [&](const Box3& b) {
      for (int a = 0; a < 3; ++a)
        if (b.lower[a] >= low[a] + edge || b.upper[a] <= low[a]) return false;
      return true;
    });
  }
  VoxelGrid& voxels_;
  const Facing* facing_;
  double diagonal_;
  std::vector<Level> levels_;
};

using Tetra = std::array<Index3, 4>;  // points of the lattice of voxels

Index3 stepped(Index3 p, std::size_t axis, int by) {
  p[axis] += by;
  return p;
}
int parity(const Index3& p) {
  return (p[0] + p[1] + p[2]) & 1;
}

/// Makes the volume positive.
Tetra oriented(Tetra t) {
  std::array<Index3, 3> e{};
  for (std::size_t n = 0; n < 3; ++n)
    for (std::size_t a = 0; a < 3; ++a) e[n][a] = t[n + 1][a] - t[0][a];
  const auto minor = [&](std::size_t r, std::size_t s) {
    return std::int64_t{e[0][r]} * e[1][s] - std::int64_t{e[0][s]} * e[1][r];
  };
  if (minor(1, 2) * e[2][0] + minor(2, 0) * e[2][1] + minor(0, 1) * e[2][2] < 0) std::swap(t[2], t[3]);
  return t;
}

/// A tetrahedron and those of its faces that nothing lies beyond, anticlockwise seen from outside.
struct Piece {
  Tetra corners;
  std::array<std::array<Index3, 3>, 3> bare{};
  std::size_t bare_count = 0;
  /// `up`: outside lies up the axis.
  void add_bare(std::array<Index3, 3> face, std::size_t axis, bool up) {
    const std::size_t u = (axis + 1) % 3, v = (axis + 2) % 3;
    const auto edge = [&](std::size_t n, std::size_t a) { return std::int64_t{face[n][a]} - face[0][a]; };
    const bool faces_up = edge(1, u) * edge(2, v) - edge(1, v) * edge(2, u) > 0;
    if (faces_up != up) std::swap(face[1], face[2]);
    bare[bare_count++] = face;
  }
};

/// The tetrahedra of one leaf.
class Leaf {
 public:
  Leaf(const Octree& tree, int level, const Index3& cell)
      : tree_(tree), level_(level), edge_(1 << level), cell_(cell) {
    for (std::size_t a = 0; a < 3; ++a) low_[a] = cell[a] << level;
  }
  /// Calls add(Piece) for each.
  template <class Add>
  void split(Add&& add) const {
    bool simple = true;
    for (std::size_t a = 0; a < 3; ++a)
      for (int n = 0; n < 8; ++n)
        if ((n >> a & 1) == 0 && edge_halved(n, a)) simple = false;
    // A side that is halved has halved edges.
    if (simple) {
      five(add);
    } else {
      for (std::size_t a = 0; a < 3; ++a) side(a, 0, add), side(a, 1, add);
    }
  }

 private:
  /// Corner n lies at x = n & 1, y = n >> 1 & 1, z = n >> 2.
  [[nodiscard]] Index3 corner(int n) const {
    return {low_[0] + (n & 1) * edge_, low_[1] + (n >> 1 & 1) * edge_, low_[2] + (n >> 2) * edge_};
  }
  /// Whether the cell one or two steps aside is split: towards the corner along the axes named.
  [[nodiscard]] bool split_towards(int n, bool x, bool y, bool z) const {
    const auto step = [&](std::size_t a, bool moves) {
      return cell_[a] + (moves ? ((n >> a & 1) != 0 ? 1 : -1) : 0);
    };
    const Index3 there{step(0, x), step(1, y), step(2, z)};
    return level_ > 0 && !tree_.whole(level_, there) && !tree_.empty(level_, there);
  }
  /// The edge from corner n up the axis: around it lie this cell and three others.
  [[nodiscard]] bool edge_halved(int n, std::size_t axis) const {
    const bool x = axis != 0, y = axis != 1, z = axis != 2;
    const std::array<bool, 3> first{x, x ? false : y, false}, second{false, x ? y : false, z};
    return split_towards(n, x, y, z) || split_towards(n, first[0], first[1], first[2]) ||
           split_towards(n, second[0], second[1], second[2]);
  }
  /// Cuts off the corners of odd sum, on the lattice of its level.
  template <class Add>
  void five(Add&& add) const {
    const std::array<int, 4> odd = parity(cell_) == 0 ? std::array{1, 2, 4, 7} : std::array{0, 3, 5, 6};
    for (const int n : odd) {
      Piece piece{oriented({corner(n), corner(n ^ 1), corner(n ^ 2), corner(n ^ 4)})};
      for (std::size_t a = 0; a < 3; ++a) {
        const bool up = (n >> a & 1) != 0;
        const int u = 1 << ((a + 1) % 3), v = 1 << ((a + 2) % 3);
        if (tree_.empty(level_, stepped(cell_, a, up ? 1 : -1)))
          piece.add_bare({corner(n), corner(n ^ u), corner(n ^ v)}, a, up);
      }
      add(piece);
    }
    add(Piece{oriented({corner(odd[0] ^ 7), corner(odd[1] ^ 7), corner(odd[2] ^ 7), corner(odd[3] ^ 7)})});
  }
  /// The cone over the side at the lower or upper end of an axis.
  template <class Add>
  void side(std::size_t axis, int end, Add&& add) const {
    const std::size_t u = (axis + 1) % 3, v = (axis + 2) % 3;
    const int base = end << axis, iu = 1 << u, iv = 1 << v, half = edge_ / 2;
    const Index3 top = stepped(stepped(stepped(low_, 0, half), 1, half), 2, half);
    const std::array<int, 4> around{base, base + iu, base + iu + iv, base + iv};
    std::array<bool, 4> halved{};
    for (std::size_t e = 0; e < 4; ++e)
      halved[e] = edge_halved(std::min(around[e], around[(e + 1) % 4]), e % 2 == 0 ? u : v);
    const auto cone = [&](const Index3& a, const Index3& b, const Index3& c, bool bare) {
      Piece piece{oriented({top, a, b, c})};
      if (bare) piece.add_bare({a, b, c}, axis, end != 0);
      add(piece);
    };
    const Index3 beyond = stepped(cell_, axis, end != 0 ? 1 : -1);
    if (halved == std::array<bool, 4>{}) {
      const std::size_t even = (parity(cell_) + std::popcount(static_cast<unsigned>(base))) % 2 == 0 ? 0 : 1;
      const auto p = [&](std::size_t n) { return corner(around[(even + n) % 4]); };
      const bool bare = tree_.empty(level_, beyond);
      cone(p(0), p(1), p(2), bare), cone(p(0), p(2), p(3), bare);
      return;
    }
    const Index3 middle = stepped(top, axis, end != 0 ? half : -half);
    // Of the cell beyond, the quarter at a corner of this side.
    const auto bare_at = [&](int n) {
      if (tree_.empty(level_, beyond)) return true;
      if (tree_.whole(level_, beyond)) return false;
      Index3 quarter{};
      for (std::size_t a = 0; a < 3; ++a) quarter[a] = 2 * beyond[a] + (n >> a & 1);
      quarter[axis] = 2 * beyond[axis] + (end != 0 ? 0 : 1);
      return tree_.empty(level_ - 1, quarter);
    };
    for (std::size_t e = 0; e < 4; ++e) {
      const int first = around[e], last = around[(e + 1) % 4];
      const Index3 from = corner(first), to = corner(last);
      if (halved[e]) {
        Index3 mid{};
        for (std::size_t a = 0; a < 3; ++a) mid[a] = (from[a] + to[a]) / 2;
        cone(middle, from, mid, bare_at(first)), cone(middle, mid, to, bare_at(last));
      } else {
        cone(middle, from, to, bare_at(first));
      }
    }
  }

  const Octree& tree_;
  int level_, edge_;
  Index3 cell_, low_{};
};

template <class Visit>
void for_each_leaf(const Octree& tree, Visit&& visit) {
  for (int l = 0; l <= tree.top(); ++l) {
    Index3 c{};
    for (c[2] = 0; c[2] < tree.size(l)[2]; ++c[2])
      for (c[1] = 0; c[1] < tree.size(l)[1]; ++c[1])
        for (c[0] = 0; c[0] < tree.size(l)[0]; ++c[0])
          if (tree.leaf(l, c)) visit(Leaf(tree, l, c));
  }
}

/// Points of the lattice that are used, a bit each; the number of one is the count of bits before it.
class Numbering {
 public:
  explicit Numbering(const Index3& size) : used_({size[0] + 1, size[1] + 1, size[2] + 1}) {}
  void use(const Index3& p) { used_.set(p[0], p[1], p[2]); }
  int count() {
    first_.resize(used_.bits.size());
    int next = 0;
    for (std::size_t w = 0; w < first_.size(); ++w) first_[w] = next, next += std::popcount(used_.bits[w]);
    return next;
  }
  [[nodiscard]] int operator()(const Index3& p) const {
    const std::size_t word = used_.row_offset(p[1], p[2]) + at(p[0] / 64);
    return first_[word] + std::popcount(used_.bits[word] & ((std::uint64_t{1} << (p[0] % 64)) - 1));
  }
  template <class Visit>
  void for_each(Visit&& visit) const {
    for (int k = 0; k < used_.size[2]; ++k)
      for (int j = 0; j < used_.size[1]; ++j)
        for (int i = 0; i < used_.size[0]; ++i)
          if (used_.test(i, j, k)) visit(Index3{i, j, k});
  }

 private:
  VoxelGrid used_;
  std::vector<int> first_;
};

void append(const Piece& piece, const Numbering& numbers, SolidMesh& solid) {
  const auto& t = piece.corners;
  for (std::size_t n = 0; n < piece.bare_count; ++n) {
    const auto& f = piece.bare[n];
    solid.surface_triangles.push_back({numbers(f[0]), numbers(f[1]), numbers(f[2])});
    solid.surface_cells.push_back(static_cast<int>(solid.tetrahedra.size()));
    for (const int p : solid.surface_triangles.back()) solid.on_surface[at(p)] = 1;
  }
  solid.tetrahedra.push_back({numbers(t[0]), numbers(t[1]), numbers(t[2]), numbers(t[3])});
}

Result<void> check(int levels, const std::vector<Box3>& fine) {
  if (levels < 0 || levels > GradedOptions::max_levels) {
    return Error{ErrorKind::bad_input, fmt::format("a solid cannot be graded over {} levels", levels), "",
                 fmt::format("Give 0 to {} levels", GradedOptions::max_levels)};
  }
  for (const Box3& box : fine) {
    if (is_finite(box.lower) && is_finite(box.upper) && !box.empty()) continue;
    return Error{ErrorKind::bad_input, "a box of fine cells is empty or not finite", "",
                 "Give its lower, then its upper corner in mm"};
  }
  return {};
}

Result<void> check_angle(double smooth_deg) {
  if (smooth_deg >= 0 && smooth_deg <= GradedOptions::most_smooth_deg) return {};
  return Error{ErrorKind::bad_input, fmt::format("a surface is not smooth to {:g} degrees", smooth_deg), "",
               fmt::format("Give 0 to {:g} degrees", GradedOptions::most_smooth_deg)};
}

Result<SolidMesh> solid_from(const Octree& tree, const VoxelGrid& voxels) {
  Numbering numbers(voxels.size);
  std::size_t cells = 0;
  for_each_leaf(tree, [&](const Leaf& leaf) {
    leaf.split([&](const Piece& piece) {
      for (const Index3& p : piece.corners) numbers.use(p);
      ++cells;
    });
  });
  if (cells > static_cast<std::size_t>(std::numeric_limits<int>::max()) / 4) {
    return Error{ErrorKind::bad_input, fmt::format("{} tetrahedra are too many to number", cells), "",
                 "Give a lower resolution"};
  }
  SolidMesh solid;
  const int points = numbers.count();
  solid.points.reserve(at(points));
  numbers.for_each([&](const Index3& p) {
    solid.points.push_back(voxels.lower + Vec3{1.0 * p[0], 1.0 * p[1], 1.0 * p[2]} * voxels.spacing);
  });
  solid.on_surface.assign(at(points), 0);
  solid.tetrahedra.reserve(cells);
  for_each_leaf(tree, [&](const Leaf& leaf) {
    leaf.split([&](const Piece& piece) { append(piece, numbers, solid); });
  });
  return solid;
}

/// The same voxels with `margin` empty ones more on every side.
VoxelGrid padded(const VoxelGrid& voxels, int margin) {
  VoxelGrid out({voxels.size[0] + 2 * margin, voxels.size[1] + 2 * margin, voxels.size[2] + 2 * margin});
  out.spacing = voxels.spacing, out.closed_holes = voxels.closed_holes;
  const double shift = margin * voxels.spacing;
  out.lower = voxels.lower - Vec3{shift, shift, shift};
  for (int k = 0; k < voxels.size[2]; ++k)
    for (int j = 0; j < voxels.size[1]; ++j)
      for (int i = 0; i < voxels.size[0]; ++i)
        if (voxels.test(i, j, k)) out.set(i + margin, j + margin, k + margin);
  return out;
}

}  // namespace

Result<SolidMesh> graded_solid(const VoxelGrid& voxels, int levels, const std::vector<Box3>& fine) {
  TURGOR_CHECK(check(levels, fine));
  VoxelGrid same = voxels;
  return solid_from(Octree(same, levels, fine), same);
}

Result<SolidMesh> graded_solid(const VoxelGrid& voxels, const TriMesh& surface,
                               const GradedOptions& options) {
  TURGOR_CHECK(check(options.levels, options.fine));
  TURGOR_CHECK(check_angle(options.smooth_deg));
  TURGOR_CHECK(validate(surface));
  if (options.smooth_deg == 0 || options.levels == 0)
    return graded_solid(voxels, options.levels, options.fine);
  VoxelGrid coarsened = padded(voxels, 1 << options.levels);
  const Facing facing(surface, coarsened, options.levels);
  const double diagonal = 2 * std::sin(radians(options.smooth_deg) / 2);
  return solid_from(Octree(coarsened, options.levels, options.fine, &facing, diagonal), coarsened);
}

Result<SolidMesh> graded_solid(const TriMesh& surface, const GradedOptions& options, const Context& context) {
  TURGOR_CHECK(check(options.levels, options.fine));
  TURGOR_CHECK(check_angle(options.smooth_deg));
  TURGOR_TRY(const VoxelGrid voxels, voxelise(surface, options.voxels, context));
  TURGOR_CHECK(context.check());
  return graded_solid(voxels, surface, options);
}

}  // namespace turgor
