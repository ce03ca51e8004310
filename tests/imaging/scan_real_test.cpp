// The real head CT of the Debian package invesalius-examples.
#include <algorithm>

#include "imaging/scan_format_files.hpp"
#include "turgor/core/file.hpp"

namespace turgor {
namespace {
using namespace scan_test;
namespace fs = std::filesystem;

const fs::path kCranium = "/usr/share/doc/invesalius-examples/examples/Cranium.inv3";
#define SKIP_WITHOUT_CRANIUM() \
  if (!fs::exists(kCranium)) GTEST_SKIP() << "the Debian package invesalius-examples is not installed"

/// A member of the project's tar archive.
std::string archive_member(const std::string& name) {
  const auto packed = read_file(kCranium);
  if (!packed) return {};
  const auto tar = scan_io::inflate_bytes(*packed, std::size_t{1} << 30).bytes;
  const auto text = [&](std::size_t at, std::size_t size) {
    return std::string(reinterpret_cast<const char*>(tar.data()) + at, size);
  };
  for (std::size_t at = 0; at + 512 <= tar.size();) {
    const std::size_t size = std::strtoull(text(at + 124, 11).c_str(), nullptr, 8);
    const std::string path = text(at, 100).c_str();
    if (path.ends_with("/" + name)) return text(at + 512, size);
    at += 512 + (size + 511) / 512 * 512;
  }
  return {};
}

std::string base64(std::string_view text) {
  static const std::string digits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string out;
  unsigned held = 0;
  int bits = 0;
  for (const char c : text) {
    const auto digit = digits.find(c);
    if (digit == std::string::npos) break;
    held = held << 6 | static_cast<unsigned>(digit);
    if ((bits += 6) >= 8) out += static_cast<char>(held >> (bits -= 8) & 0xFF);
  }
  return out;
}

/// The points of a VTK XML surface: blocks of zlib behind a table of their sizes, each part in base64.
std::vector<Vec3> vtp_points(const std::string& xml) {
  std::size_t at = xml.find("Name=\"Points\"");
  at = xml.find_first_not_of(" \n", xml.find('>', at) + 1);
  const auto number = [](const std::string& bytes, std::size_t n) {
    std::uint32_t value = 0;
    std::memcpy(&value, bytes.data() + 4 * n, 4);
    return std::size_t{value};
  };
  const std::size_t blocks = number(base64(std::string_view(xml).substr(at, 8)), 0);
  const std::size_t head = (4 * (3 + blocks) + 2) / 3 * 4;
  const std::string sizes = base64(std::string_view(xml).substr(at, head));
  std::size_t packed_size = 0;
  for (std::size_t n = 0; n < blocks; ++n) packed_size += number(sizes, 3 + n);
  const std::string packed = base64(std::string_view(xml).substr(at + head, (packed_size + 2) / 3 * 4));
  std::vector<std::byte> plain;
  std::size_t start = 0;
  for (std::size_t n = 0; n < blocks; ++n) {
    const auto block = std::as_bytes(std::span(packed.data() + start, number(sizes, 3 + n)));
    const auto inflated = scan_io::inflate_bytes(block, number(sizes, 1)).bytes;
    plain.insert(plain.end(), inflated.begin(), inflated.end());
    start += block.size();
  }
  std::vector<Vec3> points(plain.size() / 12);
  for (std::size_t n = 0; n < points.size(); ++n) {
    Vec3f p;
    std::memcpy(&p, plain.data() + 12 * n, 12);
    points[n] = to_double(p);
  }
  return points;
}

TEST(RealScanFile, HasTheSizeAndValuesThatItsProjectStates) {
  SKIP_WITHOUT_CRANIUM();
  const auto scan = read(kCranium);
  ASSERT_TRUE(scan) << scan.error().message();
  EXPECT_EQ(scan->hu.grid.size, (Index3{256, 256, 108}));
  EXPECT_NEAR(scan->hu.grid.spacing.x, 0.9570312, 1e-6);
  EXPECT_NEAR(scan->hu.grid.spacing.z, 1.5, 1e-12);
  EXPECT_EQ(scan->hu.grid.direction.c, Mat3{}.c);
  EXPECT_EQ(scan->info.patient, "ProMED CT 0051");
  EXPECT_EQ(scan->info.modality, "CT");
  EXPECT_TRUE(scan->info.stored_left_handed);
  const auto [low, high] = std::minmax_element(scan->hu.voxels.begin(), scan->hu.voxels.end());
  EXPECT_EQ(*low, -1024);
  EXPECT_EQ(*high, 2986);
}

TEST(RealScanFile, TheProgramsOwnBoneSurfaceLiesOnItsLevel) {
  SKIP_WITHOUT_CRANIUM();
  const auto scan = read(kCranium);
  ASSERT_TRUE(scan) << scan.error().message();
  const auto points = vtp_points(archive_member("surface_0.vtp"));
  ASSERT_GT(points.size(), 50'000U);
  const Grid& grid = scan->hu.grid;
  const Vec3 first = grid.to_patient({0, 0, 0});
  const Vec3 last = grid.to_patient({255, 255, 107});
  // The median value at the surface, as read and with each axis mirrored.
  const auto median_with = [&](const std::array<bool, 3>& mirrored) {
    std::vector<double> values;
    for (std::size_t n = 0; n < points.size(); n += 17) {
      Vec3 p = points[n];
      for (int a = 0; a < 3; ++a) {
        if (mirrored[static_cast<std::size_t>(a)]) p[a] = first[a] + last[a] - p[a];
      }
      values.push_back(scan->hu.sample(p));
    }
    std::nth_element(values.begin(), values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2),
                     values.end());
    return values[values.size() / 2];
  };
  EXPECT_NEAR(median_with({false, false, false}), 226, 15);
  EXPECT_LT(median_with({true, false, false}), 130);
  EXPECT_LT(median_with({false, true, false}), 130);
  EXPECT_LT(median_with({false, false, true}), 130);
}

TEST(RealScanFile, FaceLooksForwardAndTheFrontalDefectIsOnTheRight) {
  SKIP_WITHOUT_CRANIUM();
  const auto scan = read(kCranium);
  ASSERT_TRUE(scan) << scan.error().message();
  // Rays from the front through the forehead above each eye: on the right the defect lets them through.
  const CtVolume& hu = scan->hu;
  std::array<int, 2> open{};  // right, left
  constexpr int middle = 131, from = 27, to = 41;
  for (int k = 60; k < 80; ++k) {
    for (int aside = from; aside < to; ++aside) {
      for (const bool left : {false, true}) {
        const int i = left ? middle + aside : middle - aside;
        bool bone = false;
        for (int j = 0; j < 128 && !bone; ++j) bone = hu.at(i, j, k) > 226;
        if (!bone) ++open[left ? 1 : 0];
      }
    }
  }
  EXPECT_GT(open[0], 250);
  EXPECT_EQ(open[1], 0);
}

TEST(RealScanFile, SurvivesDicomAndNrrd) {
  SKIP_WITHOUT_CRANIUM();
  const Scratch scratch;
  const auto scan = read(kCranium);
  ASSERT_TRUE(scan) << scan.error().message();
  Context context;
  ASSERT_TRUE(write_dicom_series(scratch / "dicom", scan->hu, {}, context));
  const auto dicom = read(scratch / "dicom");
  ASSERT_TRUE(dicom) << dicom.error().message();
  expect_same(dicom->hu, scan->hu, 1e-9);
  ASSERT_TRUE(write_nrrd(scratch / "a.nrrd", scan->hu));
  const auto nrrd = read(scratch / "a.nrrd");
  ASSERT_TRUE(nrrd) << nrrd.error().message();
  expect_same(nrrd->hu, scan->hu, 1e-9);
}

}  // namespace
}  // namespace turgor
