#include "turgor/world/solid_fit.hpp"

#include <algorithm>
#include <cmath>

#include "turgor/core/index.hpp"
#include "turgor/dynamics/equilibrium_sensitivity.hpp"

namespace turgor {
namespace {

Result<void> check(const SolidMaterial& m) {
  const bool valid = std::isfinite(m.youngs_modulus_mpa) && m.youngs_modulus_mpa > 0 &&
                     m.poissons_ratio >= 0 && m.poissons_ratio < 0.5 && std::isfinite(m.density_g_mm3) &&
                     m.density_g_mm3 > 0 && m.area_share >= 0 && m.area_share <= 1;
  if (valid) return {};
  return Error{ErrorKind::bad_input, "the material cannot be used", "fit of a solid",
               "Give moduli and a density above 0, Poisson's ratio from 0 to below 0.5"};
}

// With a stiffness of 1 MPa everywhere, so that the parameters are MPa.
Result<SpringNetwork> network_of(const SolidMesh& mesh, double density_g_mm3) {
  SpringNetwork network;
  network.rest.assign(mesh.points.begin(), mesh.points.end());
  network.mass_g.assign(network.rest.size(), 0);
  TURGOR_TRY(Solid solid, make_solid({mesh.tetrahedra.begin(), mesh.tetrahedra.end()},
                                     static_cast<int>(network.rest.size()), mesh.spacing));
  const SolidStiffness unit{1, 1, 1};
  TURGOR_CHECK(set_stiffness(solid, network.rest, {&unit, 1}));
  add_mass(solid, network.rest, density_g_mm3, network.mass_g);
  network.solids.push_back(std::move(solid));
  return network;
}

/// k_d, k_a and k_v.
std::vector<ParameterGroup> kinds(const SolidMaterial& guess) {
  const SolidStiffness k = stiffness_of(guess);
  const double least = 1e-3 * std::max({k.length, k.area, k.volume});
  return {{"k_d", "MPa", std::max(k.length, least)},
          {"k_a", "MPa", std::max(k.area, least)},
          {"k_v", "MPa", std::max(k.volume, least)}};
}

/// A column for each kind after the others, with the weight 1 in the rows of that kind: in logarithms a
/// factor of what the nodes say.
void add_kinds(std::span<const int> kind, GroupedParameters&& of_kinds, GroupedParameters& out) {
  ParameterWeights weights;
  const int nodes = out.weights.column_count;
  for (std::size_t row = 0; row < kind.size(); ++row) {
    for (int i = out.weights.offsets[row]; i < out.weights.offsets[row + 1]; ++i) {
      weights.columns.push_back(out.weights.columns[at(i)]);
      weights.weights.push_back(out.weights.weights[at(i)]);
    }
    weights.columns.push_back(nodes + kind[row]);
    weights.weights.push_back(1);
    weights.offsets.push_back(static_cast<int>(weights.columns.size()));
  }
  weights.column_count = nodes + of_kinds.weights.column_count;
  out.weights = std::move(weights);
  for (std::size_t k = 0; k < of_kinds.parameters.size(); ++k) {
    out.parameters.push_back(std::move(of_kinds.parameters[k]));
    out.group.push_back(of_kinds.group[k] + 1);
    out.position_mm.push_back(of_kinds.position_mm[k]);
  }
}

Result<GroupedParameters> parameters_of(const SpringNetwork& network, const SolidFitOptions& options) {
  const Solid& solid = network.solids[0];
  std::vector<int> kind(solid.edges.size(), 0);
  kind.resize(kind.size() + solid.triangles.size(), 1);
  kind.resize(kind.size() + solid.tetrahedra.size(), 2);
  const std::vector<ParameterGroup> groups = kinds(options.guess);
  if (!options.proportional)
    return make_grouped_parameters(network, kind, groups, options.nodes, options.bound_factor);
  TURGOR_TRY(GroupedParameters out,
             make_grouped_parameters(network, std::vector(kind.size(), 0), {{"stiffness", "1", 1}},
                                     options.nodes, options.bound_factor));
  TURGOR_TRY(GroupedParameters of_kinds,
             make_grouped_parameters(network, kind, groups, {1, 1, 1}, options.bound_factor));
  add_kinds(kind, std::move(of_kinds), out);
  return out;
}

}  // namespace

Result<SolidFit> make_solid_fit(const SolidMesh& mesh, const SolidFitOptions& options,
                                std::vector<NetworkLoad> loads) {
  TURGOR_CHECK(check(options.guess));
  SolidFit out;
  TURGOR_TRY(out.fit.network, network_of(mesh, options.guess.density_g_mm3));
  TURGOR_TRY(out.parameters, parameters_of(out.fit.network, options));
  out.fit.weights = out.parameters.weights;
  out.fit.logarithmic = true;
  out.fit.loads = std::move(loads);
  return out;
}

}  // namespace turgor
