// Problems of a face, and what their calibrations leave for a prediction.
#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <string>

#include "turgor/commands/problem.hpp"

namespace turgor {
namespace {

namespace fs = std::filesystem;

Problem problem_of(const std::string& text) {
  auto commands = parse_script_text(text, "t.problem", problem_commands());
  EXPECT_TRUE(commands) << commands.error().message();
  return {"t.problem", commands ? *std::move(commands) : std::vector<Invocation>{}};
}
std::string plan() {
  return " -plan " TURGOR_SOURCE_DIR "/examples/setback.turgor";
}

TEST(FaceProblem, ReadsScanMovesReferenceModelAndSearch) {
  Context context;
  const Problem problem = problem_of("body face scans/a -quality draft\nload setback" + plan() +
                                     "\nload larger -held_out" + plan() +
                                     "\nreference -law neo_hookean -modulus 15kPa -poisson 0.49\n"
                                     "model network -grid 2 3 1\nbounds -low 0.1 -high 20\n"
                                     "method cma_es -budget 7 -seed 3\n");
  EXPECT_TRUE(is_face(problem));
  const auto face = face_problem(problem, context);
  ASSERT_TRUE(face) << face.error().message();
  EXPECT_EQ(face->scan, "scans/a");
  EXPECT_EQ(face->quality, Quality::draft);
  ASSERT_EQ(face->loads.size(), 2U);
  EXPECT_EQ(face->loads[0].name, "setback");
  EXPECT_FALSE(face->loads[0].held_out);
  EXPECT_TRUE(face->loads[1].held_out);
  EXPECT_EQ(face->loads[1].where, "t.problem:3:1");
  EXPECT_FALSE(face->loads[0].plan.commands.empty());
  ASSERT_TRUE(face->reference);
  EXPECT_EQ(face->reference->law, ElasticLaw::neo_hookean);
  EXPECT_DOUBLE_EQ(face->reference->youngs_modulus_mpa, 0.015);
  EXPECT_EQ(face->model.nodes, (Index3{2, 3, 1}));
  EXPECT_EQ(face->model.low, 0.1);
  EXPECT_EQ(face->model.high, 20);
  EXPECT_EQ(face->fit.method, FitMethod::cma_es);
  EXPECT_EQ(face->fit.budget, 7);
  EXPECT_EQ(face->fit.seed, 3U);
}

TEST(FaceProblem, WithoutMoreSearchesByDerivativesFromTheNetworkAsItIs) {
  Context context;
  const auto face = face_problem(problem_of("body face scan\nload setback" + plan() + "\n"), context);
  ASSERT_TRUE(face) << face.error().message();
  EXPECT_EQ(face->quality, Quality::normal);
  EXPECT_FALSE(face->reference) << "that of the plans";
  EXPECT_EQ(face->model.nodes, (Index3{1, 1, 1}));
  EXPECT_EQ(face->fit.method, FitMethod::gauss_newton);
  EXPECT_EQ(face->fit.coarse_samples, 0);
}

TEST(FaceProblem, MistakesNamePlaceAndRemedy) {
  const auto expect = [](const std::string& text, const std::string& where, const std::string& what) {
    Context context;
    const auto face = face_problem(problem_of(text), context);
    ASSERT_FALSE(face) << text;
    EXPECT_TRUE(face.error().where.starts_with(where)) << face.error().message();
    EXPECT_NE(face.error().what.find(what), std::string::npos) << face.error().message();
    EXPECT_FALSE(face.error().remedy.empty()) << text;
  };
  const std::string face = "body face scan\n", load = "load a" + plan() + "\n";
  expect(face, "t.problem", "no load to calibrate with");
  expect(face + "load a -held_out" + plan() + "\n", "t.problem", "no load to calibrate with");
  expect(face + "load a\n", "t.problem:2:1", "a load of a face is a plan");
  expect(face + load + load, "t.problem:3:6", "a load 'a' already");
  expect(face + face + load, "t.problem:2:1", "a body already");
  expect(face + load + "load b -plan none.turgor\n", "t.problem:3:14", "none.turgor: no such file");
  for (const char* other :
       {"hold -plane 0 0 0 0 0 1", "force 0 0 1 -nearest 0 0 0", "pressure 1 -sphere 0 0 0 1", "probe 2",
        "model tetrahedra", "guess -modulus 1", "measure shape", "view 0 0 1", "body shape gear -size 1 1 1"})
    expect(face + load + other + "\n", "t.problem:3:1", "a face does not take");
  expect(face + load + "bounds -low 1 -high 1\n", "t.problem:3:1", "leave no room");
}

TEST(FaceProblem, OtherBodiesDoNotTakeWhatIsOfAFace) {
  Context context;
  for (const std::string& line : {std::string("model network"), "load a" + plan()}) {
    const Problem problem = problem_of("body box 0 0 0 1 1 1 -spacing 1\n" + line + "\n");
    EXPECT_FALSE(is_face(problem));
    const auto options = calibration_options(problem, context);
    ASSERT_FALSE(options) << line;
    EXPECT_EQ(options.error().where, "t.problem:2:1");
    EXPECT_NE(options.error().message().find("of a face only"), std::string::npos);
    EXPECT_NE(options.error().remedy.find("body face SCAN"), std::string::npos);
  }
}

class ReadLayerFactors : public ::testing::Test {
 protected:
  void SetUp() override {
    path_ = fs::temp_directory_path() / ("turgor_factors_" + std::to_string(::getpid()) + ".json");
  }
  void TearDown() override { fs::remove(path_); }
  Result<LayerFactors> read(const std::string& text) const {
    std::ofstream(path_, std::ios::binary) << text;
    return read_layer_factors(path_);
  }
  static std::string file(const std::string& kind, const std::string& nodes, const std::string& parameters) {
    return R"({"program": "turgor", "model": {"kind": )" + kind + R"(, "grid_nodes": )" + nodes +
           R"(}, "parameters": )" + parameters + "}";
  }

