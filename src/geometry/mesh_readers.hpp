// What the readers of surface files share. Internal to the module.
#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <string_view>

#include "turgor/core/error.hpp"
#include "turgor/geometry/mesh_file.hpp"
#include "turgor/geometry/tri_mesh.hpp"

namespace turgor::detail {

/// A file in memory, with the name that errors give it.
struct MeshSource {
  std::span<const std::byte> bytes;
  std::string name;

  [[nodiscard]] std::string_view text() const {
    return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
  }
  [[nodiscard]] Error at_line(std::size_t line, std::string what) const;
  [[nodiscard]] Error at_byte(std::size_t byte, std::string what) const;
  [[nodiscard]] Error whole(std::string what) const;
};

Result<TriMesh> parse_ply(const MeshSource& source);
Result<TriMesh> parse_stl(const MeshSource& source);
Result<TriMesh> parse_obj(const MeshSource& source);
Result<TriMesh> parse_off(const MeshSource& source);
Result<TriMesh> parse_vtk_legacy(const MeshSource& source);
Result<TriMesh> parse_vtk_xml(const MeshSource& source);
Result<CellFile> parse_vtk_cells(const MeshSource& source);
/// Binary or JSON; buffers in files of their own lie beside `source.name`.
Result<TriMesh> parse_gltf(const MeshSource& source);

/// A polygon as a fan of triangles; those that name a point twice are left out.
void add_polygon(TriMesh& mesh, std::span<const int> polygon);

/// The mesh, or an error where it has no triangles.
Result<TriMesh> finished(const MeshSource& source, TriMesh mesh);

/// Lines and words of a text, counting lines.
class TextScanner {
 public:
  explicit TextScanner(std::string_view text) : text_(text) {}

  /// False at the end. Line ends of either kind are taken off.
  bool next_line(std::string_view& line);
  /// The next word, on whatever line; false at the end.
  bool next_word(std::string_view& word);
  /// Number of the line last read, from 1.
  [[nodiscard]] std::size_t line() const { return line_; }
  /// Bytes not read yet.
  [[nodiscard]] std::size_t left() const { return text_.size() - at_; }
  [[nodiscard]] std::size_t position() const { return at_; }

 private:
  std::string_view text_;
  std::size_t at_ = 0, line_ = 0;
  bool within_line_ = false;
};

/// Takes the first word off `line`; empty where there is none.
std::string_view take_word(std::string_view& line);
/// False where the word is not wholly a number, or one too large.
bool to_number(std::string_view word, double& value);
bool to_integer(std::string_view word, long long& value);

}  // namespace turgor::detail
