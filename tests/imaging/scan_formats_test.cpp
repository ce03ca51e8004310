// What the file formats may hold, and what they must not: types, byte orders, encodings, detached data, bad
// headers.
#include <sys/resource.h>
#include <sys/stat.h>

#include "imaging/scan_format_files.hpp"
#include "turgor/core/parallel.hpp"

namespace turgor {
namespace {
using namespace scan_test;
namespace fs = std::filesystem;

const std::array<Vec3, 3> kPlain{Vec3{0.8, 0, 0}, Vec3{0, 1.1, 0}, Vec3{0, 0, 2.5}};
const Lattice kLattice = lattice_with_mark(kPlain);

std::string error_of(const std::filesystem::path& path) {
  const auto scan = read(path);
  return scan ? "no error" : scan.error().message();
}

::testing::AssertionResult contains(const std::string& text, const std::string& part) {
  if (text.find(part) != std::string::npos) return ::testing::AssertionSuccess();
  return ::testing::AssertionFailure() << '"' << text << "\" does not hold \"" << part << '"';
}

/// Raw bytes of the marked volume in another number type.
template <class T>
std::string typed_bytes(double slope, double intercept, bool big_endian) {
  std::string out;
  for (const std::int16_t hu : marked_voxels(kLattice.size)) {
    const T value = static_cast<T>((hu - intercept) / slope);
    char raw[sizeof(T)];
    std::memcpy(raw, &value, sizeof(T));
    if (big_endian) std::reverse(raw, raw + sizeof(T));
    out.append(raw, sizeof(T));
  }
  return out;
}

template <class T>
void expect_nifti_type(std::int16_t code) {
  const Scratch scratch;
  for (const bool big : {false, true}) {
    // Slopes and intercepts that put air and the mark into the range of each type.
    NiftiSpec spec{big, false, code, 12.5F, std::is_signed_v<T> ? 0.0F : -1000.0F};
    if (sizeof(T) == 1 && std::is_signed_v<T>) spec.slope = 20;
    write_text(scratch / "a.nii", nifti_header(kLattice, spec) +
                                      typed_bytes<T>(double{spec.slope}, double{spec.intercept}, big));
    const auto scan = read(scratch / "a.nii");
    ASSERT_TRUE(scan) << scan.error().message();
    expect_mark(*scan);
  }
}

TEST(Nifti, ReadsEveryScalarTypeInBothByteOrders) {
  expect_nifti_type<std::uint8_t>(2);
  expect_nifti_type<std::int16_t>(4);
  expect_nifti_type<std::int32_t>(8);
  expect_nifti_type<float>(16);
  expect_nifti_type<double>(64);
  expect_nifti_type<std::int8_t>(256);
  expect_nifti_type<std::uint16_t>(512);
  expect_nifti_type<std::uint32_t>(768);
  expect_nifti_type<std::int64_t>(1024);
  expect_nifti_type<std::uint64_t>(1280);
}

TEST(Nifti, ReadsPairsByEitherName) {
  const Scratch scratch;
  NiftiSpec spec;
  spec.magic = "ni1";
  write_text(scratch / "a.hdr", nifti_header(kLattice, spec).substr(0, 348));
  EXPECT_TRUE(contains(error_of(scratch / "a.hdr"), "no .img file"));
  write_text(scratch / "a.img", bytes_of(marked_voxels(kLattice.size)));
  for (const char* name : {"a.hdr", "a.img"}) {
    const auto scan = read(scratch / name);
    ASSERT_TRUE(scan) << scan.error().message();
    expect_mark(*scan);
  }
}

TEST(Nifti, ReadsVersionTwo) {
  const Scratch scratch;
  BinaryHeader h(544, false);
  h.put<std::int32_t>(0, 540);
  h.put_text(4, "n+2");
  h.put<std::int16_t>(12, 4);
  h.put<std::int64_t>(16, 3);
  for (std::size_t n = 0; n < 3; ++n) h.put<std::int64_t>(24 + 8 * n, kLattice.size[n]);
  h.put<std::int64_t>(168, 544);
  h.put<std::int32_t>(348, 1);
  for (int n = 0; n < 3; ++n) {
    const double sign = n < 2 ? -1 : 1;
    const std::size_t row = 400 + 32 * static_cast<std::size_t>(n);
    for (std::size_t a = 0; a < 3; ++a) h.put<double>(row + 8 * a, sign * kLattice.axes[a][n]);
    h.put<double>(row + 24, sign * kLattice.origin[n]);
  }
  h.put<std::int32_t>(500, 2);
  write_text(scratch / "a.nii", h.bytes() + bytes_of(marked_voxels(kLattice.size)));
  const auto scan = read(scratch / "a.nii");
  ASSERT_TRUE(scan) << scan.error().message();
  expect_mark(*scan);
}

TEST(Nifti, MetresAndMicrometresBecomeMillimetres) {
  const Scratch scratch;
  for (const auto& [unit, scale] : {std::pair{1, 1e-3}, {3, 1e3}}) {
    Lattice l = kLattice;
    l.origin *= scale;
    for (Vec3& axis : l.axes) axis *= scale;
    std::string header = nifti_header(l);
    header[123] = static_cast<char>(unit);
    write_text(scratch / "a.nii", header + bytes_of(marked_voxels(l.size)));
    const auto scan = read(scratch / "a.nii");
    ASSERT_TRUE(scan) << scan.error().message();
    expect_mark(*scan);
  }
}

TEST(Nifti, SaysWhatCannotBeUsed) {
  const Scratch scratch;
  const std::string good = nifti_header(kLattice), data = bytes_of(marked_voxels(kLattice.size));
  const auto with = [&](std::size_t at, std::int16_t value) {
    std::string header = good;
    std::memcpy(header.data() + at, &value, sizeof value);
    write_text(scratch / "a.nii", header + data);
    return error_of(scratch / "a.nii");
  };
  EXPECT_TRUE(contains(with(70, 128), "NIfTI type 128"));
  EXPECT_TRUE(contains(with(40, 2), "has 2 dimensions"));
  EXPECT_TRUE(contains(with(42, -5), "is not positive"));
  EXPECT_TRUE(contains(with(42, 20000), "fewer voxels"));
  EXPECT_TRUE(contains(with(42, 32767), "fewer voxels"));
  std::string four = good;
  four[40] = 4;
  four[48] = 30;
  write_text(scratch / "a.nii", four + data);
  EXPECT_TRUE(contains(error_of(scratch / "a.nii"), "holds 30 volumes"));
  std::string analyze = good;
  analyze.replace(344, 4, std::string(4, '\0'));
  write_text(scratch / "a.hdr", analyze);
  EXPECT_TRUE(contains(error_of(scratch / "a.hdr"), "Analyze 7.5"));
  write_text(scratch / "noise.nii", std::string(5000, '\x5a'));
  EXPECT_TRUE(contains(error_of(scratch / "noise.nii"), "is not a NIfTI file"));
}

TEST(Nifti, HugeSizesEndInAnErrorWithoutMemory) {
  const Scratch scratch;
  Lattice l = kLattice;
  l.size = {32767, 32767, 32767};
  write_text(scratch / "a.nii", nifti_header(l));
  EXPECT_TRUE(contains(error_of(scratch / "a.nii"), "beyond the 4 Gi voxels"));
  l.size = {32767, 32767, 4};  // allowed, but the file is far too small to hold it
  write_text(scratch / "a.nii.gz", gzip(nifti_header(l)));
  EXPECT_TRUE(contains(error_of(scratch / "a.nii.gz"), "fewer voxels"));
}

TEST(Values, BeyondSixteenBitsAreClampedAndNotNumbersBecomeAir) {
  const Scratch scratch;
  std::vector<float> values;
  for (const std::int16_t v : marked_voxels(kLattice.size)) values.push_back(v);
  values[0] = 1e9F, values[1] = -1e30F, values[2] = 40000;
  values[3] = std::numeric_limits<float>::quiet_NaN(), values[4] = std::numeric_limits<float>::infinity();
  const NiftiSpec spec{false, false, 16};
  write_text(scratch / "a.nii",
             nifti_header(kLattice, spec) +
                 std::string(reinterpret_cast<const char*>(values.data()), values.size() * 4));
  Context context;
  const auto scan = read_scan(scratch / "a.nii", {}, context);
  ASSERT_TRUE(scan) << scan.error().message();
  // The lattice is stored along (L, P, S), so voxel order is kept.
  EXPECT_EQ(scan->hu.voxels[0], 32767);
  EXPECT_EQ(scan->hu.voxels[1], -32768);
  EXPECT_EQ(scan->hu.voxels[2], 32767);
  EXPECT_EQ(scan->hu.voxels[3], -1024);
  EXPECT_EQ(scan->hu.voxels[4], -1024);
  std::string all;
  for (const Notice& notice : context.notices()) all += notice.text + "\n";
  EXPECT_TRUE(contains(all, "3 voxels lie beyond"));
  EXPECT_TRUE(contains(all, "2 voxels are not numbers"));
}

TEST(Values, DoubtfulHounsfieldUnitsAreTold) {
  const Scratch scratch;
  write_text(scratch / "a.nrrd",
             nrrd_header(kLattice) + "\n" + bytes_of(std::vector<std::int16_t>(9 * 11 * 7, 0)));
  Context context;
  ASSERT_TRUE(read_scan(scratch / "a.nrrd", {}, context));
  std::string all;
  for (const Notice& notice : context.notices()) all += notice.text + "\n";
  EXPECT_TRUE(contains(all, "may not be Hounsfield units"));
  EXPECT_TRUE(contains(all, "does not state the modality"));
}

TEST(Nrrd, ReadsItsEncodings) {
  const Scratch scratch;
  const auto voxels = marked_voxels(kLattice.size);
  std::string ascii;
  for (const std::int16_t v : voxels) ascii += std::to_string(v) + (ascii.size() % 3 == 0 ? "\n" : " ");
  const auto header = [](const std::string& rest, const std::string& type = "short") {
    return nrrd_header(kLattice, "left-posterior-superior", {1, 1, 1}, type, rest) + "\n";
  };
  const std::vector<std::string> files{
      header("endian: little\nencoding: gzip\n") + gzip(bytes_of(voxels)),
      header("endian: big\nencoding: raw\n") + bytes_of(voxels, true),
      header("encoding: ascii\n") + ascii,
      header("encoding: ascii\n", "double") + ascii,
      header("encoding: raw\nendian: little\nline skip: 2\nbyte skip: 3\n") + "one\ntwo\nabc" +
          bytes_of(voxels),
      header("encoding: raw\nendian: little\nbyte skip: -1\n") + "any junk" + bytes_of(voxels),
      header("encoding: gz\nendian: little\nbyteskip: 4\n") + gzip("junk" + bytes_of(voxels)),
      header("encoding: raw\nendian: little\nmodality:=CT\n", "signed short int") + bytes_of(voxels)};
  for (const std::string& file : files) {
    SCOPED_TRACE(file.substr(0, 500));
    write_text(scratch / "a.nrrd", file);
    const auto scan = read(scratch / "a.nrrd");
    ASSERT_TRUE(scan) << scan.error().message();
    expect_mark(*scan);
  }
}

TEST(Nrrd, ReadsDetachedDataBesideTheHeader) {
  const Scratch scratch;
  const std::string rest = "endian: little\nencoding: gzip\ndata file: a.raw.gz\n";
  write_text(scratch / "a.nhdr", nrrd_header(kLattice, "LPS", {1, 1, 1}, "int16", rest));
  EXPECT_TRUE(contains(error_of(scratch / "a.nhdr"), "a.raw.gz: no such file"));
  write_text(scratch / "a.raw.gz", gzip(bytes_of(marked_voxels(kLattice.size))));
  const auto scan = read(scratch / "a.nhdr");
  ASSERT_TRUE(scan) << scan.error().message();
  expect_mark(*scan);
}

TEST(Nrrd, ReadsAFourthAxisOfOneSample) {
  const Scratch scratch;
  std::string header = nrrd_header(kLattice);
  header.replace(header.find("dimension: 3"), 12, "dimension: 4");
  header.replace(header.find("sizes: "), 7, "sizes: 1 ");
  header.replace(header.find("space directions: "), 18, "space directions: none ");
  write_text(scratch / "a.nrrd", header + "\n" + bytes_of(marked_voxels(kLattice.size)));
  const auto scan = read(scratch / "a.nrrd");
  ASSERT_TRUE(scan) << scan.error().message();
  expect_mark(*scan);
  header.replace(header.find("sizes: 1"), 8, "sizes: 3");
  write_text(scratch / "a.nrrd", header + "\n" + bytes_of(marked_voxels(kLattice.size)));
  EXPECT_TRUE(contains(error_of(scratch / "a.nrrd"), "3 values for each voxel"));
}

TEST(Nrrd, SpacingsWithoutDirectionsAreTakenAlongLps) {
  const Scratch scratch;
  write_text(scratch / "a.nrrd",
             "NRRD0001\ntype: short\ndimension: 3\nsizes: 9 11 7\nspacings: 0.8 1.1 2.5\nendian: little\n"
             "encoding: raw\n\n" +
                 bytes_of(marked_voxels(kLattice.size)));
  const auto scan = read(scratch / "a.nrrd");
  ASSERT_TRUE(scan) << scan.error().message();
  EXPECT_EQ(scan->hu.grid.spacing, (Vec3{0.8, 1.1, 2.5}));
  EXPECT_EQ(scan->hu.at(2, 7, 4), kMarkHu);
}

TEST(Nrrd, SaysWhatCannotBeUsed) {
  const Scratch scratch;
  const std::string data = bytes_of(marked_voxels(kLattice.size));
  const auto with = [&](const std::string& old, const std::string& fresh) {
    std::string header = nrrd_header(kLattice);
    header.replace(header.find(old), old.size(), fresh);
    write_text(scratch / "a.nrrd", header + "\n" + data);
    return error_of(scratch / "a.nrrd");
  };
  EXPECT_TRUE(contains(with("type: int16", "type: block"), "type \"block\""));
  EXPECT_TRUE(contains(with("encoding: raw", "encoding: bzip2"), "encoding \"bzip2\""));
  EXPECT_TRUE(contains(with("sizes: 9 11 7", "sizes: 9 11"), "no three sizes"));
  EXPECT_TRUE(contains(with("sizes: 9 11 7", "sizes: 9 11 x"), "no three sizes"));
  EXPECT_TRUE(contains(with("sizes: 9 11 7", "sizes: 9 11 8"), "fewer voxels"));
  EXPECT_TRUE(contains(with("sizes: 9 11 7", "sizes: 900000 900000 900000"), "beyond the 4 Gi voxels"));
  EXPECT_TRUE(contains(with("sizes: 9 11 7", "sizes: 9999999999999999999 1 1"), "no three sizes"));
  EXPECT_TRUE(contains(with("space directions: (", "space directions: (nan,"), "not vectors"));
  EXPECT_TRUE(contains(with("endian: little", "x: y"), "byte order"));
  EXPECT_TRUE(contains(with("endian: little", "no colon here"), "line 10"));
  EXPECT_TRUE(
      contains(with("endian: little", "endian: little\ndata file: a%03d.raw 1 7 1"), "several files"));
  write_text(scratch / "a.nrrd", nrrd_header(kLattice));
  EXPECT_TRUE(contains(error_of(scratch / "a.nrrd"), "cut short within its header"));
}

TEST(Nrrd, CompressedWritingIsTheSameOnAnyNumberOfThreadsAndReadsBack) {
  const Scratch scratch;
  CtVolume volume = busy_volume({200, 150, 60});  // several compressed parts
  set_thread_count(1);
  ASSERT_TRUE(write_nrrd(scratch / "a.nrrd", volume));
  set_thread_count(2);
  ASSERT_TRUE(write_nrrd(scratch / "b.nrrd", volume));
  set_thread_count(0);
  EXPECT_EQ(read_text(scratch / "a.nrrd"), read_text(scratch / "b.nrrd"));
  const auto scan = read(scratch / "a.nrrd");
  ASSERT_TRUE(scan) << scan.error().message();
  expect_same(scan->hu, volume, 1e-9);
  LabelVolume labels(volume.grid, 3);
  labels.at(5, 6, 7) = 9;
  ASSERT_TRUE(write_nrrd(scratch / "l.nrrd", labels));
  const auto read_labels = read(scratch / "l.nrrd");
  ASSERT_TRUE(read_labels);
  EXPECT_EQ(read_labels->hu.at(5, 6, 7), 9);
  EXPECT_EQ(read_labels->hu.at(0, 0, 0), 3);
  Volume<float> thickness(volume.grid, 2.0F);
  thickness.at(1, 2, 3) = 7.4F;
  ASSERT_TRUE(write_nrrd(scratch / "t.nrrd", thickness));
  const auto read_thickness = read(scratch / "t.nrrd");
  ASSERT_TRUE(read_thickness);
  EXPECT_EQ(read_thickness->hu.at(1, 2, 3), 7);
}

TEST(MetaImage, ReadsItsEncodings) {
  const Scratch scratch;
  const auto voxels = marked_voxels(kLattice.size);
  std::string ascii;
  for (const std::int16_t v : voxels) ascii += std::to_string(v) + " ";
  std::string msb = meta_header(kLattice);
  msb.replace(msb.find("MSB = False"), 11, "MSB = True");
  std::string text = meta_header(kLattice);
  text.replace(text.find("BinaryData = True"), 17, "BinaryData = False");
  const std::vector<std::string> files{
      meta_header(kLattice) + bytes_of(voxels),
      meta_header(kLattice, "CompressedData = True\n") + gzip(bytes_of(voxels)), msb + bytes_of(voxels, true),
      text + ascii};
  for (const std::string& file : files) {
    write_text(scratch / "a.mha", file);
    const auto scan = read(scratch / "a.mha");
    ASSERT_TRUE(scan) << scan.error().message();
    expect_mark(*scan);
  }
}

TEST(MetaImage, ReadsDetachedData) {
  const Scratch scratch;
  write_text(scratch / "a.mhd", meta_header(kLattice, "HeaderSize = -1\nModality = MET_MOD_CT\n", "a.raw"));
  write_text(scratch / "a.raw", "a header of its own" + bytes_of(marked_voxels(kLattice.size)));
  const auto scan = read(scratch / "a.mhd");
  ASSERT_TRUE(scan) << scan.error().message();
  expect_mark(*scan);
  EXPECT_EQ(scan->info.modality, "CT");
}

TEST(MetaImage, SaysWhatCannotBeUsed) {
  const Scratch scratch;
  const std::string data = bytes_of(marked_voxels(kLattice.size));
  const auto with = [&](const std::string& old, const std::string& fresh) {
    std::string header = meta_header(kLattice);
    header.replace(header.find(old), old.size(), fresh);
    write_text(scratch / "a.mha", header + data);
    return error_of(scratch / "a.mha");
  };
  EXPECT_TRUE(contains(with("MET_SHORT", "MET_OTHER"), "type \"MET_OTHER\""));
  EXPECT_TRUE(contains(with("DimSize = 9 11 7", "DimSize = 9 11"), "no three sizes"));
  EXPECT_TRUE(contains(with("DimSize = 9 11 7", "DimSize = 9 11 8"), "fewer voxels"));
  EXPECT_TRUE(contains(with("ObjectType = Image\n", "ObjectType = Image\nElementNumberOfChannels = 3\n"),
                       "3 values for each voxel"));
  EXPECT_TRUE(contains(with("= LOCAL", "= LIST"), "several files"));
  EXPECT_TRUE(contains(with("= LOCAL", "= none.raw"), "none.raw: no such file"));
  EXPECT_TRUE(contains(with("TransformMatrix = ", "TransformMatrix = 1 "), "not 9 numbers"));
  EXPECT_TRUE(contains(with("ElementDataFile = LOCAL\n", ""), "its header"));
}

TEST(Inv3, ReadsTheArrayWhereverItLiesInTheArchive) {
  const Scratch scratch;
  const std::string plist = inv3_plist(kLattice.size, {0.8, 1.1, 2.5});
  for (const bool first : {true, false}) {
    write_text(scratch / "a.inv3", inv3_file(plist, bytes_of(marked_voxels(kLattice.size)), first));
    const auto scan = read(scratch / "a.inv3");
    ASSERT_TRUE(scan) << scan.error().message();
    EXPECT_EQ(scan->hu.at(2, 3, 4), kMarkHu);
    EXPECT_EQ(scan->info.patient, "TEST 1");
  }
}

TEST(Inv3, SaysWhatCannotBeUsed) {
  const Scratch scratch;
  const std::string data = bytes_of(marked_voxels(kLattice.size));
  const auto error_with = [&](const std::string& file) {
    write_text(scratch / "a.inv3", file);
    return error_of(scratch / "a.inv3");
  };
  const std::string plist = inv3_plist(kLattice.size, {0.8, 1.1, 2.5});
  EXPECT_TRUE(contains(error_with("not an archive at all"), "not an InVesalius project"));
  EXPECT_TRUE(contains(error_with(gzip(tar_member("x/matrix.dat", data))), "no main.plist"));
  EXPECT_TRUE(contains(error_with(gzip(tar_member("x/main.plist", plist) + std::string(1024, '\0'))),
                       "no matrix.dat"));
  EXPECT_TRUE(contains(error_with(inv3_file(plist, data.substr(2))), "shorter than its shape"));
  EXPECT_TRUE(contains(error_with(inv3_file(plist, data + "xx")), "longer than its shape"));
  EXPECT_TRUE(contains(error_with(inv3_file("<plist><dict>", data)), "main.plist is damaged"));
  EXPECT_TRUE(
      contains(error_with(inv3_file(inv3_plist({90000, 90000, 90000}, {1, 1, 1}), data)), "4 Gi voxels"));
}

TEST(Scan, SaysWhenThereIsNothingToRead) {
  const Scratch scratch;
  EXPECT_TRUE(contains(error_of(scratch / "none"), "no such file or folder"));
  EXPECT_TRUE(contains(error_of(scratch.path()), "holds no DICOM images"));
  write_text(scratch / "empty.nii", "");
  EXPECT_TRUE(contains(error_of(scratch / "empty.nii"), "is empty"));
  write_text(scratch / "notes.txt", "These are notes about a patient, and no scan.");
  EXPECT_TRUE(contains(error_of(scratch / "notes.txt"), "not a scan in a format known here"));
  EXPECT_TRUE(contains(error_of(scratch.path()), "Name the file itself"));
}

TEST(Scan, EmptyFilesOfEveryNameAreCalledEmpty) {
  const Scratch scratch;
  for (const char* name : {"a.dcm", "a.img", "a.hdr", "a.nii", "a.nii.gz", "a.nrrd", "a.nhdr", "a.mha",
                           "a.mhd", "a.inv3", "a"}) {
    write_text(scratch / name, "");
    EXPECT_TRUE(contains(error_of(scratch / name), "is empty")) << name;
    Context context;
    const auto series = list_series(scratch / name, context);
    ASSERT_FALSE(series) << name;
    EXPECT_TRUE(contains(series.error().message(), "is empty")) << name;
  }
}

TEST(Scan, PipesAndDevicesAreRefusedAndNotWaitedFor) {
  const Scratch scratch;
  const fs::path pipe = scratch / "pipe.nii";
  ASSERT_EQ(::mkfifo(pipe.c_str(), 0600), 0);
  EXPECT_TRUE(contains(error_of(pipe), "a pipe or a device"));
  EXPECT_TRUE(contains(error_of("/dev/zero"), "a pipe or a device"));
  write_text(scratch / "a.mhd", meta_header(kLattice, "CompressedData = False\n", "pipe.nii"));
  EXPECT_TRUE(contains(error_of(scratch / "a.mhd"), "pipe.nii: is a pipe or a device"));
}

TEST(Scan, LyingSizesOfEveryFormatEndInAnErrorWithoutMemory) {
  const Scratch scratch;
  Lattice l = kLattice;
  l.size = {60000, 60000, 1};  // seven gigabytes where the file holds a few
  std::string packed = nrrd_header(l);
  packed.replace(packed.find("encoding: raw"), 13, "encoding: gzip");
  write_text(scratch / "raw.nrrd", nrrd_header(l) + "\nabc");
  write_text(scratch / "packed.nrrd", packed + "\n" + gzip("abc"));
  write_text(scratch / "raw.mha", meta_header(l) + "abc");
  write_text(scratch / "packed.mha", meta_header(l, "CompressedData = True\n") + gzip("abc"));
  const auto most_held_kb = [] {
    rusage used{};
    return ::getrusage(RUSAGE_SELF, &used) == 0 ? used.ru_maxrss : -1;
  };
  const long before = most_held_kb();
  for (const char* name : {"raw.nrrd", "packed.nrrd", "raw.mha", "packed.mha"}) {
    EXPECT_TRUE(contains(error_of(scratch / name), "fewer voxels")) << name;
  }
  EXPECT_GE(before, 0);
  EXPECT_LT(most_held_kb() - before, 100'000);
}

TEST(Scan, StopsOnRequest) {
  const Scratch scratch;
  write_text(scratch / "a.nrrd", nrrd_header(kLattice) + "\n" + bytes_of(marked_voxels(kLattice.size)));
  Context context({}, {}, [] { return true; });
  const auto scan = read_scan(scratch / "a.nrrd", {}, context);
  ASSERT_FALSE(scan);
  EXPECT_EQ(scan.error().kind, ErrorKind::cancelled);
}

}  // namespace
}  // namespace turgor
