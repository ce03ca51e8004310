#include <algorithm>
#include <map>
#include <numeric>
#include <tuple>

#include "fem/voxel_level.hpp"
#include "turgor/core/index.hpp"
#include "turgor/core/parallel.hpp"

namespace turgor::detail {
namespace {

constexpr std::size_t kMatrixGrain = 16;
constexpr int kChildren = 8;

// A cell of the fine lattice in a coarse one.
struct Child {
  int bits = 0;    // where, x 1, y 2, z 4
  int dense = -1;  // which of the cells with a matrix of their own; −1: a regular one
  std::size_t cell = 0;
};

// Children that share nodes, which make up one coarse cell.
struct Family {
  int i = 0, j = 0, k = 0;
  std::vector<Child> children;
  bool alike = true;  // all regular, of the same moduli, and nothing held
  float shear = 0, bulk = 0;

  [[nodiscard]] unsigned there() const {
    unsigned bits = 0;
    for (const Child& c : children) bits |= 1U << c.bits;
    return bits;
  }
  [[nodiscard]] bool regular() const { return alike && children.size() == kChildren; }
};

std::array<NodePlace, 8> corners_of(const VoxelLevel& fine, const Family& family, const Child& child) {
  if (child.dense >= 0) return fine.dense.cells[at(child.dense)].corners;
  return fine.rows.corners(2 * family.i + (child.bits & 1), 2 * family.j + ((child.bits >> 1) & 1),
                           2 * family.k + (child.bits >> 2));
}

bool is_held(const VoxelLevel& fine, const Child& child) {
  return !fine.held_cell.empty() && fine.held_cell[child.cell] != 0;
}

Family children_of(const VoxelLevel& fine, int i, int j, int k) {
  Family all{i, j, k, {}};
  for (int bits = 0; bits < kChildren; ++bits) {
    const int x = 2 * i + (bits & 1), y = 2 * j + ((bits >> 1) & 1), z = 2 * k + (bits >> 2);
    const std::size_t cell = fine.rows.cell(x, y, z);
    if (fine.regular(cell)) all.children.push_back({bits, -1, cell});
    if (cell == fine.rows.cell_count || fine.dense_of.empty() || fine.dense_of[cell] < 0) continue;
    const auto& dense = fine.dense.cells;
    for (auto d = at(fine.dense_of[cell]); d < dense.size(); ++d) {
      if (dense[d].i != x || dense[d].j != y || dense[d].k != z) break;
      all.children.push_back({bits, static_cast<int>(d), cell});
    }
  }
  return all;
}

void set_moduli(const VoxelLevel& fine, Family& family) {
  family.alike = true;
  family.shear = fine.shear[family.children[0].cell], family.bulk = fine.bulk[family.children[0].cell];
  for (const Child& c : family.children) {
    family.alike = family.alike && c.dense < 0 && !is_held(fine, c) && fine.shear[c.cell] == family.shear &&
                   fine.bulk[c.cell] == family.bulk;
  }
}

int find(std::vector<int>& parent, int a) {
  while (parent[at(a)] != a) a = parent[at(a)] = parent[at(parent[at(a)])];
  return a;
}

void join(std::vector<int>& parent, int a, int b) {
  const int x = find(parent, a), y = find(parent, b);
  parent[at(std::max(x, y))] = std::min(x, y);
}

// Adds the families of one place: all children, or those that hang together.
void add_families(const VoxelLevel& fine, Family all, std::vector<Family>& families) {
  const bool only_regular =
      std::all_of(all.children.begin(), all.children.end(), [](const Child& c) { return c.dense < 0; });
  // Eight cells about a node share it, where it has no double.
  if (only_regular || all.children.size() == 1) {
    set_moduli(fine, all);
    families.push_back(std::move(all));
    return;
  }
  const std::size_t n = all.children.size();
  std::vector<int> parent(n);
  std::iota(parent.begin(), parent.end(), 0);
  std::vector<std::pair<std::uint32_t, int>> nodes;
  for (std::size_t c = 0; c < n; ++c)
    for (const NodePlace& p : corners_of(fine, all, all.children[c]))
      nodes.emplace_back(p.value, static_cast<int>(c));
  std::sort(nodes.begin(), nodes.end());
  for (std::size_t e = 1; e < nodes.size(); ++e)
    if (nodes[e].first == nodes[e - 1].first) join(parent, nodes[e].second, nodes[e - 1].second);
  for (int root = 0; root < static_cast<int>(n); ++root) {
    if (find(parent, root) != root) continue;
    Family part{all.i, all.j, all.k, {}};
    for (std::size_t c = 0; c < n; ++c)
      if (find(parent, static_cast<int>(c)) == root) part.children.push_back(all.children[c]);
    set_moduli(fine, part);
    families.push_back(std::move(part));
  }
}

// Weights of the eight corners of a coarse cell at a corner of a child.
std::array<float, 8> weights_at(int child, int corner) {
  std::array<float, 8> weights{};
  for (int coarse = 0; coarse < 8; ++coarse) {
    float w = 1;
    for (int a = 0; a < 3; ++a) {
      const auto place = static_cast<float>(((child >> a) & 1) + ((corner >> a) & 1));
      w *= ((coarse >> a) & 1) != 0 ? 0.5F * place : 1 - 0.5F * place;
    }
    weights[at(coarse)] = w;
  }
  return weights;
}

struct WeightTable {
  std::array<std::array<std::array<float, 8>, 8>, 8> of{};
  WeightTable() {
    for (int child = 0; child < 8; ++child)
      for (int corner = 0; corner < 8; ++corner) of[at(child)][at(corner)] = weights_at(child, corner);
  }
};

// Which corners of coarse cells are one node, and where that lies.
class CoarseNodes {
 public:
  CoarseNodes(const VoxelLevel& fine, const std::vector<Family>& families, const Index3& box)
      : fine_(fine), families_(families), box_(box), parent_(8 * families.size()) {
    std::iota(parent_.begin(), parent_.end(), 0);
    join_corners();
    choose_places();
  }

