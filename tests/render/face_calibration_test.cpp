// What a calibration of a face leaves: a phantom's face and moves of its skin made by hand.
#include "turgor/render/face_calibration_report.hpp"

#include <gtest/gtest.h>
#include <unistd.h>

#include <cmath>
#include <filesystem>
#include <limits>
#include <nlohmann/json.hpp>

#include "turgor/anatomy/phantom.hpp"
#include "turgor/core/index.hpp"
#include "turgor/core/parallel.hpp"

namespace turgor {
namespace {

namespace fs = std::filesystem;

/// Voxels of 4 mm by the tissue at their centres: partial volumes would take ten times as long.
CtVolume coarse_scan() {
  const auto phantom = Phantom::create({});
  const Box3 extent = phantom->extent();
  Grid grid;
  grid.spacing = {4, 4, 4};
  grid.origin = extent.lower + grid.spacing / 2;
  const Vec3 size = extent.size() / 4;
  for (int a = 0; a < 3; ++a) grid.size[at(a)] = static_cast<int>(size[a]);
  CtVolume out(grid);
  parallel_for(at(grid.size[2]), 1, [&](std::size_t begin, std::size_t end) {
    for (int k = static_cast<int>(begin); k < static_cast<int>(end); ++k)
      for (int j = 0; j < grid.size[1]; ++j)
        for (int i = 0; i < grid.size[0]; ++i) {
          const Vec3 p =
              grid.to_patient({static_cast<double>(i), static_cast<double>(j), static_cast<double>(k)});
          constexpr double air = -1000, well_outside = 8;
          out.at(i, j, k) =
              static_cast<std::int16_t>(phantom->skin(p) > well_outside ? air : phantom->hounsfield(p));
        }
  });
  return out;
}

std::shared_ptr<const PatientCase> phantom_patient() {
  static const std::shared_ptr<const PatientCase> patient = [] {
    const fs::path path =
        fs::temp_directory_path() / ("turgor_face_report_" + std::to_string(::getpid()) + ".nrrd");
    CaseOptions options;
    options.head.skin_triangles = 6'000;
    options.head.bone_triangles = 8'000;
    options.tissue.columns = 300;
    Context context;
    EXPECT_TRUE(write_nrrd(path, coarse_scan()));
    auto opened = PatientCase::open(path, options, context);
    fs::remove(path);
    EXPECT_TRUE(opened) << opened.error().message();
    return opened ? std::make_shared<const PatientCase>(*std::move(opened)) : nullptr;
  }();
  return patient;
}

/// The skin with its lower third moved back by so much, mm.
Prediction set_back(const PatientCase& patient, double mm) {
  Prediction p;
  p.skin = patient.skin();
  for (const auto& [name, within] : skin_parts(patient)) {
    if (name != kLowerThird) continue;
    for (std::size_t i = 0; i < within.size(); ++i)
      if (within[i]) p.skin.points[i].y += mm;
  }
  for (std::size_t i = 0; i < p.skin.points.size(); ++i)
    p.displacement_mm.push_back(static_cast<float>(distance(p.skin.points[i], patient.skin().points[i])));
  return p;
}

/// A setback to fit, a larger one held out.
struct FaceCase {
  FaceCase() {
    const auto patient = phantom_patient();
    moves = {{"set <back>", false, patient, set_back(*patient, 6)},
             {"larger", true, patient, set_back(*patient, 8)}};
    moves[0].reference.solve_seconds = 30;
    outcome.uncalibrated = {set_back(*patient, 5), set_back(*patient, 6.5)};
    outcome.calibrated = {set_back(*patient, 5.75), set_back(*patient, 7.5)};
    outcome.calibrated[1].inverted = 2;
    face.nodes = {1, 1, 1};
    for (const char* name : {"membrane 0", "volume 2"})
      face.problem.parameters.push_back({.name = name, .unit = "1", .low = 0.01, .high = 100, .guess = 1});
    Fit& fit = outcome.fit;
    fit.parameters = {1.5, 100}, fit.deviation = {0.02, 3};
    fit.guess_error = 0.9, fit.error = 0.3, fit.failed = 1;
    constexpr double never = std::numeric_limits<double>::infinity();
    fit.samples = {{0.9, 0.9, FitSample::Stage::guess},
                   {never, 0.9, FitSample::Stage::search},
                   {0.3, 0.3, FitSample::Stage::search}};
  }
  [[nodiscard]] FaceCalibrationResults results() const {
    return {moves,
            face,
            search,
            outcome,
            {"0.0", "turgor calibrate face.problem", "face.problem", "load <set>\n"}};
  }

