// Shapes that need no file.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <numbers>
#include <variant>

#include "turgor/anatomy/phantom.hpp"
#include "turgor/core/nearest.hpp"
#include "turgor/geometry/mesh_edit.hpp"
#include "turgor/world/object_file.hpp"
#include "world/scene/bad_input.hpp"
#include "world/scene/name.hpp"

namespace turgor {
namespace {

constexpr long long kMostPoints = 4'000'000;

struct GridSize {
  int columns = 0, rows = 0;
  [[nodiscard]] int point(int column, int row) const { return row * columns + column; }
};

/// 1 × 1 about the origin, rows along y.
std::vector<Vec3> grid_points(const GridSize& size) {
  std::vector<Vec3> points;
  points.reserve(static_cast<std::size_t>(size.columns) * static_cast<std::size_t>(size.rows));
  const double last_column = size.columns - 1, last_row = size.rows - 1;
  for (int row = 0; row < size.rows; ++row) {
    for (int column = 0; column < size.columns; ++column) {
      points.push_back({column / last_column - 0.5, row / last_row - 0.5, 0});
    }
  }
  return points;
}

/// Corners of the cell above and to the right of (column, row), anticlockwise.
std::array<int, 4> cell(const GridSize& size, int column, int row) {
  return {size.point(column, row), size.point(column + 1, row), size.point(column + 1, row + 1),
          size.point(column, row + 1)};
}

Polyhedron grid(const GridSize& size) {
  Polyhedron out;
  out.points = grid_points(size);
  for (int row = 0; row + 1 < size.rows; ++row) {
    for (int column = 0; column + 1 < size.columns; ++column) out.add_polygon(cell(size, column, row));
  }
  return out;
}

Polyhedron wire_grid(const GridSize& size) {
  Polyhedron out;
  out.points = grid_points(size);
  for (int row = 0; row < size.rows; ++row) {
    for (int column = 0; column < size.columns; ++column) {
      const int p = size.point(column, row);
      if (column + 1 < size.columns) out.lines.push_back({p, p + 1});
      if (row + 1 < size.rows) out.lines.push_back({p, p + size.columns});
    }
  }
  return out;
}

/// Parallels and meridians about the z axis; triangles at the poles.
Polyhedron ball() {
  constexpr int rings = 18, around = 36;
  Polyhedron out;
  out.points.push_back({0, 0, -0.5});
  for (int ring = 1; ring < rings; ++ring) {
    const double latitude = std::numbers::pi * (static_cast<double>(ring) / rings - 0.5);
    for (int i = 0; i < around; ++i) {
      const double longitude = 2 * std::numbers::pi * i / around;
      out.points.push_back(Vec3{std::cos(latitude) * std::cos(longitude),
                                std::cos(latitude) * std::sin(longitude), std::sin(latitude)} *
                           0.5);
    }
  }
  const int top = static_cast<int>(out.points.size());
  out.points.push_back({0, 0, 0.5});
  const auto at = [](int ring, int i) { return 1 + (ring - 1) * around + i % around; };
  for (int i = 0; i < around; ++i) out.add_polygon(std::array{0, at(1, i + 1), at(1, i)});
  for (int ring = 1; ring + 1 < rings; ++ring) {
    for (int i = 0; i < around; ++i) {
      out.add_polygon(std::array{at(ring, i), at(ring, i + 1), at(ring + 1, i + 1), at(ring + 1, i)});
    }
  }
  for (int i = 0; i < around; ++i) out.add_polygon(std::array{at(rings - 1, i), at(rings - 1, i + 1), top});
  return out;
}

/// The sheet with a fusiform excision of the wound closure test (Pieper 1989, section 6.1.1): the numbers of
/// its sutures are those of 13 × 14 points less the eight of a spindle, numbered row by row.
Polyhedron fusiform() {
  constexpr GridSize size{13, 14};
  const auto cut_out = [](int column, int row) {
    const int half_width = row == 6 || row == 7 ? 1 : row == 5 || row == 8 ? 0 : -1;
    return std::abs(column - 6) <= half_width;
  };
  Polyhedron out;
  const std::vector<Vec3> points = grid_points(size);
  std::vector<int> number(points.size(), -1);
  for (int row = 0; row < size.rows; ++row) {
    for (int column = 0; column < size.columns; ++column) {
      if (cut_out(column, row)) continue;
      const auto p = static_cast<std::size_t>(size.point(column, row));
      number[p] = static_cast<int>(out.points.size());
      out.points.push_back(points[p]);
    }
  }
  // A cell that lacks one corner is a triangle: the tips of the spindle are points.
  std::vector<int> polygon;
  for (int row = 0; row + 1 < size.rows; ++row) {
    for (int column = 0; column + 1 < size.columns; ++column) {
      polygon.clear();
      for (const int corner : cell(size, column, row)) {
        if (const int p = number[static_cast<std::size_t>(corner)]; p >= 0) polygon.push_back(p);
      }
      if (polygon.size() >= 3) out.add_polygon(polygon);
    }
  }
  return out;
}

Polyhedron cube() {
  return box_polyhedron({{-0.5, -0.5, -0.5}, {0.5, 0.5, 0.5}});
}

Polyhedron line() {
  Polyhedron out;
  out.points = {{-0.5, 0, 0}, {0.5, 0, 0}};
  out.lines = {{0, 1}};
  return out;
}

/// A toothed wheel about the z axis: 16 teeth, diameter 1, a fifth thick, with a bore of a third. Fine enough
/// to show how it twists.
Polyhedron gear() {
  constexpr int teeth = 16, steps = 8, around = teeth * steps;  // of a tooth: root, flank, tip, flank
  constexpr double root = 0.40, tip = 0.50, bore = 0.165, half = 0.1;
  constexpr std::array<double, steps> rise = {0, 0, 0, 0.5, 1, 1, 1, 0.5};
  constexpr int walls = 16, faces = 8;  // quadrilaterals up a wall, and across a face
  Polyhedron out;
  // `outwards` 1 on the teeth, 0 in the bore; a ring of points about the axis.
  const auto ring = [&](double outwards, double z) {
    for (int i = 0; i < around; ++i) {
      const double outer = root + (tip - root) * rise[static_cast<std::size_t>(i % steps)];
      const double angle = 2 * std::numbers::pi * i / around, r = bore + (outer - bore) * outwards;
      out.points.push_back({r * std::cos(angle), r * std::sin(angle), z});
    }
  };
  for (int i = 0; i < walls; ++i) ring(1, half * (2.0 * i / walls - 1));
  for (int i = 0; i < faces; ++i) ring(1 - static_cast<double>(i) / faces, half);
  for (int i = 0; i < walls; ++i) ring(0, half * (1 - 2.0 * i / walls));
  for (int i = 0; i < faces; ++i) ring(static_cast<double>(i) / faces, -half);
  constexpr int rings = 2 * (walls + faces);
  for (int r = 0; r < rings; ++r) {
    const int a = r * around, b = (r + 1) % rings * around;
    for (int i = 0; i < around; ++i) {
      const int j = (i + 1) % around;
      out.add_polygon(std::array{a + i, a + j, b + j, b + i});
    }
  }
  return out;
}

/// Of the built-in phantom of a head, mm (LPS). Reduced, for the slivers of the iso-surface catch the light.
Result<Polyhedron> phantom_surface(PhantomSurface which) {
  constexpr double spacing_mm = 2;
  constexpr int triangles = 40'000;
  TURGOR_TRY(const Phantom phantom, Phantom::create({}));
  Context context;
  TURGOR_TRY(const TriMesh surface, phantom.surface(which, spacing_mm, context));
  return to_polyhedron(decimate(surface, triangles));
}
Result<Polyhedron> phantom_skin() {
  return phantom_surface(PhantomSurface::skin);
}
Result<Polyhedron> phantom_bone() {
  return phantom_surface(PhantomSurface::bone);
}

/// N.M of grid.N.M.
Result<GridSize> grid_size(const std::string& name, std::string_view text) {
  std::array<long long, 2> count{};
  const char* at = text.data();
  const char* const end = at + text.size();
  for (std::size_t i = 0; i < 2; ++i) {
    const auto [stop, code] = std::from_chars(at, end, count[i]);
    const bool closed = i == 0 ? stop != end && *stop == '.' : stop == end;
    if (code == std::errc::result_out_of_range) count[i] = kMostPoints + 1;
    if ((code != std::errc{} && code != std::errc::result_out_of_range) || !closed || count[i] < 2) {
      return bad_input(fmt::format("no grid of the name {}", shown_name(name)),
                       "Give the points along x and along y, two or more, as in grid.10.10");
    }
    at = closed && i == 0 ? stop + 1 : stop;
  }
  if (count[0] > kMostPoints || count[1] > kMostPoints || count[0] * count[1] > kMostPoints) {
    return bad_input(fmt::format("{} would have more than 4 million points", shown_name(name)),
                     "Ask for a coarser grid");
  }
  return GridSize{static_cast<int>(count[0]), static_cast<int>(count[1])};
}

/// Of a plain shape; of one that may fail; of one whose size follows its name.
using Plain = Polyhedron (*)();
using Made = Result<Polyhedron> (*)();
using Sized = Polyhedron (*)(const GridSize&);
struct Primitive {
  std::string_view name;
  std::string_view typed;
  std::variant<Plain, Made, Sized> make;
};

constexpr std::array<Primitive, 9> kPrimitives{{
    {"grid", "grid.N.M", grid},
    {"wiregrid", "wiregrid.N.M", wire_grid},
    {"sphere", "sphere", ball},
    {"cube", "cube", cube},
    {"line", "line", line},
    {"fusiform", "fusiform", fusiform},
    {"gear", "gear", gear},
    {"phantom_skin", "phantom_skin", phantom_skin},
    {"phantom_bone", "phantom_bone", phantom_bone},
}};

/// nullptr where there is none of the name.
const Primitive* find_primitive(std::string_view name) {
  const auto found = std::find_if(kPrimitives.begin(), kPrimitives.end(), [name](const Primitive& p) {
    if (!std::holds_alternative<Sized>(p.make)) return name == p.name;
    return name.starts_with(p.name) && name.substr(p.name.size()).starts_with('.');
  });
  return found == kPrimitives.end() ? nullptr : &*found;
}

Result<Polyhedron> shape(const std::string& name) {
  const Primitive* const primitive = find_primitive(name);
  if (primitive == nullptr) {
    std::string remedy = fmt::format("There are {}", fmt::join(primitive_names(), ", "));
    if (const auto nearest = nearest_primitive(name); !nearest.empty()) {
      remedy = fmt::format("Did you mean {}?", nearest);
    }
    return bad_input(fmt::format("no primitive of the name {}", shown_name(name)), remedy);
  }
  if (const Plain* const plain = std::get_if<Plain>(&primitive->make)) return (*plain)();
  if (const Made* const made = std::get_if<Made>(&primitive->make)) return (*made)();
  TURGOR_TRY(const GridSize size, grid_size(name, std::string_view(name).substr(primitive->name.size() + 1)));
  return std::get<Sized>(primitive->make)(size);
}

}  // namespace

bool is_primitive_name(std::string_view name) {
  return find_primitive(name) != nullptr;
}

std::string_view nearest_primitive(std::string_view name) {
  std::array<std::string_view, kPrimitives.size()> words;
  for (std::size_t i = 0; i < words.size(); ++i) words[i] = kPrimitives[i].name;
  const std::string_view nearest = nearest_word(name.substr(0, name.find('.')), words);
  for (const Primitive& primitive : kPrimitives) {
    if (primitive.name == nearest) return primitive.typed;
  }
  return {};
}

std::vector<std::string> primitive_names() {
  std::vector<std::string> names;
  names.reserve(kPrimitives.size());
  for (const Primitive& primitive : kPrimitives) names.emplace_back(primitive.typed);
  return names;
}

Result<Object> make_primitive(const std::string& name) {
  TURGOR_TRY(Polyhedron polyhedron, shape(name));
  Object object;
  object.name = name;
  object.description = std::move(polyhedron);
  return object;
}

}  // namespace turgor
