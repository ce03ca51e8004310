// Asymmetric volumes with one marked place, scratch folders and helpers shared by the scan tests.
#pragma once

#include <gtest/gtest.h>

#include <unistd.h>

#include <array>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include "turgor/core/context.hpp"
#include "turgor/imaging/scan.hpp"

namespace turgor::scan_test {

/// A folder of its own for each test, removed at the end.
class Scratch {
 public:
  explicit Scratch(const std::string& label = {}) {
    const auto* test = ::testing::UnitTest::GetInstance()->current_test_info();
    std::string name = std::string(test->test_suite_name()) + "." + test->name();
    for (char& c : name) c = c == '/' ? '_' : c;
    // In memory where there is such a place: the damage tests write thousands of small files.
    std::filesystem::path root = "/dev/shm";
    if (::access(root.c_str(), W_OK) != 0) root = ::testing::TempDir();
    path_ = root / ("turgor_" + std::to_string(::getpid()) + name + label);
    std::filesystem::remove_all(path_);
    std::filesystem::create_directories(path_);
  }
  Scratch(const Scratch&) = delete;
  Scratch& operator=(const Scratch&) = delete;
  ~Scratch() {
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
  }
  std::filesystem::path operator/(const std::string& name) const { return path_ / name; }
  [[nodiscard]] const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
};

/// The patient point that every test volume marks, and its Hounsfield value; all else is air.
inline constexpr Vec3 kMark{11.0, -23.0, 37.0};
inline constexpr std::int16_t kMarkHu = 1500;

/// Stored lattice: patient point of (i, j, k) = origin + i axes[0] + j axes[1] + k axes[2], LPS mm.
struct Lattice {
  Index3 size{9, 11, 7};
  Vec3 origin{};
  std::array<Vec3, 3> axes{};
  Index3 mark{2, 7, 4};  ///< the voxel at kMark
};

/// A lattice along `axes` that has kMark at its voxel `at`.
inline Lattice lattice_with_mark(const std::array<Vec3, 3>& axes, const Index3& at = {2, 7, 4}) {
  Lattice lattice;
  lattice.axes = axes;
  lattice.mark = at;
  lattice.origin = kMark - axes[0] * at[0] - axes[1] * at[1] - axes[2] * at[2];
  return lattice;
}

/// Air, but for the mark at voxel `at`: i fastest.
inline std::vector<std::int16_t> marked_voxels(const Index3& size, const Index3& at = {2, 7, 4}) {
  std::vector<std::int16_t> voxels(static_cast<std::size_t>(size[0] * size[1] * size[2]), -1000);
  voxels[static_cast<std::size_t>((at[2] * size[1] + at[1]) * size[0] + at[0])] = kMarkHu;
  return voxels;
}

/// Canonical axes, and the mark where it belongs and nowhere else.
inline void expect_mark(const Scan& scan, double tolerance_mm = 1e-3) {
  const Grid& grid = scan.hu.grid;
  EXPECT_NEAR(grid.direction.determinant(), 1.0, 1e-9);
  for (int a = 0; a < 3; ++a) {
    for (int b = 0; b < 3; ++b) {
      EXPECT_NEAR(
          dot(grid.direction.c[static_cast<std::size_t>(a)], grid.direction.c[static_cast<std::size_t>(b)]),
          a == b ? 1.0 : 0.0, 1e-9);
    }
    EXPECT_GT(grid.direction.c[static_cast<std::size_t>(a)][a], 0.5);
  }
  ASSERT_EQ(scan.hu.voxels.size(), grid.voxel_count());
  int bright = 0, astray = 0;
  for (int k = 0; k < grid.size[2]; ++k) {
    for (int j = 0; j < grid.size[1]; ++j) {
      for (int i = 0; i < grid.size[0]; ++i) {
        if (scan.hu.at(i, j, k) < 0) continue;
        ++bright;
        if (distance(grid.to_patient({double(i), double(j), double(k)}), kMark) >= tolerance_mm ||
            scan.hu.at(i, j, k) != kMarkHu) {
          ++astray;
        }
      }
    }
  }
  EXPECT_EQ(bright, 1);
  EXPECT_EQ(astray, 0);
  EXPECT_NEAR(scan.hu.sample(kMark), kMarkHu, 2600 * tolerance_mm + 1e-3);
}

inline Result<Scan> read(const std::filesystem::path& path, const std::string& series = {}) {
  Context context;
  return read_scan(path, {series}, context);
}

/// Values that differ from voxel to voxel, on an oblique grid.
inline CtVolume busy_volume(const Index3& size = {13, 9, 6}) {
  Grid grid;
  grid.size = size;
  grid.spacing = {0.75, 1.25, 2.0};
  grid.origin = {-20.5, 31.25, -100};
  grid.direction = rotation(normalized(Vec3{1, 2, 3}), 0.3);
  CtVolume volume(grid);
  for (std::size_t n = 0; n < volume.voxels.size(); ++n) {
    volume.voxels[n] = static_cast<std::int16_t>(static_cast<int>(n * 7919 % 4000) - 1024);
  }
  return volume;
}

/// Same size and values; same place within `tolerance`.
inline void expect_same(const CtVolume& a, const CtVolume& b, double tolerance = 1e-5) {
  ASSERT_EQ(a.grid.size, b.grid.size);
  EXPECT_EQ(a.voxels, b.voxels);
  const Vec3 last{a.grid.size[0] - 1.0, a.grid.size[1] - 1.0, a.grid.size[2] - 1.0};
  for (const Vec3& index : {Vec3{}, last, Vec3{last.x, 0, 0}, Vec3{0, last.y, 0}, Vec3{0, 0, last.z}}) {
    EXPECT_LT(distance(a.grid.to_patient(index), b.grid.to_patient(index)), tolerance);
  }
}

inline void write_text(const std::filesystem::path& path, const std::string& text) {
  std::ofstream(path, std::ios::binary) << text;
}

inline std::string read_text(const std::filesystem::path& path) {
  std::ifstream in(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

/// Axes of every kind: canonical, each patient axis along each array axis, both handednesses, oblique.
inline std::vector<std::array<Vec3, 3>> all_axes() {
  const Vec3 spacing{0.8, 1.1, 2.5};
  std::vector<std::array<Vec3, 3>> all;
  for (const auto& order : {std::array{0, 1, 2}, {1, 2, 0}, {2, 0, 1}, {0, 2, 1}, {1, 0, 2}, {2, 1, 0}}) {
    for (int signs = 0; signs < 8; ++signs) {
      for (const double tilt : {0.0, 0.35}) {
        const Mat3 turn = rotation(normalized(Vec3{1, -2, 0.5}), tilt);
        std::array<Vec3, 3> axes{};
        for (int a = 0; a < 3; ++a) {
          Vec3 unit{};
          unit[order[static_cast<std::size_t>(a)]] = (signs >> a & 1) != 0 ? -1 : 1;
          axes[static_cast<std::size_t>(a)] = turn * unit * spacing[a];
        }
        all.push_back(axes);
      }
    }
  }
  return all;
}

}  // namespace turgor::scan_test
