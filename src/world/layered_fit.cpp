#include "turgor/world/layered_fit.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <string_view>

#include "turgor/core/index.hpp"
#include "turgor/dynamics/equilibrium_sensitivity.hpp"

namespace turgor {
namespace {

constexpr std::array<std::string_view, 6> kKinds = {"membrane", "plate",  "vertical",
                                                    "diagonal", "suture", "fibre"};
constexpr int kVolumes = static_cast<int>(kKinds.size());  // after all springs

/// Layer and kind.
using Key = std::array<int, 2>;

Error bad(std::string what, std::string remedy) {
  return {ErrorKind::bad_input, std::move(what), "fit of layered tissue", std::move(remedy)};
}

Result<void> check(const std::vector<int>& layers, std::size_t count, std::string_view of) {
  if (!layers.empty() && layers.size() != count)
    return bad(fmt::format("{} layers are given for {} {}", layers.size(), count, of),
               "Give one for each, or none");
  for (const int layer : layers) {
    if (layer < -1) return bad(fmt::format("one of the {} is of layer {}", of, layer), "-1 is none");
  }
  return {};
}

std::string name_of(const Key& key, bool layers) {
  const std::string kind =
      key[1] == kVolumes ? std::string("volumes") : fmt::format("{} springs", kKinds[at(key[1])]);
  return layers ? fmt::format("{} of layer {}", kind, key[0]) : kind;
}

}  // namespace

Result<LayeredFit> make_layered_fit(SpringNetwork network, const LayeredFitOptions& options,
                                    std::vector<NetworkLoad> loads) {
  TURGOR_CHECK(check(options.spring_layer, network.springs.size(), "springs"));
  TURGOR_CHECK(check(options.volume_layer, network.volumes.size(), "volumes"));
  for (const Spring& spring : network.springs) {
    if (at(static_cast<int>(spring.kind)) >= kKinds.size())
      return bad(fmt::format("a spring is of kind {}", static_cast<int>(spring.kind)),
                 "Kinds are those of SpringKind");
  }
  const auto layer = [](const std::vector<int>& layers, std::size_t i) {
    return layers.empty() ? 0 : layers[i];
  };
  std::vector<Key> keys;
  for (std::size_t i = 0; i < network.springs.size(); ++i)
    keys.push_back({layer(options.spring_layer, i), static_cast<int>(network.springs[i].kind)});
  for (std::size_t i = 0; i < network.volumes.size(); ++i)
    keys.push_back({layer(options.volume_layer, i), kVolumes});
  std::map<Key, int> numbers;
  for (const Key& key : keys)
    if (key[0] >= 0) numbers[key] = 0;
  std::vector<ParameterGroup> groups;
  for (auto& [key, number] : numbers) {
    number = static_cast<int>(groups.size());
    groups.push_back({name_of(key, !options.spring_layer.empty() || !options.volume_layer.empty()), "1", 1});
  }
  std::vector<int> group(NetworkConstants(network).count(), -1);
  for (std::size_t i = 0; i < keys.size(); ++i)
    if (keys[i][0] >= 0) group[i] = numbers[keys[i]];
  LayeredFit out;
  TURGOR_TRY(out.parameters,
             make_grouped_parameters(network, group, groups, options.nodes, options.bound_factor));
  out.fit.network = std::move(network);
  out.fit.weights = out.parameters.weights;
  out.fit.logarithmic = true;
  out.fit.loads = std::move(loads);
  return out;
}

Result<LayeredFit> make_layered_fit(SpringNetwork network, const LayeredTissue& tissue, const Index3& nodes,
                                    std::vector<NetworkLoad> loads) {
  LayeredFitOptions options{.spring_layer = {}, .volume_layer = {}, .nodes = nodes};
  // Points lie in sheets, outermost first.
  for (const Spring& s : network.springs)
    options.spring_layer.push_back(std::min(s.a, s.b) / tissue.columns());
  for (const VolumeElement& v : network.volumes)
    options.volume_layer.push_back(*std::min_element(v.p, v.p + 4) / tissue.columns());
  return make_layered_fit(std::move(network), options, std::move(loads));
}

Result<void> scale_layers(const LayeredTissue& tissue, const LayerFactors& factors, SpringNetwork& network) {
  if (factors.factors.empty()) return {};
  TURGOR_TRY(LayeredFit fit, make_layered_fit(std::move(network), tissue, factors.nodes, {}));
  std::vector<double> logarithms(fit.parameters.parameters.size());
  for (const auto& [name, factor] : factors.factors) {
    const auto found = std::ranges::find(fit.parameters.parameters, name, &FitParameter::name);
    if (found == fit.parameters.parameters.end())
      return bad("the tissue has no " + name, "Calibrate a tissue of as many layers");
    if (!(std::isfinite(factor) && factor > 0))
      return bad(fmt::format("the factor of {} is {}", name, factor), "It must be above 0");
    logarithms[at(static_cast<int>(found - fit.parameters.parameters.begin()))] = std::log(factor);
  }
  std::vector<double> scale(fit.parameters.weights.rows());
  fit.parameters.weights.apply(logarithms, scale);
  for (double& s : scale) s = std::exp(s);
  network = std::move(fit.fit.network);
  scale_constants(network, scale);
  return {};
}

}  // namespace turgor
