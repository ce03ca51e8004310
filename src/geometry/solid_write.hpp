// The formats of solids. Internal.
#pragma once

#include <fmt/format.h>

#include <cstddef>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "turgor/core/error.hpp"
#include "turgor/geometry/solid_file.hpp"

namespace turgor::detail {

/// A solid as files see it: cells of `corners` points each.
struct SolidView {
  const SolidMesh& solid;
  int corners = 4;
  std::span<const int> connectivity;

  [[nodiscard]] std::size_t cell_count() const {
    return connectivity.size() / static_cast<std::size_t>(corners);
  }
  [[nodiscard]] std::span<const int> cell(std::size_t c) const {
    return connectivity.subspan(c * static_cast<std::size_t>(corners), static_cast<std::size_t>(corners));
  }
  /// The cell behind a triangle of the surface.
  [[nodiscard]] int behind(std::size_t triangle) const {
    const int tetrahedron = solid.surface_cells[triangle];
    return corners == 4 ? tetrahedron : tetrahedron / 5;
  }
  /// The faces on the surface: triangles, or the quadrilaterals that pairs of them make up.
  [[nodiscard]] std::vector<std::vector<int>> faces() const;
};

/// Lines of numbers.
class TextWriter {
 public:
  void line(std::string_view words) { text_.append(words).push_back('\n'); }
  void number(std::size_t value) { word(fmt::format_int(value)); }
  void number(int value) { word(fmt::format_int(value)); }
  /// Shortest digits that read back as the same number.
  void number(double value) { fmt::format_to(std::back_inserter(text_), "{}{}", separator(), value); }
  void end() { text_.push_back('\n'); }
  /// What stands between the numbers of a line, one character.
  void separate_by(char c) { between_ = c; }
  [[nodiscard]] const std::string& text() const { return text_; }

 private:
  [[nodiscard]] std::string_view separator() const {
    const bool first = text_.empty() || text_.back() == '\n';
    return first ? std::string_view{} : std::string_view(&between_, 1);
  }
  void word(const fmt::format_int& digits) { text_.append(separator()).append(digits.data(), digits.size()); }

  std::string text_;
  char between_ = ' ';
};

Result<void> write_tetgen(const std::filesystem::path& path, const SolidView& view);
Result<void> write_gmsh(const std::filesystem::path& path, const SolidView& view);
Result<void> write_abaqus(const std::filesystem::path& path, const SolidView& view);
Result<void> write_solid_vtu(const std::filesystem::path& path, const SolidView& view);
Result<void> write_plain_solid(const std::filesystem::path& path, const SolidView& view);

}  // namespace turgor::detail
