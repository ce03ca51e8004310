// VTK's XML files (PolyData, UnstructuredGrid) with appended raw data: VTK file formats, "XML file formats".
#include <fmt/format.h>

#include <limits>

#include "geometry/bytes.hpp"
#include "geometry/field_check.hpp"
#include "turgor/core/file.hpp"
#include "turgor/geometry/mesh_file.hpp"

namespace turgor {
namespace {

/// Collects arrays: their elements for the XML part, their bytes (each after its length) for the appended
/// part.
class Appended {
 public:
  template <class T>
  std::string array(const std::string& name, const char* type, int components, const std::vector<T>& values) {
    std::string element = fmt::format(
        "<DataArray type=\"{}\" Name=\"{}\" NumberOfComponents=\"{}\" format=\"appended\" offset=\"{}\"/>\n",
        type, name, components, bytes_.size());
    bytes_.put(static_cast<std::uint64_t>(values.size() * sizeof(T)));
    bytes_.put_all(values);
    return element;
  }
  std::string points(const std::vector<Vec3>& points) {
    std::vector<Vec3f> single(points.size());
    for (std::size_t i = 0; i < points.size(); ++i) single[i] = to_float(points[i]);
    return "<Points>\n" + array("Points", "Float32", 3, single) + "</Points>\n";
  }
  std::string fields(const char* where, const std::vector<MeshField>& fields) {
    std::string text = fmt::format("<{}>\n", where);
    for (const MeshField& f : fields)
      text += array(detail::safe_name(f.name), "Float32", f.components, f.values);
    return text + fmt::format("</{}>\n", where);
  }
  [[nodiscard]] const std::vector<std::byte>& bytes() const { return bytes_.bytes(); }

 private:
  detail::ByteWriter bytes_;
};

Result<void> write_document(const std::filesystem::path& path, const char* type, const std::string& piece,
                            const Appended& data) {
  detail::ByteWriter out(piece.size() + data.bytes().size() + 512);
  out.text(
      fmt::format("<?xml version=\"1.0\"?>\n<!-- Turgor; millimetres, LPS: x to the patient's left, y to the "
                  "back, z up -->\n<VTKFile type=\"{}\" version=\"1.0\" byte_order=\"LittleEndian\" "
                  "header_type=\"UInt64\">\n<{}>\n{}</{}>\n<AppendedData encoding=\"raw\">\n_",
                  type, type, piece, type));
  out.put_all(data.bytes());
  out.text("\n</AppendedData>\n</VTKFile>\n");
  return write_file(path, out.bytes());
}

/// Connectivity names only points there are, and the cells end in rising order within it.
Result<void> check_cells(const CellMesh& mesh, const std::filesystem::path& path) {
  const auto fail = [&](const char* what) { return Error{ErrorKind::internal, what, path.string()}; };
  if (mesh.offsets.size() != mesh.types.size()) return fail("the mesh has not one type for each cell");
  int end = 0;
  for (const int offset : mesh.offsets) {
    if (offset < end) return fail("the cells of the mesh end out of order");
    end = offset;
  }
  if (static_cast<std::size_t>(end) != mesh.connectivity.size())
    return fail("the cells do not end where their points do");
  for (const int p : mesh.connectivity) {
    if (p < 0 || static_cast<std::size_t>(p) >= mesh.points.size())
      return fail("a cell names a point that is not there");
  }
  return {};
}

}  // namespace

Result<void> write_vtp(const std::filesystem::path& path, const TriMesh& mesh,
                       const std::vector<MeshField>& point_fields) {
  TURGOR_CHECK(detail::check_surface(mesh, path));
  TURGOR_CHECK(detail::check_fields(point_fields, mesh.points.size(), path));
  std::vector<std::int32_t> connectivity, offsets;
  connectivity.reserve(mesh.triangles.size() * 3);
  offsets.reserve(mesh.triangles.size());
  for (const Index3& t : mesh.triangles) {
    connectivity.insert(connectivity.end(), t.begin(), t.end());
    offsets.push_back(static_cast<std::int32_t>(connectivity.size()));
  }
  Appended data;
  std::string piece = fmt::format(
      "<Piece NumberOfPoints=\"{}\" NumberOfVerts=\"0\" NumberOfLines=\"0\" NumberOfStrips=\"0\" "
      "NumberOfPolys=\"{}\">\n",
      mesh.points.size(), mesh.triangles.size());
  piece += data.fields("PointData", point_fields);
  piece += data.points(mesh.points);
  piece += "<Polys>\n" + data.array("connectivity", "Int32", 1, connectivity);
  piece += data.array("offsets", "Int32", 1, offsets) + "</Polys>\n</Piece>\n";
  return write_document(path, "PolyData", piece, data);
}

Result<void> write_vtu(const std::filesystem::path& path, const CellMesh& mesh,
                       const std::vector<MeshField>& point_fields,
                       const std::vector<MeshField>& cell_fields) {
  TURGOR_CHECK(check_cells(mesh, path));
  TURGOR_CHECK(detail::check_fields(point_fields, mesh.points.size(), path));
  TURGOR_CHECK(detail::check_fields(cell_fields, mesh.types.size(), path));
  Appended data;
  std::string piece = fmt::format("<Piece NumberOfPoints=\"{}\" NumberOfCells=\"{}\">\n", mesh.points.size(),
                                  mesh.types.size());
  piece += data.fields("PointData", point_fields);
  piece += data.fields("CellData", cell_fields);
  piece += data.points(mesh.points);
  piece += "<Cells>\n" + data.array("connectivity", "Int32", 1, mesh.connectivity);
  piece += data.array("offsets", "Int32", 1, mesh.offsets);
  piece += data.array("types", "UInt8", 1, mesh.types) + "</Cells>\n</Piece>\n";
  return write_document(path, "UnstructuredGrid", piece, data);
}

}  // namespace turgor
