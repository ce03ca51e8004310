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
  explicit PressedBox(double side = 10, bool proportional = false) {
    CalibrationOptions o;
    o.body = BoxBody{{{0, 0, 0}, {side, side, side}}, side / 2};
    o.model.proportional = proportional;
    RestRegion low, high;
    low.beyond = Plane{{0, 0, -1}, 0}, high.beyond = Plane{{0, 0, 1}, side};
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
  for (const char* part :
       {"0.9 mm (0.0009 m)</b> to <b>0.08 mm (8e-05 m)", "60 %", "5.3 %", "press &lt;1&gt;", "held out",
        "did not come to rest", "k_d", "± 2 %", "load &lt;press&gt;", "standard deviation"})
    EXPECT_TRUE(has(page, part)) << part;
  EXPECT_FALSE(has(page, "http")) << "no outside links";
  EXPECT_FALSE(has(page, "topped by the user"));
  box.outcome.fit.stopped = true;
  EXPECT_TRUE(has(page_of(), "stopped by the user"));
}

TEST(CalibrationReport, MetresAreStatedAndGoFirstFrom100MmOn) {
  const PressedBox small, large(100);
  EXPECT_EQ(error_text(small.results(), 1.5), "1.5 mm (0.0015 m)");
  EXPECT_EQ(error_text(large.results(), 1.5), "0.0015 m (1.5 mm)");
  EXPECT_EQ(error_text(large.results(), std::numeric_limits<double>::infinity()), "did not come to rest");
  const auto json = nlohmann::json::parse(calibration_json(large.results(), Context{}));
  EXPECT_DOUBLE_EQ(json["error_before_m"], 0.0009);
  EXPECT_DOUBLE_EQ(json["error_after_m"], 0.00008);
  for (const auto& load : json["loads"])
    EXPECT_DOUBLE_EQ(load["reference_m"].get<double>(), load["reference"].get<double>() / 1000);
  EXPECT_DOUBLE_EQ(json["loads"][0]["error_before_m"], 0.0009);
  EXPECT_DOUBLE_EQ(json["loads"][0]["error_after_m"], 0.00008);
  EXPECT_TRUE(json["loads"][1]["error_before_m"].is_null());
}

TEST(CalibrationReport, TheUncalibratedGuessIsStatedAsItWas) {
  for (const bool proportional : {false, true}) {
    const PressedBox box(10, proportional);
    const SolidStiffness closed_form = stiffness_of(box.problem->options().model.guess);
    const auto guess = nlohmann::json::parse(calibration_json(box.results(), Context{}))["model"]["guess"];
    EXPECT_NEAR(guess["k_d_mpa"], closed_form.length, 1e-12 * closed_form.length);
    EXPECT_NEAR(guess["k_a_mpa"], closed_form.area, 1e-12 * closed_form.area);
    EXPECT_NEAR(guess["k_v_mpa"], closed_form.volume, 1e-12 * closed_form.volume);
    const std::string text = guess_text(box.results());
    for (const char* part : {"modulus 0.015 MPa", "ratio 0.45", "k_d = 0.06207 MPa", "k_a = ", "k_v = "})
      EXPECT_NE(text.find(part), std::string::npos) << text;
    const std::string page = calibration_html(box.results(), {}, "{}", Context{});
    EXPECT_NE(page.find("k_d = 0.06207 MPa"), std::string::npos);
  }
}

TEST(CalibrationReport, ATerminalIsToldOfTheGuessAndOfEachLoad) {
  const PressedBox box(100);
  const std::string text = calibration_summary(box.results());
  for (const char* part :
       {"Uncalibrated guess: Young's",
        "fitted    before: 0.0009 m (0.9 mm) = 60 %; after: 8e-05 m (0.08 mm) = 5.3 %; of 0.0015 m (1.5 "
        "mm)\n",
        "held out  before: did not come to rest; after: 0.0001 m (0.1 mm) = 8.3 %; of 0.0012 m (1.2 mm)\n"})
    EXPECT_NE(text.find(part), std::string::npos) << text;
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