  std::vector<FaceMove> moves;
  FaceFit face;
  FitOptions search;
  FaceOutcome outcome;
};

TEST(FaceCalibrationReport, JsonHasDistancesInTheLowerThirdAndWhatAPredictionTakes) {
  const FaceCase face;
  const auto json = nlohmann::json::parse(face_calibration_json(face.results(), Context{}));
  EXPECT_EQ(json["model"]["kind"], "network");
  EXPECT_EQ(json["model"]["grid_nodes"], (nlohmann::json{1, 1, 1}));
  ASSERT_EQ(json["parameters"].size(), 2U);
  EXPECT_EQ(json["parameters"][0]["name"], "membrane 0");
  EXPECT_EQ(json["parameters"][0]["value"], 1.5);
  EXPECT_EQ(json["error_before"], 0.9);
  EXPECT_EQ(json["error_after"], 0.3);
  ASSERT_EQ(json["loads"].size(), 2U);
  const auto& [fitted, larger] = std::tie(json["loads"][0], json["loads"][1]);
  EXPECT_EQ(fitted["calibrated_with"], true);
  EXPECT_EQ(larger["calibrated_with"], false);
  EXPECT_NEAR(fitted["lower_third_before"]["mean_mm"], 1, 1e-9);
  EXPECT_NEAR(fitted["lower_third_after"]["mean_mm"], 0.25, 1e-9);
  EXPECT_NEAR(fitted["lower_third_after"]["mean_m"], 0.00025, 1e-12);
  EXPECT_NEAR(larger["lower_third_movement"]["mean_mm"], 8, 1e-9);
  EXPECT_NEAR(larger["lower_third_before"]["percentile_95_mm"], 1.5, 1e-9);
  EXPECT_NEAR(larger["lower_third_after"]["greatest_mm"], 0.5, 1e-9);
  EXPECT_GT(fitted["lower_third_before"]["points"], 100);
  EXPECT_EQ(larger["inverted_prisms"], 2);
  EXPECT_TRUE(json["samples"][1]["error"].is_null()) << "did not come to rest";
}

TEST(FaceCalibrationReport, PageTellsDistancesFactorsAndWhetherItWasStopped) {
  FaceCase face;
  const auto has = [](const std::string& text, const std::string& part) {
    return text.find(part) != std::string::npos;
  };
  const std::string page = face_calibration_html(face.results(), {}, "{}", Context{});
  for (const char* part : {"0.9 mm (0.0009 m)</b> to <b>0.3 mm (0.0003 m)", "6.00", "1.00&nbsp;(17&nbsp;%)",
                           "0.25&nbsp;(4.2&nbsp;%)", "set &lt;back&gt;", "held out", "1.00", "0.25", "1.50",
                           "0.50", "membrane 0", "± 2 %", "at its upper bound",
                           "more than ten times either way", "load &lt;set&gt;", "2 moves"})
    EXPECT_TRUE(has(page, part)) << part;
  EXPECT_FALSE(has(page, "http")) << "no outside links";
  EXPECT_FALSE(has(page, "stopped by the user"));
  face.outcome.fit.stopped = true;
  EXPECT_TRUE(has(face_calibration_html(face.results(), {}, "{}", Context{}), "stopped by the user"));
}

TEST(FaceCalibrationReport, WritesPageNumbersAndPictures) {
  FaceCase face;
  face.moves.pop_back();
  const fs::path folder = fs::temp_directory_path() / ("turgor_face_report_" + std::to_string(::getpid()));
  fs::create_directories(folder);
  Context context;
  const auto written = write_face_calibration(face.results(), folder, context);
  ASSERT_TRUE(written) << written.error().message();
  for (const char* file : {"report.html", "calibration.json", "pictures/load_1.png", "pictures/search.png"})
    EXPECT_GT(fs::exists(folder / file) ? fs::file_size(folder / file) : 0, 500U) << file;
  EXPECT_FALSE(fs::exists(folder / "pictures/load_2.png"));
  fs::remove_all(folder);
}

TEST(FaceCalibrationReport, StopsWhenAskedTo) {
  FaceCase face;
  face.moves.pop_back();
  Context cancelled({}, {}, [] { return true; });
  const auto stopped = write_face_calibration(face.results(), fs::temp_directory_path(), cancelled);
  ASSERT_FALSE(stopped);
  EXPECT_EQ(stopped.error().kind, ErrorKind::cancelled);
}

}  // namespace
}  // namespace turgor
