#include "turgor/fem/response_space.hpp"

#include <gtest/gtest.h>

#include "fem/voxel_bodies.hpp"

namespace turgor {
namespace {

// A block held below whose upper end is moved like a bone.
class ResponseSpaceTest : public testing::Test {
 protected:
  void SetUp() override {
    supports_ = supports_where(solid_, [](const Vec3& p) { return p.z < 0.1 || p.z > 3.9; });
    auto fem = VoxelElasticity::prepare(solid_, body_of(0.015, 0.45), {supports_, {}}, {}, context_);
    ASSERT_TRUE(fem) << fem.error().message();
    fem_.emplace(*std::move(fem));
    const std::vector<Vec3> none(solid_.points.size());
    ASSERT_TRUE(space_.add(std::vector<Vec3>(supports_.size()), none));
  }
  /// A small turn about x and a shift, of the upper end.
  [[nodiscard]] std::vector<Vec3> held(const Vec3& shift, double turn = 0) const {
    std::vector<Vec3> out;
    for (const NodeSupport& s : supports_) {
      const Vec3& p = solid_.points[static_cast<std::size_t>(s.node)];
      out.push_back(p.z > 3.9 ? shift + Vec3{0, -p.z, p.y} * turn : Vec3{});
    }
    return out;
  }
  ElasticSolution solve(const std::vector<Vec3>& held_mm) {
    EXPECT_TRUE(fem_->set_displacements(held_mm));
    const auto start = space_.start(held_mm);
    EXPECT_TRUE(start);
    auto solution = fem_->solve({}, context_, *start);
    EXPECT_TRUE(solution && solution->converged);
    EXPECT_TRUE(space_.add(held_mm, solution->displacement_mm));
    return *std::move(solution);
  }

  Context context_;
  SolidMesh solid_ = voxel_box({6, 6, 8}, 0.5);
  std::vector<NodeSupport> supports_;
  std::optional<VoxelElasticity> fem_;
  ResponseSpace space_;
};

TEST_F(ResponseSpaceTest, GoingOnCostsNothing) {
  EXPECT_GT(solve(held({0, 0.3, 0})).iterations, 3);
  EXPECT_EQ(solve(held({0, 0.35, 0})).iterations, 0);
}

TEST_F(ResponseSpaceTest, KnownDirectionsAndTurnsAddUp) {
  for (const auto& known : {held({0.1, 0, 0}), held({0, 0.2, 0}), held({0, 0, 0.1}), held({}, 0.02)})
    solve(known);
  const auto mixed = held({0.3, -0.1, 0.05}, -0.03);
  const auto start = space_.start(mixed);
  ASSERT_TRUE(start);
  const ElasticSolution solution = solve(mixed);
  EXPECT_EQ(solution.iterations, 0);
  EXPECT_LT(distance(*start, solution.displacement_mm), 1e-12 * norm(*start));
}

TEST_F(ResponseSpaceTest, TheOldestIsForgotten) {
  ResponseSpace small(2);
  const std::vector<Vec3> nodes(3);
  for (int i = 0; i < 4; ++i) ASSERT_TRUE(small.add(std::vector<Vec3>(2, Vec3{double(i), 0, 0}), nodes));
  EXPECT_EQ(small.size(), 2U);
}

TEST_F(ResponseSpaceTest, OtherLengthsAreErrors) {
  EXPECT_FALSE(space_.add(std::vector<Vec3>(1), std::vector<Vec3>(solid_.points.size())));
  EXPECT_FALSE(space_.add(std::vector<Vec3>(supports_.size()), std::vector<Vec3>(1)));
  EXPECT_FALSE(space_.start(std::vector<Vec3>(1)));
  EXPECT_TRUE(ResponseSpace().start(std::vector<Vec3>(5))->empty());
}

}  // namespace
}  // namespace turgor
