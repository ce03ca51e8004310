#include "geometry/mesh_readers.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <limits>

#include "turgor/core/file.hpp"
#include "turgor/core/lower_case.hpp"
#include "turgor/geometry/mesh_file.hpp"

namespace turgor {
namespace detail {
namespace {

bool is_space(char c) {
  return c == ' ' || c == '\t' || c == '\r' || c == '\n' || c == '\v' || c == '\f';
}

constexpr const char* remedy = "Export the surface again, as binary PLY if possible";

}  // namespace

Error MeshSource::at_line(std::size_t line, std::string what) const {
  return {ErrorKind::bad_input, std::move(what), fmt::format("{}, line {}", name, line), remedy};
}
Error MeshSource::at_byte(std::size_t byte, std::string what) const {
  return {ErrorKind::bad_input, std::move(what), fmt::format("{}, byte {}", name, byte), remedy};
}
Error MeshSource::whole(std::string what) const {
  return {ErrorKind::bad_input, std::move(what), name, remedy};
}

void add_polygon(TriMesh& mesh, std::span<const int> polygon) {
  for (std::size_t i = 2; i < polygon.size(); ++i) {
    const Index3 t{polygon[0], polygon[i - 1], polygon[i]};
    if (t[0] != t[1] && t[1] != t[2] && t[2] != t[0]) mesh.triangles.push_back(t);
  }
}

Result<TriMesh> finished(const MeshSource& source, TriMesh mesh) {
  if (mesh.triangles.empty()) return source.whole("holds no triangles");
  return mesh;
}

bool TextScanner::next_line(std::string_view& line) {
  if (at_ >= text_.size()) return false;
  if (!within_line_) ++line_;
  within_line_ = false;
  const std::size_t end = std::min(text_.find('\n', at_), text_.size());
  line = text_.substr(at_, end - at_);
  at_ = std::min(end + 1, text_.size());
  if (!line.empty() && line.back() == '\r') line.remove_suffix(1);
  return true;
}

bool TextScanner::next_word(std::string_view& word) {
  while (at_ < text_.size() && is_space(text_[at_])) {
    if (!within_line_) ++line_, within_line_ = true;
    if (text_[at_++] == '\n') within_line_ = false;
  }
  if (at_ >= text_.size()) return false;
  if (!within_line_) ++line_, within_line_ = true;
  const std::size_t start = at_;
  while (at_ < text_.size() && !is_space(text_[at_])) ++at_;
  word = text_.substr(start, at_ - start);
  return true;
}

std::string_view take_word(std::string_view& line) {
  std::size_t start = 0;
  while (start < line.size() && is_space(line[start])) ++start;
  std::size_t end = start;
  while (end < line.size() && !is_space(line[end])) ++end;
  const std::string_view word = line.substr(start, end - start);
  line.remove_prefix(end);
  return word;
}

bool to_number(std::string_view word, double& value) {
  if (word.size() > 1 && word[0] == '+' && word[1] != '-') word.remove_prefix(1);
  const auto [end, code] = std::from_chars(word.data(), word.data() + word.size(), value);
  // What is too small for a double is as good as zero.
  if (code == std::errc::result_out_of_range && end == word.data() + word.size()) {
    const std::size_t e = word.find_first_of("eE");
    value = 0;
    return e != std::string_view::npos && e + 1 < word.size() && word[e + 1] == '-';
  }
  return code == std::errc{} && end == word.data() + word.size();
}

bool to_integer(std::string_view word, long long& value) {
  if (word.size() > 1 && word[0] == '+' && word[1] != '-') word.remove_prefix(1);
  const auto [end, code] = std::from_chars(word.data(), word.data() + word.size(), value);
  return code == std::errc{} && end == word.data() + word.size();
}

}  // namespace detail

namespace {

std::string lower_extension(const std::string& name) {
  return lower_case(std::filesystem::path(name).extension().string());
}

/// The first word of the file that is not in a comment, in lower case.
std::string first_word(std::string_view text) {
  detail::TextScanner scanner(text.substr(0, 4096));
  std::string_view line;
  while (scanner.next_line(line)) {
    const std::string_view word = detail::take_word(line);
    if (word.empty() || word[0] == '#') continue;
    return lower_case(word.substr(0, 16));
  }
  return {};
}

}  // namespace

bool is_surface_file(const std::filesystem::path& path) {
  const std::string extension = lower_extension(path.string());
  const auto known = {".ply", ".stl", ".obj", ".off", ".vtk", ".vtp", ".vtu", ".glb", ".gltf"};
  return std::find(known.begin(), known.end(), extension) != known.end();
}

Result<TriMesh> parse_mesh(std::span<const std::byte> bytes, const std::string& name) {
  const detail::MeshSource source{bytes, name};
  if (bytes.empty()) return source.whole("is empty");
  if (bytes.size() > static_cast<std::size_t>(std::numeric_limits<int>::max()) * 4) {
    return source.whole("is too large for a surface (8 GiB at most)");
  }
  const std::string_view text = source.text();
  if (text.starts_with("# vtk DataFile")) return detail::parse_vtk_legacy(source);
  const std::string word = first_word(text), extension = lower_extension(name);
  if (text.starts_with("glTF") || extension == ".glb" || extension == ".gltf") {
    return detail::parse_gltf(source);
  }
  if (word.starts_with("<vtkfile") || word.starts_with("<?xml") || extension == ".vtp" ||
      extension == ".vtu") {
    return detail::parse_vtk_xml(source);
  }
  if (extension == ".vtk") return source.at_line(1, "does not begin with \"# vtk DataFile\"");
  if (word == "ply") return detail::parse_ply(source);
  if (word.ends_with("off") && word.size() <= 6 && extension != ".stl" && extension != ".obj") {
    return detail::parse_off(source);
  }
  if (extension == ".stl" || word == "solid") return detail::parse_stl(source);
  if (extension == ".off") return detail::parse_off(source);
  if (extension == ".ply") return source.at_byte(0, "does not begin with \"ply\"");
  const auto words = {"v", "vn", "vt", "f", "o", "g", "s", "mtllib", "usemtl"};
  if (extension == ".obj" || std::find(words.begin(), words.end(), word) != words.end()) {
    return detail::parse_obj(source);
  }
  return Error{ErrorKind::bad_input, "is not a surface file known here", name,
               fmt::format("Give {}", surface_file_help)};
}

Result<CellFile> parse_vtu(std::span<const std::byte> bytes, const std::string& name) {
  const detail::MeshSource source{bytes, name};
  const std::string word = first_word(source.text());
  if (word.starts_with("<vtkfile") || word.starts_with("<?xml")) return detail::parse_vtk_cells(source);
  Error error = source.whole("is not a file of VTK's XML");
  error.remedy = "Give a .vtu file";
  return error;
}

Result<CellFile> read_vtu(const std::filesystem::path& path) {
  TURGOR_TRY(const std::vector<std::byte> bytes, read_file(path));
  return parse_vtu(bytes, path.string());
}

Result<TriMesh> read_mesh(const std::filesystem::path& path) {
  TURGOR_TRY(const std::vector<std::byte> bytes, read_file(path));
  return parse_mesh(bytes, path.string());
}

}  // namespace turgor