  [[nodiscard]] const std::vector<std::size_t>& extra_nodes() const { return extra_nodes_; }
  [[nodiscard]] bool has_extra(std::size_t family) const {
    for (std::size_t c = 0; c < 8; ++c)
      if (extra_[at(root_[8 * family + c])] >= 0) return true;
    return false;
  }
  [[nodiscard]] NodePlace place(const VoxelRows& rows, std::size_t family, std::size_t corner) const {
    const Index3 n = lattice(family, static_cast<int>(corner));
    const int extra = extra_[at(root_[8 * family + corner])];
    if (extra < 0) return rows.node(n[0], n[1], n[2]);
    return {static_cast<std::uint32_t>(rows.extras[at(n[2])] + 3 * at(extra)), 1};
  }

 private:
  [[nodiscard]] Index3 lattice(std::size_t family, int corner) const {
    const Family& f = families_[family];
    return {f.i + (corner & 1), f.j + ((corner >> 1) & 1), f.k + (corner >> 2)};
  }
  [[nodiscard]] std::size_t lattice_number(std::size_t family, int corner) const {
    const Index3 n = lattice(family, corner);
    return (at(n[2]) * at(box_[1] + 1) + at(n[1])) * at(box_[0] + 1) + at(n[0]);
  }

  // Cells that share a fine node share the coarse nodes from which it is interpolated.
  void join_corners() {
    std::vector<int> owner(fine_.rows.values(), -1);
    for (std::size_t f = 0; f < families_.size(); ++f) {
      for (const Child& child : families_[f].children) {
        const auto corners = corners_of(fine_, families_[f], child);
        for (int corner = 0; corner < 8; ++corner) {
          int& first = owner[corners[at(corner)].value];
          if (first < 0) first = static_cast<int>(f);
          if (first == static_cast<int>(f)) continue;
          join_shared(at(first), f, table_.of[at(child.bits)][at(corner)]);
        }
      }
    }
    root_.resize(parent_.size());
    for (std::size_t s = 0; s < parent_.size(); ++s) root_[s] = find(parent_, static_cast<int>(s));
  }

  void join_shared(std::size_t first, std::size_t second, const std::array<float, 8>& weights) {
    const Family &a = families_[first], &b = families_[second];
    for (int c = 0; c < 8; ++c) {
      if (weights[at(c)] == 0) continue;
      const int x = b.i + (c & 1) - a.i, y = b.j + ((c >> 1) & 1) - a.j, z = b.k + (c >> 2) - a.k;
      join(parent_, static_cast<int>(8 * first) + x + 2 * y + 4 * z, static_cast<int>(8 * second) + c);
    }
  }

