// The program as a user meets it: exit codes, one clear sentence for each mistake, nothing written.
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/mount.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <functional>
#include <map>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "program/run_program.hpp"

namespace {
using namespace turgor_program;
namespace fs = std::filesystem;

std::vector<fs::path> files_of(const fs::path& folder) {
  std::vector<fs::path> files;
  for (const auto& entry : fs::directory_iterator(folder)) files.push_back(entry.path());
  std::sort(files.begin(), files.end());
  return files;
}

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

class Program : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    root_ = new fs::path(fs::temp_directory_path() / ("turgor_program_" + std::to_string(::getpid())));
    fs::create_directories(*root_);
    phantom_ = run("phantom -o " + (*root_ / "phantom").string() + " -voxel 2 -slice 2");
    write(plan(), "setback -amount 6\n");
  }
  static void TearDownTestSuite() {
    fs::remove_all(*root_);
    delete root_;
  }
  static void write(const fs::path& path, const std::string& text) { std::ofstream(path) << text; }
  static fs::path root() { return *root_; }
  static fs::path plan() { return *root_ / "plan.turgor"; }
  static fs::path dicom() { return *root_ / "phantom/dicom"; }
  static fs::path out() { return *root_ / "out"; }
  static std::string predict(const fs::path& scan, const fs::path& with) {
    return "predict " + scan.string() + " -plan " + with.string() + " -quality draft -o " + out().string();
  }
  // Fails with code 2, says `expected`, and leaves nothing behind.
  static void expect_refusal(const std::string& arguments, const std::string& expected) {
    const Outcome o = run(arguments);
    EXPECT_EQ(o.code, 2) << o.text;
    EXPECT_NE(o.text.find(expected), std::string::npos) << "wanted: " << expected << "\ngot: " << o.text;
    EXPECT_FALSE(fs::exists(out()));
    for (const auto& entry : fs::directory_iterator(root())) {
      EXPECT_EQ(entry.path().string().find(".part"), std::string::npos) << entry.path();
    }
  }
  // A copy of the phantom's series to damage.
  static fs::path copy_of_series(const std::string& name) {
    const fs::path copy = root() / name;
    fs::copy(dicom(), copy, fs::copy_options::recursive | fs::copy_options::overwrite_existing);
    return copy;
  }
  static fs::path slice(const fs::path& folder, int from_middle) {
    const std::vector<fs::path> files = files_of(folder);
    return files[files.size() / 2 + static_cast<std::size_t>(from_middle)];
  }
  // The scan under that name, refused with `expected`, its file and a remedy.
  static void expect_unfit(const std::string& name, const Cube& cube, const std::string& expected) {
    SCOPED_TRACE(name);
    cube.save(root() / name);
    expect_refusal(predict(root() / name, plan()), name + ": ");
    expect_refusal(predict(root() / name, plan()), expected);
  }

  static inline fs::path* root_ = nullptr;
  static inline Outcome phantom_{};
};

