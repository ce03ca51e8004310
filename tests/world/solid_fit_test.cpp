// Tetrahedra learn from the elasticity of the cubes that they fill (Morris 2006, section 3.6, in small).
#include "turgor/world/solid_fit.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "turgor/calibration/calibrate.hpp"
#include "turgor/core/index.hpp"
#include "turgor/fem/voxel_elasticity.hpp"
#include "turgor/geometry/voxel_solid.hpp"

namespace turgor {
namespace {

constexpr int kCells = 8;
constexpr double kTop = 80, kSoft = 0.05, kHard = 1;  // mm, MPa

SolidMesh cube() {
  VoxelGrid grid(Index3{kCells + 2, kCells + 2, kCells + 2});
  grid.spacing = kTop / kCells;
  grid.lower = Vec3{-1, -1, -1} * grid.spacing;
  for (int k = 1; k <= kCells; ++k)
    for (int j = 1; j <= kCells; ++j)
      for (int i = 1; i <= kCells; ++i) grid.set(i, j, k);
  return *solid_of(grid);
}

// Pressed on its top, its base held.
NetworkLoad press(const SolidMesh& mesh) {
  NetworkLoad load;
  load.name = "press";
  load.loads.force_n.resize(mesh.points.size());
  for (std::size_t p = 0; p < mesh.points.size(); ++p) {
    const Vec3& x = mesh.points[p];
    if (x.z < 1) load.motion.fixed.push_back(static_cast<int>(p));
    if (x.z > kTop - 1 && std::abs(x.x - 40) < 21 && std::abs(x.y - 40) < 21)
      load.loads.force_n[p] = {0, 0, -0.5};
  }
  return load;
}

template <class Modulus>
ReferenceLoad elastic(const SolidMesh& mesh, const NetworkLoad& load, double poissons_ratio,
                      Modulus&& modulus) {
  ElasticBody body;
  body.materials[0].youngs_modulus_mpa = 1;
  body.materials[0].poissons_ratio = poissons_ratio;
  for (const auto& corners : hexahedra(mesh))
    body.modulus_factor.push_back(modulus((mesh.points[at(corners[0])] + mesh.points[at(corners[6])]) * 0.5));
  std::vector<NodeSupport> supports;
  for (const int p : load.motion.fixed) supports.push_back({p, {true, true, true}, {}});
  ElasticLoad applied;
  for (std::size_t p = 0; p < mesh.points.size(); ++p)
    applied.forces.push_back({static_cast<int>(p), load.loads.force_n[p]});
  Context context;
  const auto solver = VoxelElasticity::prepare(mesh, body, {supports, {}}, {}, context);
  const auto solved = solver->solve(applied, context);
  EXPECT_TRUE(solved && solved->converged);
  ReferenceLoad out;
  out.name = load.name;
  out.reference.position_mm.assign(mesh.points.begin(), mesh.points.end());
  for (std::size_t p = 0; p < mesh.points.size(); ++p)
    out.reference.position_mm[p] += solved->displacement_mm[p];
  return out;
}

Fit fitted(const ForwardModel& model, const SolidFit& solid, const ReferenceLoad& reference,
           double regularisation) {
  FitOptions options;
  options.coarse_samples = 0;
  options.budget = 25;
  options.regularisation = regularisation;
  Context context;
  auto fit = calibrate({&model, solid.parameters.parameters, {reference}}, options, context);
  EXPECT_TRUE(static_cast<bool>(fit)) << (fit ? "" : fit.error().message());
  return *std::move(fit);
}

// Root mean square displacement below and above the middle.
std::array<double, 2> moved(const SolidMesh& mesh, const std::vector<Vec3>& positions) {
  std::array<double, 2> sum{}, count{};
  for (std::size_t p = 0; p < positions.size(); ++p) {
    const std::size_t part = mesh.points[p].z < kTop / 2 ? 0 : 1;
    sum[part] += squared_length(positions[p] - mesh.points[p]);
    count[part] += 1;
  }
  return {std::sqrt(sum[0] / count[0]), std::sqrt(sum[1] / count[1])};
}

TEST(SolidFit, HomogeneousConstantsComeCloseToElasticity) {
  const SolidMesh mesh = cube();
  const NetworkLoad load = press(mesh);
  const ReferenceLoad reference = elastic(mesh, load, 0.45, [](const Vec3& /*place*/) { return 0.1; });
  auto solid = make_solid_fit(mesh, {{0.1, 0.45, 1e-3, 0.2}, {1, 1, 1}}, {load});
  ASSERT_TRUE(static_cast<bool>(solid));
  const auto model = make_forward_model(solid->fit);
  const Fit fit = fitted(**model, *solid, reference, 0);
  const double effect = *response_error(reference, Response{{mesh.points.begin(), mesh.points.end()}, {}},
                                        ErrorMeasure::distance);
  EXPECT_LT(fit.error, 0.1 * effect);
  EXPECT_LT(fit.error, 0.7 * fit.guess_error);
}

TEST(SolidFit, LearnsWhereABodyIsHard) {
  const SolidMesh mesh = cube();
  const NetworkLoad load = press(mesh);
  const ReferenceLoad reference =
      elastic(mesh, load, 0.499, [](const Vec3& place) { return place.z < kTop / 2 ? kHard : kSoft; });
  SolidFitOptions options{{std::sqrt(kSoft * kHard), 0.45, 1e-3, 0.2}, {2, 2, 4}};
  options.proportional = true;
  auto solid = make_solid_fit(mesh, options, {load});
  ASSERT_TRUE(static_cast<bool>(solid));
  const auto model = make_forward_model(solid->fit);
  const Fit fit = fitted(**model, *solid, reference, 1e-3);
  EXPECT_LT(fit.error, 0.3 * fit.guess_error);
  // Each node's factor tells the half it lies in.
  double least_hard = 1e9, most_soft = 0;
  for (std::size_t k = 0; k < fit.parameters.size(); ++k) {
    if (solid->parameters.group[k] != 0) continue;
    double& bound = solid->parameters.position_mm[k].z < kTop / 2 ? least_hard : most_soft;
    bound = &bound == &least_hard ? std::min(bound, fit.parameters[k]) : std::max(bound, fit.parameters[k]);
  }
  EXPECT_GT(least_hard, most_soft);
  // The load is taken up in the soft half.
  Context context;
  const auto run = (*model)->run(fit.parameters, 0, nullptr, context);
  ASSERT_TRUE(static_cast<bool>(run));
  const auto found = moved(mesh, (*run)->response().position_mm),
             truth = moved(mesh, reference.reference.position_mm);
  EXPECT_NEAR(found[1], truth[1], 0.1 * truth[1]);
  EXPECT_LT(found[0], 0.15 * found[1]);
}

}  // namespace
}  // namespace turgor
