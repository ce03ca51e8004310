// Building flesh outward from a surface, and cutting it.
#include "turgor/anatomy/flesh.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstdint>
#include <limits>

#include "turgor/anatomy/layered_tissue.hpp"
#include "turgor/core/index.hpp"

namespace turgor {
namespace {

constexpr std::size_t kMostSamples = 20'000'000;

Error broken(std::string what, std::string remedy) {
  return {ErrorKind::bad_input, std::move(what), "flesh", std::move(remedy)};
}

bool above_zero(double x) {
  return std::isfinite(x) && x > 0;
}
bool at_least_zero(double x) {
  return std::isfinite(x) && x >= 0;
}

Result<void> check_sample(const FleshSample& sample, std::size_t number) {
  if (!is_within_reach(sample.rest)) {
    return broken(fmt::format("the rest position of sample {} is not a finite number of millimetres", number),
                  "Coordinates reach to 1e9 mm");
  }
  if (above_zero(sample.mass_g) && above_zero(sample.growth) && above_zero(sample.spacing) &&
      at_least_zero(sample.stiffness)) {
    return {};
  }
  return broken(fmt::format("sample {} has mass {} g, growth {}, stiffness {} and spacing {}", number,
                            sample.mass_g, sample.growth, sample.stiffness, sample.spacing),
                "Mass, growth and spacing must be above 0, stiffness at least 0");
}

Result<void> check_material(double stiffness_n, SpringLaw law, double modulus_mpa, double guard_mpa) {
  if (at_least_zero(stiffness_n) && at_least_zero(modulus_mpa) && at_least_zero(guard_mpa) &&
      law <= SpringLaw::square) {
    return {};
  }
  return broken(
      fmt::format("the material has stiffness {} N, law {}, volume modulus {} MPa and guard {} MPa",
                  stiffness_n, static_cast<int>(law), modulus_mpa, guard_mpa),
      "The numbers must be finite and at least 0, the law linear, exponential, logarithmic or square");
}

Result<void> check_count(std::size_t layers, std::size_t columns) {
  if (columns <= kMostSamples && layers <= kMostSamples / std::max<std::size_t>(columns, 1)) return {};
  return broken(fmt::format("{} layers of {} points are more than {} samples", layers, columns, kMostSamples),
                "Take a coarser surface or fewer layers");
}

// The points that polygons use.
std::vector<bool> used_points(const Polyhedron& surface) {
  std::vector<bool> used(surface.points.size(), false);
  for (const int p : surface.corners) used[at(p)] = true;
  return used;
}

Result<void> check_source(const Polyhedron& source) {
  if (source.ends.empty()) return broken("the surface has no polygons", "Give a surface of polygons");
  const std::vector<bool> used = used_points(source);
  for (std::size_t i = 0; i < used.size(); ++i) {
    if (!used[i]) return broken(fmt::format("no polygon uses point {}", i), "Remove loose points");
    if (!is_within_reach(source.points[i])) {
      return broken(fmt::format("point {} lies farther than 1e9 mm away", i), "Bring the surface nearer");
    }
  }
  return {};
}

Result<void> check_normals(const std::vector<Vec3>& normals) {
  for (std::size_t i = 0; i < normals.size(); ++i) {
    if (normals[i] == Vec3{}) {
      return broken(fmt::format("point {} has no normal: its polygons are flat or face each other", i),
                    "Repair the surface");
    }
  }
  return {};
}

Result<void> check_thickness(const std::vector<std::vector<double>>& thickness, std::size_t columns) {
  for (std::size_t layer = 0; layer < thickness.size(); ++layer) {
    const std::vector<double>& values = thickness[layer];
    if (values.size() != 1 && values.size() != columns) {
      return broken(fmt::format("the thickness above layer {} has {} values for {} points", layer,
                                values.size(), columns),
                    "Give one value, or one for each point");
    }
    for (const double t : values) {
      if (above_zero(t)) continue;
      return broken(fmt::format("a thickness above layer {} is {} mm", layer, t), "It must be above 0");
    }
  }
  return {};
}

// Takes away the polygons not kept, and the columns that only they used or that no polygon did.
Result<FleshMap> keep_polygons(Flesh& flesh, const std::vector<bool>& keep) {
  Flesh rest = flesh;
  rest.surface = {};
  std::vector<bool> used(flesh.surface.points.size(), false);
  for (int i = 0; i < flesh.surface.polygon_count(); ++i) {
    if (!keep[at(i)]) continue;
    rest.surface.add_polygon(flesh.surface.polygon(i));
    for (const int p : flesh.surface.polygon(i)) used[at(p)] = true;
  }
  if (rest.surface.ends.empty()) return broken("no polygon would be left", "Remove less");
  FleshMap map;
  map.new_of_old.assign(flesh.samples.size(), -1);
  rest.samples.clear();
  for (int layer = 0; layer < flesh.layers; ++layer) {
    for (int column = 0; column < flesh.columns(); ++column) {
      if (!used[at(column)]) continue;
      const int old = flesh.sample(layer, column);
      map.new_of_old[at(old)] = static_cast<int>(map.origin.size());
      map.origin.push_back({old, old});
      rest.samples.push_back(flesh.samples[at(old)]);
      if (layer == 0) rest.surface.points.push_back(flesh.surface.points[at(column)]);
    }
  }
  for (int& p : rest.surface.corners) p = map.new_of_old[at(p)];  // layer 0: samples are columns
  flesh = std::move(rest);
  return map;
}

Error wrong_count(std::size_t given, std::size_t wanted, const char* of) {
  return broken(fmt::format("there are {} values for {} {}", given, wanted, of), "Give one for each");
}

}  // namespace

Result<void> validate(const Flesh& flesh) {
  TURGOR_CHECK(validate(flesh.surface));
  if (flesh.layers < 1) return broken(fmt::format("it has {} layers", flesh.layers), "Give one or more");
  TURGOR_CHECK(check_count(at(flesh.layers), flesh.surface.points.size()));
  if (flesh.samples.size() != at(flesh.layers) * flesh.surface.points.size()) {
    return broken(fmt::format("{} samples are not {} layers of {} columns", flesh.samples.size(),
                              flesh.layers, flesh.columns()),
                  "Give each layer one sample a column");
  }
  if (!flesh.surface.lines.empty()) return broken("its surface has loose lines", "Give polygons alone");
  TURGOR_CHECK(
      check_material(flesh.stiffness_n, flesh.law, flesh.volume_modulus_mpa, flesh.inversion_guard_mpa));
  for (std::size_t i = 0; i < flesh.samples.size(); ++i) TURGOR_CHECK(check_sample(flesh.samples[i], i));
  for (std::size_t i = 0; i < flesh.surface.points.size(); ++i) {
    if (flesh.surface.points[i] == flesh.samples[i].rest) continue;
    return broken(fmt::format("sample {} of layer 0 does not rest at its point of the surface", i),
                  "Move both");
  }
  return {};
}

Result<Flesh> flesh_out(const Polyhedron& source, const FleshOptions& options) {
  TURGOR_CHECK(validate(source));
  TURGOR_CHECK(check_source(source));
  const std::vector<Vec3> normals = vertex_normals(source);
  TURGOR_CHECK(check_normals(normals));
  TURGOR_CHECK(check_count(options.thickness.size() + 1, source.points.size()));
  TURGOR_CHECK(check_thickness(options.thickness, source.points.size()));
  if (!above_zero(options.mass_g)) {
    return broken(fmt::format("the mass of a sample is {} g", options.mass_g), "It must be above 0");
  }
  Flesh flesh;
  flesh.surface = source;
  flesh.surface.lines.clear();
  flesh.layers = static_cast<int>(options.thickness.size()) + 1;
  flesh.stiffness_n = options.stiffness_n;
  flesh.law = options.law;
  flesh.volume_modulus_mpa = options.volume_modulus_mpa;
  flesh.inversion_guard_mpa = options.inversion_guard_mpa;
  flesh.samples.resize(at(flesh.layers) * source.points.size());
  for (int layer = 0; layer < flesh.layers; ++layer) {
    for (int column = 0; column < flesh.columns(); ++column) {
      FleshSample& sample = flesh.samples[at(flesh.sample(layer, column))];
      sample.mass_g = options.mass_g;
      sample.mobile = layer > 0 || !options.fix_bone;
      sample.rest = source.points[at(column)];
      if (layer == 0) continue;
      const std::vector<double>& thickness = options.thickness[at(layer) - 1];
      sample.rest = flesh.samples[at(flesh.sample(layer - 1, column))].rest +
                    normals[at(column)] * thickness[thickness.size() == 1 ? 0 : at(column)];
    }
  }
  TURGOR_CHECK(validate(flesh));
  return flesh;
}

Result<FleshMap> remove_columns(Flesh& flesh, const std::vector<bool>& remove) {
  TURGOR_CHECK(validate(flesh));
  if (remove.size() != flesh.surface.points.size()) {
    return wrong_count(remove.size(), flesh.surface.points.size(), "columns");
  }
  std::vector<bool> keep(flesh.surface.ends.size());
  for (int i = 0; i < flesh.surface.polygon_count(); ++i) {
    const auto polygon = flesh.surface.polygon(i);
    keep[at(i)] = std::none_of(polygon.begin(), polygon.end(), [&](int p) { return remove[at(p)]; });
  }
  return keep_polygons(flesh, keep);
}

Result<FleshMap> remove_polygons(Flesh& flesh, const std::vector<bool>& remove) {
  TURGOR_CHECK(validate(flesh));
  if (remove.size() != flesh.surface.ends.size()) {
    return wrong_count(remove.size(), flesh.surface.ends.size(), "polygons");
  }
  std::vector<bool> keep = remove;
  keep.flip();
  return keep_polygons(flesh, keep);
}

std::vector<double> polygon_strain(const Flesh& flesh, const std::vector<Vec3>& positions) {
  std::vector<double> strain(flesh.surface.ends.size(), 0.0);
  const int top = flesh.layers - 1;
  for (int i = 0; i < flesh.surface.polygon_count(); ++i) {
    const auto polygon = flesh.surface.polygon(i);
    for (std::size_t k = 0; k < polygon.size(); ++k) {
      const std::size_t a = at(flesh.sample(top, polygon[k]));
      const std::size_t b = at(flesh.sample(top, polygon[k + 1 < polygon.size() ? k + 1 : 0]));
      const double rest = distance(flesh.samples[a].rest, flesh.samples[b].rest) *
                          (flesh.samples[a].growth + flesh.samples[b].growth) / 2;
      const double now = distance(positions[a], positions[b]);
      if (now != rest) strain[at(i)] = std::max(strain[at(i)], std::max(now, rest) / std::min(now, rest) - 1);
    }
  }
  return strain;
}

}  // namespace turgor
