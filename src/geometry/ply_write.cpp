// Surfaces to binary little-endian PLY.
#include <fmt/format.h>

#include "geometry/bytes.hpp"
#include "geometry/field_check.hpp"
#include "turgor/core/file.hpp"
#include "turgor/geometry/mesh_file.hpp"

namespace turgor {
namespace {

std::string header(const TriMesh& mesh, const std::vector<MeshField>& fields) {
  std::string text = fmt::format(
      "ply\nformat binary_little_endian 1.0\ncomment Turgor; millimetres, LPS: x to the patient's left, y to "
      "the "
      "back, z up\nelement vertex {}\nproperty float x\nproperty float y\nproperty float z\n",
      mesh.points.size());
  for (const MeshField& field : fields) {
    const std::string name = detail::safe_name(field.name);
    if (field.components == 1) {
      text += fmt::format("property float {}\n", name);
    } else {
      for (int c = 0; c < field.components; ++c) text += fmt::format("property float {}_{}\n", name, c);
    }
  }
  text += fmt::format("element face {}\nproperty list uchar int vertex_indices\nend_header\n",
                      mesh.triangles.size());
  return text;
}

}  // namespace

Result<void> write_ply(const std::filesystem::path& path, const TriMesh& mesh,
                       const std::vector<MeshField>& point_fields) {
  TURGOR_CHECK(detail::check_surface(mesh, path));
  TURGOR_CHECK(detail::check_fields(point_fields, mesh.points.size(), path));
  std::size_t row = 3 * sizeof(float);
  for (const MeshField& field : point_fields)
    row += static_cast<std::size_t>(field.components) * sizeof(float);
  detail::ByteWriter out(512 + 64 * point_fields.size() + mesh.points.size() * row +
                         mesh.triangles.size() * 13);
  out.text(header(mesh, point_fields));
  for (std::size_t i = 0; i < mesh.points.size(); ++i) {
    for (int k = 0; k < 3; ++k) out.put(static_cast<float>(mesh.points[i][k]));
    for (const MeshField& field : point_fields) {
      const auto components = static_cast<std::size_t>(field.components);
      for (std::size_t c = 0; c < components; ++c) out.put(field.values[i * components + c]);
    }
  }
  for (const Index3& t : mesh.triangles) {
    out.put(std::uint8_t{3});
    for (const int p : t) out.put(static_cast<std::int32_t>(p));
  }
  return write_file(path, out.bytes());
}

}  // namespace turgor
