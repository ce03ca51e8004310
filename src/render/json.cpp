#include "render/json.hpp"

namespace turgor::render_detail {

Json triple(const Vec3& v) {
  return Json::array({v.x, v.y, v.z});
}

Json distance_json(const SkinDistance& d) {
  return {{"mean_mm", d.mean},
          {"mean_m", d.mean / 1000},
          {"percentile_95_mm", d.percentile_95},
          {"greatest_mm", d.greatest},
          {"points", d.points}};
}

}  // namespace turgor::render_detail