TEST_F(Program, PredictsFromThePhantomsSeriesAndWritesEverything) {
  ASSERT_EQ(phantom_.code, 0) << phantom_.text;
  const Outcome o = run(predict(dicom(), plan()));
  ASSERT_EQ(o.code, 0) << o.text;
  for (const char* file :
       {"report.html", "result.json", "tissue.vtu", "skin_before.ply", "skin_before.vtp", "skin_before.glb",
        "skin_after.ply", "skin_after.vtp", "skin_after.glb", "skin_after_chain.ply", "bone_after_distal.ply",
        "pictures/before_front.png", "pictures/after_profile.png", "pictures/superimposed_front.png",
        "pictures/displacement_three_quarter_left.png"}) {
    EXPECT_TRUE(fs::exists(out() / file) && fs::file_size(out() / file) > 100) << file;
  }
  fs::remove_all(out());
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

TEST_F(Program, PredictsTheFaceByCubesAndComparesEveryPair) {
  write(root() / "cubes.turgor", "setback -amount 6\nsolver fem -spacing 4.5mm\n");
  const Outcome o =
      run(predict(dicom(), root() / "cubes.turgor") + " -solver fem -solver solid -solver chain");
  ASSERT_EQ(o.code, 0) << o.text;
  for (const char* name : {"cubes_fem.vtu", "cubes_solid.vtu", "skin_after.ply", "skin_after_solid.ply"})
    EXPECT_GT(fs::file_size(out() / name), 1000U) << name;
  const std::string result = bytes_of(out() / "result.json"), report = bytes_of(out() / "report.html");
  for (const char* pair : {"fem and solid", "fem and chain", "solid and chain"})
    EXPECT_NE(report.find(pair), std::string::npos) << pair;
  for (const char* key : {"\"lower_third\"", "\"lips\"", "\"elements_inverted\"", "\"cubes\"", "\"law\""})
    EXPECT_NE(result.find(key), std::string::npos) << key;
  fs::remove_all(out());
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

TEST_F(Program, WhatCannotBePrintedIsAnError) {
  if (!fs::exists("/dev/full")) GTEST_SKIP() << "this system has no /dev/full";
  const Outcome o = turgor::support::shell(TURGOR_PROGRAM " help 2>&1 >/dev/full");
  EXPECT_EQ(o.code, 2);
  const std::string line = o.text.substr(0, o.text.find('\n'));
  EXPECT_NE(line.find("standard output"), std::string::npos) << o.text;
}

TEST_F(Program, CtrlCStopsTheWorkAndLeavesNothing) {
  using std::chrono::milliseconds;
  const std::string folder = (root() / "stopped/here").string();
  const std::vector<std::string> phantom{"phantom", "-voxel", "0.5", "-slice", "0.5", "-o", folder},
      prediction{"predict", dicom().string(), "-plan", plan().string(), "-o", folder};
  // A run that is through before its time is no failure, so only those before half a second must be stopped.
  for (const int delay : {100, 400, 900, 1300, 2000, 2800}) {
    for (const auto& work : {phantom, prediction}) {
      SCOPED_TRACE(work.front() + " after " + std::to_string(delay) + " ms");
      int code = -1;
      const double seconds = seconds_to_stop(work, milliseconds(delay), code);
      if (code == 0 && delay > 500) {
        fs::remove_all(root() / "stopped");
        continue;
      }
      EXPECT_EQ(code, 130);
      // Alone it stops within a second; other tests share the machine here. The phantom would run for a
      // minute.
      EXPECT_LT(seconds, 6);
      EXPECT_FALSE(fs::exists(root() / "stopped"));
    }
  }
}

TEST_F(Program, EveryStageIsAnnouncedOnce) {
  const Outcome o = run(predict(dicom(), plan()));
  ASSERT_EQ(o.code, 0) << o.text;
  fs::remove_all(out());
  std::map<std::string, int> stages;
  for (std::size_t at = 0, end; (end = o.text.find('\n', at)) != std::string::npos; at = end + 1) {
    const std::string line = o.text.substr(at, end - at);
    if (line.ends_with(" ...")) ++stages[line];
  }
  EXPECT_EQ(stages.count("Building the head ..."), 1U) << o.text;
  EXPECT_GT(stages.size(), 5U);
  for (const auto& [line, count] : stages) EXPECT_EQ(count, 1) << line;
}

TEST_F(Program, TheProgressLineLeavesNothingOnATerminal) {
  if (std::system("command -v script >/dev/null") != 0) GTEST_SKIP() << "the program script is not installed";
  const std::string log = (root() / "terminal").string();
  const std::string inner = "stty cols 30; " TURGOR_PROGRAM " " + predict(dicom(), plan());
  ASSERT_EQ(std::system(("script -qec '" + inner + "' " + log + " >/dev/null </dev/null").c_str()), 0);
  fs::remove_all(out());
  const std::string text = bytes_of(log), wipe = "\r\033[K";
  EXPECT_NE(text.find(" %"), std::string::npos) << "no progress was drawn";
  // What stays of each line once everything before the last wipe is gone.
  for (std::size_t at = 0; at < text.size();) {
    const std::size_t end = std::min(text.find('\n', at), text.size());
    std::string line = text.substr(at, end - at);
    for (std::size_t from = 0, next; from < line.size(); from = next + wipe.size()) {
      next = std::min(line.find(wipe, from), line.size());
      if (next < line.size())
        EXPECT_LT(next - from, 30U) << "a line that wraps: " << line.substr(from, next - from);
    }
    if (const std::size_t last = line.rfind(wipe); last != std::string::npos)
      line.erase(0, last + wipe.size());
    EXPECT_EQ(line.find(" %"), std::string::npos) << line;
    at = end + 1;
  }
}

TEST_F(Program, AMovieHasEachTimeOnceAndASheetHoldsThePictures) {
  write(root() / "fall.turgor",
        "instance_object grid.3.3 sheet\nflesh_out sheet\ngravity_face -g 0.1\nsimulate -dt 0.05 -until 1\n");
  const Outcome o = run("run " + (root() / "fall.turgor").string() + " -o " + out().string() +
                        " -at 0.5 -sheet -size 64 48 -movie 0.1");
  EXPECT_EQ(o.code, 0) << o.text;
  EXPECT_EQ(files_of(out() / "frames").size(), 11u);  // 0, 0.1, … 1
  // Width and height of a PNG stand in bytes 16 to 23, high byte first.
  const auto size = [](const std::string& png) {
    const auto byte = [&](std::size_t i) { return static_cast<int>(static_cast<unsigned char>(png.at(i))); };
    return std::pair(256 * byte(18) + byte(19), 256 * byte(22) + byte(23));
  };
  EXPECT_EQ(size(bytes_of(out() / "t_0.5.png")), (std::pair{64, 48}));
  const auto [width, height] = size(bytes_of(out() / "sheet.png"));
  EXPECT_GE(width, 3 * 64);  // start, 0.5 and end side by side
  EXPECT_LT(width, 4 * 64);
  EXPECT_GT(height, 48);
  fs::remove_all(out());
}

/// A tetrahedron of 9 mm as OFF, without its last `missing` faces.
std::string tetrahedron_off(int missing) {
  std::string text = "OFF\n4 " + std::to_string(4 - missing) + " 0\n0 0 0\n9 0 0\n0 9 0\n0 0 9\n";
  const char* const faces[] = {"3 0 2 1\n", "3 0 1 3\n", "3 0 3 2\n", "3 1 2 3\n"};
  for (int f = 0; f < 4 - missing; ++f) text += faces[f];
  return text;
}

TEST_F(Program, MeshesASurfaceIntoEveryFormat) {
  const fs::path surface = root() / "corner.off";
  write(surface, tetrahedron_off(0));
  const std::string mesh = "mesh " + surface.string() + " -resolution 12 -o " + root().string();
  for (const char* name : {"/c.ele", "/c.vtu", "/c.msh", "/c.inp", "/c.solid"}) {
    const Outcome o = run(mesh + name);
    EXPECT_EQ(o.code, 0) << o.text;
    EXPECT_NE(o.text.find(" tetrahedra, "), std::string::npos) << o.text;
    EXPECT_TRUE(fs::exists(root().string() + name));
  }
  EXPECT_TRUE(fs::exists(root() / "c.node") && fs::exists(root() / "c.face"));
  const Outcome cubes = run(mesh + "/cubes.inp -hexahedra -no_border");
  EXPECT_NE(cubes.text.find(" hexahedra, "), std::string::npos) << cubes.text;
  EXPECT_NE(bytes_of(root() / "cubes.inp").find("C3D8"), std::string::npos);
}

TEST_F(Program, SurfacesThatCannotBeMeshedAreRefused) {
  const fs::path open = root() / "open.off";
  write(open, tetrahedron_off(1));
  const std::string mesh = "mesh " + open.string() + " -o " + out().string();
  expect_refusal(mesh + ".vtu", "hole of 9 x 9 x 9 mm");
  expect_refusal(mesh + ".stl", "not written to files of this kind");
  expect_refusal(mesh + ".ele -hexahedra", "tetrahedra only");
  expect_refusal(mesh + ".vtu -resolution 0", "resolution");
  expect_refusal("mesh " + (root() / "no.off").string() + " -o " + out().string() + ".vtu", "no.off");
  const std::string picture = (root() / "leak.png").string();
  expect_refusal(mesh + ".vtu -leak_picture " + picture, "leak.png shows where");
  EXPECT_EQ(bytes_of(picture).substr(1, 3), "PNG");
  expect_refusal(mesh + ".vtu -spacing 2", "-spacing is for parts of a scan");
  expect_refusal(mesh + ".vtu -fine 0 0 0 1 1 1", "-fine is for graded solids");
  EXPECT_EQ(run(mesh + ".vtu -fill winding").code, 0);
  fs::remove(out().string() + ".vtu");
}

TEST_F(Program, MeshesPartsOfScansAndGradesSolids) {
  // A label map of 12 x 12 x 12 voxels of 2 mm: label 3 within the inner 8 x 8 x 8.
  const fs::path labels = root() / "labels.nrrd";
  std::string voxels;
  const auto inner = [](int n) { return n >= 2 && n < 10; };
  for (int k = 0; k < 12; ++k)
    for (int j = 0; j < 12; ++j)
      for (int i = 0; i < 12; ++i) voxels += inner(i) && inner(j) && inner(k) ? '\3' : '\0';
  write(labels,
        "NRRD0004\ntype: uint8\ndimension: 3\nspace: left-posterior-superior\nsizes: 12 12 12\n"
        "space directions: (2,0,0) (0,2,0) (0,0,2)\nspace origin: (0,0,0)\nencoding: raw\n\n" +
            voxels);
  const std::string mesh = "mesh " + labels.string() + " -o " + (root() / "l.vtu").string();
  const Outcome own = run(mesh + " -label 3");
  EXPECT_EQ(own.code, 0) << own.text;
  EXPECT_NE(own.text.find("2560 tetrahedra"), std::string::npos) << own.text;
  EXPECT_NE(own.text.find("cubes of 2 mm"), std::string::npos) << own.text;
  const Outcome graded = run(mesh + " -label 3 -resolution 32 -graded 2 -fine 10 10 10 12 12 12");
  EXPECT_EQ(graded.code, 0) << graded.text;
  EXPECT_NE(graded.text.find("dihedral angles 45 to"), std::string::npos) << graded.text;
  EXPECT_NE(run(mesh + " -above 2 -spacing 1").text.find("cubes of 1 mm"), std::string::npos);
  expect_refusal(mesh + " -label 4", "Give labels that there are: 3");
  expect_refusal(mesh + " -above 100", "no voxel lies within the threshold");
  expect_refusal(mesh + " -label 3 -no_border", "-no_border is for surfaces");
  expect_refusal(mesh + " -label 3 -above 2", "label");
}

TEST_F(Program, HelpVersionAndCompletionWork) {
  EXPECT_NE(run("help").text.find("predict"), std::string::npos);
  EXPECT_NE(run("help setback").text.find("amount"), std::string::npos);
  EXPECT_EQ(run("version").code, 0);
  EXPECT_EQ(run("commands -format bash").code, 0);
  EXPECT_EQ(run("help nonsense").code, 2);
}

TEST_F(Program, TheSameRunGivesTheSameFiles) {
  const auto digest = [&](const std::string& threads) {
    const Outcome o = run(predict(dicom(), plan()) + " -solver network -threads " + threads);
    EXPECT_EQ(o.code, 0) << o.text;
    std::string bytes;
    for (const char* file :
         {"skin_after.ply", "tissue.vtu", "pictures/after_front.png", "pictures/displacement_front.png"}) {
      std::ifstream in(out() / file, std::ios::binary);
      bytes.append(std::istreambuf_iterator<char>(in), {});
    }
    fs::remove_all(out());
    return bytes;
  };
  const std::string one = digest("1"), two = digest("2");
  EXPECT_GT(one.size(), 100'000U);
  EXPECT_TRUE(one == two);
}

}  // namespace
