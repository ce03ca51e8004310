#include <gtest/gtest.h>

#include <filesystem>

#include "imaging/imaging_support.hpp"
#include "turgor/imaging/filter.hpp"
#include "turgor/imaging/histogram.hpp"
#include "turgor/imaging/isosurface.hpp"
#include "turgor/imaging/scan.hpp"
#include "turgor/imaging/segmentation.hpp"
#include "turgor/imaging/voxel_box.hpp"

namespace turgor {
namespace {

/// The head CT of the Debian package invesalius-examples: 256 x 256 x 108 voxels, cut at the upper lip, with
/// a head holder of two plates.
class RealScan : public testing::Test {
 protected:
  void SetUp() override {
    const std::filesystem::path path = "/usr/share/doc/invesalius-examples/examples/Cranium.inv3";
    if (!std::filesystem::exists(path)) GTEST_SKIP() << "the package invesalius-examples is not installed";
    Context context;
    Result<Scan> scan = read_scan(path, {}, context);
    ASSERT_TRUE(scan) << scan.error().message();
    volume_ = std::move(scan->hu);
  }

  CtVolume volume_;
};

TEST_F(RealScan, FallsIntoHeadAndTwoPlatesOfTheHolder) {
  const std::vector<std::size_t> skin = connected_components(threshold(volume_, -200, 4000)).sizes;
  ASSERT_GE(skin.size(), 3u);
  EXPECT_NEAR(static_cast<double>(skin[0]), 2.27e6, 0.01e6);
  EXPECT_NEAR(static_cast<double>(skin[1]), 33e3, 1e3);
  EXPECT_NEAR(static_cast<double>(skin[2]), 33e3, 1e3);
  const std::vector<std::size_t> bone = connected_components(threshold(volume_, 226, 4000)).sizes;
  ASSERT_GE(bone.size(), 3u);
  EXPECT_NEAR(static_cast<double>(bone[0]), 432e3, 1e3);
  EXPECT_NEAR(static_cast<double>(bone[1]), 21e3, 1e3);
}

TEST_F(RealScan, GivesClosedSurfacesOfTheVolumeThatItsVoxelsHave) {
  const double voxel_ml = volume_.grid.spacing.x * volume_.grid.spacing.y * volume_.grid.spacing.z / 1000;
  for (const double level : {-200.0, 226.0}) {
    const TriMesh mesh = isosurface(volume_, level, true);
    EXPECT_TRUE(test::is_closed_and_oriented(mesh));
    std::size_t voxels = 0;
    for (const std::int16_t v : volume_.voxels) voxels += v >= level;
    const double expected = static_cast<double>(voxels) * voxel_ml;
    EXPECT_NEAR(enclosed_volume(mesh) / 1000, expected, 0.02 * expected);
  }
}

TEST_F(RealScan, KeepsOnlyTheHeadInTheSurfaceOfItsLargestPiece) {
  const LabelVolume head = fill_holes(largest_component(threshold(volume_, -200, 4000)));
  EXPECT_TRUE(test::is_closed_and_oriented(isosurface_of_label(volume_, -200, head, 1, true)));
  const VoxelBox everything = bounding_box(threshold(volume_, -200, 4000)), kept = bounding_box(head);
  EXPECT_LT(kept.size()[0], everything.size()[0]);

  TriMesh skin = isosurface_of_label(volume_, -200, head);
  const int moved = refine_to_local_level(skin, volume_, 3, 1.5);
  EXPECT_GT(moved, 0.98 * static_cast<double>(skin.points.size()));
  EXPECT_TRUE(validate(skin));
}

TEST_F(RealScan, HasItsLevelsBetweenTheTissues) {
  const Histogram h = histogram(volume_);
  const std::optional<double> skin = otsu_level(h, -1024, 300);
  ASSERT_TRUE(skin.has_value());
  EXPECT_GT(*skin, -700);
  EXPECT_LT(*skin, -200);
  EXPECT_NEAR(*histogram(volume_, -1024, -900).mode(), -1004, 15);
}

}  // namespace
}  // namespace turgor
