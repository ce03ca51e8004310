// The program as a user meets it: what it writes, tells and stops at.
#include <chrono>
#include <cstdlib>
#include <map>
#include <utility>

#include "program/phantom_program.hpp"

namespace {
using namespace turgor_program;

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
