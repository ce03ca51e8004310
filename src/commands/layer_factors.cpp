// What a calibration of a face has found, read from its calibration.json.
#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "turgor/commands/problem.hpp"
#include "turgor/core/file.hpp"

namespace turgor {

Result<LayerFactors> read_layer_factors(const std::filesystem::path& path) {
  using nlohmann::json;
  const Error wrong{ErrorKind::bad_input, "the file holds no calibrated constants of a face", path.string(),
                    "Give the calibration.json that turgor calibrate writes for a body face"};
  TURGOR_TRY(const std::string text, read_text_file(path));
  const json all = json::parse(text, nullptr, false);
  const json* const model = all.is_object() && all.contains("model") ? &all["model"] : nullptr;
  if (model == nullptr || !model->is_object() || model->value("kind", json()) != "network") return wrong;
  const json nodes = model->value("grid_nodes", json()), parameters = all.value("parameters", json());
  if (!nodes.is_array() || nodes.size() != 3 || !parameters.is_array() || parameters.empty()) return wrong;
  LayerFactors out;
  for (std::size_t a = 0; a < 3; ++a) {
    if (!nodes[a].is_number_integer() || nodes[a] < 1 || nodes[a] > 1000) return wrong;
    out.nodes[a] = nodes[a].get<int>();
  }
  for (const json& p : parameters) {
    if (!p.is_object()) return wrong;
    const json name = p.value("name", json()), value = p.value("value", json());
    if (!name.is_string() || !value.is_number()) return wrong;
    out.factors.emplace_back(name.get<std::string>(), value.get<double>());
    if (!(out.factors.back().second > 0)) {
      return Error{ErrorKind::bad_input,
                   fmt::format("the factor of {} is {}", out.factors.back().first, out.factors.back().second),
                   path.string(), "It must be above 0: calibrate again"};
    }
  }
  return out;
}

}  // namespace turgor