  // The node in the rows is the one that regular cells have, if any has: they share what they touch.
  void choose_places() {
    std::vector<int> in_rows(at(box_[0] + 1) * at(box_[1] + 1) * at(box_[2] + 1), -1);
    for (const bool regular : {true, false}) {
      for (std::size_t f = 0; f < families_.size(); ++f) {
        if (families_[f].regular() != regular) continue;
        for (int c = 0; c < 8; ++c) {
          int& root = in_rows[lattice_number(f, c)];
          if (root < 0) root = root_[8 * f + at(c)];
        }
      }
    }
    extra_.assign(parent_.size(), -1);
    extra_nodes_.assign(at(box_[2] + 1), 0);
    for (std::size_t s = 0; s < parent_.size(); ++s) {
      const std::size_t f = s / 8;
      const int c = static_cast<int>(s % 8), root = root_[s];
      if (in_rows[lattice_number(f, c)] == root || extra_[at(root)] >= 0) continue;
      extra_[at(root)] = static_cast<int>(extra_nodes_[at(lattice(f, c)[2])]++);
    }
  }

  const VoxelLevel& fine_;
  const std::vector<Family>& families_;
  Index3 box_;
  WeightTable table_;
  std::vector<int> parent_, root_;  // of each corner of each family
  std::vector<int> extra_;          // number in its plane of the extra node of a root, −1: in the rows
  std::vector<std::size_t> extra_nodes_;
};

// What coarse cells are made of.
struct Units {
  CubeMatrix shear, bulk;                                           // of a child of unit moduli
  std::array<CubeMatrix, kChildren> coarse_shear{}, coarse_bulk{};  // its Galerkin product

