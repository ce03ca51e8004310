// Values that several of the JSON files have. Internal to render.
#pragma once

#include <nlohmann/json.hpp>

#include "turgor/world/prediction.hpp"

namespace turgor::render_detail {

// Keys stay in the order they are written, so that a person finds them.
using Json = nlohmann::ordered_json;

Json triple(const Vec3& v);
Json distance_json(const SkinDistance& d);

}  // namespace turgor::render_detail
