// Parts of scans as cubes, against closed forms.
#include "turgor/imaging/label_solid.hpp"

#include "imaging/imaging_support.hpp"
#include "imaging/scan/stored_volume.hpp"
#include "imaging/scan_format_files.hpp"
#include "turgor/core/parallel.hpp"

namespace turgor {
namespace {

using namespace scan_test;
using test::grid_of;

constexpr double kPi = 3.141592653589793;
const Mat3 kOblique = rotation(normalized(Vec3{1, 2, -1}), 0.4);

/// 7 within `radius` mm of the centre, 3 within a fifth of it about a far place, else 0.
CtVolume balls(const Grid& grid, const Vec3& centre, double radius, const Vec3& far) {
  return test::sampled(grid, [&](const Vec3& p) {
    return distance(p, centre) <= radius ? 7 : distance(p, far) <= radius / 5 ? 3 : 0;
  });
}

double volume_of(const VoxelGrid& g) {
  return static_cast<double>(g.count()) * g.spacing * g.spacing * g.spacing;
}

Vec3 middle_of(const VoxelGrid& g) {
  Vec3 sum;
  for (int k = 0; k < g.size[2]; ++k)
    for (int j = 0; j < g.size[1]; ++j)
      for (int i = 0; i < g.size[0]; ++i)
        if (g.test(i, j, k)) sum += g.lower + Vec3{i + 0.5, j + 0.5, k + 0.5} * g.spacing;
  return sum / static_cast<double>(g.count());
}

LabelOptions label(int number, int resolution = 0, double spacing = 0) {
  LabelOptions options;
  options.labels = {number}, options.resolution = resolution, options.spacing_mm = spacing;
  return options;
}

VoxelGrid voxels_of(const CtVolume& scan, const LabelOptions& options) {
  auto grid = label_voxels(scan, options);
  EXPECT_TRUE(grid) << (grid ? "" : grid.error().message());
  return grid ? *std::move(grid) : VoxelGrid({1, 1, 1});
}

std::string error_of(const CtVolume& scan, const LabelOptions& options) {
  const auto grid = label_voxels(scan, options);
  return grid ? "no error" : grid.error().message();
}

TEST(LabelSolid, TheScansOwnVoxelsWhereNothingIsAsked) {
  const CtVolume scan = balls(grid_of({40, 38, 36}, {0.5, 0.5, 0.5}, {3, -8, 11}), {12, 1, 20}, 6, {});
  const VoxelGrid grid = voxels_of(scan, label(7));
  EXPECT_EQ(grid.spacing, 0.5);
  EXPECT_EQ(grid.count(), static_cast<std::size_t>(std::count(scan.voxels.begin(), scan.voxels.end(), 7)));
  for (int k = 0; k < grid.size[2]; ++k) {
    for (int j = 0; j < grid.size[1]; ++j) {
      for (int i = 0; i < grid.size[0]; ++i) {
        const Vec3 p = scan.grid.to_index(grid.lower + Vec3{i + 0.5, j + 0.5, k + 0.5} * grid.spacing);
        ASSERT_NEAR(p.x, std::round(p.x), 1e-9);
        ASSERT_EQ(grid.test(i, j, k), std::lround(scan.sample_index(p)) == 7);
      }
    }
  }
}

TEST(LabelSolid, ABallOfAnObliqueScanOfUnequalSpacingsKeepsVolumeAndPlace) {
  const Vec3 centre{4, -20, 33};
  Grid oblique = grid_of({110, 90, 40}, {0.4, 0.5, 1.1}, {}, kOblique);
  oblique.origin = centre - kOblique * Vec3{20, 21, 22};
  const CtVolume scan = balls(oblique, centre, 15, {});
  const double exact = 4.0 / 3 * kPi * 15 * 15 * 15;
  for (const LabelOptions& o : {label(7), label(7, 60), label(7, 0, 0.7)}) {
    const VoxelGrid grid = voxels_of(scan, o);
    EXPECT_NEAR(volume_of(grid), exact, 0.02 * exact) << o.resolution << ' ' << o.spacing_mm;
    EXPECT_LT(distance(middle_of(grid), centre), 0.1);
  }
  EXPECT_EQ(voxels_of(scan, label(7)).spacing, 0.4);
  EXPECT_NEAR(voxels_of(scan, label(7, 60)).spacing, 30.0 / 60, 0.02);
  EXPECT_EQ(voxels_of(scan, label(7, 0, 0.7)).spacing, 0.7);
}

TEST(LabelSolid, SeveralLabelsAndComponentsAreKept) {
  const CtVolume scan = balls(grid_of({60, 30, 30}), {15, 15, 15}, 10, {45, 15, 15});
  LabelOptions both = label(7);
  both.labels.push_back(3);
  const auto count = [&](int v) {
    return static_cast<std::size_t>(std::count(scan.voxels.begin(), scan.voxels.end(), v));
  };
  EXPECT_EQ(voxels_of(scan, label(3)).count(), count(3));
  EXPECT_EQ(voxels_of(scan, both).count(), count(3) + count(7));
}

TEST(LabelSolid, AThresholdFollowsTheInterpolatedValue) {
  // 1000 HU at the centre, falling by 50 HU a mm.
  const Vec3 centre{20, 20, 20};
  const CtVolume scan = test::sampled(grid_of({33, 33, 33}, {1.25, 1.25, 1.25}),
                                      [&](const Vec3& p) { return 1000 - 50 * distance(p, centre); });
  LabelOptions options;
  options.above = 500, options.resolution = 80;
  const double exact = 4.0 / 3 * kPi * 1000;
  EXPECT_NEAR(volume_of(voxels_of(scan, options)), exact, 0.02 * exact);
  options.below = 750;  // a shell
  EXPECT_NEAR(volume_of(voxels_of(scan, options)), exact * (1 - 0.125), 0.02 * exact);
}

TEST(LabelSolid, ThePartAtTheEndOfAScanIsWhole) {
  const CtVolume scan(grid_of({4, 5, 6}, {2, 2, 2}), 9);
  EXPECT_DOUBLE_EQ(volume_of(voxels_of(scan, label(9))), 4 * 5 * 6 * 8);
  EXPECT_DOUBLE_EQ(volume_of(voxels_of(scan, label(9, 24))), 4 * 5 * 6 * 8);
  LabelOptions all;
  all.above = 0;
  EXPECT_DOUBLE_EQ(volume_of(voxels_of(scan, all)), 4 * 5 * 6 * 8);
  EXPECT_TRUE(solid_of(voxels_of(scan, all)));
}

TEST(LabelSolid, ErrorsNameWhatThereIs) {
  const CtVolume scan = balls(grid_of({30, 20, 20}), {10, 10, 10}, 6, {24, 10, 10});
  EXPECT_NE(error_of(scan, label(5)).find("no voxel has the label 5. Give labels that there are: 3, 7"),
            std::string::npos)
      << error_of(scan, label(5));
  EXPECT_NE(error_of(scan, label(100000)).find("100000"), std::string::npos);
  EXPECT_NE(error_of(CtVolume(grid_of({3, 3, 3})), label(5)).find("no labels but 0"), std::string::npos);
  LabelOptions high;
  high.above = 300;
  EXPECT_NE(error_of(scan, high).find("0 to 7 HU"), std::string::npos) << error_of(scan, high);
  high.below = 200;
  EXPECT_NE(error_of(scan, high).find("above 300 and below 200"), std::string::npos);
  EXPECT_NE(error_of(scan, {}).find("either labels or a threshold"), std::string::npos);
  EXPECT_NE(error_of(scan, label(7, 0, 1e-300)).find("Give a spacing of"), std::string::npos);
  EXPECT_NE(error_of(scan, label(7, 0, std::nan(""))).find("spacing"), std::string::npos);
  EXPECT_NE(error_of(scan, label(7, 2000)).find("resolution 2000"), std::string::npos);
  EXPECT_NE(error_of(scan, label(7, 10, 1)).find("resolution and spacing"), std::string::npos);
}

TEST(LabelSolid, TheSameBitsOnAnyNumberOfThreads) {
  const CtVolume scan =
      balls(grid_of({50, 45, 40}, {1, 1, 1}, {}, kOblique), kOblique * Vec3{22, 22, 20}, 18, {});
  set_thread_count(1);
  const VoxelGrid one = voxels_of(scan, label(7, 50));
  set_thread_count(3);
  const VoxelGrid three = voxels_of(scan, label(7, 50));
  set_thread_count(0);
  EXPECT_TRUE(one.bits == three.bits);
}

TEST(LabelMaps, AreReadFromEveryFormatAsTheyAre) {
  const Scratch scratch;
  Lattice lattice = lattice_with_mark({Vec3{0.8, 0, 0}, Vec3{0, 1.1, 0}, Vec3{0, 0, 2.5}});
  std::vector<std::int16_t> values = marked_voxels(lattice.size);
  for (std::int16_t& v : values) v = v == kMarkHu ? 4 : 0;
  std::string bytes, ints;
  for (const std::int16_t v : values) {
    bytes += static_cast<char>(v);
    ints += std::string{static_cast<char>(v), 0, 0, 0};
  }
  write_text(
      scratch / "uchar.nrrd",
      nrrd_header(lattice, "left-posterior-superior", {1, 1, 1}, "uchar", "encoding: raw\n\n") + bytes);
  NiftiSpec spec;
  spec.datatype = 8;
  write_text(scratch / "int32.nii", nifti_header(lattice, spec) + ints);
  write_text(scratch / "short.mha", meta_header(lattice) + bytes_of(values));
  for (const char* name : {"uchar.nrrd", "int32.nii", "short.mha"}) {
    Context context;
    ReadScanOptions options;
    options.labels = true;
    const auto scan = read_scan(scratch / name, options, context);
    ASSERT_TRUE(scan) << scan.error().message();
    EXPECT_TRUE(context.notices().empty()) << name << ": labels are not Hounsfield units";
    const VoxelGrid grid = voxels_of(scan->hu, label(4, 25));
    EXPECT_LT(distance(middle_of(grid), kMark), 0.2) << name;
    EXPECT_NEAR(volume_of(grid), 0.8 * 1.1 * 2.5, 0.15 * 2.2) << name;
  }
}

TEST(LabelMaps, OfTiltedStacksAreNotBlended) {
  scan_io::StoredVolume stored;
  stored.size = {20, 24, 12}, stored.axes = {Vec3{1, 0, 0}, Vec3{0, 1, 0}, Vec3{0, 0.35, 1}};
  stored.voxels.assign(scan_io::voxel_count(stored.size), 1000);
  for (std::size_t v = 0; v < stored.voxels.size(); v += 2) stored.voxels[v] = 2;
  Context context;
  const auto scan = scan_io::to_canonical(stored, "tilted", context, true);
  ASSERT_TRUE(scan) << scan.error().message();
  for (const std::int16_t v : scan->hu.voxels) ASSERT_TRUE(v == 0 || v == 2 || v == 1000) << v;
  stored.losses.clamped = 1;
  const auto lost = scan_io::to_canonical(stored, "many", context, true);
  ASSERT_FALSE(lost);
  EXPECT_NE(lost.error().message().find("Renumber"), std::string::npos);
}

}  // namespace
}  // namespace turgor