  fs::path path_;
};

constexpr const char* kTwo =
    R"([{"name": "membrane 0", "unit": "1", "value": 1.5, "guess": 1}, {"name": "volume 2", "value": 0.25}])";

TEST_F(ReadLayerFactors, TakesNodesNamesAndValues) {
  const auto factors = read(file("\"network\"", "[2, 1, 3]", kTwo));
  ASSERT_TRUE(factors) << factors.error().message();
  EXPECT_EQ(factors->nodes, (Index3{2, 1, 3}));
  EXPECT_EQ(factors->factors,
            (std::vector<std::pair<std::string, double>>{{"membrane 0", 1.5}, {"volume 2", 0.25}}));
}

TEST_F(ReadLayerFactors, OtherFilesAreToldByNameWithTheRemedy) {
  const std::string network = "\"network\"", nodes = "[1, 1, 1]";
  for (const std::string& text : {std::string(),
                                  std::string("[]"),
                                  std::string("{"),
                                  std::string("3"),
                                  std::string("{}"),
                                  std::string(R"({"model": 3})"),
                                  std::string(R"({"model": {"kind": "network"}})"),
                                  file("\"tetrahedra\"", nodes, kTwo),
                                  file("null", nodes, kTwo),
                                  file(network, "null", kTwo),
                                  file(network, "[1, 1]", kTwo),
                                  file(network, "[1, 1, 0]", kTwo),
                                  file(network, "[1, 1, 1.5]", kTwo),
                                  file(network, "[1, 1, 1001]", kTwo),
                                  file(network, "[1, 1, \"1\"]", kTwo),
                                  file(network, nodes, "null"),
                                  file(network, nodes, "[]"),
                                  file(network, nodes, "[3]"),
                                  file(network, nodes, "[{}]"),
                                  file(network, nodes, R"([{"name": 3, "value": 1}])"),
                                  file(network, nodes, R"([{"name": "a"}])"),
                                  file(network, nodes, R"([{"name": "a", "value": null}])"),
                                  file(network, nodes, R"([{"name": "a", "value": NaN}])"),
                                  file(network, nodes, R"([{"name": "a", "value": 1e999}])")}) {
    const auto factors = read(text);
    ASSERT_FALSE(factors) << text;
    EXPECT_EQ(factors.error().kind, ErrorKind::bad_input);
    EXPECT_EQ(factors.error().where, path_.string());
    EXPECT_NE(factors.error().what.find("no calibrated constants of a face"), std::string::npos) << text;
    EXPECT_NE(factors.error().remedy.find("calibration.json"), std::string::npos);
  }
}

TEST_F(ReadLayerFactors, FactorsMustBeAboveZero) {
  for (const char* value : {"0", "-2"}) {
    const auto factors = read(
        file("\"network\"", "[1, 1, 1]", R"([{"name": "membrane 0", "value": )" + std::string(value) + "}]"));
    ASSERT_FALSE(factors) << value;
    EXPECT_NE(factors.error().message().find("the factor of membrane 0 is " + std::string(value)),
              std::string::npos)
        << factors.error().message();
    EXPECT_EQ(factors.error().where, path_.string());
  }
}

TEST_F(ReadLayerFactors, AFileThatIsNotThereIsNamed) {
  const auto factors = read_layer_factors("none.json");
  ASSERT_FALSE(factors);
  EXPECT_NE(factors.error().message().find("none.json"), std::string::npos);
}

}  // namespace
}  // namespace turgor
