#include <gdcmTrace.h>
#include <sys/stat.h>

#include <algorithm>

#include "imaging/scan_dicom_files.hpp"
#include "turgor/core/file.hpp"
#include "turgor/core/parallel.hpp"
#include "turgor/core/random.hpp"

namespace turgor {
namespace {
using namespace scan_test;
namespace fs = std::filesystem;

const std::array<Vec3, 3> kAxial{Vec3{0.8, 0, 0}, Vec3{0, 1.1, 0}, Vec3{0, 0, 2.5}};
const Lattice kLattice = lattice_with_mark(kAxial);

void write(const fs::path& folder, const CtVolume& hu, const DicomWriteOptions& options = {}) {
  Context context;
  const auto written = write_dicom_series(folder, hu, options, context);
  ASSERT_TRUE(written) << written.error().message();
}

std::string error_of(const fs::path& path, const std::string& series = {}) {
  const auto scan = read(path, series);
  return scan ? "no error" : scan.error().message();
}

::testing::AssertionResult contains(const std::string& text, const std::string& part) {
  if (text.find(part) != std::string::npos) return ::testing::AssertionSuccess();
  return ::testing::AssertionFailure() << '"' << text << "\" does not hold \"" << part << '"';
}

/// Reads the folder and expects the mark in its place.
void expect_readable(const fs::path& path, std::size_t skipped = 0) {
  const auto scan = read(path);
  ASSERT_TRUE(scan) << scan.error().message();
  expect_mark(*scan);
  EXPECT_EQ(scan->info.skipped_files.size(), skipped);
}

TEST(Dicom, OurFilesReadInGdcmWithTheSameValuesAndPlace) {
  const Scratch scratch;
  const CtVolume volume = busy_volume();
  write(scratch.path(), volume);
  gdcm::ImageReader reader;
  const std::string name = (scratch / "IM0003.dcm").string();
  reader.SetFileName(name.c_str());
  ASSERT_TRUE(reader.Read());
  const gdcm::Image& image = reader.GetImage();
  ASSERT_EQ(image.GetDimension(0), 13U);
  ASSERT_EQ(image.GetDimension(1), 9U);
  EXPECT_EQ(image.GetIntercept(), -1024);
  EXPECT_EQ(image.GetSlope(), 1);
  EXPECT_NEAR(image.GetSpacing(0), 0.75, 1e-12);
  EXPECT_NEAR(image.GetSpacing(1), 1.25, 1e-12);
  const Vec3 place = volume.grid.to_patient({0, 0, 2});
  for (int n = 0; n < 3; ++n) {
    EXPECT_NEAR(image.GetOrigin(static_cast<unsigned>(n)), place[n], 1e-9);
    EXPECT_NEAR(image.GetDirectionCosines(static_cast<unsigned>(n)), volume.grid.direction.c[0][n], 1e-12);
    EXPECT_NEAR(image.GetDirectionCosines(static_cast<unsigned>(3 + n)), volume.grid.direction.c[1][n],
                1e-12);
  }
  std::vector<std::uint16_t> pixels(image.GetBufferLength() / 2);
  ASSERT_TRUE(image.GetBuffer(reinterpret_cast<char*>(pixels.data())));
  for (std::size_t n = 0; n < pixels.size(); ++n) {
    ASSERT_EQ(pixels[n] - 1024, volume.voxels[2 * 13 * 9 + n]);
  }
}

TEST(Dicom, OurFilesHoldWhatCtImageStorageRequires) {
  const Scratch scratch;
  write(scratch.path(), busy_volume());
  gdcm::Reader reader;
  const std::string name = (scratch / "IM0001.dcm").string();
  reader.SetFileName(name.c_str());
  ASSERT_TRUE(reader.Read());
  const gdcm::DataSet& set = reader.GetFile().GetDataSet();
  // Type 1 attributes of the modules of PS3.3 table A.3-1, and the type 2 ones that viewers ask for.
  const std::vector<std::uint32_t> required{
      0x00080008, 0x00080016, 0x00080018, 0x00080060, 0x00100010, 0x00100020, 0x00180050, 0x00180060,
      0x0020000D, 0x0020000E, 0x00200010, 0x00200011, 0x00200012, 0x00200013, 0x00200032, 0x00200037,
      0x00200052, 0x00280002, 0x00280004, 0x00280010, 0x00280011, 0x00280030, 0x00280100, 0x00280101,
      0x00280102, 0x00280103, 0x00281052, 0x00281053, 0x7FE00010};
  for (const std::uint32_t tag : required) {
    const gdcm::Tag t(static_cast<std::uint16_t>(tag >> 16), static_cast<std::uint16_t>(tag & 0xFFFF));
    ASSERT_TRUE(set.FindDataElement(t)) << t;
    EXPECT_FALSE(set.GetDataElement(t).IsEmpty()) << t;
  }
}

TEST(Dicom, RoundTripKeepsValuesAndPlace) {
  const Scratch scratch;
  CtVolume volume = busy_volume();
  for (const bool below_minus_1024 : {false, true}) {
    if (below_minus_1024) volume.voxels[5] = -3000, volume.voxels[6] = 32767;
    write(scratch.path(), volume);
    const auto scan = read(scratch.path());
    ASSERT_TRUE(scan) << scan.error().message();
    expect_same(scan->hu, volume, 1e-9);
    EXPECT_EQ(scan->info.modality, "CT");
    EXPECT_EQ(scan->info.patient, "Phantom^Turgor");
    EXPECT_EQ(scan->info.gantry_tilt_deg, 0);
    EXPECT_FALSE(scan->info.stored_left_handed);
  }
}

TEST(Dicom, WritesTheSameBytesAgainAndOtherUidsForOtherContent) {
  const Scratch scratch;
  const CtVolume volume = busy_volume();
  set_thread_count(1);
  write(scratch / "a", volume);
  set_thread_count(2);
  write(scratch / "b", volume);
  set_thread_count(0);
  CtVolume other = volume;
  other.voxels[100] += 1;
  write(scratch / "c", other);
  DicomWriteOptions options;
  options.seed = 1;
  write(scratch / "d", volume, options);
  EXPECT_EQ(read_text(scratch / "a/IM0004.dcm"), read_text(scratch / "b/IM0004.dcm"));
  std::vector<std::string> uids;
  for (const char* name : {"a", "b", "c", "d"}) {
    Context context;
    const auto list = list_series(scratch / name, context);
    ASSERT_TRUE(list);
    ASSERT_EQ(list->size(), 1U);
    EXPECT_EQ(list->front().slices, 6);
    uids.push_back(list->front().uid);
  }
  EXPECT_EQ(uids[0], uids[1]);
  EXPECT_NE(uids[0], uids[2]);
  EXPECT_NE(uids[0], uids[3]);
}

TEST(Dicom, FindsTheMarkOnSlicesOfEveryOrientation) {
  for (const auto& axes : all_axes()) {
    const Scratch scratch;
    SCOPED_TRACE(vector_text(axes[0]) + vector_text(axes[1]) + vector_text(axes[2]));
    const Lattice lattice = lattice_with_mark(axes);
    write_series(scratch.path(), lattice);
    const auto scan = read(scratch.path());
    ASSERT_TRUE(scan) << scan.error().message();
    expect_mark(*scan);
  }
}

TEST(Dicom, OneFileStandsForItsSeries) {
  const Scratch scratch;
  write_series(scratch.path(), kLattice);
  DicomSpec other;
  other.series = "9.9.9";
  other.pixels = std::string(9 * 11 * 2, '\0');
  write_dicom(scratch / "other.dcm", other);
  expect_readable(scratch / "3.dcm");
  EXPECT_TRUE(contains(error_of(scratch / "other.dcm"), "one slice only"));
}

TEST(Dicom, ReadsEveryUncompressedTransferSyntax) {
  using TS = gdcm::TransferSyntax;
  for (const auto syntax : {TS::ImplicitVRLittleEndian, TS::ExplicitVRLittleEndian, TS::ExplicitVRBigEndian,
                            TS::DeflatedExplicitVRLittleEndian}) {
    SCOPED_TRACE(TS::GetTSString(syntax));
    const Scratch scratch;
    write_series(scratch.path(), kLattice, [&](int, DicomSpec& spec) { spec.syntax = syntax; });
    const auto scan = read(scratch.path());
    ASSERT_TRUE(scan) << scan.error().message();
    expect_mark(*scan);
  }
}

TEST(Dicom, ReadsCompressedTransferSyntaxes) {
  using TS = gdcm::TransferSyntax;
  gdcm::Trace::WarningOff();
  for (const auto syntax : {TS::RLELossless, TS::JPEGLosslessProcess14, TS::JPEGLosslessProcess14_1,
                            TS::JPEGLSLossless, TS::JPEG2000Lossless}) {
    SCOPED_TRACE(TS::GetTSString(syntax));
    const Scratch scratch;
    Lattice lattice = kLattice;
    write_series(scratch.path(), lattice, [&](int, DicomSpec& spec) {
      spec.syntax = syntax;
      spec.is_signed = false;
      spec.intercept = "-1024";
      std::vector<std::int16_t> stored(spec.pixels.size() / 2);
      std::memcpy(stored.data(), spec.pixels.data(), spec.pixels.size());
      for (auto& v : stored) v = static_cast<std::int16_t>(v + 1024);
      spec.pixels = bytes_of(stored);
    });
    expect_readable(scratch.path());
  }
}

TEST(Dicom, ReadsCompressedSignedAndEightBitSlices) {
  using TS = gdcm::TransferSyntax;
  for (const auto syntax : {TS::RLELossless, TS::JPEGLSLossless, TS::JPEG2000Lossless}) {
    SCOPED_TRACE(TS::GetTSString(syntax));
    const Scratch words;
    write_series(words.path(), kLattice, [&](int, DicomSpec& spec) { spec.syntax = syntax; });
    expect_readable(words.path());
    const Scratch bytes("bytes");
    Lattice even = kLattice;  // GDCM's coders do not take an odd number of bytes
    even.size[0] = 10;
    write_series(bytes.path(), even, [&](int, DicomSpec& spec) {
      spec.syntax = syntax;
      spec.allocated = spec.stored = 8;
      spec.is_signed = false;
      spec.slope = "12.5", spec.intercept = "-1000";
      std::string narrow;
      for (std::size_t n = 0; n < spec.pixels.size(); n += 2) {
        std::int16_t v = 0;
        std::memcpy(&v, spec.pixels.data() + n, 2);
        narrow += static_cast<char>(v == kMarkHu ? 200 : 0);
      }
      spec.pixels = narrow;
    });
    expect_readable(bytes.path());
  }
}

TEST(Dicom, HonoursStoredBitsAndSign) {
  const Scratch scratch;
  // 12 bits stored, two's complement, with rubbish in the four bits above.
  write_series(scratch.path(), kLattice, [](int k, DicomSpec& spec) {
    spec.stored = 12;
    for (std::size_t n = 1; n < spec.pixels.size(); n += 2) {
      spec.pixels[n] = static_cast<char>((spec.pixels[n] & 0x0F) | ((k * 16) & 0xF0));
    }
  });
  expect_readable(scratch.path());
}

TEST(Dicom, AppliesSlopeAndInterceptOfEachSlice) {
  const Scratch scratch;
  write_series(scratch.path(), kLattice, [](int k, DicomSpec& spec) {
    const int slope = k % 2 + 1, intercept = -100 * k;
    spec.slope = std::to_string(slope), spec.intercept = std::to_string(intercept);
    std::vector<std::int16_t> stored(spec.pixels.size() / 2);
    std::memcpy(stored.data(), spec.pixels.data(), spec.pixels.size());
    for (auto& v : stored) v = static_cast<std::int16_t>((v - intercept) / slope);
    spec.pixels = bytes_of(stored);
  });
  expect_readable(scratch.path());
}

TEST(Dicom, PaddingBelowAirBecomesAir) {
  const Scratch scratch;
  write_series(scratch.path(), kLattice, [](int, DicomSpec& spec) {
    const std::int16_t padding = -2000;
    spec.intercept = "-1024";
    std::vector<std::int16_t> stored(spec.pixels.size() / 2);
    std::memcpy(stored.data(), spec.pixels.data(), spec.pixels.size());
    for (auto& v : stored) v = static_cast<std::int16_t>(v + 1024);
    stored[0] = padding;
    spec.pixels = bytes_of(stored);
    spec.edit = [=](gdcm::DataSet& set) {
      put(set, 0x0028, 0x0120, "SS", std::string(reinterpret_cast<const char*>(&padding), 2));
    };
  });
  const auto scan = read(scratch.path());
  ASSERT_TRUE(scan) << scan.error().message();
  EXPECT_EQ(scan->hu.at(0, 0, 0), -1024);
  expect_mark(*scan);
}

/// A linear field on slices tilted by `tilt_deg` about x, 0.8 × 1.1 × 2 mm.
void write_tilted(const fs::path& folder, double tilt_deg, const std::function<double(const Vec3&)>& field) {
  const double t = radians(tilt_deg);
  const Lattice lattice{{24, 30, 12},
                        {3, -5, 8},
                        {Vec3{0.8, 0, 0}, Vec3{0, std::cos(t), std::sin(t)} * 1.1, {0, 0, 2}},
                        {0, 0, 0}};
  write_series(folder, lattice, [&](int k, DicomSpec& spec) {
    std::vector<std::int16_t> values;
    for (int j = 0; j < 30; ++j) {
      for (int i = 0; i < 24; ++i) {
        const Vec3 p = lattice.origin + lattice.axes[0] * i + lattice.axes[1] * j + lattice.axes[2] * k;
        values.push_back(static_cast<std::int16_t>(std::floor(field(p) + 0.5)));
      }
    }
    spec.pixels = bytes_of(values);
  });
}

TEST(Dicom, GantryTiltIsReportedAndUndone) {
  const Scratch scratch;
  const auto field = [](const Vec3& p) { return 5 * p.x - 7 * p.y + 6 * p.z; };
  write_tilted(scratch.path(), -14, field);
  const auto scan = read(scratch.path());
  ASSERT_TRUE(scan) << scan.error().message();
  EXPECT_NEAR(scan->info.gantry_tilt_deg, 14, 1e-3);
  const Grid& grid = scan->hu.grid;
  EXPECT_NEAR(dot(grid.direction.c[1], grid.direction.c[2]), 0, 1e-12);
  EXPECT_EQ(grid.size[2], 12);
  int checked = 0;
  for (int k = 0; k < grid.size[2]; ++k) {
    for (int j = 0; j < grid.size[1]; ++j) {
      for (int i = 0; i < grid.size[0]; ++i) {
        if (scan->hu.at(i, j, k) == -1024) continue;
        ++checked;
        ASSERT_NEAR(scan->hu.at(i, j, k), field(grid.to_patient({double(i), double(j), double(k)})), 1.0);
      }
    }
  }
  EXPECT_GT(checked, 24 * 29 * 12 * 9 / 10);
}

TEST(Dicom, TakesTheLargestCtOrTheOneNamed) {
  const Scratch scratch;
  fs::create_directories(scratch / "big");
  fs::create_directories(scratch / "small");
  fs::create_directories(scratch / "mr");
  Lattice small = kLattice;
  small.size[2] = 5;
  small.origin -= small.axes[2] * 0;
  write_series(scratch / "small", small,
               [](int, DicomSpec& s) { s.series = "1.5.77", s.description = "bone"; });
  write_series(scratch / "big", kLattice,
               [](int, DicomSpec& s) { s.series = "1.5.78", s.description = "soft"; });
  Lattice longer = kLattice;
  longer.size[2] = 12;
  write_series(scratch / "mr", longer, [](int, DicomSpec& s) { s.series = "1.5.9", s.modality = "MR"; });
  Context context;
  const auto list = list_series(scratch.path(), context);
  ASSERT_TRUE(list);
  ASSERT_EQ(list->size(), 3U);
  EXPECT_EQ((*list)[0].uid, "1.5.78");
  EXPECT_EQ((*list)[1].uid, "1.5.77");
  EXPECT_EQ((*list)[2].modality, "MR");
  const auto size_of = [&](const std::string& series) {
    const auto scan = read(scratch.path(), series);
    return scan ? scan->hu.grid.size[2] : 0;
  };
  EXPECT_EQ(size_of(""), 7);
  EXPECT_EQ(size_of("1.5.77"), 5);
  EXPECT_EQ(size_of("77"), 5);
  EXPECT_EQ(size_of("bone"), 5);
  EXPECT_EQ(size_of("1.5.9"), 12);
  EXPECT_TRUE(contains(error_of(scratch.path(), "1.5.7"), "several series that match"));
  EXPECT_TRUE(contains(error_of(scratch.path(), "brain"), "no series \"brain\""));
  EXPECT_TRUE(contains(error_of(scratch / "mr"), "no CT series"));
}

TEST(Dicom, LocalizersOfASeriesAreLeftOut) {
  const Scratch scratch;
  write_series(scratch.path(), kLattice);
  DicomSpec scout;
  scout.image_type = "ORIGINAL\\PRIMARY\\LOCALIZER";
  scout.column = {0, 0, -1};
  scout.instance = "1.2.3.4.99";
  scout.pixels = std::string(9 * 11 * 2, '\0');
  write_dicom(scratch / "scout.dcm", scout);
  expect_readable(scratch.path());
}

TEST(Dicom, OtherFilesAreSkippedWithAWarning) {
  const Scratch scratch;
  write_series(scratch.path(), kLattice);
  write_text(scratch / "README.txt", "notes");
  write_text(scratch / "cut.dcm", read_text(scratch / "2.dcm").substr(0, 300));
  std::string noise;
  for (int n = 0; n < 5000; ++n)
    noise += static_cast<char>(RandomStream(3).bits(static_cast<std::uint64_t>(n)));
  write_text(scratch / "encrypted.dcm", noise);
  write_text(scratch / "DICOMDIR", "passed over without a word");
  Context context;
  const auto scan = read_scan(scratch.path(), {}, context);
  ASSERT_TRUE(scan) << scan.error().message();
  expect_mark(*scan);
  EXPECT_EQ(scan->info.skipped_files.size(), 3U);
  const auto notices = context.notices();
  ASSERT_EQ(notices.size(), 1U);
  EXPECT_EQ(notices[0].severity, Severity::warning);
  EXPECT_TRUE(contains(notices[0].text, "3 file(s) skipped"));
  EXPECT_TRUE(contains(notices[0].text, "cut.dcm (is cut short or damaged)"));
  EXPECT_TRUE(contains(notices[0].text, "encrypted.dcm (is not a DICOM file)"));
}

TEST(Dicom, ADamagedLastSliceIsSkippedAndAMissingMiddleOneIsNot) {
  const Scratch scratch;
  const auto jpeg2000 = [](int, DicomSpec& s) { s.syntax = gdcm::TransferSyntax::JPEG2000Lossless; };
  write_series(scratch.path(), kLattice, jpeg2000);
  const auto cut = [&](const std::string& name) {
    const std::string whole = read_text(scratch / name);
    write_text(scratch / name, whole.substr(0, whole.size() - 40));
  };
  cut("6.dcm");
  const auto scan = read(scratch.path());
  ASSERT_TRUE(scan) << scan.error().message();
  EXPECT_EQ(scan->hu.grid.size[2], 6);
  expect_mark(*scan);
  EXPECT_EQ(scan->info.skipped_files.size(), 1U);
  cut("1.dcm");
  EXPECT_TRUE(contains(error_of(scratch.path()), "lacks 1 slice(s) between 0.dcm and 2.dcm"));
  EXPECT_TRUE(contains(error_of(scratch.path()), "skipped because it is cut short"));
}

TEST(Dicom, PipesDevicesAndLinksToNothingAmongSlicesAreSkipped) {
  const Scratch scratch;
  write_series(scratch.path(), kLattice);
  ASSERT_EQ(::mkfifo((scratch / "pipe.dcm").c_str(), 0600), 0);
  fs::create_symlink("/dev/zero", scratch / "zero.dcm");
  fs::create_symlink(scratch / "nowhere", scratch / "lost.dcm");
  fs::create_directory_symlink(scratch.path(), scratch / "again");
  Context context;
  const auto scan = read_scan(scratch.path(), {}, context);
  ASSERT_TRUE(scan) << scan.error().message();
  expect_mark(*scan);
  EXPECT_EQ(scan->info.skipped_files.size(), 3U);
  ASSERT_EQ(context.notices().size(), 1U);
  EXPECT_TRUE(contains(context.notices()[0].text, "lost.dcm (cannot be read)"));
}

TEST(Dicom, ADestroyedSliceIsNamedAsTheCauseOfTheGap) {
  const Scratch scratch;
  write_series(scratch.path(), kLattice);
  write_text(scratch / "README.txt", "notes");
  for (const std::string& content : {std::string(), std::string(5000, '\x5a')}) {
    write_text(scratch / "3.dcm", content);
    const std::string error = error_of(scratch.path());
    EXPECT_TRUE(contains(error, "lacks 1 slice(s) between 2.dcm and 4.dcm"));
    EXPECT_TRUE(contains(error, "3.dcm was skipped because it is not a DICOM file")) << error;
  }
}

TEST(Dicom, DoubleSlicesOfOneNameAreToldApartByTheirFolders) {
  const Scratch scratch;
  write_series(scratch.path(), kLattice);
  fs::create_directory(scratch / "copy");
  fs::copy_file(scratch / "3.dcm", scratch / "copy/3.dcm");
  const std::string error = error_of(scratch.path());
  EXPECT_TRUE(contains(error, (scratch / "3.dcm").string())) << error;
  EXPECT_TRUE(contains(error, (scratch / "copy/3.dcm").string())) << error;
}

TEST(Dicom, NamesMissingDoubleAndMixedSlices) {
  const auto error_with = [](const std::function<void(int, DicomSpec&)>& edit,
                             const std::string& remove = {}) {
    const Scratch scratch;
    write_series(scratch.path(), kLattice, edit);
    if (!remove.empty()) fs::remove(scratch / remove);
    return error_of(scratch.path());
  };
  EXPECT_TRUE(contains(error_with({}, "3.dcm"), "lacks 1 slice(s) between 2.dcm and 4.dcm"));
  EXPECT_TRUE(contains(error_with([](int k, DicomSpec& s) {
                         if (k == 3) s.position.z -= 2.5;
                       }),
                       "two slices at one place (2.dcm and 3.dcm)"));
  EXPECT_TRUE(contains(error_with([](int k, DicomSpec& s) {
                         if (k == 3) s.position.z -= 1.0;
                       }),
                       "unevenly spaced"));
  EXPECT_TRUE(contains(error_with([](int k, DicomSpec& s) {
                         if (k == 3) s.position.x += 1.0;
                       }),
                       "shifted against"));
  EXPECT_TRUE(contains(error_with([](int k, DicomSpec& s) {
                         if (k == 3) s.rows = 10;
                       }),
                       "mixes slices of 9 × 11 voxels (0.dcm) and 9 × 10 (3.dcm)"));
  EXPECT_TRUE(contains(error_with([](int k, DicomSpec& s) {
                         if (k == 3) s.row_spacing = 1.2;
                       }),
                       "pixel spacing"));
  EXPECT_TRUE(contains(error_with([](int k, DicomSpec& s) {
                         if (k == 3) s.row = {0, 0, 1};
                       }),
                       "orientation"));
}

TEST(Dicom, RefusesFilesWithoutPlaceOrPixels) {
  const auto error_with = [](std::uint16_t group, std::uint16_t element) {
    const Scratch scratch;
    write_series(scratch.path(), kLattice, [&](int, DicomSpec& s) {
      s.edit = [=](gdcm::DataSet& set) { set.Remove(gdcm::Tag(group, element)); };
    });
    return error_of(scratch.path());
  };
  EXPECT_TRUE(contains(error_with(0x0020, 0x0032), "no position and orientation"));
  EXPECT_TRUE(contains(error_with(0x0028, 0x0030), "no pixel spacing"));
  EXPECT_TRUE(contains(error_with(0x0028, 0x0010), "holds no image"));
  EXPECT_TRUE(contains(error_with(0x7FE0, 0x0010), "holds no pixels"));
}

TEST(Dicom, ALyingSizeAsksForNoMemory) {
  const Scratch scratch;
  write_series(scratch.path(), kLattice, [](int, DicomSpec& s) { s.rows = s.columns = 65535; });
  EXPECT_TRUE(contains(error_of(scratch.path()), "holds fewer pixels than its image size"));
}

/// The marked volume as one enhanced multi-frame file.
void write_multi_frame(const fs::path& path, const Lattice& lattice) {
  DicomSpec spec;
  spec.columns = lattice.size[0], spec.rows = lattice.size[1];
  spec.pixels = bytes_of(marked_voxels(lattice.size));
  spec.edit = [&](gdcm::DataSet& set) {
    set.Remove(gdcm::Tag(0x0020, 0x0032));
    set.Remove(gdcm::Tag(0x0020, 0x0037));
    set.Remove(gdcm::Tag(0x0028, 0x0030));
    put(set, 0x0008, 0x0016, "UI", "1.2.840.10008.5.1.4.1.1.2.1");
    put(set, 0x0028, 0x0008, "IS", std::to_string(lattice.size[2]));
    gdcm::DataSet orientation, measures, rescale, shared;
    put(orientation, 0x0020, 0x0037, "DS",
        ds(normalized(lattice.axes[0])) + "\\" + ds(normalized(lattice.axes[1])));
    put(measures, 0x0028, 0x0030, "DS",
        fmt::format("{}\\{}", length(lattice.axes[1]), length(lattice.axes[0])));
    put(rescale, 0x0028, 0x1052, "DS", "0");
    put(rescale, 0x0028, 0x1053, "DS", "1");
    put_sequence(shared, 0x0020, 0x9116, {orientation});
    put_sequence(shared, 0x0028, 0x9110, {measures});
    put_sequence(shared, 0x0028, 0x9145, {rescale});
    put_sequence(set, 0x5200, 0x9229, {shared});
    std::vector<gdcm::DataSet> frames;
    for (int k = 0; k < lattice.size[2]; ++k) {
      gdcm::DataSet position, frame;
      put(position, 0x0020, 0x0032, "DS", ds(lattice.origin + lattice.axes[2] * k));
      put_sequence(frame, 0x0020, 0x9113, {position});
      frames.push_back(frame);
    }
    put_sequence(set, 0x5200, 0x9230, frames);
  };
  write_dicom(path, spec);
}

TEST(Dicom, ReadsEnhancedMultiFrameFiles) {
  const Scratch scratch;
  const Lattice oblique = lattice_with_mark(all_axes()[9]);
  write_multi_frame(scratch / "a.dcm", oblique);
  expect_readable(scratch.path());
  recode(scratch / "a.dcm", gdcm::TransferSyntax::RLELossless);
  expect_readable(scratch.path());
  recode(scratch / "a.dcm", gdcm::TransferSyntax::JPEGLSLossless);
  expect_readable(scratch / "a.dcm");
}

TEST(Dicom, MultiFrameWithoutPositionsIsRefused) {
  const Scratch scratch;
  DicomSpec spec;
  spec.pixels = bytes_of(marked_voxels(kLattice.size));
  spec.edit = [](gdcm::DataSet& set) { put(set, 0x0028, 0x0008, "IS", "7"); };
  write_dicom(scratch / "a.dcm", spec);
  EXPECT_TRUE(contains(error_of(scratch.path()), "7 frames without a position"));
}

TEST(Dicom, ReadsTheSameOnOneAndTwoThreadsAndInAnyFileOrder) {
  const Scratch scratch;
  const CtVolume volume = busy_volume({32, 30, 20});
  write(scratch.path(), volume);
  for (int k = 1; k <= 20; ++k) {  // names that sort otherwise than the slices
    fs::rename(scratch / fmt::format("IM{:04}.dcm", k), scratch / fmt::format("{:02}.dcm", k * 7 % 20));
  }
  for (const int threads : {1, 2}) {
    set_thread_count(threads);
    const auto scan = read(scratch.path());
    set_thread_count(0);
    ASSERT_TRUE(scan) << scan.error().message();
    expect_same(scan->hu, volume, 1e-9);
  }
}

TEST(Dicom, StopsOnRequestWhileReadingAndWriting) {
  const Scratch scratch;
  write(scratch.path(), busy_volume());
  Context stop({}, {}, [] { return true; });
  const auto scan = read_scan(scratch.path(), {}, stop);
  ASSERT_FALSE(scan);
  EXPECT_EQ(scan.error().kind, ErrorKind::cancelled);
  const auto written = write_dicom_series(scratch / "b", busy_volume(), {}, stop);
  ASSERT_FALSE(written);
  EXPECT_EQ(written.error().kind, ErrorKind::cancelled);
}

}  // namespace
}  // namespace turgor
