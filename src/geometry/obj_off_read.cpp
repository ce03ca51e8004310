// Surfaces from the text formats Wavefront OBJ and OFF.
#include <fmt/format.h>

#include <cstdint>
#include <limits>

#include "geometry/mesh_readers.hpp"

namespace turgor::detail {
namespace {

/// The first three numbers of a line as a point.
bool take_point(std::string_view& rest, Vec3& p) {
  for (int i = 0; i < 3; ++i) {
    if (!to_number(take_word(rest), p[i])) return false;
  }
  return true;
}

constexpr std::size_t most_points = static_cast<std::size_t>(std::numeric_limits<int>::max());

/// Point number, from 0, of a corner "v", "v/vt", "v//vn" or "v/vt/vn"; negative numbers count back from the
/// last.
bool take_corner(std::string_view word, std::size_t points, long long& corner) {
  if (!to_integer(word.substr(0, word.find('/')), corner) || corner == 0) return false;
  corner = corner < 0 ? static_cast<long long>(points) + corner : corner - 1;
  return corner >= 0 && static_cast<std::size_t>(corner) < most_points;
}

/// A line of OFF that holds something, without its comment.
bool next_content(TextScanner& scanner, std::string_view& line) {
  while (scanner.next_line(line)) {
    line = line.substr(0, line.find('#'));
    if (line.find_first_not_of(" \t\r") != std::string_view::npos) return true;
  }
  return false;
}

}  // namespace

Result<TriMesh> parse_obj(const MeshSource& source) {
  TriMesh mesh;
  TextScanner scanner(source.text());
  std::string_view line;
  std::string joined;
  std::vector<int> polygon;
  long long highest = -1;
  std::size_t highest_line = 0;
  while (scanner.next_line(line)) {
    // A line that ends in a backslash goes on in the next.
    if (!line.empty() && line.back() == '\\') {
      joined.assign(line.substr(0, line.size() - 1));
      while (scanner.next_line(line)) {
        const bool more = !line.empty() && line.back() == '\\';
        joined.append(" ").append(line.substr(0, line.size() - (more ? 1 : 0)));
        if (!more) break;
      }
      line = joined;
    }
    std::string_view rest = line;
    const std::string_view word = take_word(rest);
    const auto fail = [&](const char* what) {
      return source.at_line(scanner.line(), fmt::format("{}: \"{:.60}\"", what, line));
    };
    if (word == "v") {
      Vec3 p;
      if (!take_point(rest, p)) return fail("a point needs three numbers");
      if (!is_finite(p)) return fail("a point is not a finite number");
      if (mesh.points.size() == most_points) return fail("more points than can be numbered");
      mesh.points.push_back(p);
    } else if (word == "f" || word == "fo") {
      polygon.clear();
      for (std::string_view corner = take_word(rest); !corner.empty() && corner[0] != '#';
           corner = take_word(rest)) {
        long long index = 0;
        if (!take_corner(corner, mesh.points.size(), index))
          return fail("a face names a point that is not there");
        if (index > highest) highest = index, highest_line = scanner.line();
        polygon.push_back(static_cast<int>(index));
      }
      if (polygon.size() < 3) return fail("a face of fewer than three corners");
      add_polygon(mesh, polygon);
    }
  }
  // Faces may come before their points, so the range is known only now.
  if (highest >= static_cast<long long>(mesh.points.size())) {
    return source.at_line(highest_line,
                          fmt::format("a face names point {} of {}", highest + 1, mesh.points.size()));
  }
  return finished(source, std::move(mesh));
}

Result<TriMesh> parse_off(const MeshSource& source) {
  TextScanner scanner(source.text());
  std::string_view line;
  const auto fail = [&](std::string what) { return source.at_line(scanner.line(), std::move(what)); };
  if (!next_content(scanner, line)) return fail("is empty");
  // COFF, NOFF and the like put colours and normals behind each point's place, which is where they are left.
  const std::string_view kind = take_word(line);
  if (!kind.ends_with("OFF") && !kind.ends_with("off")) return fail("does not begin with \"OFF\"");
  if (kind.find_first_of("4n") != std::string_view::npos) return fail("is of other than three dimensions");
  // The numbers may follow on the same line.
  const bool on_next_line = line.find_first_not_of(" \t\r") == std::string_view::npos;
  if (on_next_line && !next_content(scanner, line)) return fail("truncated: no numbers of points and faces");
  long long points = -1, faces = -1;
  if (!to_integer(take_word(line), points) || !to_integer(take_word(line), faces) || points < 0 ||
      faces < 0) {
    return fail("the numbers of points and faces are missing (binary OFF is not known here)");
  }
  // A point takes six bytes at least ("0 0 0" and the end of its line), a face eight.
  if (static_cast<std::uint64_t>(points) > scanner.left() / 6 + 1 ||
      static_cast<std::uint64_t>(faces) > scanner.left() / 4 + 1 ||
      static_cast<std::size_t>(points) > most_points) {
    return fail(fmt::format("truncated: {} points and {} faces are announced", points, faces));
  }
  TriMesh mesh;
  mesh.points.resize(static_cast<std::size_t>(points));
  for (Vec3& p : mesh.points) {
    if (!next_content(scanner, line)) return fail("truncated among the points");
    if (!take_point(line, p)) return fail("a point needs three numbers");
    if (!is_finite(p)) return fail("a point is not a finite number");
  }
  std::vector<int> polygon;
  for (long long i = 0; i < faces; ++i) {
    if (!next_content(scanner, line))
      return fail(fmt::format("truncated: {} of {} faces are there", i, faces));
    long long corners = 0;
    if (!to_integer(take_word(line), corners) || corners < 1)
      return fail("a face begins with the number of its corners");
    polygon.clear();
    for (long long k = 0; k < corners; ++k) {
      long long index = 0;
      const std::string_view word = take_word(line);
      if (word.empty() || !to_integer(word, index))
        return fail(fmt::format("a face of {} corners names {}", corners, k));
      if (index < 0 || index >= points)
        return fail(fmt::format("a face names point {} of {}", index, points));
      polygon.push_back(static_cast<int>(index));
    }
    add_polygon(mesh, polygon);
  }
  return finished(source, std::move(mesh));
}

}  // namespace turgor::detail
