// turgor mesh: any surface, or a part of a scan, to a solid of tetrahedra or cubes (Morris 2006, section 2).
#include <fmt/format.h>

#include "subcommands.hpp"
#include "turgor/geometry/graded_solid.hpp"
#include "turgor/geometry/mesh_file.hpp"
#include "turgor/geometry/solid_file.hpp"
#include "turgor/geometry/solid_quality.hpp"
#include "turgor/geometry/surface_holes.hpp"
#include "turgor/geometry/voxel_solid.hpp"
#include "turgor/imaging/label_solid.hpp"
#include "turgor/imaging/scan.hpp"
#include "turgor/render/leak_picture.hpp"

namespace turgor {
namespace {

VoxelOptions options_of(const Invocation& arguments) {
  VoxelOptions options;
  options.resolution = static_cast<int>(arguments.integer("resolution"));
  options.border = !arguments.flag("no_border");
  if (arguments.word("fill") == "winding") options.fill = VoxelOptions::Fill::winding;
  return options;
}

bool of_scan(const Invocation& arguments) {
  return arguments.given("label") || arguments.given("above") || arguments.given("below");
}

LabelOptions part_of(const Invocation& arguments) {
  LabelOptions options;
  for (const Argument& list : arguments.all("label"))
    for (const std::int64_t label : list.integers) options.labels.push_back(static_cast<int>(label));
  if (arguments.given("above")) options.above = static_cast<int>(arguments.integer("above"));
  if (arguments.given("below")) options.below = static_cast<int>(arguments.integer("below"));
  if (arguments.given("resolution")) options.resolution = static_cast<int>(arguments.integer("resolution"));
  if (arguments.given("spacing")) options.spacing_mm = arguments.number("spacing");
  return options;
}

/// What goes with a surface, and not with a scan, or the other way round, or only with another flag.
Result<void> check_flags(const Invocation& arguments) {
  const auto refuse = [](const char* flag, const char* what) {
    return Error{ErrorKind::bad_command, fmt::format("-{} is {}", flag, what), "",
                 fmt::format("Leave out -{}", flag)};
  };
  for (const char* flag : {"no_border", "fill", "leak_picture", "smooth"})
    if (of_scan(arguments) && arguments.given(flag))
      return refuse(flag, "for surfaces, not for parts of a scan");
  if (!of_scan(arguments) && arguments.given("spacing")) return refuse("spacing", "for parts of a scan");
  for (const char* flag : {"fine", "smooth"})
    if (arguments.given(flag) && !arguments.given("graded")) return refuse(flag, "for graded solids");
  return {};
}

Error at_file(Error error, const std::filesystem::path& path) {
  error.where = error.where.empty() ? path.string() : path.string() + ", " + error.where;
  return error;
}

/// Draws where the surface is open, where it is.
Result<bool> draw_leak(const TriMesh& surface, const std::filesystem::path& picture, Context& context) {
  TURGOR_TRY(const std::vector<SurfaceHole> holes, surface_holes(surface));
  if (holes.empty()) return false;
  TURGOR_TRY(const Image image, leak_picture(surface, holes, {}, context));
  TURGOR_CHECK(write_png(picture, image));
  return true;
}

GradedOptions grading(const Invocation& arguments) {
  GradedOptions options;
  options.voxels = options_of(arguments);
  options.levels = static_cast<int>(arguments.integer("graded"));
  options.smooth_deg = arguments.number("smooth");
  for (const Argument& box : arguments.all("fine")) options.fine.push_back(to_box(box));
  return options;
}

Result<SolidMesh> filled(const TriMesh& surface, const Invocation& arguments, Context& context) {
  TURGOR_TRY(const VoxelGrid voxels, voxelise(surface, options_of(arguments), context));
  if (voxels.closed_holes > 0)
    context.notice(fmt::format("small holes of the surface that were closed: {}", voxels.closed_holes));
  TURGOR_CHECK(context.check());
  if (arguments.given("graded")) return graded_solid(voxels, surface, grading(arguments));
  return solid_of(voxels);
}

Result<SolidMesh> surface_solid(const Invocation& arguments, Context& context) {
  const std::filesystem::path path = arguments.path("surface");
  TriMesh surface;
  {
    const Stage stage(context, "reading the surface");
    TURGOR_TRY(surface, read_mesh(path));
  }
  const Stage stage(context, "meshing");
  auto solid = filled(surface, arguments, context);
  if (solid) return solid;
  Error error = at_file(solid.error(), path);
  if (arguments.given("leak_picture") && error.kind == ErrorKind::bad_input) {
    const std::filesystem::path picture = arguments.path("leak_picture");
    TURGOR_TRY(const bool drawn, draw_leak(surface, picture, context));
    if (drawn) error.remedy += fmt::format("; {} shows where", picture.string());
  }
  return error;
}

Result<SolidMesh> scan_solid(const Invocation& arguments, Context& context) {
  const std::filesystem::path path = arguments.path("surface");
  ReadScanOptions options;
  options.labels = arguments.given("label");
  TURGOR_TRY(const Scan scan, read_scan(path, options, context));
  const Stage stage(context, "meshing");
  const auto voxels = label_voxels(scan.hu, part_of(arguments));
  if (!voxels) return at_file(voxels.error(), path);
  TURGOR_CHECK(context.check());
  if (!arguments.given("graded")) return solid_of(*voxels);
  const GradedOptions graded = grading(arguments);
  return graded_solid(*voxels, graded.levels, graded.fine);
}

void print_summary(const SolidMesh& solid, bool cubes) {
  fmt::print("{} {}, {} points, {} faces on the surface; ", solid.tetrahedra.size() / (cubes ? 5 : 1),
             cubes ? "hexahedra" : "tetrahedra", solid.points.size(),
             solid.surface_triangles.size() / (cubes ? 2 : 1));
  if (solid.spacing > 0) {
    fmt::print("cubes of {:.4g} mm\n", solid.spacing);
  } else {
    const SolidQuality quality = solid_quality(solid.points, solid.tetrahedra);
    fmt::print("dihedral angles {:.0f} to {:.0f} degrees, radius ratio {:.2f} or more\n",
               quality.least_dihedral_deg, quality.greatest_dihedral_deg, quality.least_radius_ratio);
  }
}

}  // namespace

Result<void> run_mesh(const Invocation& arguments, Context& context) {
  const std::filesystem::path target = arguments.path("output");
  const SolidCells cells = arguments.flag("hexahedra") ? SolidCells::hexahedra : SolidCells::tetrahedra;
  TURGOR_CHECK(check_flags(arguments));
  TURGOR_CHECK(check_solid_file(target, cells));
  TURGOR_TRY(const SolidMesh solid,
             of_scan(arguments) ? scan_solid(arguments, context) : surface_solid(arguments, context));
  TURGOR_CHECK(context.check());
  {
    const Stage stage(context, "writing the solid");
    TURGOR_CHECK(write_solid(target, solid, cells));
  }
  print_summary(solid, cells == SolidCells::hexahedra);
  fmt::print("solid: {}\n", target.string());
  return {};
}

}  // namespace turgor
