#include <fmt/format.h>

#include <cmath>

#include "render/picture_files.hpp"
#include "render/shown_solid.hpp"
#include "turgor/core/file.hpp"
#include "turgor/core/index.hpp"
#include "turgor/geometry/mesh_file.hpp"
#include "turgor/render/calibration_report.hpp"

namespace turgor {
namespace {

CellMesh cells_of(const SolidMesh& mesh) {
  constexpr std::uint8_t tetrahedron = 10;  // VTK's number
  CellMesh out;
  out.points.assign(mesh.points.begin(), mesh.points.end());
  for (const auto& p : mesh.tetrahedra) {
    out.connectivity.insert(out.connectivity.end(), p.begin(), p.end());
    out.offsets.push_back(static_cast<int>(out.connectivity.size()));
    out.types.push_back(tetrahedron);
  }
  return out;
}

void add(MeshField& field, const Vec3& v) {
  const Vec3f f = to_float(v);
  field.values.insert(field.values.end(), {f.x, f.y, f.z});
}

MeshField displacement(const std::string& of, std::span<const Vec3> positions, const SolidMesh& mesh) {
  MeshField field{"displacement_mm_" + of, 3, {}};
  for (std::size_t p = 0; p < positions.size(); ++p) add(field, positions[p] - mesh.points[p]);
  return field;
}

MeshField error(const std::string& of, std::span<const Vec3> positions, std::span<const Vec3> reference) {
  MeshField field{"error_mm_" + of, 1, {}};
  for (std::size_t p = 0; p < positions.size(); ++p)
    field.values.push_back(static_cast<float>(distance(positions[p], reference[p])));
  return field;
}

MeshField modulus_field(const CalibrationCase& problem) {
  MeshField modulus{"reference_youngs_modulus_mpa", 1, {}};
  for (std::size_t t = 0; t < problem.mesh().tetrahedra.size(); ++t)
    modulus.values.push_back(static_cast<float>(problem.reference_body().of(t / 5).youngs_modulus_mpa));
  return modulus;
}

MeshField held_field(const CalibrationCase& problem) {
  MeshField held{"held", 1, std::vector<float>(problem.mesh().points.size())};
  for (const int p : problem.held()) held.values[at(p)] = 1;
  return held;
}

Result<void> write_load(const CalibrationResults& results, std::size_t l, const CellMesh& cells,
                        const render_detail::ShownSolid& shown, const std::filesystem::path& folder) {
  const SolidMesh& mesh = results.problem.mesh();
  const PreparedLoad& load = results.problem.loads()[l];
  const LoadShapes& shapes = results.outcome.loads[l];
  MeshField force{"force_n", 3, {}};
  for (const Vec3& f : load.force_n) add(force, f);
  std::vector<MeshField> fields{std::move(force), held_field(results.problem),
                                displacement("reference", load.reference, mesh)};
  const std::string stem = fmt::format("load_{}", l + 1);
  TURGOR_CHECK(write_ply(folder / (stem + "_reference.ply"), shown.shape(load.reference)));
  const auto add_model = [&](const std::string& name, const std::vector<Vec3>& positions) -> Result<void> {
    if (positions.empty()) return {};
    fields.push_back(displacement(name, positions, mesh));
    fields.push_back(error(name, positions, load.reference));
    return write_ply(folder / (stem + "_" + name + ".ply"), shown.shape(positions));
  };
  TURGOR_CHECK(add_model("uncalibrated", shapes.guess));
  TURGOR_CHECK(add_model("calibrated", shapes.calibrated));
  return write_vtu(folder / (stem + ".vtu"), cells, fields, {modulus_field(results.problem)});
}

}  // namespace

Result<void> write_calibration_meshes(const CalibrationResults& results,
                                      const std::filesystem::path& folder) {
  const CellMesh cells = cells_of(results.problem.mesh());
  const SolidMesh& mesh = results.problem.mesh();
  TURGOR_CHECK(write_solid_constants(folder / "constants.vtu", mesh.points, results.problem.elements(),
                                     results.outcome.stiffness));
  const auto* body = std::get_if<SurfaceBody>(&results.problem.options().body);
  TURGOR_TRY(const auto shown,
             render_detail::ShownSolid::create(results.problem.mesh(), body ? &body->surface : nullptr));
  for (std::size_t l = 0; l < results.problem.loads().size(); ++l)
    TURGOR_CHECK(write_load(results, l, cells, shown, folder));
  return {};
}

Result<void> write_calibration(const CalibrationResults& results, const std::filesystem::path& folder,
                               Context& context) {
  const PictureOptions options{.width = 640, .height = 540, .samples = 16};
  TURGOR_TRY(const std::vector<Picture> pictures, calibration_pictures(results, options, context));
  const Stage stage(context, "files");
  TURGOR_CHECK(write_calibration_meshes(results, folder));
  TURGOR_CHECK(render_detail::write_pictures(pictures, folder / "pictures", context));
  const std::string json = calibration_json(results, context);
  TURGOR_CHECK(write_file(folder / "report.html", calibration_html(results, pictures, json, context)));
  return write_file(folder / "calibration.json", json);
}

}  // namespace turgor
