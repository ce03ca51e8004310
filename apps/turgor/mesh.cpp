// turgor mesh: any surface to a solid of tetrahedra or cubes (Morris 2006, section 2).
#include <fmt/format.h>

#include "subcommands.hpp"
#include "turgor/geometry/mesh_file.hpp"
#include "turgor/geometry/solid_file.hpp"
#include "turgor/geometry/voxel_solid.hpp"

namespace turgor {
namespace {

VoxelOptions options_of(const Invocation& arguments) {
  VoxelOptions options;
  options.resolution = static_cast<int>(arguments.integer("resolution"));
  options.border = !arguments.flag("no_border");
  if (arguments.word("fill") == "winding") options.fill = VoxelOptions::Fill::winding;
  return options;
}

Result<VoxelSolid> solid_from(const std::filesystem::path& path, const VoxelOptions& options,
                              Context& context) {
  TriMesh surface;
  {
    const Stage stage(context, "reading the surface");
    TURGOR_TRY(surface, read_mesh(path));
  }
  const Stage stage(context, "meshing");
  auto voxels = voxelise(surface, options, context);
  if (!voxels) {
    Error error = voxels.error();
    error.where = error.where.empty() ? path.string() : path.string() + ", " + error.where;
    return error;
  }
  if (voxels->closed_holes > 0)
    context.notice(fmt::format("small holes of the surface that were closed: {}", voxels->closed_holes));
  return solid_of(*voxels);
}

}  // namespace

Result<void> run_mesh(const Invocation& arguments, Context& context) {
  const std::filesystem::path target = arguments.path("output");
  const SolidCells cells = arguments.flag("hexahedra") ? SolidCells::hexahedra : SolidCells::tetrahedra;
  TURGOR_CHECK(check_solid_file(target, cells));
  TURGOR_TRY(const VoxelSolid solid, solid_from(arguments.path("surface"), options_of(arguments), context));
  TURGOR_CHECK(context.check());
  {
    const Stage stage(context, "writing the solid");
    TURGOR_CHECK(write_solid(target, solid, cells));
  }
  const bool cubes = cells == SolidCells::hexahedra;
  fmt::print("{} {}, {} points, {} faces on the surface; cubes of {:.4g} mm\n",
             solid.tetrahedra.size() / (cubes ? 5 : 1), cubes ? "hexahedra" : "tetrahedra",
             solid.points.size(), solid.surface_triangles.size() / (cubes ? 2 : 1), solid.spacing);
  fmt::print("solid: {}\n", target.string());
  return {};
}

}  // namespace turgor
