#include "turgor/world/parameter_groups.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "turgor/core/index.hpp"
#include "turgor/dynamics/equilibrium_sensitivity.hpp"

namespace turgor {
namespace {

Error bad(std::string what, std::string remedy) {
  return {ErrorKind::bad_input, std::move(what), "parameters of a network", std::move(remedy)};
}

template <class Corners>
Vec3 mean_of(const Corners& corners, const std::vector<Vec3>& rest) {
  Vec3 sum;
  for (const int p : corners) sum += rest[at(p)];
  return sum / static_cast<double>(std::size(corners));
}

Result<void> check(std::span<const int> group_of_constant, const std::vector<ParameterGroup>& groups,
                   std::size_t constants, double bound_factor) {
  if (group_of_constant.size() != constants)
    return bad(fmt::format("{} groups are given for {} constants", group_of_constant.size(), constants),
               "Give one for each spring, volume, area and element of a solid");
  for (const int g : group_of_constant) {
    if (g < -1 || g >= static_cast<int>(groups.size()))
      return bad(fmt::format("a constant is of group {} of {}", g, groups.size()),
                 "Groups are numbered from 0; -1 is none");
  }
  for (const ParameterGroup& g : groups) {
    if (!(std::isfinite(g.guess) && g.guess > 0))
      return bad(fmt::format("the guess of {} is {}", g.name, g.guess), "It must be above 0");
  }
  if (!(std::isfinite(bound_factor) && bound_factor > 1))
    return bad(fmt::format("the bounds lie a factor {} from the guess", bound_factor), "It must be above 1");
  return {};
}

FitParameter parameter_of(const ParameterGroup& group, const Index3& place, const Index3& nodes,
                          double bound_factor) {
  FitParameter out;
  out.name = nodes == Index3{1, 1, 1}
                 ? group.name
                 : fmt::format("{} at node ({}, {}, {})", group.name, place[0], place[1], place[2]);
  out.unit = group.unit;
  out.low = group.guess / bound_factor;
  out.high = group.guess * bound_factor;
  out.guess = group.guess;
  return out;
}

}  // namespace

std::vector<Vec3> places_of_constants(const SpringNetwork& network) {
  const std::vector<Vec3>& x = network.rest;
  std::vector<Vec3> out;
  for (const Spring& s : network.springs) out.push_back((x[at(s.a)] + x[at(s.b)]) * 0.5);
  for (const VolumeElement& v : network.volumes) out.push_back(mean_of(v.p, x));
  for (const AreaElement& a : network.areas) out.push_back(mean_of(a.p, x));
  for (const Solid& solid : network.solids) {
    for (const auto& p : solid.edges) out.push_back(mean_of(p, x));
    for (const auto& p : solid.triangles) out.push_back(mean_of(p, x));
    for (const auto& p : solid.tetrahedra) out.push_back(mean_of(p, x));
  }
  return out;
}

Result<GroupedParameters> make_grouped_parameters(const SpringNetwork& network,
                                                  std::span<const int> group_of_constant,
                                                  const std::vector<ParameterGroup>& groups,
                                                  const Index3& nodes, double bound_factor) {
  TURGOR_CHECK(validate(network));
  TURGOR_CHECK(check(group_of_constant, groups, NetworkConstants(network).count(), bound_factor));
  std::vector<Vec3> places;
  const std::vector<Vec3> all = places_of_constants(network);
  for (std::size_t c = 0; c < all.size(); ++c)
    if (group_of_constant[c] >= 0) places.push_back(all[c]);
  TURGOR_TRY(const ParameterGrid grid, make_parameter_grid(nodes, places));

  const std::size_t kept = grid.places.size();
  std::vector<int> column(groups.size() * kept, -1);  // by group and node
  const auto visit = [&](auto&& body) {               // row of the grid, constant
    for (std::size_t c = 0, row = 0; c < all.size(); ++c)
      if (group_of_constant[c] >= 0) body(c, row++);
  };
  const auto entries = [&](std::size_t c, std::size_t row, auto&& body) {
    for (int i = grid.weights.offsets[row]; i < grid.weights.offsets[row + 1]; ++i)
      body(column[at(group_of_constant[c]) * kept + at(grid.weights.columns[at(i)])],
           grid.weights.weights[at(i)]);
  };
  visit([&](std::size_t c, std::size_t row) {
    entries(c, row, [](int& used, double /*weight*/) { used = 0; });
  });
  GroupedParameters out;
  for (std::size_t i = 0; i < column.size(); ++i) {
    if (column[i] < 0) continue;
    column[i] = static_cast<int>(out.parameters.size());
    out.parameters.push_back(parameter_of(groups[i / kept], grid.places[i % kept], nodes, bound_factor));
    out.group.push_back(static_cast<int>(i / kept));
    out.position_mm.push_back(grid.positions[i % kept]);
  }
  out.weights.offsets.assign(all.size() + 1, 0);
  out.weights.column_count = static_cast<int>(out.parameters.size());
  visit([&](std::size_t c, std::size_t row) {
    entries(c, row, [&](int& used, double weight) {
      out.weights.columns.push_back(used);
      out.weights.weights.push_back(weight);
    });
    out.weights.offsets[c + 1] = static_cast<int>(out.weights.columns.size());
  });
  for (std::size_t c = 0; c < all.size(); ++c)
    out.weights.offsets[c + 1] = std::max(out.weights.offsets[c], out.weights.offsets[c + 1]);
  return out;
}

}  // namespace turgor
