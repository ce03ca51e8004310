#include "turgor/world/solid_constants.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "turgor/core/index.hpp"
#include "turgor/geometry/mesh_file.hpp"

namespace turgor {
namespace {

constexpr std::array<std::uint8_t, 3> kCellTypes = {3, 5, 10};  // VTK's line, triangle, tetrahedron
constexpr std::array<const char*, 3> kNames = {"edges", "triangles", "tetrahedra"};

std::array<std::size_t, 3> counts(const Solid& solid) {
  return {solid.edges.size(), solid.triangles.size(), solid.tetrahedra.size()};
}

/// Calls body(kind, element's points) for each element in the order of SolidConstants.
template <class Body>
void visit(const Solid& solid, Body&& body) {
  for (const auto& e : solid.edges) body(std::size_t{0}, std::span<const int>(e));
  for (const auto& t : solid.triangles) body(std::size_t{1}, std::span<const int>(t));
  for (const auto& t : solid.tetrahedra) body(std::size_t{2}, std::span<const int>(t));
}

Result<Solid> of_one_mpa(const Solid& solid, std::span<const Vec3> rest, std::span<const double> factor) {
  std::vector<SolidStiffness> unit;
  for (const double f : factor) unit.push_back({f, f, f});
  Solid out = solid;
  TURGOR_CHECK(set_stiffness(out, rest, unit));
  return out;
}

Error wrong_file(const std::filesystem::path& path, std::string what, std::string remedy) {
  return {ErrorKind::bad_input, std::move(what), path.string(), std::move(remedy)};
}

/// Whether the file's cells are the solid's elements.
Result<void> check_cells(const CellMesh& cells, const Solid& solid, const std::filesystem::path& path) {
  std::array<std::size_t, 3> found{};
  for (const std::uint8_t type : cells.types) {
    const auto kind = std::ranges::find(kCellTypes, type) - kCellTypes.begin();
    if (kind == 3) {
      return wrong_file(path, fmt::format("holds a cell of type {}, which no element of a solid is", type),
                        "Give the constants.vtu that turgor calibrate writes");
    }
    ++found[static_cast<std::size_t>(kind)];
  }
  constexpr const char* same =
      "Make the solid as the calibration's problem makes its body: same surface, resolution and border";
  const auto own = counts(solid);
  for (std::size_t c = 0; c < 3; ++c) {
    if (found[c] != own[c])
      return wrong_file(path, fmt::format("is of {} {}, the solid has {}", found[c], kNames[c], own[c]),
                        same);
  }
  std::size_t cell = 0, different = 0;
  int from = 0;
  visit(solid, [&](std::size_t kind, std::span<const int> points) {
    const int to = cells.offsets[cell];
    const std::span<const int> theirs(cells.connectivity.data() + from, at(to - from));
    if (cells.types[cell] != kCellTypes[kind] || !std::ranges::equal(points, theirs)) ++different;
    from = to, ++cell;
  });
  if (different > 0) {
    return wrong_file(path,
                      fmt::format("{} of its {} elements join other points than the solid's", different,
                                  cells.types.size()),
                      same);
  }
  return {};
}

}  // namespace

Result<void> set_constants(Solid& solid, std::span<const Vec3> rest, const SolidConstants& constants,
                           std::span<const double> factor) {
  const auto own = counts(solid);
  for (std::size_t c = 0; c < 3; ++c) {
    if (constants[c].size() != own[c]) {
      return Error{ErrorKind::bad_input,
                   fmt::format("there are {} constants for {} {}", constants[c].size(), own[c], kNames[c]),
                   "solid", "Give one for each"};
    }
  }
  TURGOR_TRY(Solid next, of_one_mpa(solid, rest, factor));
  const std::array to{&next.edge_nmm, &next.triangle_nmm, &next.tetrahedron_nmm};
  for (std::size_t c = 0; c < 3; ++c) {
    for (std::size_t e = 0; e < own[c]; ++e) {
      double& constant = (*to[c])[e];
      constant *= constants[c][e];
      if (!(std::isfinite(constant) && constant >= 0)) {
        return Error{ErrorKind::bad_input,
                     fmt::format("the constant {} of an element is {}", kSolidConstants[c], constant),
                     "solid", "Give stiffness of at least 0 that is not too large"};
      }
    }
  }
  solid = std::move(next);
  return {};
}

std::vector<SolidStiffness> means_of_tetrahedra(const Solid& solid, const SolidConstants& constants) {
  const auto value = [](const auto& elements, const auto& element, const std::vector<double>& of) {
    return of[static_cast<std::size_t>(std::ranges::lower_bound(elements, element) - elements.begin())];
  };
  std::vector<SolidStiffness> out(solid.tetrahedra.size());
  for (std::size_t t = 0; t < out.size(); ++t) {
    std::array<int, 4> p = solid.tetrahedra[t];
    std::ranges::sort(p);
    for (std::size_t a = 0; a < 4; ++a) {
      for (std::size_t b = a + 1; b < 4; ++b)
        out[t].length += value(solid.edges, std::array{p[a], p[b]}, constants[0]) / 6;
      Index3 triangle{};
      for (std::size_t c = 0, k = 0; c < 4; ++c)
        if (c != a) triangle[k++] = p[c];
      out[t].area += value(solid.triangles, triangle, constants[1]) / 4;
    }
    out[t].volume = constants[2][t];
  }
  return out;
}

Result<SolidConstants> constants_of(const Solid& solid, std::span<const Vec3> rest,
                                    std::span<const SolidStiffness> stiffness) {
  constexpr double one = 1;
  TURGOR_TRY(const Solid unit, of_one_mpa(solid, rest, {&one, 1}));
  Solid stiff = solid;
  TURGOR_CHECK(set_stiffness(stiff, rest, stiffness));
  SolidConstants out{std::move(stiff.edge_nmm), std::move(stiff.triangle_nmm),
                     std::move(stiff.tetrahedron_nmm)};
  const std::array units{&unit.edge_nmm, &unit.triangle_nmm, &unit.tetrahedron_nmm};
  for (std::size_t c = 0; c < 3; ++c)
    for (std::size_t e = 0; e < out[c].size(); ++e) out[c][e] /= (*units[c])[e];
  return out;
}

Result<void> write_solid_constants(const std::filesystem::path& path, std::span<const Vec3> rest,
                                   const Solid& solid, const SolidConstants& constants) {
  CellMesh mesh;
  mesh.points.assign(rest.begin(), rest.end());
  MeshField stiffness{"stiffness_mpa", 1, {}}, constant{"constant_nmm", 1, {}}, corners{"corners", 1, {}};
  const std::array units{&solid.edge_nmm, &solid.triangle_nmm, &solid.tetrahedron_nmm};
  std::array<std::size_t, 3> next{};
  visit(solid, [&](std::size_t kind, std::span<const int> points) {
    mesh.connectivity.insert(mesh.connectivity.end(), points.begin(), points.end());
    mesh.offsets.push_back(static_cast<int>(mesh.connectivity.size()));
    mesh.types.push_back(kCellTypes[kind]);
    const std::size_t e = next[kind]++;
    stiffness.values.push_back(static_cast<float>(constants[kind][e]));
    constant.values.push_back(static_cast<float>(constants[kind][e] * (*units[kind])[e]));
    corners.values.push_back(static_cast<float>(points.size()));
  });
  return write_vtu(path, mesh, {}, {std::move(constant), std::move(stiffness), std::move(corners)});
}

Result<SolidConstants> read_solid_constants(const std::filesystem::path& path, const Solid& solid) {
  TURGOR_TRY(const CellFile file, read_vtu(path));
  const auto field = std::ranges::find(file.cell_fields, "stiffness_mpa", &CellField::name);
  if (field == file.cell_fields.end() || field->components != 1) {
    return wrong_file(path, "holds no constants of a solid: the field stiffness_mpa of its cells is missing",
                      "Give the constants.vtu that turgor calibrate writes");
  }
  TURGOR_CHECK(check_cells(file.mesh, solid, path));
  for (std::size_t e = 0; e < field->values.size(); ++e) {
    if (!(std::isfinite(field->values[e]) && field->values[e] >= 0)) {
      return wrong_file(path, fmt::format("the stiffness of element {} is {} MPa", e, field->values[e]),
                        "Calibrate again: it must be a finite number of at least 0");
    }
  }
  SolidConstants out;
  auto from = field->values.begin();
  for (std::size_t c = 0; c < 3; ++c) {
    const auto to = from + static_cast<std::ptrdiff_t>(counts(solid)[c]);
    out[c].assign(from, to), from = to;
  }
  return out;
}

}  // namespace turgor
