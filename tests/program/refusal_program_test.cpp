// Mistakes as a user makes them: one clear sentence for each, exit code 2, nothing written.
#include <sys/mount.h>
#include <sys/stat.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <functional>

#include "program/phantom_program.hpp"

namespace {
using namespace turgor_program;

/// Hounsfield units of a cube's voxels, by their place.
struct Cube {
  int size[3]{};
  double spacing_mm = 2;
  std::vector<std::int16_t> hu;

  void save(const fs::path& path) const {
    std::ofstream out(path, std::ios::binary);
    out << "NRRD0004\ntype: short\ndimension: 3\nspace: left-posterior-superior\nsizes: " << size[0] << ' '
        << size[1] << ' ' << size[2] << "\nspace directions: (" << spacing_mm << ",0,0) (0," << spacing_mm
        << ",0) (0,0," << spacing_mm << ")\nspace origin: (0,0,0)\nendian: little\nencoding: raw\n\n";
    out.write(reinterpret_cast<const char*>(hu.data()), static_cast<std::streamsize>(2 * hu.size()));
  }
};

/// A slice of the phantom as the program writes it: little endian, pixels last, air at 0.
Cube phantom_cube(const fs::path& series) {
  Cube cube;
  for (const fs::path& file : files_of(series)) {
    const std::string bytes = bytes_of(file);
    const auto number = [&](const char* tag) {
      std::uint16_t value = 0;
      std::memcpy(&value, bytes.data() + bytes.find(std::string(tag, 4) + "US") + 8, sizeof value);
      return int{value};
    };
    cube.size[0] = number("\x28\x00\x11\x00"), cube.size[1] = number("\x28\x00\x10\x00"), ++cube.size[2];
    const auto voxels = static_cast<std::size_t>(cube.size[0]) * static_cast<std::size_t>(cube.size[1]);
    const char* pixels = bytes.data() + bytes.size() - 2 * voxels;
    for (std::size_t n = 0; n < voxels; ++n) {
      std::uint16_t stored = 0;
      std::memcpy(&stored, pixels + 2 * n, sizeof stored);
      cube.hu.push_back(static_cast<std::int16_t>(stored - 1024));
    }
  }
  return cube;
}

// A copy of the phantom's series to damage.
fs::path copy_of_series(const std::string& name) {
  const fs::path copy = Program::root() / name;
  fs::copy(Program::dicom(), copy, fs::copy_options::recursive | fs::copy_options::overwrite_existing);
  return copy;
}

fs::path slice(const fs::path& folder, int from_middle) {
  const std::vector<fs::path> files = files_of(folder);
  return files[files.size() / 2 + static_cast<std::size_t>(from_middle)];
}

// The scan under that name, refused with `expected`, its file and a remedy.
void expect_unfit(const std::string& name, const Cube& cube, const std::string& expected) {
  SCOPED_TRACE(name);
  const std::string scan = Program::predict(Program::root() / name, Program::plan());
  cube.save(Program::root() / name);
  Program::expect_refusal(scan, name + ": ");
  Program::expect_refusal(scan, expected);
}

TEST_F(Program, MistakesWithPathsAndCommandsAreNamed) {
  expect_refusal(predict(root() / "nowhere", plan()), "no such");
  const fs::path empty = root() / "empty";
  fs::create_directories(empty);
  expect_refusal(predict(empty, plan()), empty.string());
  write(root() / "notes.txt", "not a scan");
  expect_refusal(predict(root() / "notes.txt", plan()), "notes.txt");
  write(root() / "bad.turgor", "; a comment\nsetbak -amount 6\n");
  expect_refusal(predict(dicom(), root() / "bad.turgor"), "bad.turgor:2:1");
  expect_refusal(predict(dicom(), root() / "bad.turgor"), "setback");
  expect_refusal("predikt x", "predict");
  expect_refusal("predict", "lacks SCAN");
}

TEST_F(Program, DamagedSeriesAreRefusedWithTheFileOrTheGap) {
  const fs::path gap = copy_of_series("gap");
  fs::remove(slice(gap, 0));
  expect_refusal(predict(gap, plan()), "lacks 1 slice");
  const fs::path cut = copy_of_series("cut");
  fs::resize_file(slice(cut, 0), fs::file_size(slice(cut, 0)) / 2);
  expect_refusal(predict(cut, plan()), slice(cut, 0).filename().string() + " was skipped because it is cut");
  const fs::path encrypted = copy_of_series("encrypted");
  write(slice(encrypted, 0), std::string(5000, '\x5a'));
  expect_refusal(predict(encrypted, plan()), slice(encrypted, 0).filename().string() + " was skipped");
  const fs::path twice = copy_of_series("twice");
  fs::copy(slice(twice, 0), twice / "again.dcm");
  expect_refusal(predict(twice, plan()), "two slices at one place");
  expect_refusal(predict(twice, plan()), "again.dcm");
  const fs::path mixed = copy_of_series("sizes");
  const fs::path odd = slice(mixed, 0);
  std::string bytes = bytes_of(odd);
  // Half the rows: the pixels left over are no fault.
  const std::size_t rows = bytes.find(std::string("\x28\x00\x10\x00US", 6)) + 8;
  bytes[rows] = static_cast<char>(static_cast<unsigned char>(bytes[rows]) / 2);
  std::ofstream(odd, std::ios::binary) << bytes;
  expect_refusal(predict(mixed, plan()), "mixes slices of");
  expect_refusal(predict(mixed, plan()), odd.filename().string());
}

TEST_F(Program, ScansThatShowNoHeadAreRefusedWithTheirFault) {
  const Cube head = phantom_cube(dicom());
  const auto changed = [&](const std::function<std::int16_t(std::int16_t)>& change) {
    Cube cube = head;
    for (std::int16_t& v : cube.hu) v = change(v);
    return cube;
  };
  const auto no_bone = [](std::int16_t v) { return std::min<std::int16_t>(v, 60); };
  expect_unfit("soft.nrrd", changed(no_bone), "shows no bone");
  expect_unfit("air.nrrd", changed([](std::int16_t) { return std::int16_t{-1000}; }), "shows no skin");
  expect_unfit("metal.nrrd", changed([](std::int16_t) { return std::int16_t{1500}; }), "no air around");
  expect_unfit("voxel.nrrd", {{1, 1, 1}, 2, {0}}, "1 × 1 × 1 voxels");
  expect_unfit("few.nrrd", {{2, 2, 2}, 2, std::vector<std::int16_t>(8, 0)}, "too small for a head");
  Cube other = head;
  std::reverse(other.hu.begin(), other.hu.end());
  expect_unfit("upside_down.nrrd", other, "upside down");
  other = head;
  other.spacing_mm = 20;
  expect_unfit("centimetres.nrrd", other, "Check the voxel spacing");
}

TEST_F(Program, ALimbIsNotAHead) {
  Cube limb{{80, 80, 80}, 2, {}};
  for (int n = 0; n < 80 * 80 * 80; ++n) {
    const double r = 2 * std::hypot(n % 80 - 40, n / 80 % 80 - 40);
    limb.hu.push_back(static_cast<std::int16_t>(r < 6 ? 200 : r < 14 ? 1200 : r < 50 ? 50 : -1000));
  }
  expect_unfit("limb.nrrd", limb, "does not show a head");
}

TEST_F(Program, EmptyAndMeaninglessFilesOfEveryNameAreRefused) {
  for (const char* ending :
       {"dcm", "nii", "nii.gz", "hdr", "nrrd", "nhdr", "mha", "mhd", "inv3", "img", "txt"}) {
    const std::string name = std::string("damaged.") + ending;
    write(root() / name, "");
    expect_refusal(predict(root() / name, plan()), name + ": is empty");
    write(root() / name, std::string(3000, '\x5a'));
    expect_refusal("info " + (root() / name).string(), name + ": ");
    fs::remove(root() / name);
  }
}

TEST_F(Program, PipesDevicesAndFoldersAreNotWaitedFor) {
  const fs::path pipe = root() / "pipe";
  ASSERT_EQ(::mkfifo(pipe.c_str(), 0600), 0);
  expect_refusal(predict(pipe, plan()), "a pipe or a device");
  expect_refusal(predict(dicom(), pipe), "a pipe or a device");
  expect_refusal(predict("/dev/zero", plan()), "/dev/zero: is a pipe or a device");
  expect_refusal(predict(dicom(), "/dev/zero"), "/dev/zero: is a pipe or a device");
  expect_refusal(predict(dicom(), dicom()), "is a folder, not a file");
  write(root() / "includes.turgor", "#include \"pipe\"\n");
  expect_refusal(predict(dicom(), root() / "includes.turgor"), "includes.turgor:1:10");
  fs::remove(pipe);
}

TEST_F(Program, StrangeFilesAmongGoodOnesAreSkippedWithAWarning) {
  const fs::path mixed = copy_of_series("mixed");
  write(mixed / "readme.txt", "hello");
  write(mixed / "noise.dcm", std::string(5000, '\x5a'));
  const Outcome o = run("info " + mixed.string());
  EXPECT_EQ(o.code, 0) << o.text;
  EXPECT_NE(o.text.find("skipped"), std::string::npos) << o.text;
}

TEST_F(Program, PlansThatCannotBeCarriedOutAreRefusedAtTheirLine) {
  write(root() / "miss.turgor", "osteotomy x -of mandible -plane 0 0 900 0 0 1\nmove x -by 0 1 0\n");
  expect_refusal(predict(dicom(), root() / "miss.turgor"), "miss the bone");
  expect_refusal(predict(dicom(), root() / "miss.turgor"), "miss.turgor:1");
  write(root() / "through.turgor", "move mandible -by 0 -70 0\n");
  expect_refusal(predict(dicom(), root() / "through.turgor"), "'mandible' drives bone");
  expect_refusal(predict(dicom(), root() / "through.turgor"), "through.turgor: ");
  write(root() / "nothing.turgor", "; nothing at all\n");
  expect_refusal(predict(dicom(), root() / "nothing.turgor"),
                 "nothing.turgor: no bone under the tissue moves");
  write(root() / "none.turgor", "");
  expect_refusal(predict(dicom(), root() / "none.turgor"), "none.turgor: no bone under the tissue moves");
  write(root() / "far.turgor", "landmark pogonion 9000 0 0\nsetback -amount 5\n");
  expect_refusal(predict(dicom(), root() / "far.turgor"), "far.turgor: the landmark 'pogonion'");
}

TEST_F(Program, AnOutputThatCannotBeWrittenIsToldBeforeTheWork) {
  expect_refusal("phantom -voxel 3 -slice 3 -o /proc/turgor", "/proc/turgor: the folder cannot be made");
  write(root() / "file", "x");
  const std::string file = (root() / "file").string();
  expect_refusal("phantom -voxel 3 -slice 3 -o " + file, "file: exists and is not a folder");
  expect_refusal("phantom -voxel 3 -slice 3 -o " + file + "/below", "file/below: ");
  const Outcome o = run("predict " + dicom().string() + " -plan " + plan().string() + " -o " + file);
  EXPECT_EQ(o.code, 2);
  EXPECT_EQ(o.text.find("Scan"), std::string::npos) << o.text;  // no stage was begun
}

TEST_F(Program, CubesOutOfRangeAreRefused) {
  write(root() / "dust.turgor", "setback -amount 6\nsolver fem -spacing 0.01mm\n");
  expect_refusal(predict(dicom(), root() / "dust.turgor") + " -solver fem", "dust.turgor:2:");
}

TEST_F(Program, FoldersMadeForAnOutputThatFailsAreRemoved) {
  const std::string deep = (root() / "new/deep/out").string();
  write(root() / "sparse.nrrd", "NRRD0004\n");
  EXPECT_EQ(
      run("predict " + (root() / "sparse.nrrd").string() + " -plan " + plan().string() + " -o " + deep).code,
      2);
  EXPECT_FALSE(fs::exists(root() / "new"));
}

TEST_F(Program, AFullDiskLeavesNothing) {
  const fs::path disk = root() / "disk";
  fs::create_directory(disk);
  if (::mount("none", disk.c_str(), "tmpfs", 0, "size=200k") != 0) GTEST_SKIP() << "only root may mount";
  for (const char* target : {"", "new/deep"}) {  // the disk itself, which exists, and a folder on it
    const Outcome o = run("predict " + dicom().string() + " -plan " + plan().string() +
                          " -quality draft -solver chain -o " + (disk / target).string());
    EXPECT_EQ(o.code, 2) << o.text;
    EXPECT_NE(o.text.find("The disk is full"), std::string::npos) << o.text;
    EXPECT_EQ(o.text.find(".part"), std::string::npos) << o.text;
    EXPECT_TRUE(fs::is_empty(disk));
  }
  EXPECT_EQ(::umount(disk.c_str()), 0);
}

}  // namespace
