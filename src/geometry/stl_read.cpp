// Surfaces from STL, text or binary; equal points are merged.
#include <fmt/format.h>

#include <array>
#include <cstdint>
#include <cstring>
#include <limits>

#include "geometry/mesh_readers.hpp"
#include "geometry/welder.hpp"
#include "turgor/core/lower_case.hpp"

namespace turgor::detail {
namespace {

constexpr std::size_t header_bytes = 84, facet_bytes = 50;

std::uint32_t facets_announced(const MeshSource& source) {
  std::uint32_t count = 0;
  std::memcpy(&count, source.bytes.data() + 80, sizeof count);
  return count;
}

Result<TriMesh> parse_binary(const MeshSource& source) {
  if (source.bytes.size() < header_bytes)
    return source.at_byte(source.bytes.size(), "truncated: no STL header");
  const std::uint32_t count = facets_announced(source);
  const std::size_t there = (source.bytes.size() - header_bytes) / facet_bytes;
  if (count > there) {
    return source.at_byte(source.bytes.size(),
                          fmt::format("truncated: {} of {} triangles are there", there, count));
  }
  if (count > static_cast<std::uint32_t>(std::numeric_limits<int>::max() / 3))
    return source.whole("has too many triangles");
  TriMesh mesh;
  mesh.triangles.reserve(count);
  Welder welder(mesh);
  for (std::uint32_t i = 0; i < count; ++i) {
    const std::size_t start = header_bytes + facet_bytes * i;
    std::array<float, 12> v;  // the normal, which the corners tell better, and three corners
    std::memcpy(v.data(), source.bytes.data() + start, sizeof v);
    std::array<int, 3> corners{};
    for (std::size_t k = 0; k < 3; ++k) {
      const Vec3 p{v[3 * k + 3], v[3 * k + 4], v[3 * k + 5]};
      if (!is_finite(p))
        return source.at_byte(start, fmt::format("a corner of triangle {} is not a finite number", i));
      corners[k] = welder.number(p);
    }
    add_polygon(mesh, corners);
  }
  return finished(source, std::move(mesh));
}

Result<TriMesh> parse_text(const MeshSource& source) {
  TriMesh mesh;
  Welder welder(mesh);
  TextScanner scanner(source.text());
  std::string_view line;
  std::vector<int> loop;
  bool in_solid = false, in_loop = false;
  while (scanner.next_line(line)) {
    std::string_view rest = line;
    const std::string word = lower_case(take_word(rest).substr(0, 16));
    const auto fail = [&](const char* what) {
      return source.at_line(scanner.line(), fmt::format("{}: \"{:.60}\"", what, line));
    };
    if (word == "solid") {
      in_solid = true;
    } else if (word == "endsolid") {
      if (in_loop) return fail("the solid ends within a triangle");
      in_solid = false;
    } else if (word == "outer") {
      if (in_loop) return fail("a loop within a loop");
      in_loop = true;
      loop.clear();
    } else if (word == "vertex") {
      std::array<double, 3> v{};
      for (double& x : v) {
        if (!to_number(take_word(rest), x)) return fail("a corner needs three numbers");
      }
      if (!in_loop) return fail("a corner outside any loop");
      const Vec3 p{v[0], v[1], v[2]};
      if (!is_finite(p)) return fail("a corner is not a finite number");
      loop.push_back(welder.number(p));
    } else if (word == "endloop") {
      if (!in_loop || loop.size() < 3) return fail("a loop of fewer than three corners");
      add_polygon(mesh, loop);
      in_loop = false;
    } else if (!word.empty() && word != "facet" && word != "endfacet" && word != "color" && word[0] != '#') {
      return fail("unknown word in the STL text");
    }
  }
  if (in_solid || in_loop) return source.at_line(scanner.line(), "truncated: \"endsolid\" is missing");
  return finished(source, std::move(mesh));
}

}  // namespace

Result<TriMesh> parse_stl(const MeshSource& source) {
  const std::string_view text = source.text();
  const bool says_solid = text.substr(0, 5) == "solid" || text.substr(0, 5) == "SOLID";
  if (source.bytes.size() >= header_bytes &&
      header_bytes + facet_bytes * std::uint64_t{facets_announced(source)} == source.bytes.size()) {
    return parse_binary(source);
  }
  // Some programs begin binary headers with "solid" too; text has no zero bytes.
  if (says_solid && text.substr(0, 4096).find('\0') == std::string_view::npos) return parse_text(source);
  return parse_binary(source);
}

}  // namespace turgor::detail
