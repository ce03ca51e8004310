#include "turgor/world/face_solid.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "turgor/core/index.hpp"
#include "turgor/core/parallel.hpp"
#include "turgor/geometry/surface_query.hpp"
#include "turgor/geometry/voxel_solid.hpp"

namespace turgor {
namespace {

/// What the centre of a cube lies in.
enum class Cell : std::uint8_t { outside, tissue, bone, behind_bone, air, too_deep, beyond_region };

/// Deepest tissue that is looked at, mm, as of rays that meet bone.
constexpr double kDeepestMm = 32.0;

struct CellGrid {
  Index3 size{0, 0, 0};
  Vec3 lower;
  double spacing = 1;
  std::vector<Cell> cells;
  std::vector<float> depth_mm;

  [[nodiscard]] std::size_t index(int i, int j, int k) const {
    return (at(k) * at(size[1]) + at(j)) * at(size[0]) + at(i);
  }
  [[nodiscard]] Vec3 centre(int i, int j, int k) const {
    return lower + Vec3{i + 0.5, j + 0.5, k + 0.5} * spacing;
  }
  [[nodiscard]] std::size_t count() const { return at(size[0]) * at(size[1]) * at(size[2]); }
};

CellGrid empty_grid(const LayeredTissue& tissue, double spacing) {
  constexpr int margin = 3;
  const Box3 box = bounds(tissue.surface);
  CellGrid grid;
  grid.spacing = spacing;
  grid.lower = box.lower - Vec3{margin, margin, margin} * spacing;
  if (tissue.slit) {
    // Its middle in the middle of a layer.
    const Vec3 corner = (tissue.slit->left + tissue.slit->right) * 0.5;
    const double height = corner.z - tissue.slit->plane.signed_distance(corner) / tissue.slit->plane.normal.z;
    const double layers = (height - grid.lower.z) / spacing - 0.5;
    grid.lower.z += (layers - std::ceil(layers)) * spacing;
  }
  for (int a = 0; a < 3; ++a) {
    grid.size[at(a)] = static_cast<int>(std::ceil((box.upper[a] - grid.lower[a]) / spacing)) + margin;
  }
  grid.cells.assign(grid.count(), Cell::outside);
  grid.depth_mm.assign(grid.count(), 0);
  return grid;
}

/// Runs along rays from before the face to the back, and hands each cell that lies within the surfaces to
/// `found`. Surfaces may overlap, and may be open behind: within is where more have been entered than left.
template <class Found>
void fill(const SurfaceQuery& query, const std::vector<const TriMesh*>& surfaces, const CellGrid& grid,
          Found found) {
  double front = grid.lower.y;
  for (const TriMesh* mesh : surfaces) front = std::min(front, bounds(*mesh).lower.y);
  front -= 1;
  const double reach = grid.lower.y + grid.size[1] * grid.spacing - front;
  parallel_for(at(grid.size[2]), 1, [&](std::size_t begin, std::size_t) {
    const int k = static_cast<int>(begin);
    for (int i = 0; i < grid.size[0]; ++i) {
      const Vec3 start = grid.centre(i, 0, k);
      const std::vector<RayHit> hits = query.all_hits({start.x, front, start.z}, {0, 1, 0}, 0, reach);
      std::size_t next = 0;
      int within = 0;
      for (int j = 0; j < grid.size[1]; ++j) {
        const double place = grid.centre(i, j, k).y - front;
        for (; next < hits.size() && hits[next].distance < place; ++next) {
          const TriMesh& mesh = *surfaces[at(hits[next].surface)];
          const bool enters = triangle_normal(mesh, mesh.triangles[at(hits[next].triangle)]).y < 0;
          within = std::max(0, within + (enters ? 1 : -1));
        }
        if (within > 0) found(grid.index(i, j, k));
      }
    }
  });
}

/// How deep tissue is looked at below each point of the layered tissue's skin, mm.
std::vector<double> deepest(const LayeredTissue& tissue) {
  std::vector<double> out(at(tissue.columns()), kDeepestMm);
  for (std::size_t c = 0; c < out.size(); ++c)
    if (tissue.ends[c] == ColumnEnd::none) out[c] = tissue.thickness_mm[c];
  return out;
}

/// Tissue that is too deep, or behind bone.
void limit_depth(const LayeredTissue& tissue, const SurfaceQuery& bone, CellGrid& grid) {
  const SurfaceQuery skin(tissue.surface);
  const std::vector<double> limits = deepest(tissue);
  parallel_for(at(grid.size[2]), 1, [&](std::size_t begin, std::size_t) {
    const int k = static_cast<int>(begin);
    for (int j = 0; j < grid.size[1]; ++j) {
      for (int i = 0; i < grid.size[0]; ++i) {
        Cell& cell = grid.cells[grid.index(i, j, k)];
        if (cell != Cell::tissue) continue;
        const Vec3 p = grid.centre(i, j, k);
        const auto near = skin.nearest(p, kDeepestMm);
        if (!near) {
          cell = Cell::too_deep;
          continue;
        }
        grid.depth_mm[grid.index(i, j, k)] = static_cast<float>(near->distance);
        const Index3& t = tissue.surface.triangles[at(near->triangle)];
        const double limit = limits[at(t[0])] * (1 - near->u - near->v) + limits[at(t[1])] * near->u +
                             limits[at(t[2])] * near->v;
        const Vec3 inwards = normalized(p - near->point);
        if (near->distance > 0 && bone.first_hit(near->point, inwards, 0, near->distance)) {
          cell = Cell::behind_bone;
        } else if (near->distance > limit) {
          cell = Cell::too_deep;
        }
      }
    }
  });
}

/// A layer of air between the lips, so thick that cubes on its two sides share no node.
void part(const LipSlit& slit, CellGrid& grid) {
  const Vec3& n = slit.plane.normal;
  const double half = 0.5 * grid.spacing * (std::abs(n.x) + std::abs(n.y) + std::abs(n.z));
  for (int k = 0; k < grid.size[2]; ++k) {
    for (int j = 0; j < grid.size[1]; ++j) {
      for (int i = 0; i < grid.size[0]; ++i) {
        Cell& cell = grid.cells[grid.index(i, j, k)];
        const Vec3 p = grid.centre(i, j, k);
        if (cell != Cell::tissue || std::abs(slit.plane.signed_distance(p)) >= half || !slit.covers(p))
          continue;
        cell = Cell::air;
      }
    }
  }
}

/// Whether tissue fills a block of two by two by two cells that this one is a part of.
bool is_thick(const CellGrid& grid, int i, int j, int k) {
  for (int block = 0; block < 8; ++block) {
    bool full = true;
    for (int cell = 0; cell < 8 && full; ++cell) {
      const auto shift = [&](int axis) { return ((cell >> axis) & 1) - ((block >> axis) & 1); };
      full = grid.cells[grid.index(i + shift(0), j + shift(1), k + shift(2))] == Cell::tissue;
    }
    if (full) return true;
  }
  return false;
}

/// Tissue a single cube thick that is not skin, as between the edges of teeth or along them, counts as air:
/// it bears nothing, and would crumple.
void drop_films(CellGrid& grid) {
  std::vector<std::size_t> films;
  for (int k = 1; k + 1 < grid.size[2]; ++k) {
    for (int j = 1; j + 1 < grid.size[1]; ++j) {
      for (int i = 1; i + 1 < grid.size[0]; ++i) {
        if (grid.cells[grid.index(i, j, k)] != Cell::tissue || is_thick(grid, i, j, k)) continue;
        bool skin = false;
        for (int n = 0; n < 27; ++n)
          skin = skin ||
                 grid.cells[grid.index(i + n % 3 - 1, j + n / 3 % 3 - 1, k + n / 9 - 1)] == Cell::outside;
        if (!skin) films.push_back(grid.index(i, j, k));
      }
    }
  }
  for (const std::size_t c : films) grid.cells[c] = Cell::air;
}

/// The largest piece of cubes that share faces; the others count as air.
void keep_largest(CellGrid& grid) {
  std::vector<int> piece(grid.count(), -1);
  const std::array<std::ptrdiff_t, 3> step{1, grid.size[0],
                                           static_cast<std::ptrdiff_t>(grid.size[0]) * grid.size[1]};
  std::size_t largest = 0;
  int best = -1, pieces = 0;
  std::vector<std::size_t> queue;
  for (std::size_t seed = 0; seed < piece.size(); ++seed) {
    if (grid.cells[seed] != Cell::tissue || piece[seed] >= 0) continue;
    queue.assign(1, seed);
    piece[seed] = pieces;
    for (std::size_t next = 0; next < queue.size(); ++next) {
      for (const std::ptrdiff_t s : step) {
        for (const std::ptrdiff_t way : {-s, s}) {
          // The grid's outermost cells are never tissue.
          const auto other = static_cast<std::size_t>(static_cast<std::ptrdiff_t>(queue[next]) + way);
          if (grid.cells[other] != Cell::tissue || piece[other] >= 0) continue;
          piece[other] = pieces;
          queue.push_back(other);
        }
      }
    }
    if (queue.size() > largest) largest = queue.size(), best = pieces;
    ++pieces;
  }
  for (std::size_t c = 0; c < piece.size(); ++c)
    if (grid.cells[c] == Cell::tissue && piece[c] != best) grid.cells[c] = Cell::air;
}

CellGrid classify(const Head& head, const LayeredTissue& tissue, const SurfaceQuery& bone, double spacing) {
  CellGrid grid = empty_grid(tissue, spacing);
  const auto put = [&](std::vector<const TriMesh*> surfaces, const SurfaceQuery& query, auto&& found) {
    fill(query, surfaces, grid, found);
  };
  put({&head.skin}, SurfaceQuery(head.skin), [&](std::size_t c) { grid.cells[c] = Cell::tissue; });
  if (!head.airway.empty()) {
    put({&head.airway}, SurfaceQuery(head.airway), [&](std::size_t c) {
      if (grid.cells[c] == Cell::tissue) grid.cells[c] = Cell::air;
    });
  }
  put({&head.skull, &head.mandible, &head.rami}, bone, [&](std::size_t c) {
    if (grid.cells[c] == Cell::tissue) grid.cells[c] = Cell::bone;
  });
  for (int k = 0; k < grid.size[2]; ++k) {
    for (int j = 0; j < grid.size[1]; ++j) {
      for (int i = 0; i < grid.size[0]; ++i) {
        Cell& cell = grid.cells[grid.index(i, j, k)];
        const bool edge = i == 0 || j == 0 || k == 0 || i + 1 == grid.size[0] || j + 1 == grid.size[1] ||
                          k + 1 == grid.size[2];
        if (cell == Cell::tissue && (edge || !tissue.region.contains(grid.centre(i, j, k))))
          cell = Cell::beyond_region;
      }
    }
  }
  limit_depth(tissue, bone, grid);
  if (tissue.slit) part(*tissue.slit, grid);
  drop_films(grid);
  keep_largest(grid);
  return grid;
}

/// The cells around each node, by what they are.
class NodeCells {
 public:
  NodeCells(const CellGrid& grid, const Vec3& node) {
    for (std::size_t a = 0; a < 3; ++a) {
      const int i = static_cast<int>(a);
      low_[a] = static_cast<int>(std::lround((node[i] - grid.lower[i]) / grid.spacing)) - 1;
    }
    for (std::size_t n = 0; n < 8; ++n) cells_[n] = grid.cells[index(grid, n)];
  }
  [[nodiscard]] bool any(Cell kind) const {
    return std::find(cells_.begin(), cells_.end(), kind) != cells_.end();
  }
  /// Faces between tissue and bone that meet here.
  [[nodiscard]] int bone_faces() const {
    int faces = 0;
    for (std::size_t n = 0; n < 8; ++n) {
      for (const std::size_t bit : {1U, 2U, 4U}) {
        if ((n & bit) != 0) continue;
        const Cell a = cells_[n], b = cells_[n | bit];
        if ((a == Cell::tissue && is_bone(b)) || (b == Cell::tissue && is_bone(a))) ++faces;
      }
    }
    return faces;
  }