  explicit Units(const CubeStiffness& s) : shear(matrix_of(s.shear)), bulk(matrix_of(s.bulk)) {
    for (int child = 0; child < kChildren; ++child) {
      add_galerkin(shear, child, coarse_shear[at(child)]);
      add_galerkin(bulk, child, coarse_bulk[at(child)]);
    }
  }
};

// Of the stiffness of a cube's corner: what coarse lattices resist with where a plane holds a node, so that
// no coarse motion that planes leave nothing of is free.
constexpr double kResidual = 1e-4;

// With the motion along a normal left out, or resisted, of one corner.
void put_on_plane(const NodePlane& plane, std::size_t corner, bool owner, CubeMatrix& own) {
  const auto entry = [&](std::size_t c, std::size_t k) { return kCubeUnknowns * (8 * c + corner) + k; };
  const auto n = [&](std::size_t c) { return static_cast<double>(plane.normal[c]); };
  double resists = static_cast<double>(plane.stiffness);
  if (plane.holds) {
    resists = kResidual * own[entry(0, corner)];
    for (const bool rows : {true, false}) {
      for (std::size_t k = 0; k < kCubeUnknowns; ++k) {
        const auto at_entry = [&](std::size_t c) -> double& {
          return own[rows ? entry(c, k) : kCubeUnknowns * k + 8 * c + corner];
        };
        const double along = n(0) * at_entry(0) + n(1) * at_entry(1) + n(2) * at_entry(2);
        for (std::size_t c = 0; c < 3; ++c) at_entry(c) -= along * n(c);
      }
    }
  }
  for (std::size_t a = 0; a < 3 && owner; ++a)
    for (std::size_t b = 0; b < 3; ++b) own[entry(a, 8 * b + corner)] += resists * n(a) * n(b);
}

// The matrix of a child with the components left out that are held, and its corners on their planes.
CubeMatrix held_matrix(const VoxelLevel& fine, const std::vector<std::uint8_t>& held, const Units& units,
                       const Family& family, const Child& child) {
  CubeMatrix own{};
  const double shear = fine.shear[child.cell], bulk = fine.bulk[child.cell];
  const auto corners = corners_of(fine, family, child);
  const auto unknowns = unknowns_of(corners);
  for (std::size_t a = 0; a < kCubeUnknowns; ++a) {
    for (std::size_t b = 0; b < kCubeUnknowns; ++b) {
      const std::size_t e = kCubeUnknowns * a + b;
      if (held[unknowns[a]] == 0 && held[unknowns[b]] == 0)
        own[e] = shear * units.shear[e] + bulk * units.bulk[e];
    }
  }
  for (std::size_t corner = 0; corner < 8 && !fine.plane_of.empty(); ++corner) {
    const int p = fine.plane_of[corners[corner].value];
    if (p >= 0) put_on_plane(fine.planes[at(p)], corner, fine.planes[at(p)].cell == child.cell, own);
  }
  return own;
}

CubeMatrix coarse_matrix(const VoxelLevel& fine, const std::vector<std::uint8_t>& held, const Units& units,
                         const Family& family) {
  CubeMatrix sum{};
  for (const Child& child : family.children) {
    if (child.dense >= 0) {
      CubeMatrix own;
      const double* from = fine.dense.matrix(fine.dense.cells[at(child.dense)].matrix);
      for (std::size_t e = 0; e < own.size(); ++e) own[e] = from[e];
      add_galerkin(own, child.bits, sum);
    } else if (is_held(fine, child)) {
      add_galerkin(held_matrix(fine, held, units, family, child), child.bits, sum);
    } else {
      const double shear = fine.shear[child.cell], bulk = fine.bulk[child.cell];
      const CubeMatrix &of_shear = units.coarse_shear[at(child.bits)],
                       &of_bulk = units.coarse_bulk[at(child.bits)];
      for (std::size_t e = 0; e < sum.size(); ++e) sum[e] += shear * of_shear[e] + bulk * of_bulk[e];
    }
  }
  return sum;
}

std::vector<CellSpan> coarse_spans(const VoxelLevel& fine, const Index3& box) {
  std::vector<CellSpan> spans(at(box[1]) * at(box[2]));
  for (int k = 0; k < fine.rows.cells[2]; ++k) {
    for (int j = 0; j < fine.rows.cells[1]; ++j) {
      const CellSpan& s = fine.spans[at(k * fine.rows.cells[1] + j)];
      if (s.end <= s.first) continue;
      CellSpan& c = spans[at((k / 2) * box[1] + j / 2)];
      const bool none = c.end <= c.first;
      c.first = none ? s.first / 2 : std::min(c.first, s.first / 2);
      c.end = none ? (s.end + 1) / 2 : std::max(c.end, (s.end + 1) / 2);
    }
  }
  return spans;
}

std::vector<Family> make_families(const VoxelLevel& fine, const std::vector<CellSpan>& spans,
                                  const Index3& box) {
  std::vector<Family> families;
  for (int k = 0; k < box[2]; ++k) {
    for (int j = 0; j < box[1]; ++j) {
      const CellSpan& span = spans[at(k * box[1] + j)];
      for (int i = span.first; i < span.end; ++i) {
        Family all = children_of(fine, i, j, k);
        if (!all.children.empty()) add_families(fine, std::move(all), families);
      }
    }
  }
  return families;
}

// Regular cells get their moduli, others a matrix, shared by those of one shape; returns a family for each
// matrix.
std::vector<const Family*> place_cells(const std::vector<Family>& families, const CoarseNodes& nodes,
                                       VoxelLevel& coarse) {
  std::vector<const Family*> of_matrix;
  std::map<std::tuple<float, float, unsigned>, int> by_shape;
  coarse.dense.layers.assign(at(coarse.rows.cells[2]) + 1, 0);
  for (std::size_t f = 0; f < families.size(); ++f) {
    const Family& family = families[f];
    const std::size_t cell = coarse.rows.cell(family.i, family.j, family.k);
    if (family.regular()) {
      coarse.shear[cell] = family.shear, coarse.bulk[cell] = family.bulk;
      continue;
    }
    auto number = static_cast<int>(of_matrix.size());
    if (family.alike)
      number = by_shape.try_emplace({family.shear, family.bulk, family.there()}, number).first->second;
    if (number == static_cast<int>(of_matrix.size())) of_matrix.push_back(&family);
    DenseCell dense{family.i, family.j, family.k, number, {}};
    for (std::size_t c = 0; c < 8; ++c) dense.corners[c] = nodes.place(coarse.rows, f, c);
    if (coarse.dense_of[cell] < 0) coarse.dense_of[cell] = static_cast<int>(coarse.dense.cells.size());
    coarse.dense.cells.push_back(dense);
    coarse.dense.layers[at(family.k) + 1] = static_cast<int>(coarse.dense.cells.size());
  }
  for (std::size_t k = 1; k < coarse.dense.layers.size(); ++k)
    coarse.dense.layers[k] = std::max(coarse.dense.layers[k], coarse.dense.layers[k - 1]);
  return of_matrix;
}

bool is_extra(const VoxelRows& rows, const NodePlace& node, int plane) {
  return node.value >= rows.extras[at(plane)];
}

std::vector<OddNode> odd_nodes(const VoxelLevel& fine, const std::vector<Family>& families,
                               const CoarseNodes& nodes, const VoxelRows& coarse) {
  std::vector<OddNode> odd;
  std::vector<bool> known(fine.rows.values(), false);
  const WeightTable table;
  for (std::size_t f = 0; f < families.size(); ++f) {
    const bool has_extra = nodes.has_extra(f);
    for (const Child& child : families[f].children) {
      if (!has_extra && child.dense < 0) continue;
      const auto corners = corners_of(fine, families[f], child);
      for (int corner = 0; corner < 8; ++corner) {
        OddNode node{corners[at(corner)], 0, {}, {}};
        const int plane = 2 * families[f].k + (child.bits >> 2) + (corner >> 2);
        bool is_odd = is_extra(fine.rows, node.node, plane);
        const auto& weights = table.of[at(child.bits)][at(corner)];
        for (std::size_t c = 0; c < 8; ++c) {
          if (weights[c] == 0) continue;
          node.weight[at(node.count)] = weights[c];
          node.coarse[at(node.count)] = nodes.place(coarse, f, c);
          is_odd = is_odd ||
                   is_extra(coarse, node.coarse[at(node.count)], families[f].k + static_cast<int>(c >> 2));
          ++node.count;
        }
        if (!is_odd || known[node.node.value]) continue;
        known[node.node.value] = true;
        odd.push_back(node);
      }
    }
  }
  return odd;
}

}  // namespace

std::unique_ptr<VoxelLevel> coarser(VoxelLevel& fine, const std::vector<std::uint8_t>& held) {
  auto made = std::make_unique<VoxelLevel>();
  VoxelLevel& coarse = *made;
  const Index3& n = fine.rows.cells;
  const Index3 box{(n[0] + 1) / 2, (n[1] + 1) / 2, (n[2] + 1) / 2};
  coarse.spans = coarse_spans(fine, box);
  coarse.stiffness = coarsened(fine.stiffness);
  const std::vector<Family> families = make_families(fine, coarse.spans, box);
  const CoarseNodes nodes(fine, families, box);
  coarse.rows = VoxelRows(box, coarse.spans, families.size(), nodes.extra_nodes());
  coarse.shear.assign(coarse.rows.cell_count, 0.0F);
  coarse.bulk.assign(coarse.rows.cell_count, 0.0F);
  coarse.dense_of.assign(coarse.rows.cell_count, -1);
  const std::vector<const Family*> of_matrix = place_cells(families, nodes, coarse);
  fine.odd_nodes = odd_nodes(fine, families, nodes, coarse.rows);
  const Units units(fine.stiffness);
  coarse.dense.matrices.resize(of_matrix.size() * kCubeUnknowns * kCubeUnknowns);
  parallel_for(of_matrix.size(), kMatrixGrain, [&](std::size_t begin, std::size_t end) {
    for (std::size_t m = begin; m < end; ++m) {
      const CubeMatrix matrix = coarse_matrix(fine, held, units, *of_matrix[m]);
      double* to = coarse.dense.matrices.data() + m * matrix.size();
      for (std::size_t a = 0; a < kCubeUnknowns; ++a)
        for (std::size_t b = 0; b < kCubeUnknowns; ++b)
          to[kCubeUnknowns * a + b] = 0.5 * (matrix[kCubeUnknowns * a + b] + matrix[kCubeUnknowns * b + a]);
    }
  });
  coarse.finish({});
  return made;
}

}  // namespace turgor::detail
