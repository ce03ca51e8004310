#include "turgor/render/calibration_report.hpp"

#include <gtest/gtest.h>

#include <filesystem>
#include <limits>
#include <nlohmann/json.hpp>
#include <optional>

namespace turgor {
namespace {

/// A small box pressed on its upper side, and an outcome made by hand: the guess does not come to rest under
/// the second load.
struct PressedBox {
  PressedBox() {
    CalibrationOptions o;
    o.body = BoxBody{{{0, 0, 0}, {10, 10, 10}}, 5};
    RestRegion low, high;
    low.beyond = Plane{{0, 0, -1}, 0}, high.beyond = Plane{{0, 0, 1}, 10};
    o.held = {low};
    o.reference = {{{.youngs_modulus_mpa = 0.05, .poissons_ratio = 0.4}, {}}};
    const auto force = [&](const Vec3& f) {
      return CalibrationForce{CalibrationForce::Kind::force, f, high};
    };
    o.loads = {{"press <1>", false, {force({0, 0, -0.5})}, ""}, {"shear", true, {force({0.2, 0, 0})}, ""}};
    o.model.grid = {1, 1, 2};
    Context context;
    problem.emplace(*CalibrationCase::prepare(o, context));
    Fit& fit = outcome.fit;
    fit.parameters = problem->guess();
    fit.deviation.assign(fit.parameters.size(), 0.02);
    fit.guess_error = 0.9, fit.error = 0.08, fit.failed = 1;
    constexpr double never = std::numeric_limits<double>::infinity();
    fit.samples = {{0.9, 0.9, FitSample::Stage::guess},
                   {never, 0.9, FitSample::Stage::coarse},
                   {0.08, 0.08, FitSample::Stage::search}};
    fit.loads = {{0.9, 0.08, 1.5}, {never, 0.1, 1.2}};
    const auto& points = problem->mesh().points;
    outcome.loads = {{{points.begin(), points.end()}, problem->loads()[0].reference},
                     {{}, problem->loads()[1].reference}};
    outcome.stiffness = problem->stiffness(fit.parameters);
  }
  [[nodiscard]] CalibrationResults results() const {
    return {*problem, outcome, {"0.0", "turgor calibrate box.problem", "box.problem", "load <press>\n"}};
  }

  std::optional<CalibrationCase> problem;
  CalibrationOutcome outcome;
};

TEST(CalibrationReport, JsonHasEveryInputParameterAndError) {
  const PressedBox box;
  const auto json = nlohmann::json::parse(calibration_json(box.results(), Context{}));
  EXPECT_EQ(json["error_before"], 0.9);
  EXPECT_EQ(json["error_after"], 0.08);
  EXPECT_EQ(json["body"]["cubes"], 8);
  EXPECT_EQ(json["search"]["method"], "gauss_newton");
  EXPECT_EQ(json["search"]["stopped_by_user"], false);
  ASSERT_EQ(json["loads"].size(), 2u);
  EXPECT_TRUE(json["loads"][1]["error_before"].is_null()) << "did not come to rest";
  EXPECT_EQ(json["loads"][1]["calibrated_with"], false);
  EXPECT_NEAR(json["loads"][0]["part_after"].get<double>(), 0.08 / 1.5, 1e-12);
  ASSERT_EQ(json["parameters"].size(), 6u);
  EXPECT_EQ(json["parameters"][0]["name"], "k_d at node (0, 0, 0)");
  EXPECT_EQ(json["parameters"][0]["deviation_of_logarithm"], 0.02);
  EXPECT_EQ(json["samples"].size(), 3u);
  EXPECT_TRUE(json["samples"][1]["error"].is_null());
}

TEST(CalibrationReport, PageTellsErrorsConstantsAndWhetherItWasStopped) {
  PressedBox box;
  const auto page_of = [&] {
    return calibration_html(box.results(), {}, calibration_json(box.results(), Context{}), Context{});
  };
  const std::string page = page_of();
  const auto has = [](const std::string& text, const std::string& part) {
    return text.find(part) != std::string::npos;
  };
  for (const char* part : {"0.9 mm</b> to <b>0.08 mm", "press &lt;1&gt;", "held out", "did not come to rest",
                           "k_d", "± 2 %", "load &lt;press&gt;", "standard deviation"})
    EXPECT_TRUE(has(page, part)) << part;
  EXPECT_FALSE(has(page, "http")) << "no outside links";
  EXPECT_FALSE(has(page, "topped by the user"));
  box.outcome.fit.stopped = true;
  EXPECT_TRUE(has(page_of(), "stopped by the user"));
}

TEST(CalibrationReport, WritesPicturesShapesAndConstants) {
  const PressedBox box;
  const auto folder = std::filesystem::temp_directory_path() / "turgor_calibration_report";
  std::filesystem::remove_all(folder);
  std::filesystem::create_directories(folder);
  Context context;
  const auto pictures =
      calibration_pictures(box.results(), {.width = 120, .height = 100, .samples = 2}, context);
  ASSERT_TRUE(pictures) << pictures.error().message();
  std::vector<std::string> names;
  for (const Picture& p : *pictures) {
    names.push_back(p.name);
    EXPECT_GT(p.png.size(), 500u);
    EXPECT_FALSE(p.caption.empty());
  }
  EXPECT_EQ(names, (std::vector<std::string>{"load_1", "load_2", "constants", "search"}));
  const auto written = write_calibration_meshes(box.results(), folder);
  ASSERT_TRUE(written) << written.error().message();
  for (const char* file : {"constants.vtu", "load_1.vtu", "load_1_reference.ply", "load_1_uncalibrated.ply",
                           "load_2.vtu", "load_2_calibrated.ply"})
    EXPECT_TRUE(std::filesystem::exists(folder / file)) << file;
  EXPECT_FALSE(std::filesystem::exists(folder / "load_2_uncalibrated.ply")) << "it did not come to rest";
  std::filesystem::remove_all(folder);
}

}  // namespace
}  // namespace turgor
