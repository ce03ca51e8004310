// Constants that a calibration has found, loaded into a scene.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <memory>
#include <string>

#include "turgor/commands/problem.hpp"
#include "turgor/commands/session.hpp"
#include "turgor/core/file.hpp"
#include "turgor/geometry/mesh_file.hpp"
#include "turgor/world/solid_constants.hpp"
#include "turgor/world/solid_objects.hpp"

namespace turgor {
namespace {

namespace fs = std::filesystem;

/// A bar, harder at its held end, pulled aside at the other.
constexpr const char* kProblem =
    "body surface {} -resolution 8 -no_border\n"
    "hold -plane 0 0 -19 0 0 -1\n"
    "reference -law corotational -modulus 50kPa -poisson 0.4\n"
    "reference -law corotational -modulus 500kPa -poisson 0.4 -plane 0 0 0 0 0 -1\n"
    "model tetrahedra -grid 1 1 3\nguess -modulus 90kPa -poisson 0.4\n"
    "load aside\nforce 30mN 0 40mN -sphere 0 0 25 9\n"
    "method gauss_newton -coarse 0 -budget 6\n";
constexpr const char* kScene =
    "instance_object cube bar\nedit_xform bar -s 10 10 40\n"
    "voxelize bar -resolution 8 -no_border -young 0.09 -poisson 0.4\n";
/// As the problem holds and loads the body: far away and limited, a grab is a constant force.
constexpr const char* kLoad =
    "fix bar -box -9 -9 -21 9 9 -19\n"
    "grab pull -at 0 0 25 -radius 9 -to 3e7 0 4e7 -c 1 -limit 0.05\nsettle -residual 1e-8\n";

struct Played {
  Context context;
  std::unique_ptr<Session> session;
  Result<void> done;

  explicit Played(const std::string& script) {
    session = std::make_unique<Session>(SessionOptions{}, context);
    done = session->enter_text(script, "test");
    if (done) done = session->run();
  }
  [[nodiscard]] std::string error() const { return done ? "" : done.error().message(); }
  [[nodiscard]] const TissueBody& body() const { return session->scene().specimen.bodies().at(1); }
  [[nodiscard]] std::vector<Vec3> positions() const { return session->scene().specimen.positions_of(body()); }
};

/// The surface that the scene makes of its cube, so that both have the same cubes to the last digit.
void write_bar(const fs::path& path) {
  std::ofstream(path)
      << "OFF\n8 6 0\n-5 -5 -20\n5 -5 -20\n5 5 -20\n-5 5 -20\n-5 -5 20\n5 -5 20\n5 5 20\n-5 5 20\n"
         "4 0 3 2 1\n4 4 5 6 7\n4 0 1 5 4\n4 1 2 6 5\n4 2 3 7 6\n4 3 0 4 7\n";
}

double greatest_distance(const std::vector<Vec3>& a, const std::vector<Vec3>& b) {
  if (a.size() != b.size()) return INFINITY;
  double greatest = 0;
  for (std::size_t p = 0; p < a.size(); ++p) greatest = std::max(greatest, distance(a[p], b[p]));
  return greatest;
}

class SceneConstants : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    folder_ = fs::temp_directory_path() / ("turgor_constants_" + std::to_string(::getpid()));
    fs::create_directories(folder_);
    write_bar(folder_ / "bar.off");
    Context context;
    auto commands = parse_script_text(fmt::format(kProblem, (folder_ / "bar.off").string()), "bar.problem",
                                      problem_commands());
    ASSERT_TRUE(commands) << commands.error().message();
    auto options = calibration_options({"bar.problem", *std::move(commands)}, context);
    ASSERT_TRUE(options) << options.error().message();
    auto prepared = CalibrationCase::prepare(*std::move(options), context);
    ASSERT_TRUE(prepared) << prepared.error().message();
    problem_ = std::make_unique<CalibrationCase>(*std::move(prepared));
    auto fit = calibrate(problem_->problem(), problem_->options().fit, context);
    ASSERT_TRUE(fit) << fit.error().message();
    auto outcome = outcome_of(*problem_, *std::move(fit), context);
    ASSERT_TRUE(outcome) << outcome.error().message();
    outcome_ = std::make_unique<CalibrationOutcome>(*std::move(outcome));
    const auto written =
        write_solid_constants(file(), problem_->mesh().points, problem_->elements(), outcome_->stiffness);
    ASSERT_TRUE(written) << written.error().message();
  }
  static void TearDownTestSuite() {
    fs::remove_all(folder_);
    outcome_.reset(), problem_.reset();
  }
  static fs::path file() { return folder_ / "constants.vtu"; }
  static std::string load_constants() { return "constants bar \"" + file().string() + "\"\n"; }

