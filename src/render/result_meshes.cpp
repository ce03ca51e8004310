#include "turgor/core/index.hpp"
#include "turgor/geometry/mesh_file.hpp"
#include "turgor/geometry/voxel_solid.hpp"
#include "turgor/render/results.hpp"

namespace turgor {
namespace {

constexpr Vec3f skin_colour{0.62f, 0.36f, 0.26f}, bone_colour{0.78f, 0.70f, 0.55f};

Result<void> write_surface(const std::filesystem::path& stem, const TriMesh& mesh,
                           const std::vector<MeshField>& fields, const Vec3f& colour) {
  TURGOR_CHECK(write_ply(stem.string() + ".ply", mesh, fields));
  TURGOR_CHECK(write_vtp(stem.string() + ".vtp", mesh, fields));
  return write_glb(stem.string() + ".glb", {{stem.filename().string(), &mesh, colour, 0.5f, {}}});
}

CellMesh prisms(const LayeredTissue& tissue) {
  constexpr std::uint8_t vtk_wedge = 13;
  CellMesh mesh;
  mesh.points = tissue.points;
  for (int s = 0; s + 1 < tissue.sheets; ++s) {
    for (const Index3& t : tissue.surface.triangles) {
      // VTK's wedge: the first triangle's normal points away from the second.
      for (const int c : t) mesh.connectivity.push_back(tissue.point(s, c));
      for (const int c : t) mesh.connectivity.push_back(tissue.point(s + 1, c));
      mesh.offsets.push_back(static_cast<int>(mesh.connectivity.size()));
      mesh.types.push_back(vtk_wedge);
    }
  }
  return mesh;
}

std::vector<MeshField> tissue_point_fields(const CaseResults& results) {
  const LayeredTissue& tissue = results.patient.tissue();
  MeshField thickness{"thickness_mm", 1, {}}, attached{"attached", 1, {}}, fixed{"fixed", 1, {}},
      end{"bone", 1, {}};
  for (int s = 0; s < tissue.sheets; ++s) {
    for (int c = 0; c < tissue.columns(); ++c) {
      const bool inner = s == tissue.sheets - 1;
      thickness.values.push_back(static_cast<float>(tissue.thickness_mm[at(c)]));
      attached.values.push_back(inner && tissue.attached[at(c)] ? 1.0f : 0.0f);
      fixed.values.push_back(tissue.fixed[at(c)] ? 1.0f : 0.0f);
      end.values.push_back(static_cast<float>(tissue.ends[at(c)]));
    }
  }
  std::vector<MeshField> fields{std::move(thickness), std::move(attached), std::move(fixed), std::move(end)};
  for (const Prediction& p : results.predictions) {
    if (p.tissue_points.empty()) continue;
    MeshField shift{"displacement_mm_" + std::string(name_of(p.solver)), 3, {}};
    for (std::size_t i = 0; i < tissue.points.size(); ++i) {
      const Vec3f d = to_float(p.tissue_points[i] - tissue.points[i]);
      shift.values.insert(shift.values.end(), {d.x, d.y, d.z});
    }
    fields.push_back(std::move(shift));
  }
  return fields;
}

CellMesh cubes(const FaceSolid& face) {
  constexpr std::uint8_t vtk_hexahedron = 12;
  CellMesh mesh;
  mesh.points.assign(face.mesh.points.begin(), face.mesh.points.end());
  for (const auto& cube : hexahedra(face.mesh)) {
    mesh.connectivity.insert(mesh.connectivity.end(), cube.begin(), cube.end());
    mesh.offsets.push_back(static_cast<int>(mesh.connectivity.size()));
    mesh.types.push_back(vtk_hexahedron);
  }
  return mesh;
}

// Where the cubes were before surgery, and what became of them.
Result<void> write_cubes(const std::filesystem::path& path, const CubeField& field) {
  MeshField shift{"displacement_mm", 3, {}}, place{"lies_on", 1, {}};
  for (const Vec3& displacement : field.displacement_mm) {
    const Vec3f d = to_float(displacement);
    shift.values.insert(shift.values.end(), {d.x, d.y, d.z});
  }
  for (const FaceNode node : field.face.nodes) place.values.push_back(static_cast<float>(node));
  std::vector<MeshField> of_cubes{{"depth_mm", 1, field.face.depth_mm}};
  if (!field.von_mises_mpa.empty()) of_cubes.push_back({"von_mises_mpa", 1, field.von_mises_mpa});
  return write_vtu(path, cubes(field.face), {std::move(shift), std::move(place)}, of_cubes);
}

MeshField layer_field(const LayeredTissue& tissue) {
  MeshField layer{"layer", 1, {}};
  for (int s = 0; s + 1 < tissue.sheets; ++s) {
    layer.values.insert(layer.values.end(), tissue.surface.triangles.size(), static_cast<float>(s));
  }
  return layer;
}

}  // namespace

Result<void> write_meshes(const CaseResults& results, const std::filesystem::path& folder) {
  const PatientCase& patient = results.patient;
  TURGOR_CHECK(write_surface(folder / "skin_before", patient.skin(), {}, skin_colour));
  for (std::size_t i = 0; i < results.predictions.size(); ++i) {
    const Prediction& p = results.predictions[i];
    const std::string name = i == 0 ? "skin_after" : "skin_after_" + std::string(name_of(p.solver));
    TURGOR_CHECK(
        write_surface(folder / name, p.skin, {{"displacement_mm", 1, p.displacement_mm}}, skin_colour));
    if (p.cubes != nullptr)
      TURGOR_CHECK(write_cubes(folder / ("cubes_" + std::string(name_of(p.solver)) + ".vtu"), *p.cubes));
  }
  for (const BoneSegment& s : patient.bones().segments()) {
    if (s.surface.empty()) continue;
    const TriMesh after = transformed(s.surface, s.motion);
    TURGOR_CHECK(write_ply(folder / ("bone_before_" + s.name + ".ply"), s.surface));
    TURGOR_CHECK(write_ply(folder / ("bone_after_" + s.name + ".ply"), after));
    TURGOR_CHECK(
        write_glb(folder / ("bone_after_" + s.name + ".glb"), {{s.name, &after, bone_colour, 0.6f, {}}}));
  }
  return write_vtu(folder / "tissue.vtu", prisms(patient.tissue()), tissue_point_fields(results),
                   {layer_field(patient.tissue())});
}

}  // namespace turgor
