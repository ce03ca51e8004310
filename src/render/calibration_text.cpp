// Numbers of a calibration in words: for the report, the pictures and the terminal.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "render/calibration_sections.hpp"
#include "turgor/render/calibration_report.hpp"

namespace turgor {

using namespace render_detail;

namespace {

constexpr double kSmallBodyMm = 100;

bool is_small(const SolidMesh& mesh) {
  Box3 box;
  for (const Vec3& p : mesh.points) box.extend(p);
  const Vec3 size = box.size();
  return std::max({size.x, size.y, size.z}) < kSmallBodyMm;
}

}  // namespace

namespace render_detail {

std::string part_text(double v, double of) {
  if (!std::isfinite(v) || !(of > 0)) return "";
  const double percent = 100 * v / of;
  return percent < 10 ? fmt::format("{:.2g} %", percent) : fmt::format("{:.0f} %", percent);
}

std::array<double, 3> guess_mpa(const CalibrationCase& problem) {
  const SolidConstants each = problem.stiffness(problem.guess());
  return {each[0].front(), each[1].front(), each[2].front()};
}

}  // namespace render_detail

std::string error_text(const CalibrationResults& results, double error) {
  if (!std::isfinite(error)) return "did not come to rest";
  if (results.problem.options().fit.measure == ErrorMeasure::force) return fmt::format("{:.3g} N", error);
  return is_small(results.problem.mesh()) ? fmt::format("{:.3g} mm ({:.3g} m)", error, error / 1000)
                                          : fmt::format("{:.3g} m ({:.3g} mm)", error / 1000, error);
}

std::string guess_text(const CalibrationResults& results) {
  const SolidMaterial& m = results.problem.options().model.guess;
  const auto [k_d, k_a, k_v] = guess_mpa(results.problem);
  return fmt::format(
      "Uncalibrated guess: Young's modulus {:.4g} MPa, Poisson's ratio {:.4g}, areas with {:.3g} of the "
      "shear: "
      "k_d = {:.4g} MPa, k_a = {:.4g} MPa, k_v = {:.4g} MPa",
      m.youngs_modulus_mpa, m.poissons_ratio, m.area_share, k_d, k_a, k_v);
}

std::string calibration_summary(const CalibrationResults& results) {
  const Fit& fit = results.outcome.fit;
  const auto with_part = [&](double error, double of) {
    const std::string part = part_text(error, of), text = error_text(results, error);
    return part.empty() ? text : text + " = " + part;
  };
  std::string out = guess_text(results) + "\n";
  for (std::size_t l = 0; l < fit.loads.size(); ++l) {
    const PreparedLoad& load = results.problem.loads()[l];
    const LoadFit& of = fit.loads[l];
    out += fmt::format("{:<16} {:<9} before: {}; after: {}; of {}\n", load.name,
                       load.held_out ? "held out" : "fitted", with_part(of.before, of.reference),
                       with_part(of.after, of.reference), error_text(results, of.reference));
  }
  return out;
}

}  // namespace turgor
