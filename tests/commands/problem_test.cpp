#include "turgor/commands/problem.hpp"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

namespace turgor {
namespace {

Problem problem_of(const std::string& text) {
  auto commands = parse_script_text(text, "t.problem", problem_commands());
  EXPECT_TRUE(commands) << commands.error().message();
  return {"t.problem", commands ? *std::move(commands) : std::vector<Invocation>{}};
}

Result<CalibrationOptions> options_of(const std::string& text) {
  Context context;
  return calibration_options(problem_of(text), context);
}

constexpr const char* kBox = "body box 0 0 0 10 10 10 -spacing 2.5\nreference -modulus 50kPa -poisson 0.4\n";

TEST(Problem, ReadsBodyLoadsReferenceModelAndMethod) {
  const auto o =
      options_of(std::string(kBox) +
                 "hold -plane 0 0 0 0 0 -1\n"
                 "reference -law mooney_rivlin -modulus 1 -poisson 0.45 -c20 9kPa -box 0 0 0 10 10 5\n"
                 "load push\nforce 0 0 -20mN -nearest 5 5 10\ntraction 2kPa 0 0 -box 0 0 9 10 10 11\n"
                 "load squeeze -held_out\npressure 5kPa -sphere 5 5 10 3\n"
                 "displace 0 0 -1mm -plane 0 0 10 0 0 1\n"
                 "model tetrahedra -grid 2 3 4\n"
                 "guess -modulus 20kPa -poisson 0.3 -area_share 10%\nbounds -low 0.1 -high 20\n"
                 "measure shape\nmethod annealing -budget 7 -coarse 3 -chains 2 -seed 9\n"
                 "probe 2 -held_out -depth 3%\nview 0 0 2\n");
  ASSERT_TRUE(o) << o.error().message();
  EXPECT_EQ(std::get<BoxBody>(o->body).spacing_mm, 2.5);
  ASSERT_EQ(o->held.size(), 1u);
  EXPECT_TRUE(o->held[0].contains({3, 3, 0}, 0));
  EXPECT_FALSE(o->held[0].contains({3, 3, 1}, 0));
  ASSERT_EQ(o->reference.size(), 2u);
  EXPECT_DOUBLE_EQ(o->reference[0].material.youngs_modulus_mpa, 0.05);
  EXPECT_EQ(o->reference[1].material.law, ElasticLaw::mooney_rivlin);
  EXPECT_DOUBLE_EQ(o->reference[1].material.c20_mpa, 0.009);
  ASSERT_EQ(o->loads.size(), 2u);
  EXPECT_EQ(o->loads[0].forces.size(), 2u);
  EXPECT_EQ(o->loads[0].forces[0].vector, (Vec3{0, 0, -0.02}));
  EXPECT_EQ(o->loads[0].forces[0].region.nearest, (Vec3{5, 5, 10}));
  EXPECT_TRUE(o->loads[1].held_out);
  EXPECT_EQ(o->loads[1].forces[0].kind, CalibrationForce::Kind::pressure);
  EXPECT_EQ(o->loads[1].forces[1].vector, (Vec3{0, 0, -1}));
  EXPECT_EQ(o->model.grid, (Index3{2, 3, 4}));
  EXPECT_DOUBLE_EQ(o->model.guess.youngs_modulus_mpa, 0.02);
  EXPECT_EQ(o->model.high, 20);
  EXPECT_EQ(o->fit.measure, ErrorMeasure::shape);
  EXPECT_EQ(o->fit.method, FitMethod::annealing);
  EXPECT_EQ(o->fit.budget, 7);
  EXPECT_EQ(o->fit.seed, 9u);
  EXPECT_EQ(o->probes.loads, 2);
  EXPECT_DOUBLE_EQ(o->probes.depth, 0.03);
  EXPECT_EQ(o->seen_from, (Vec3{0, 0, 1}));
}

TEST(Problem, GuessesTheModulusOfTheReferenceUnlessToldOtherwise) {
  const auto o = options_of(kBox);
  ASSERT_TRUE(o) << o.error().message();
  EXPECT_DOUBLE_EQ(o->model.guess.youngs_modulus_mpa, 0.05);
}

TEST(Problem, ScalesShapesAndSurfaces) {
  const auto o = options_of("body shape gear -size 60 50 16\nreference -modulus 1 -poisson 0.3\n");
  ASSERT_TRUE(o) << o.error().message();
  const Box3 box = bounds(std::get<SurfaceBody>(o->body).surface);
  EXPECT_NEAR(box.size().x, 60, 1e-9);
  EXPECT_NEAR(box.size().y, 50, 1e-9);
  EXPECT_NEAR(box.lower.z, -8, 1e-9);
}

TEST(Problem, MistakesNameLineAndColumnAndRemedy) {
  const auto expect = [](const std::string& text, const std::string& where, const std::string& what) {
    const auto o = options_of(text);
    ASSERT_FALSE(o) << text;
    EXPECT_EQ(o.error().where, where) << text;
    EXPECT_NE(o.error().what.find(what), std::string::npos) << o.error().message();
    EXPECT_FALSE(o.error().remedy.empty()) << text;
  };
  expect("", "t.problem", "no body");
  expect("body box 0 0 0 1 1 1 -spacing 1\n", "t.problem", "made of");
  expect(std::string(kBox) + "body shape gear -size 1 1 1\n", "t.problem:3:1", "a body already");
  expect(std::string(kBox) + "force 0 0 1 -nearest 0 0 0\n", "t.problem:3:1", "no load");
  expect(std::string(kBox) + "load a\nload a\n", "t.problem:4:6", "already");
  expect("body surface none.ply\n", "t.problem:1:14", "none.ply");
  expect("reference -modulus 1 -poisson 0.3 -c20 1\n", "t.problem:1:40", "mooney_rivlin");
}

TEST(Problem, RefusesWhatIsDeclaredOtherwise) {
  for (const char* line : {"hold", "force 0 0 1", "reference -modulus 0 -poisson 0.3", "method newton",
                           "reference -modulus 1 -poisson 0.5", "probe 0", "bounds -low 2", "measure nothing",
                           "model tetrahedra -grid 0 1 1", "force nan 0 0 -nearest 0 0 0"}) {
    const auto parsed = parse_script_text(line, "t.problem", problem_commands());
    ASSERT_FALSE(parsed) << line;
    EXPECT_EQ(parsed.error().kind, ErrorKind::bad_command);
    EXPECT_TRUE(parsed.error().where.starts_with("t.problem:1:")) << parsed.error().where;
  }
}

TEST(Problem, ItsTextParsesToTheSame) {
  const Problem problem = problem_of("load twist\nforce 0 20mN 0 -box 0 0 0 1 1 1\nguess -modulus 9kPa\n");
  const Problem again = problem_of(problem.text());
  EXPECT_EQ(problem.text(), again.text());
}

TEST(Problem, DeclaresTheNamesOfTheCode) {
  const auto choices = [](std::string_view command, std::string_view parameter) {
    return problem_commands().find(command)->find(parameter)->choices;
  };
  ASSERT_EQ(choices("reference", "law").size(), kElasticLaws.size());
  for (std::size_t i = 0; i < kElasticLaws.size(); ++i)
    EXPECT_EQ(choices("reference", "law")[i], name_of(kElasticLaws[i]));
  for (std::size_t i = 0; i < 4; ++i)
    EXPECT_EQ(choices("method", "name")[i], name_of(static_cast<FitMethod>(i)));
  for (std::size_t i = 0; i < 3; ++i)
    EXPECT_EQ(choices("measure", "what")[i], name_of(static_cast<ErrorMeasure>(i)));
}

TEST(Problem, FlagsOfTheProgramGoBeforeTheProblem) {
  const std::vector<std::string> words{"calibrate", "a.problem", "-o", "out",   "-method",
                                       "cma_es",    "-budget",   "5",  "-seed", "3"};
  const auto program = parse_arguments(words, program_commands());
  ASSERT_TRUE(program) << program.error().message();
  FitOptions fit;
  fit.coarse_samples = 77;
  apply_search_flags(*program, fit);
  EXPECT_EQ(fit.method, FitMethod::cma_es);
  EXPECT_EQ(fit.budget, 5);
  EXPECT_EQ(fit.seed, 3u);
  EXPECT_EQ(fit.coarse_samples, 77);
}

TEST(Problem, ExamplesOfTheRepositoryAreRead) {
  int count = 0;
  for (const auto& entry : std::filesystem::directory_iterator(TURGOR_SOURCE_DIR "/examples/calibration")) {
    if (entry.path().extension() != ".problem") continue;
    const auto problem = read_problem(entry.path());
    ASSERT_TRUE(problem) << problem.error().message();
    if (is_face(*problem)) continue;  // its scan is made first
    Context context;
    const auto options = calibration_options(*problem, context);
    EXPECT_TRUE(options) << options.error().message();
    ++count;
  }
  EXPECT_GE(count, 3);
}

}  // namespace
}  // namespace turgor
