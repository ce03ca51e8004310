#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "html.hpp"
#include "report_style.hpp"
#include "turgor/anatomy/tissue_network.hpp"
#include "turgor/render/results.hpp"
#include "turgor/world/reference_bands.hpp"

namespace turgor {
namespace {

using html::escape;
using html::section;

const Picture* find(const std::vector<Picture>& pictures, std::string_view name) {
  const auto it =
      std::find_if(pictures.begin(), pictures.end(), [&](const Picture& p) { return p.name == name; });
  return it == pictures.end() ? nullptr : &*it;
}

std::string group(const std::vector<Picture>& pictures, std::string_view prefix) {
  std::string out = "<div class=\"row\">";
  for (const Picture& p : pictures) {
    if (p.name.starts_with(prefix)) out += html::figure(p.png, p.caption);
  }
  return out + "</div>\n";
}

std::string head(const CaseResults& results) {
  const ScanInfo& scan = results.patient.scan_info();
  const Grid& grid = results.patient.scan_grid();
  return fmt::format(
      "<header><p class=\"brand\">Turgor {}</p><h1>{}</h1>\n"
      "<p class=\"facts\">{} &middot; {} &middot; {} × {} × {} voxels of {:.2f} × {:.2f} × {:.2f} "
      "mm</p></header>\n",
      escape(results.record.version),
      results.predictions.empty() ? "Head and tissue" : "Predicted face after surgery",
      escape(scan.patient.empty() ? "no patient name in the scan" : scan.patient), escape(scan.format),
      grid.size[0], grid.size[1], grid.size[2], grid.spacing.x, grid.spacing.y, grid.spacing.z);
}

// To a tenth of a millimetre, without a minus before zero.
std::string tenths(double mm) {
  const double rounded = std::round(10 * mm) / 10;
  return fmt::format("{:.1f}", rounded == 0 ? 0.0 : rounded);
}

std::string readable(std::string_view name) {
  std::string out = escape(std::string(name));
  std::replace(out.begin(), out.end(), '_', ' ');
  return out;
}

// The one sentence that a reader in a hurry takes along.
std::string summary(const CaseResults& results) {
  const Prediction& main = results.predictions.front();
  const float greatest = *std::max_element(main.displacement_mm.begin(), main.displacement_mm.end());
  std::string text = fmt::format("The skin moves by up to <b>{:.1f} mm</b>.", greatest);
  for (const SoftToHard& r : main.ratios) {
    text += fmt::format(" The {} follows the {} by <b>{:.0f} %</b> of its {:.1f} mm.", readable(r.soft),
                        readable(r.hard), 100 * r.ratio(), r.hard_mm);
    if (text.size() > 420) break;
  }
  return "<p class=\"lead\">" + text + "</p>\n";
}

std::string plan(const CaseResults& results) {
  std::vector<std::vector<std::string>> rows;
  for (const BoneSegment& s : results.patient.bones().segments()) {
    const Vec3 c = bounds(s.surface).centre(), d = s.motion.point(c) - c;
    const double cosine =
        0.5 * (s.motion.rotation.c[0].x + s.motion.rotation.c[1].y + s.motion.rotation.c[2].z - 1);
    rows.push_back({escape(s.name), tenths(-d.y), tenths(d.x), tenths(d.z),
                    fmt::format("{:.1f}°", degrees(std::acos(std::clamp(cosine, -1.0, 1.0))))});
  }
  return "<pre>" + escape(results.record.plan_text) + "</pre>\n" +
         html::table({"Bone segment", "forward mm", "to the left mm", "up mm", "rotation"}, rows);
}

// Before and after in one picture with a handle to wipe between them.
std::string wipe(const std::vector<Picture>& pictures, std::string_view view) {
  const Picture *before = find(pictures, fmt::format("before_{}", view)),
                *after = find(pictures, fmt::format("after_{}", view));
  if (before == nullptr || after == nullptr) return {};
  return fmt::format(
      "<figure><div class=\"wipe\"><img src=\"{}\" alt=\"{}\"><img class=\"over\" src=\"{}\" alt=\"{}\">"
      "<input type=\"range\" min=\"0\" max=\"100\" value=\"50\" aria-label=\"wipe between before and "
      "after\"></div>"
      "<figcaption>Left of the handle: before; right of it: after</figcaption></figure>\n",
      html::data_url(after->png), escape(after->caption), html::data_url(before->png),
      escape(before->caption));
}

std::string bands(const CaseResults& results) {
  std::vector<std::vector<std::string>> rows;
  for (const Prediction& p : results.predictions) {
    for (const BandResult& b : judge(results.patient, p)) {
      rows.push_back(
          {escape(std::string(name_of(p.solver))), escape(b.band->soft), escape(b.band->hard),
           fmt::format("{:.2f}", b.ratio), fmt::format("{:.2f} to {:.2f}", b.band->low, b.band->high),
           b.inside() ? "<span class=\"good\">within</span>" : "<span class=\"bad\">outside</span>",
           escape(b.band->source)});
    }
  }
  if (rows.empty()) return "<p>No published ratios are known here for this combination of movements.</p>\n";
  return html::table({"Solver", "Soft tissue", "relative to bone", "ratio", "published band", "", "source"},
                     rows);
}

std::string landmark_table(const Prediction& p) {
  std::vector<std::vector<std::string>> rows;
  for (const LandmarkShift& l : p.landmarks) {
    const Vec3 d = l.after - l.before;
    if (length(d) < 0.05) continue;
    rows.push_back({escape(l.name), tenths(-d.y), tenths(d.x), tenths(d.z), tenths(length(d))});
  }
  return html::table({"Landmark", "forward mm", "to the left mm", "up mm", "distance mm"}, rows);
}

std::string distances(const CaseResults& results) {
  const auto parts = skin_parts(results.patient);
  std::vector<std::string> header{"Between", "whole face mm"};
  for (const auto& [name, part] : parts) header.push_back(readable(name) + " mm");
  std::vector<std::vector<std::string>> rows;
  const auto cell = [](const SkinDistance& d) {
    return d.points == 0 ? std::string("still")
                         : fmt::format("{:.2f} (95 %: {:.2f})", d.mean, d.percentile_95);
  };
  for (std::size_t i = 0; i < results.predictions.size(); ++i) {
    for (std::size_t j = i + 1; j < results.predictions.size(); ++j) {
      const Prediction &a = results.predictions[i], &b = results.predictions[j];
      rows.push_back({fmt::format("{} and {}", name_of(a.solver), name_of(b.solver)), cell(compare(a, b))});
      for (const auto& [name, part] : parts) rows.back().push_back(cell(compare(a, b, part)));
    }
  }
  if (rows.empty()) return {};
  return "<p>Mean distance between the solvers' skins where either moves, and within which 95 % of points "
         "lie:</p>\n" +
         html::table(header, rows);
}

std::string solvers(const CaseResults& results) {
  std::vector<std::vector<std::string>> rows;
  for (const Prediction& p : results.predictions) {
    const bool equilibrium = p.solver != Solver::chain;
    std::string residual =
        equilibrium ? fmt::format("{:.1e}", p.equilibrium.relative_residual) : "not an equilibrium";
    if (equilibrium && p.equilibrium.residual_n > 0)
      residual += fmt::format(" ({:.1e} N)", p.equilibrium.residual_n);
    rows.push_back(
        {escape(std::string(name_of(p.solver))), fmt::format("{}", p.points),
         p.solver == Solver::fem ? fmt::format("{} cubes", p.volumes) : fmt::format("{} springs", p.springs),
         residual, fmt::format("{}", p.equilibrium.newton_steps),
         fmt::format("{:.1f} ms", 1000 * p.solve_seconds), fmt::format("{}", p.inverted),
         fmt::format("{:.2f}", p.largest_stretch),
         equilibrium ? fmt::format("{:.2f} mm", p.deepest_contact_mm) : "no contact"});
  }
  return html::table({"Solver", "points", "elements", "residual", "Newton steps", "time", "inverted",
                      "greatest stretch of skin", "deepest in bone"},
                     rows) +
         distances(results);
}

std::string model(const CaseResults& results, const std::vector<Picture>& pictures) {
  const LayeredTissue& t = results.patient.tissue();
  const auto [low, high] = std::minmax_element(t.thickness_mm.begin(), t.thickness_mm.end());
  const Head& h = results.patient.head();
  constexpr const char* states[] = {"a piece of its own in the scan", "cut free of the skull, shown in red",
                                    "not in this scan"};
  std::string out = fmt::format(
      "<p>{} points, {} prisms, {} springs. Thickness {:.1f} to {:.1f} mm, {:.1f} mm on average over bone. "
      "{} of {} rays "
      "missed bone and were given a "
      "depth; {} prisms were "
      "repaired; {} are inverted. Skin at {:.0f} HU, bone at {:.0f} HU, both refined locally. Mandible: {}. "
      "Pieces removed "
      "(head holder, table, cables): {}.</p>\n",
      t.points.size(), t.prisms(), spring_count(t), *low, *high, t.mean_hit_thickness_mm, t.rays_missed,
      t.columns(), t.prisms_repaired, count_inverted(t, t.points), h.skin_level_hu, h.bone_level_hu,
      states[static_cast<std::size_t>(h.mandible_state)], h.removed_pieces);
  return out + group(pictures, "thickness") + group(pictures, "landmarks") + group(pictures, "bones_front") +
         group(pictures, "bones_profile");
}

std::string limits(const CaseResults& results) {
  std::string out =
      "<ul><li>This is a computed prediction for planning and teaching. It is not a medical device and no "
      "substitute for a "
      "surgeon's judgement.</li>"
      "<li>Published methods of this kind differ from operated patients by 0.6 mm in the median and 1.5 to "
      "1.7 mm at the 90th "
      "percentile (Mollemans et al. 2007); lips are the least certain part.</li>"
      "<li>Lips and cheeks slide on the teeth, but soft tissue does not yet touch soft tissue. Muscle tone, "
      "swelling, scars and later adaptation are not modelled: an upper lip follows the maxilla farther here "
      "than "
      "in patients.</li>"
      "<li>Tissue stiffness is taken from the literature, not measured on this patient.</li>";
  if (results.patient.head().open_below) {
    out +=
        "<li>The scan cuts the head at its lower end: what lies near that edge is not held and is less "
        "certain.</li>";
  }
  return out + "</ul>\n";
}

}  // namespace

std::string report_html(const CaseResults& results, const std::vector<Picture>& pictures,
                        std::string_view json, const Context& context) {
  std::string page = report_head("Predicted face after surgery") + head(results);
  if (!results.predictions.empty()) {
    page += summary(results);
    page += section("Before and after", "<div class=\"row\">" + wipe(pictures, "front") +
                                            wipe(pictures, "profile") + "</div>\n" +
                                            group(pictures, "superimposed"));
    page += section("How far the skin moves", group(pictures, "displacement"));
    page += section("The plan", plan(results) + group(pictures, "bones_after"));
    page += section("Against published experience", bands(results));
    page += section("Landmarks", landmark_table(results.predictions.front()));
    page += section("Three-quarter views", group(pictures, "before_three") + group(pictures, "after_three"));
    page += section("Solvers", solvers(results));
  }
  page += section("The model", model(results, pictures));
  page += section("What this does not tell", limits(results));
  page += html::run_details(context, json);
  return page + std::string(report_tail);
}

}  // namespace turgor
