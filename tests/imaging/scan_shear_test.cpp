// Stacks whose axes are not at right angles (gantry tilt, sheared affine matrices).
#include "imaging/scan/stored_volume.hpp"

#include <algorithm>

#include "imaging/scan_support.hpp"
#include "turgor/core/parallel.hpp"

namespace turgor {
namespace {
using namespace scan_test;
using scan_io::StoredVolume;

double field(const Vec3& p) {
  return 4 * p.x - 3 * p.y + 2.5 * p.z;
}

/// A linear field sampled on sheared axes: trilinear interpolation reproduces it but for rounding.
StoredVolume sheared_field(const std::array<Vec3, 3>& axes, const Index3& size = {40, 36, 24}) {
  StoredVolume stored;
  stored.size = size;
  stored.axes = axes;
  stored.origin = {5, -7, 11};
  for (int k = 0; k < size[2]; ++k) {
    for (int j = 0; j < size[1]; ++j) {
      for (int i = 0; i < size[0]; ++i) {
        const Vec3 p = stored.origin + axes[0] * i + axes[1] * j + axes[2] * k;
        stored.voxels.push_back(
            static_cast<std::int16_t>(std::clamp(std::floor(field(p) + 0.5), -32768.0, 32767.0)));
      }
    }
  }
  return stored;
}

/// Checks every voxel of the result: the field where it lies inside the stored stack, air outside.
void expect_field(const Scan& scan, const StoredVolume& stored, int slack = 1) {
  const Mat3 axes{{stored.axes[0], stored.axes[1], stored.axes[2]}};
  const Mat3 inverse = axes.inverse();
  const Grid& grid = scan.hu.grid;
  EXPECT_NEAR(grid.direction.determinant(), 1, 1e-9);
  std::size_t inside = 0;
  for (int k = 0; k < grid.size[2]; ++k) {
    for (int j = 0; j < grid.size[1]; ++j) {
      for (int i = 0; i < grid.size[0]; ++i) {
        const Vec3 p = grid.to_patient({double(i), double(j), double(k)});
        const Vec3 at = inverse * (p - stored.origin);
        double out = -1e9;
        for (int a = 0; a < 3; ++a) {
          out = std::max({out, -at[a], at[a] - (stored.size[static_cast<std::size_t>(a)] - 1)});
        }
        if (out < -1e-3) {
          ++inside;
          ASSERT_NEAR(scan.hu.at(i, j, k), field(p), slack) << i << ' ' << j << ' ' << k;
        } else if (out > 1e-3) {
          ASSERT_EQ(scan.hu.at(i, j, k), scan_io::kAirHu) << i << ' ' << j << ' ' << k;
        }
      }
    }
  }
  EXPECT_GT(inside, stored.voxels.size() * 6 / 10);
}

TEST(Shear, TiltedSlicesAreSlidIntoPlace) {
  const double tilt = radians(18);
  // Slices tilted about x; the stack runs along z.
  const std::array<Vec3, 3> axes{Vec3{0.5, 0, 0}, Vec3{0, 0.5 * std::cos(tilt), 0.5 * std::sin(tilt)},
                                 Vec3{0, 0, 1.25}};
  const StoredVolume stored = sheared_field(axes);
  Context context;
  const auto scan = to_canonical(stored, "tilt", context);
  ASSERT_TRUE(scan) << scan.error().message();
  expect_field(*scan, stored);
  EXPECT_EQ(scan->hu.grid.size[2], stored.size[2]) << "slices must not be blended with each other";
  EXPECT_NEAR(scan->hu.grid.spacing.z, 1.25 * std::cos(tilt), 1e-12);
}

TEST(Shear, HoldsForMirroredAndGeneralShear) {
  const Mat3 turn = rotation(normalized(Vec3{1, 2, -1}), 0.4);
  for (const double mirror : {1.0, -1.0}) {
    const std::array<Vec3, 3> axes{turn * Vec3{0.7, 0, 0}, turn * Vec3{0.2, 0.8, 0},
                                   turn * Vec3{-0.15, 0.3, mirror}};
    const StoredVolume stored = sheared_field(axes);
    Context context;
    const auto scan = to_canonical(stored, "shear", context);
    ASSERT_TRUE(scan) << scan.error().message();
    EXPECT_EQ(scan->info.stored_left_handed, mirror < 0);
    expect_field(*scan, stored, 2);
  }
}

TEST(Shear, GivesTheSameBitsOnOneAndTwoThreads) {
  const std::array<Vec3, 3> axes{Vec3{0.5, 0, 0}, Vec3{0, 0.5, 0}, Vec3{0.1, 0.3, 1}};
  const auto run = [&](int threads) {
    set_thread_count(threads);
    Context context;
    auto scan = to_canonical(sheared_field(axes), "shear", context);
    set_thread_count(0);
    return scan->hu.voxels;
  };
  EXPECT_EQ(run(1), run(2));
}

TEST(Shear, RoundedDirectionsCountAsOrthogonal) {
  const std::array<Vec3, 3> axes{Vec3{0.5, 1e-6, 0}, Vec3{0, 0.5, -1e-6}, Vec3{1e-6, 0, 1}};
  const StoredVolume stored = sheared_field(axes);
  Context context;
  const auto scan = to_canonical(stored, "rounded", context);
  ASSERT_TRUE(scan);
  EXPECT_EQ(scan->hu.voxels, stored.voxels);
  EXPECT_NEAR(dot(scan->hu.grid.direction.c[0], scan->hu.grid.direction.c[2]), 0, 1e-15);
}

TEST(Shear, RefusesAxesThatCannotHoldAVolume) {
  const auto error_for = [](const std::array<Vec3, 3>& axes, const Index3& size = {4, 4, 4}) {
    Context context;
    const auto scan = to_canonical(sheared_field(axes, size), "bad.nrrd", context);
    return scan ? std::string() : scan.error().message();
  };
  const Vec3 x{1, 0, 0}, y{0, 1, 0}, z{0, 0, 1};
  EXPECT_NE(error_for({x, y, x + z * 0.1}).find("nearly parallel"), std::string::npos);
  EXPECT_NE(error_for({x, y, Vec3{}}).find("spacing along axis 3 is 0 mm"), std::string::npos);
  EXPECT_NE(error_for({x, y, z * 5000}).find("spacing"), std::string::npos);
  EXPECT_NE(error_for({x, y, z}, {1, 1, 1}).find("1 × 1 × 1"), std::string::npos);
  EXPECT_NE(error_for({x, y, z}, {4, 4, 1}).find("not a volume"), std::string::npos);
}

}  // namespace
}  // namespace turgor
