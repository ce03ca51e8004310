#include "fem/voxel_numbering.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "fem/elastic_problem.hpp"
#include "turgor/core/index.hpp"
#include "turgor/core/parallel.hpp"
#include "turgor/geometry/voxel_solid.hpp"

namespace turgor::detail {
namespace {

constexpr std::size_t kGrain = 4096;
constexpr double kOffLattice = 1e-3;  // of the spacing
constexpr int kLongestAxis = 1 << 13;

Error no_lattice(std::string what, std::string where) {
  return bad_elasticity(std::move(what), std::move(where),
                        "Give a solid made of voxels, as solid_of() makes it");
}

Result<void> check_indices(const SolidMesh& solid) {
  if (!(solid.spacing > 1e-30) || !(solid.spacing < kBeyondReach) || solid.tetrahedra.empty() ||
      solid.tetrahedra.size() % 5 != 0) {
    return no_lattice("the solid is not made of cubes", "voxel solid");
  }
  for (std::size_t t = 0; t < solid.tetrahedra.size(); ++t) {
    for (const int p : solid.tetrahedra[t]) {
      if (p < 0 || at(p) >= solid.points.size())
        return no_lattice(fmt::format("there is no point {}", p), fmt::format("tetrahedron {}", t));
    }
  }
  return {};
}

// The lattice's lowest corner.
Result<Vec3> lower_corner(const SolidMesh& solid, const std::vector<std::array<int, 8>>& cubes) {
  Box3 box;
  for (const auto& cube : cubes) {
    for (const int p : {cube[0], cube[6]}) {
      if (!is_finite(solid.points[at(p)]))
        return no_lattice("a point is not finite", fmt::format("point {}", p));
      box.extend(solid.points[at(p)]);
    }
  }
  const Vec3 extent = box.size() / solid.spacing;
  if (!(std::max({extent.x, extent.y, extent.z}) < kLongestAxis))
    return no_lattice(fmt::format("the lattice is longer than {} cubes", kLongestAxis), "voxel solid");
  return box.lower;
}

// The cell of a cube whose corners lie where they should.
bool cell_of(const SolidMesh& solid, const Vec3& lower, const std::array<int, 8>& cube, Index3& cell) {
  const Vec3 low = (solid.points[at(cube[0])] - lower) / solid.spacing;
  for (int a = 0; a < 3; ++a) cell[at(a)] = static_cast<int>(std::lround(low[a]));
  for (std::size_t n = 0; n < 8; ++n) {
    const Vec3 p = (solid.points[at(cube[n])] - lower) / solid.spacing;
    for (int a = 0; a < 3; ++a) {
      const int expected = cell[at(a)] + ((kCornerBits[n] >> a) & 1);
      if (!(std::abs(p[a] - expected) < kOffLattice)) return false;
    }
  }
  return std::min({cell[0], cell[1], cell[2]}) >= 0;
}

}  // namespace

Result<VoxelNumbering> VoxelNumbering::of(const SolidMesh& solid) {
  TURGOR_CHECK(check_indices(solid));
  VoxelNumbering v;
  v.cubes = hexahedra(solid);
  TURGOR_TRY(const Vec3 lower, lower_corner(solid, v.cubes));
  v.cells.resize(v.cubes.size());
  const int astray = parallel_reduce<int>(
      v.cubes.size(), kGrain, -1,
      [&](std::size_t begin, std::size_t end) {
        for (std::size_t c = begin; c < end; ++c)
          if (!cell_of(solid, lower, v.cubes[c], v.cells[c])) return static_cast<int>(c);
        return -1;
      },
      [](int a, int b) { return a >= 0 ? a : b; });
  if (astray >= 0) return no_lattice("a cube does not lie on the lattice", fmt::format("cube {}", astray));
  Index3 box{0, 0, 0};
  for (const Index3& cell : v.cells)
    for (std::size_t a = 0; a < 3; ++a) box[a] = std::max(box[a], cell[a] + 1);
  v.spans.assign(at(box[1]) * at(box[2]), {});
  for (const Index3& cell : v.cells) {
    CellSpan& span = v.spans[at(cell[2]) * at(box[1]) + at(cell[1])];
    const bool none = span.end <= span.first;
    span.first = none ? cell[0] : std::min(span.first, cell[0]);
    span.end = none ? cell[0] + 1 : std::max(span.end, cell[0] + 1);
  }
  v.rows = VoxelRows(box, v.spans, v.cells.size());
  if (v.rows.values() > 0xFFFFFFFF) return no_lattice("the lattice has too many points", "voxel solid");
  v.nodes.assign(solid.points.size(), {});
  std::vector<int> point_at(v.rows.values(), -1);
  std::vector<bool> taken(v.rows.cell_count, false);
  for (std::size_t c = 0; c < v.cubes.size(); ++c) {
    if (taken[v.cell(c)]) return no_lattice("two cubes lie in one place", fmt::format("cube {}", c));
    taken[v.cell(c)] = true;
    const auto corners = v.rows.corners(v.cells[c][0], v.cells[c][1], v.cells[c][2]);
    for (std::size_t n = 0; n < 8; ++n) {
      const NodePlace& place = corners[at(kCornerBits[n])];
      const int p = v.cubes[c][n];
      int& there = point_at[place.value];
      if (there >= 0 && there != p)
        return no_lattice(fmt::format("points {} and {} lie in one place", there, p), "voxel solid");
      there = p;
      v.nodes[at(p)] = place;
    }
  }
  return v;
}

void VoxelNumbering::face_pairs(const std::function<void(int, int)>& pair) const {
  std::vector<int> cube_at(rows.cell_count + 1, -1);
  for (std::size_t c = 0; c < cubes.size(); ++c) cube_at[cell(c)] = static_cast<int>(c);
  for (std::size_t c = 0; c < cubes.size(); ++c) {
    const Index3& at_cell = cells[c];
    for (std::size_t a = 0; a < 3; ++a) {
      Index3 before = at_cell;
      --before[a];
      const int other = cube_at[rows.cell(before[0], before[1], before[2])];
      if (other >= 0) pair(other, static_cast<int>(c));
    }
  }
}

void VoxelNumbering::scatter(std::span<const Vec3> of_nodes, std::vector<double>& values) const {
  parallel_for(nodes.size(), kGrain, [&](std::size_t begin, std::size_t end) {
    for (std::size_t n = begin; n < end; ++n) {
      const NodePlace& p = nodes[n];
      if (p.stride == 0) continue;
      for (std::size_t c = 0; c < 3; ++c) values[p.component(c)] = of_nodes[n][static_cast<int>(c)];
    }
  });
}

std::vector<Vec3> VoxelNumbering::gather(const std::vector<double>& values) const {
  std::vector<Vec3> out(nodes.size());
  parallel_for(nodes.size(), kGrain, [&](std::size_t begin, std::size_t end) {
    for (std::size_t n = begin; n < end; ++n) {
      const NodePlace& p = nodes[n];
      if (p.stride == 0) continue;
      out[n] = {values[p.component(0)], values[p.component(1)], values[p.component(2)]};
    }
  });
  return out;
}

}  // namespace turgor::detail