 private:
  static bool is_bone(Cell c) { return c == Cell::bone || c == Cell::behind_bone; }
  [[nodiscard]] std::size_t index(const CellGrid& grid, std::size_t n) const {
    return grid.index(low_[0] + static_cast<int>(n & 1), low_[1] + static_cast<int>((n >> 1) & 1),
                      low_[2] + static_cast<int>(n >> 2));
  }
  Index3 low_{};
  std::array<Cell, 8> cells_{};
};

void mark_nodes(const CellGrid& grid, const SurfaceQuery& bone, FaceSolid& face) {
  const std::size_t n = face.mesh.points.size();
  face.nodes.assign(n, FaceNode::inner);
  face.bone_area_mm2.assign(n, 0);
  parallel_for(n, 1024, [&](std::size_t begin, std::size_t end) {
    for (std::size_t p = begin; p < end; ++p) {
      const NodeCells cells(grid, face.mesh.points[p]);
      // In the shadow of bone tissue ends without any.
      const bool near_bone = (cells.any(Cell::bone) || cells.any(Cell::behind_bone)) &&
                             bone.nearest(face.mesh.points[p], 1.2 * grid.spacing);
      if (cells.any(Cell::beyond_region)) {
        face.nodes[p] = FaceNode::rim;
      } else if (near_bone) {
        face.nodes[p] = FaceNode::bone;
        face.bone_area_mm2[p] = 0.25 * grid.spacing * grid.spacing * std::max(1, cells.bone_faces());
      } else if (cells.any(Cell::outside)) {
        face.nodes[p] = FaceNode::skin;
      } else if (cells.any(Cell::air) || cells.any(Cell::too_deep) || cells.any(Cell::behind_bone) ||
                 cells.any(Cell::bone)) {
        face.nodes[p] = FaceNode::free;
      }
    }
  });
}

VoxelGrid voxels_of(const CellGrid& grid) {
  VoxelGrid voxels(grid.size);
  voxels.lower = grid.lower, voxels.spacing = grid.spacing;
  for (int k = 0; k < grid.size[2]; ++k)
    for (int j = 0; j < grid.size[1]; ++j)
      for (int i = 0; i < grid.size[0]; ++i)
        if (grid.cells[grid.index(i, j, k)] == Cell::tissue) voxels.set(i, j, k);
  return voxels;
}

}  // namespace

Result<FaceSolid> build_face_solid(const Head& head, const LayeredTissue& tissue, double spacing_mm,
                                   Context& context) {
  const Stage stage(context, "cubes of the face");
  if (!(spacing_mm >= kLeastCubeMm) || !(spacing_mm <= kGreatestCubeMm)) {
    return Error{ErrorKind::bad_command,
                 fmt::format("cubes of {:g} mm, where {:g} to {:g} mm are possible", spacing_mm, kLeastCubeMm,
                             kGreatestCubeMm),
                 "plan", "Set another spacing: solver fem -spacing 2"};
  }
  const SurfaceQuery bone({&head.skull, &head.mandible, &head.rami});
  const CellGrid grid = classify(head, tissue, bone, spacing_mm);
  TURGOR_CHECK(context.check());
  if (std::count(grid.cells.begin(), grid.cells.end(), Cell::tissue) == 0) {
    return Error{ErrorKind::bad_input, "no cube lies in soft tissue", "scan",
                 "Set a smaller spacing: solver fem -spacing 1.5"};
  }
  FaceSolid face;
  TURGOR_TRY(face.mesh, solid_of(voxels_of(grid)));
  for (std::size_t c = 0; c < grid.cells.size(); ++c)
    if (grid.cells[c] == Cell::tissue) face.depth_mm.push_back(grid.depth_mm[c]);
  mark_nodes(grid, bone, face);
  return face;
}

}  // namespace turgor
