// The cases of Morris (2006), sections 3.4 and 3.6, as examples/calibration has them, with fewer cubes.
#include <gtest/gtest.h>

#include <filesystem>

#include "turgor/commands/problem.hpp"

namespace turgor {
namespace {

CalibrationOptions example(const std::string& name) {
  Context context;
  const auto problem = read_problem(std::filesystem::path(TURGOR_SOURCE_DIR) / "examples/calibration" / name);
  EXPECT_TRUE(problem) << (problem ? "" : problem.error().message());
  auto options = problem ? calibration_options(*problem, context) : problem.error();
  EXPECT_TRUE(options) << (options ? "" : options.error().message());
  return options ? *std::move(options) : CalibrationOptions{};
}

/// Its teeth hang together all the same.
CalibrationOptions coarse_gear(const std::string& name) {
  CalibrationOptions options = example(name);
  auto& voxels = std::get<SurfaceBody>(options.body).voxels;
  voxels.resolution = 12, voxels.border = true;
  return options;
}

struct Calibrated {
  CalibrationCase problem;
  Fit fit;

  [[nodiscard]] double part(std::size_t load) const {
    return fit.loads[load].after / fit.loads[load].reference;
  }
};

std::optional<Calibrated> calibrated(CalibrationOptions options) {
  Context context;
  auto problem = CalibrationCase::prepare(std::move(options), context);
  EXPECT_TRUE(problem) << (problem ? "" : problem.error().message());
  if (!problem) return std::nullopt;
  auto fit = calibrate(problem->problem(), problem->options().fit, context);
  EXPECT_TRUE(fit) << (fit ? "" : fit.error().message());
  if (!fit) return std::nullopt;
  return Calibrated{*std::move(problem), *std::move(fit)};
}

TEST(CalibrationExamples, TheGearsConstantsCarryOverToOtherLoads) {
  const auto gear = calibrated(coarse_gear("gear.problem"));
  ASSERT_TRUE(gear);
  ASSERT_EQ(gear->fit.loads.size(), 3U);
  EXPECT_GT(gear->fit.loads[0].before, 0.5 * gear->fit.loads[0].reference);
  EXPECT_LT(gear->part(0), 0.1);
  EXPECT_LT(gear->part(1), 0.15);
  EXPECT_LT(gear->part(2), 0.15);
}

TEST(CalibrationExamples, AGridLeavesLessOfTheGearThanUniformConstants) {
  CalibrationOptions options = coarse_gear("gear_grid.problem");
  options.fit.regularisation = 1e-3;
  const auto fine = calibrated(options);
  options.model.grid = {1, 1, 1};
  const auto uniform = calibrated(options);
  ASSERT_TRUE(fine && uniform);
  EXPECT_LT(fine->fit.error, 0.75 * uniform->fit.error);
}

TEST(CalibrationExamples, ConstantsTellTheHardPartOfTheCubeFromTheSoft) {
  CalibrationOptions options = example("cube.problem");
  std::get<BoxBody>(options.body).spacing_mm = 12.5;
  const auto cube = calibrated(std::move(options));
  ASSERT_TRUE(cube);
  const auto correlation = modulus_correlation(cube->problem, cube->problem.stiffness(cube->fit.parameters));
  ASSERT_TRUE(correlation);
  EXPECT_GT(*correlation, 0.9);
  // Figure 13 c: the hard part hardly moves, and so in the model.
  Context context;
  const auto run = cube->problem.problem().model->run(cube->fit.parameters, 0, nullptr, context);
  ASSERT_TRUE(run) << run.error().message();
  double greatest = 0, greatest_below = 0;
  for (std::size_t p = 0; p < cube->problem.mesh().points.size(); ++p) {
    const Vec3 rest = cube->problem.mesh().points[p];
    const double moved = distance((*run)->response().position_mm[p], rest);
    greatest = std::max(greatest, moved);
    if (rest.z < 51) greatest_below = std::max(greatest_below, moved);
  }
  EXPECT_LT(greatest_below, 0.1 * greatest);
}

TEST(CalibrationExamples, AUniformReferenceHasNoCorrelation) {
  CalibrationOptions options = example("cube.problem");
  options.reference.pop_back(), options.loads.pop_back();
  options.body = BoxBody{{{0, 0, 0}, {100, 100, 100}}, 25};
  options.fit.budget = 1;
  const auto cube = calibrated(std::move(options));
  ASSERT_TRUE(cube);
  EXPECT_FALSE(modulus_correlation(cube->problem, cube->problem.stiffness(cube->fit.parameters)));
}

}  // namespace
}  // namespace turgor