  static inline fs::path folder_;
  static inline std::unique_ptr<CalibrationCase> problem_;
  static inline std::unique_ptr<CalibrationOutcome> outcome_;
};

TEST_F(SceneConstants, UnderTheSameLoadASceneFindsTheCalibratedEquilibrium) {
  const LoadShapes& shapes = outcome_->loads.at(0);
  const auto& rest = problem_->mesh().points;
  const double moved = greatest_distance({rest.begin(), rest.end()}, shapes.calibrated);
  ASSERT_GT(moved, 1);
  ASSERT_GT(greatest_distance(shapes.guess, shapes.calibrated), 0.2 * moved);

  const Played guess(std::string(kScene) + kLoad);
  ASSERT_TRUE(guess.done) << guess.error();
  EXPECT_LT(greatest_distance(guess.positions(), shapes.guess), 1e-5 * moved);
  const Played calibrated(std::string(kScene) + load_constants() + kLoad);
  ASSERT_TRUE(calibrated.done) << calibrated.error();
  EXPECT_LT(greatest_distance(calibrated.positions(), shapes.calibrated), 1e-5 * moved);
  RecordProperty("greatest_distance_mm",
                 fmt::format("{}", greatest_distance(calibrated.positions(), shapes.calibrated)));
  const Played again(calibrated.session->recording());
  ASSERT_TRUE(again.done) << again.error();
  EXPECT_EQ(greatest_distance(again.positions(), calibrated.positions()), 0) << "the recording has them";
}

TEST_F(SceneConstants, TheFileHasEachElementsStiffnessToSevenDigits) {
  const auto read = read_solid_constants(file(), problem_->elements());
  ASSERT_TRUE(read) << read.error().message();
  for (std::size_t c = 0; c < 3; ++c) {
    ASSERT_EQ((*read)[c].size(), outcome_->stiffness[c].size());
    for (std::size_t e = 0; e < (*read)[c].size(); ++e)
      EXPECT_NEAR((*read)[c][e], outcome_->stiffness[c][e], 1e-7 * outcome_->stiffness[c][e]);
  }
}

TEST_F(SceneConstants, ElementsTakeThemTimesTheVolumeThatTheyStandFor) {
  const Played larger(
      "instance_object cube bar\nedit_xform bar -s 20 20 80 -t 7 0 0\n"
      "voxelize bar -resolution 8 -no_border\n" +
      load_constants() + "stiffen bar -by 3\n");
  ASSERT_TRUE(larger.done) << larger.error();
  const Solid& unit = problem_->elements();
  const Solid& found = larger.body().solid->elements;
  for (std::size_t e = 0; e < unit.edges.size(); ++e) {
    const double expected = 3 * 8 * unit.edge_nmm[e] * outcome_->stiffness[0][e];
    EXPECT_NEAR(found.edge_nmm[e], expected, 1e-6 * expected);
  }
  for (std::size_t t = 0; t < unit.tetrahedra.size(); ++t) {
    const double expected = 3 * 8 * unit.tetrahedron_nmm[t] * outcome_->stiffness[2][t];
    EXPECT_NEAR(found.tetrahedron_nmm[t], expected, 1e-6 * expected);
  }
}

TEST_F(SceneConstants, ANewMeshTakesOverMeans) {
  const Played same(std::string(kScene) + load_constants() + kLoad);
  const Played finer(std::string(kScene) + load_constants() + "remesh bar -resolution 12\n" + kLoad);
  ASSERT_TRUE(finer.done) << finer.error();
  const SolidPart& part = *finer.body().solid;
  ASSERT_EQ(part.constants[2].size(), part.mesh.tetrahedra.size());
  const auto [least, greatest] = std::ranges::minmax(outcome_->stiffness[0]);
  EXPECT_GT(greatest, 2 * least);
  for (std::size_t e = 0; e < part.elements.edges.size(); ++e) {
    EXPECT_GT(part.constants[0][e], 0.999 * least);
    EXPECT_LT(part.constants[0][e], 1.001 * greatest);
  }
  const auto reach = [](const Played& run) {
    return measure_solids(run.session->scene().specimen).front().box.upper.x;
  };
  EXPECT_NEAR(reach(finer), reach(same), 0.3 * (reach(same) - 5));
}

