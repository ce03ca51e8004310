// The program as a user meets it: exit codes, one clear sentence for each mistake, nothing written.
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <string>
#include <thread>
#include <vector>

#include "support/example_scan.hpp"

namespace {
namespace fs = std::filesystem;

struct Outcome {
  int code;
  std::string text;  // both streams
};

Outcome run(const std::string& arguments) {
  const std::string command = std::string(TURGOR_PROGRAM) + ' ' + arguments + " 2>&1";
  Outcome out{-1, {}};
  FILE* pipe = ::popen(command.c_str(), "r");
  if (pipe == nullptr) return out;
  std::array<char, 4096> buffer;
  for (std::size_t n; (n = std::fread(buffer.data(), 1, buffer.size(), pipe)) > 0;)
    out.text.append(buffer.data(), n);
  const int status = ::pclose(pipe);
  out.code = WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
  return out;
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
    std::vector<fs::path> files;
    for (const auto& entry : fs::directory_iterator(folder)) files.push_back(entry.path());
    std::sort(files.begin(), files.end());
    return files[files.size() / 2 + static_cast<std::size_t>(from_middle)];
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
  const fs::path twice = copy_of_series("twice");
  // The same position under another name and instance is a slice too many, not a copy of a file: so take a
  // true copy.
  fs::copy(slice(twice, 0), twice / "again.dcm");
  const Outcome o = run(predict(twice, plan()));
  EXPECT_TRUE(o.code == 2 || o.code == 0) << o.text;
  EXPECT_NE(o.text.find("again.dcm"), std::string::npos) << o.text;
  fs::remove_all(out());
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
  expect_refusal(predict(dicom(), root() / "through.turgor"), "'mandible'");
  write(root() / "nothing.turgor", "; nothing at all\n");
  expect_refusal(predict(dicom(), root() / "nothing.turgor"), "no bone under the tissue moves");
}

TEST_F(Program, AFullDiskOrAForbiddenFolderLeavesNothing) {
  expect_refusal("phantom -voxel 3 -slice 4 -o /proc/turgor", "/proc");
  write(root() / "file", "x");
  expect_refusal("phantom -voxel 3 -slice 4 -o " + (root() / "file").string(), "not a folder");
}

TEST_F(Program, CtrlCStopsWithinASecondAndLeavesNothing) {
  const pid_t child = ::fork();
  ASSERT_GE(child, 0);
  if (child == 0) {
    std::freopen("/dev/null", "w", stdout);
    std::freopen("/dev/null", "w", stderr);
    const std::string folder = (root() / "stopped").string();
    ::execl(TURGOR_PROGRAM, TURGOR_PROGRAM, "phantom", "-voxel", "0.5", "-slice", "0.5", "-o", folder.c_str(),
            nullptr);
    ::_exit(99);
  }
  std::this_thread::sleep_for(std::chrono::milliseconds(1200));
  ::kill(child, SIGINT);
  int status = 0;
  ::waitpid(child, &status, 0);
  EXPECT_TRUE(WIFEXITED(status));
  EXPECT_EQ(WEXITSTATUS(status), 130);
  EXPECT_FALSE(fs::exists(root() / "stopped"));
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
