// Every reader on systematically damaged files: cut at each length, and with bytes changed. A value or an
// error, never a crash; a value must be a proper volume, an error a full sentence.
#include "imaging/scan_dicom_files.hpp"
#include "turgor/core/random.hpp"

namespace turgor {
namespace {
using namespace scan_test;
namespace fs = std::filesystem;

const std::array<Vec3, 3> kAxes{Vec3{0.8, 0.1, 0}, Vec3{-0.1, 0.8, 0}, Vec3{0, 0, 2.5}};

Lattice small_lattice() {
  Lattice lattice = lattice_with_mark(kAxes, {1, 2, 1});
  lattice.size = {6, 4, 3};
  return lattice;
}
std::vector<std::int16_t> small_voxels() {
  return marked_voxels({6, 4, 3}, {1, 2, 1});
}

/// True where a volume came out.
bool expect_value_or_error(const fs::path& path) {
  Context context;
  const auto scan = read_scan(path, {}, context);
  if (!scan) {
    EXPECT_FALSE(scan.error().what.empty());
    EXPECT_FALSE(scan.error().where.empty());
    EXPECT_FALSE(scan.error().remedy.empty()) << scan.error().message();
    return false;
  }
  const Grid& grid = scan->hu.grid;
  EXPECT_EQ(scan->hu.voxels.size(), grid.voxel_count());
  EXPECT_LT(grid.voxel_count(), 1'000'000U);
  EXPECT_NEAR(grid.direction.determinant(), 1, 1e-6);
  EXPECT_TRUE(is_finite(grid.origin));
  for (int a = 0; a < 3; ++a) EXPECT_GT(grid.spacing[a], 0);
  return true;
}

/// Damages `whole` in place at `file` and reads `scan` each time.
void damage(const fs::path& file, const fs::path& scan, const std::string& whole, std::size_t step = 1) {
  write_text(file, whole);
  ASSERT_TRUE(expect_value_or_error(scan)) << "the whole file must read";
  for (std::size_t length = 0; length < whole.size(); length += step) {
    SCOPED_TRACE("cut at " + std::to_string(length));
    write_text(file, whole.substr(0, length));
    expect_value_or_error(scan);
  }
  const RandomStream random(20240607);
  std::uint64_t draw = 0;
  const auto pick = [&](std::size_t n) { return static_cast<std::size_t>(random.bits(draw++) % n); };
  for (int round = 0; round < 1500; ++round) {
    SCOPED_TRACE("round " + std::to_string(round));
    std::string changed = whole;
    const std::size_t count = 1 + pick(4);
    for (std::size_t n = 0; n < count; ++n) {
      // Headers are where the damage is worst.
      const std::size_t at =
          pick(round % 2 == 0 ? changed.size() : std::min<std::size_t>(changed.size(), 600));
      static constexpr std::array<int, 6> values{0, 0xFF, 0x7F, 0x80, '9', ' '};
      changed[at] =
          static_cast<char>(pick(2) == 0 ? values[pick(values.size())] : static_cast<int>(pick(256)));
    }
    write_text(file, changed);
    expect_value_or_error(scan);
  }
}

TEST(Damage, Nrrd) {
  const Scratch scratch;
  damage(scratch / "a.nrrd", scratch / "a.nrrd",
         nrrd_header(small_lattice()) + "\n" + bytes_of(small_voxels()));
}

TEST(Damage, NrrdCompressed) {
  const Scratch scratch;
  std::string header = nrrd_header(small_lattice());
  header.replace(header.find("encoding: raw"), 13, "encoding: gzip");
  damage(scratch / "a.nrrd", scratch / "a.nrrd", header + "\n" + gzip(bytes_of(small_voxels())));
}

TEST(Damage, Nifti) {
  const Scratch scratch;
  const std::string whole = nifti_header(small_lattice()) + bytes_of(small_voxels());
  damage(scratch / "a.nii", scratch / "a.nii", whole);
  damage(scratch / "a.nii.gz", scratch / "a.nii.gz", gzip(whole));
}

TEST(Damage, MetaImage) {
  const Scratch scratch;
  damage(scratch / "a.mha", scratch / "a.mha", meta_header(small_lattice()) + bytes_of(small_voxels()));
  damage(scratch / "b.mha", scratch / "b.mha",
         meta_header(small_lattice(), "CompressedData = True\n") + gzip(bytes_of(small_voxels())));
}

TEST(Damage, Inv3) {
  const Scratch scratch;
  const std::string plist = inv3_plist({6, 4, 3}, {0.8, 0.8, 2.5});
  damage(scratch / "a.inv3", scratch / "a.inv3", inv3_file(plist, bytes_of(small_voxels())));
  // The same with the archive open to the damage; the readers take plain tar archives as well.
  const std::string tar =
      tar_member("t/main.plist", plist) + tar_member("t/matrix.dat", bytes_of(small_voxels()));
  damage(scratch / "b.inv3", scratch / "b.inv3", tar + std::string(1024, '\0'), 7);
}

class DamagedDicom : public ::testing::TestWithParam<gdcm::TransferSyntax::TSType> {};

TEST_P(DamagedDicom, IsSkippedOrRefused) {
  const Scratch scratch;
  Lattice lattice = lattice_with_mark(kAxes, {1, 2, 0});
  lattice.size = {12, 8, 3};
  const auto edit = [](int k, DicomSpec& spec) {
    spec.syntax = GetParam();
    // Texture, so that the coders have something to code.
    std::vector<std::int16_t> values;
    for (std::uint64_t n = 0; n < 96; ++n) {
      values.push_back(
          static_cast<std::int16_t>(RandomStream(5).bits(n + 96 * static_cast<std::uint64_t>(k)) % 4096));
    }
    spec.is_signed = false, spec.stored = 12, spec.intercept = "-1024";
    spec.pixels = bytes_of(values);
  };
  write_series(scratch.path(), lattice, edit);
  damage(scratch / "2.dcm", scratch.path(), read_text(scratch / "2.dcm"));
}

INSTANTIATE_TEST_SUITE_P(TransferSyntaxes, DamagedDicom,
                         ::testing::Values(gdcm::TransferSyntax::ExplicitVRLittleEndian,
                                           gdcm::TransferSyntax::ImplicitVRLittleEndian,
                                           gdcm::TransferSyntax::DeflatedExplicitVRLittleEndian,
                                           gdcm::TransferSyntax::RLELossless,
                                           gdcm::TransferSyntax::JPEGLosslessProcess14_1,
                                           gdcm::TransferSyntax::JPEGLSLossless,
                                           gdcm::TransferSyntax::JPEG2000Lossless),
                         [](const auto& info) { return "Syntax" + std::to_string(info.index); });

}  // namespace
}  // namespace turgor
