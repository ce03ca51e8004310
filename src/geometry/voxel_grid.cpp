// From a surface to voxels.
#include <algorithm>

#include "geometry/voxel_crossings.hpp"
#include "geometry/voxel_fill.hpp"
#include "geometry/voxel_lattice.hpp"
#include "turgor/geometry/voxel_solid.hpp"

namespace turgor {
namespace {

using detail::Hole;
using detail::Lattice;

bool any_bit(const VoxelGrid& grid) {
  return std::any_of(grid.bits.begin(), grid.bits.end(), [](std::uint64_t word) { return word != 0; });
}

Error open_error(const std::vector<Hole>& holes, const Lattice& lattice) {
  const std::string where = holes.empty() ? "" : in_mm(holes[0], lattice).text();
  return {ErrorKind::bad_input, "the surface is open, so inside leaks out", where,
          "Close the surface, or use -fill winding"};
}

/// The voxels that an even number of sheets shut off from outside.
VoxelGrid doubtful_voxels(const detail::CrossedLinks& links, const VoxelGrid& inside) {
  VoxelGrid rest = flood_outside(links, VoxelGrid(inside.size));
  for (std::size_t w = 0; w < rest.bits.size(); ++w) rest.bits[w] = ~(rest.bits[w] | inside.bits[w]);
  return rest;
}

Result<void> fill_by_crossings(const VoxelOptions& options, Lattice& lattice, VoxelGrid& inside) {
  detail::CrossedLinks links;
  add_crossings(lattice, lattice.triangles, inside, links);
  bool closed = fill_by_parity(links, inside);
  std::vector<Hole> holes;
  if (!closed) {
    holes = find_holes(lattice);
    const auto longest = std::max({lattice.size[0], lattice.size[1], lattice.size[2]}) - 2;
    const double limit = std::ldexp(std::max(1.0, options.largest_hole * longest), lattice.shift);
    const auto first =
        std::find_if(holes.begin(), holes.end(), [&](const Hole& h) { return h.width <= limit; });
    const auto before = static_cast<std::ptrdiff_t>(lattice.triangles.size());
    for (auto hole = first; hole != holes.end(); ++hole) close_hole(*hole, lattice);
    inside.closed_holes = static_cast<int>(holes.end() - first);
    holes.erase(first, holes.end());
    add_crossings(lattice, {lattice.triangles.begin() + before, lattice.triangles.end()}, inside, links);
    closed = fill_by_parity(links, inside);
  }
  if (!closed) return open_error(holes, lattice);
  const VoxelGrid doubtful = doubtful_voxels(links, inside);
  if (any_bit(doubtful)) resolve_shells(lattice, doubtful, inside);
  if (any_bit(inside)) return {};
  // Nothing inside: a sheet thinner than a voxel, or no body at all.
  holes = find_holes(lattice);
  if (!holes.empty()) return open_error(holes, lattice);
  return {};
}

}  // namespace

Result<VoxelGrid> voxelise(const TriMesh& surface, const VoxelOptions& options, const Context& context) {
  TURGOR_TRY(Lattice lattice, detail::make_lattice(surface, options));
  VoxelGrid grid(lattice.size);
  grid.lower = lattice.lower, grid.spacing = lattice.spacing;
  if (options.fill == VoxelOptions::Fill::winding) {
    detail::CrossedLinks links;
    add_crossings(lattice, lattice.triangles, grid, links);
    detail::fill_by_winding(surface, links, grid, context);
  } else {
    TURGOR_CHECK(fill_by_crossings(options, lattice, grid));
  }
  TURGOR_CHECK(context.check());
  if (options.border) add_touched(lattice, grid);
  if (any_bit(grid)) return grid;
  return Error{ErrorKind::bad_input, "the centre of no voxel lies inside the surface", "",
               "Give a higher resolution, or keep the border voxels"};
}

}  // namespace turgor
