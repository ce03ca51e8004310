#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "subcommands.hpp"
#include "turgor/imaging/scan.hpp"

namespace turgor {
namespace {

struct Hounsfield {
  int least, greatest;
};

Hounsfield range_of(const CtVolume& volume) {
  const auto [low, high] = std::minmax_element(volume.voxels.begin(), volume.voxels.end());
  return {*low, *high};
}

void print_text(const Scan& scan, const std::vector<SeriesInfo>& series) {
  const Grid& g = scan.hu.grid;
  const Vec3 last = g.to_patient({g.size[0] - 1.0, g.size[1] - 1.0, g.size[2] - 1.0});
  const Hounsfield hu = range_of(scan.hu);
  const auto line = [](std::string_view name, const std::string& value) {
    if (!value.empty()) fmt::print("{:<12}{}\n", name, value);
  };
  line("format", scan.info.format);
  line("patient", scan.info.patient);
  line("study", scan.info.study);
  line("series", scan.info.series);
  line("modality", scan.info.modality);
  line("size", fmt::format("{} × {} × {} voxels", g.size[0], g.size[1], g.size[2]));
  line("spacing", fmt::format("{:.4g} × {:.4g} × {:.4g} mm", g.spacing.x, g.spacing.y, g.spacing.z));
  line("extent", fmt::format("({:.1f}, {:.1f}, {:.1f}) to ({:.1f}, {:.1f}, {:.1f}) mm, LPS", g.origin.x,
                             g.origin.y, g.origin.z, last.x, last.y, last.z));
  line("Hounsfield", fmt::format("{} to {}", hu.least, hu.greatest));
  if (scan.info.gantry_tilt_deg != 0)
    line("gantry tilt", fmt::format("{:.1f}°, straightened", scan.info.gantry_tilt_deg));
  if (scan.info.stored_left_handed) line("stored", "left-handed; put right, the patient is not mirrored");
  for (const SeriesInfo& s : series) {
    fmt::print("  series {} {} {} slices {}\n", s.uid, s.modality, s.slices, s.description);
  }
}

std::string to_json(const Scan& scan, const std::vector<SeriesInfo>& series) {
  using Json = nlohmann::ordered_json;
  const Grid& g = scan.hu.grid;
  const auto triple = [](const Vec3& v) { return Json::array({v.x, v.y, v.z}); };
  const Hounsfield hu = range_of(scan.hu);
  Json list = Json::array();
  for (const SeriesInfo& s : series) {
    list.push_back(
        {{"uid", s.uid}, {"description", s.description}, {"modality", s.modality}, {"slices", s.slices}});
  }
  const Json out{
      {"format", scan.info.format},
      {"patient", scan.info.patient},
      {"study", scan.info.study},
      {"series", scan.info.series},
      {"modality", scan.info.modality},
      {"size", g.size},
      {"spacing_mm", triple(g.spacing)},
      {"origin_mm_lps", triple(g.origin)},
      {"direction_columns", {triple(g.direction.c[0]), triple(g.direction.c[1]), triple(g.direction.c[2])}},
      {"hounsfield", {hu.least, hu.greatest}},
      {"gantry_tilt_deg", scan.info.gantry_tilt_deg},
      {"stored_left_handed", scan.info.stored_left_handed},
      {"skipped_files", scan.info.skipped_files},
      {"all_series", list}};
  return out.dump(2, ' ', false, Json::error_handler_t::replace);
}

}  // namespace

Result<void> run_info(const Invocation& arguments, Context& context) {
  ReadScanOptions options;
  if (arguments.given("series")) options.series = arguments.word("series");
  TURGOR_TRY(const auto series, list_series(arguments.path("scan"), context));
  TURGOR_TRY(const Scan scan, read_scan(arguments.path("scan"), options, context));
  if (arguments.flag("json")) {
    fmt::print("{}\n", to_json(scan, series));
  } else {
    print_text(scan, series);
  }
  return {};
}

}  // namespace turgor