TEST_F(SceneConstants, ABoxOfCubesIsTheCubeOfAScene) {
  for (const int resolution : {4, 8, 12}) {
    Context context;
    CalibrationOptions options = problem_->options();
    options.body = BoxBody{{{-5, -5, -20}, {5, 5, 20}}, 40.0 / resolution};
    const auto box = CalibrationCase::prepare(std::move(options), context);
    ASSERT_TRUE(box) << box.error().message();
    ASSERT_TRUE(write_solid_constants(folder_ / "box.vtu", box->mesh().points, box->elements(),
                                      box->stiffness(box->guess())));
    const Played run(
        fmt::format("instance_object cube bar\nedit_xform bar -s 10 10 40\n"
                    "voxelize bar -resolution {} -no_border\nconstants bar \"{}\"\n",
                    resolution, (folder_ / "box.vtu").string()));
    EXPECT_TRUE(run.done) << run.error();
  }
}

TEST_F(SceneConstants, MistakesNameFilePlaceAndRemedy) {
  const auto message = [](const std::string& scene, const fs::path& path) {
    return Played(scene + "constants bar \"" + path.string() + "\"\n").error();
  };
  const auto expect = [](const std::string& text, std::initializer_list<const char*> parts) {
    for (const char* part : parts) EXPECT_NE(text.find(part), std::string::npos) << text;
  };
  expect(message(kScene, "none.vtu"), {"test:4:15", "none.vtu"});
  std::ofstream(folder_ / "text.vtu") << "not XML";
  expect(message(kScene, folder_ / "text.vtu"), {"test:4:15", "text.vtu", "not a file of VTK's XML", "Give"});
  expect(
      message("instance_object cube bar\nedit_xform bar -s 10 10 40\nvoxelize bar -resolution 12\n", file()),
      {"test:4:15", "constants.vtu", "edges, the solid has", "same surface, resolution and border"});
  expect(
      message("instance_object cube bar\nedit_xform bar -s 40 10 10\nvoxelize bar -resolution 8 -no_border\n",
              file()),
      {"join other points", "same surface"});
  expect(message("instance_object cube bar\n", file()), {"test:2:11", "no solid 'bar'", "voxelize"});

  // The same cells with other numbers.
  const auto cells = read_vtu(file());
  ASSERT_TRUE(cells) << cells.error().message();
  MeshField stiffness{"stiffness_mpa", 1, std::vector<float>(cells->mesh.types.size(), 1)};
  ASSERT_TRUE(write_vtu(folder_ / "other.vtu", cells->mesh));
  expect(message(kScene, folder_ / "other.vtu"), {"other.vtu", "stiffness_mpa", "turgor calibrate writes"});
  for (const auto& [value, said] : {std::pair(NAN, "element 3 is nan MPa"), std::pair(-1.0F, "is -1 MPa"),
                                    std::pair(INFINITY, "is inf MPa")}) {
    stiffness.values[3] = value;
    ASSERT_TRUE(write_vtu(folder_ / "bad.vtu", cells->mesh, {}, {stiffness}));
    expect(message(kScene, folder_ / "bad.vtu"), {"test:4:15", "bad.vtu", said, "Calibrate again"});
  }
  CellMesh hexahedra = cells->mesh;
  hexahedra.types.back() = 12;
  stiffness.values[3] = 1;
  ASSERT_TRUE(write_vtu(folder_ / "bad.vtu", hexahedra, {}, {stiffness}));
  expect(message(kScene, folder_ / "bad.vtu"), {"a cell of type 12"});
}

TEST_F(SceneConstants, AnErrorLeavesTheSolidAsItWas) {
  Played run(kScene);
  ASSERT_TRUE(run.done) << run.error();
  Specimen specimen;
  ASSERT_TRUE(specimen.add_solid("bar", *run.body().solid));
  const SolidPart& part = *specimen.bodies().at(1).solid;
  const std::vector<double> before = part.elements.edge_nmm;
  SolidConstants few = outcome_->stiffness, huge = few;
  few[1].pop_back();
  EXPECT_FALSE(specimen.set_solid_constants("bar", few));
  huge[0][0] = 1e308;
  EXPECT_FALSE(specimen.set_solid_constants("bar", huge));
  EXPECT_FALSE(specimen.set_solid_constants("none", outcome_->stiffness));
  EXPECT_EQ(part.elements.edge_nmm, before);
  EXPECT_TRUE(part.constants[2].empty());
}

TEST(SceneConstantsExample, IsAScriptOfAScene) {
  const auto script =
      parse_script(TURGOR_SOURCE_DIR "/examples/calibration/bar_scene.turgor", scene_commands());
  EXPECT_TRUE(script) << script.error().message();
}

}  // namespace
}  // namespace turgor
