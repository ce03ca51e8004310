// Scenes from the command line: `turgor run` to the end of a script, `turgor shell` line by line.
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "program/run_program.hpp"

namespace {
using namespace turgor_program;
using nlohmann::json;

constexpr const char* kSheet =
    "screen -size 64 48\ninstance_object grid.4.4 sheet\ninstance_object sphere ball\nedit_xform ball -t 0 0 "
    "-0.6\n"
    "flesh_out sheet -dfth 0.1 -sfth 0.1 -me 1\nadd_muscle pull 4 7 -c 5\nsetup twitch pull 0 1 1 0.5\n"
    "gravity -g 0.1\ndrape -c 100 -s ball\ndamping 0.2\n";

class SceneProgram : public ::testing::Test {
 protected:
  void SetUp() override {
    root_ = fs::temp_directory_path() / ("turgor_scene_program_" + std::to_string(::getpid()));
    fs::create_directories(root_);
  }
  void TearDown() override { fs::remove_all(root_); }

  fs::path write(const std::string& name, const std::string& text) const {
    std::ofstream(root_ / name, std::ios::binary) << text;
    return root_ / name;
  }
  fs::path out(const std::string& name = "out") const { return root_ / name; }
  Outcome play(const fs::path& script, const std::string& more = "", const std::string& to = "out") const {
    return run("run " + script.string() + " -samples 1 -o " + out(to).string() + " " + more);
  }
  // The console, fed with these lines by a pipe.
  Outcome talk(const std::string& lines, const std::string& arguments) const {
    const fs::path input = write("input", lines);
    return run("shell " + arguments + " < " + input.string());
  }
  static bool is_there(const fs::path& file) { return fs::exists(file) && fs::file_size(file) > 0; }

  fs::path root_;
};

TEST_F(SceneProgram, RunWritesPicturesStatesARecordingAndItsResult) {
  const fs::path script =
      write("drape.bolio", std::string(kSheet) + "simulate -dt 0.05 -until 2\npicture last\nstate last\n");
  const Outcome o = play(script, "-at 1 0.5 -states -movie 1");
  ASSERT_EQ(o.code, 0) << o.text;
  for (const char* file :
       {"start.png", "t_0.5.png", "t_1.png", "end.png", "last.png", "start.state", "t_0.5.state", "end.state",
        "end.vtu", "last.state", "recording.turgor", "result.json"}) {
    EXPECT_TRUE(is_there(out() / file)) << file;
  }
  EXPECT_EQ(bytes_of(out() / "end.state"), bytes_of(out() / "last.state"));
  const json result = json::parse(bytes_of(out() / "result.json"));
  EXPECT_FALSE(result.contains("error"));
  EXPECT_EQ(result["most_inverted_prisms"], 0);
  EXPECT_EQ(result["movie_frames"], 3);
  ASSERT_EQ(result["history"].size(), 4U);
  EXPECT_NEAR(result["history"][1]["time"].get<double>(), 0.5, 1e-9);
  EXPECT_EQ(result["history"][1]["picture"], "t_0.5.png");
  EXPECT_NEAR(result["final"]["time"].get<double>(), 2, 1e-9);
  EXPECT_EQ(result["final"]["tissue"][0]["name"], "sheet");
  EXPECT_EQ(result["final"]["tissue"][0]["samples"], 48);
  EXPECT_EQ(result["final"]["muscles"][0]["fibres"].size(), 1U);
  EXPECT_EQ(result["final"]["collisions"][0]["object"], "ball");
  EXPECT_NE(result["command_line"].get<std::string>().find("drape.bolio"), std::string::npos);
}

TEST_F(SceneProgram, ARecordingRunsToTheSameBitsOnAnyNumberOfThreads) {
  const fs::path script = write("drape.bolio", std::string(kSheet) +
                                                   "simulate -dt 0.05 -until 2\nremove sheet -sphere 0.5 0.5 "
                                                   "0.2 0.3\nsimulate 10 -dt 0.02 -runge_kutta\n");
  ASSERT_EQ(play(script, "-states -threads 1").code, 0);
  const Outcome again = play(out() / "recording.turgor", "-states -threads 2", "again");
  ASSERT_EQ(again.code, 0) << again.text;
  EXPECT_EQ(bytes_of(out() / "end.state"), bytes_of(out("again") / "end.state"));
  EXPECT_EQ(bytes_of(out() / "end.png"), bytes_of(out("again") / "end.png"));
  EXPECT_EQ(bytes_of(out() / "recording.turgor"), bytes_of(out("again") / "recording.turgor"));
}

TEST_F(SceneProgram, AScriptThatFailsEndsWithItsPlaceAndKeepsWhatWasWritten) {
  const fs::path script =
      write("fails.bolio", std::string(kSheet) +
                               "simulate 5 -dt 0.05\nstate before\nedit_xform bal -t 0 0 1\nstate after\n");
  const Outcome o = play(script);
  EXPECT_EQ(o.code, 2) << o.text;
  EXPECT_NE(o.text.find("fails.bolio:13:1: there is no object 'bal'. Did you mean ball?"), std::string::npos)
      << o.text;
  EXPECT_TRUE(is_there(out() / "before.state"));
  EXPECT_FALSE(fs::exists(out() / "after.state"));
  const json result = json::parse(bytes_of(out() / "result.json"));
  EXPECT_NE(result["error"].get<std::string>().find("fails.bolio:13:1"), std::string::npos);
  EXPECT_NE(bytes_of(out() / "recording.turgor").find("simulate 5"), std::string::npos);
}

TEST_F(SceneProgram, MistakesBeforeTheFirstCommandLeaveNothing) {
  const fs::path open = write("open.bolio", "post 'ball\n");
  for (const fs::path& script : {root_ / "nowhere.bolio", open}) {
    const Outcome o = play(script);
    EXPECT_EQ(o.code, 2) << o.text;
    EXPECT_NE(o.text.find(script.filename().string()), std::string::npos) << o.text;
    EXPECT_FALSE(fs::exists(out()));
  }
  const Outcome o = play(write("endless.bolio", std::string(kSheet) + "simulate -dt 0.1\n"));
  EXPECT_EQ(o.code, 2);
  EXPECT_NE(o.text.find("endless.bolio:11:1: the simulation would never end"), std::string::npos) << o.text;
}

TEST_F(SceneProgram, AnInterruptedRunKeepsWhatItHas) {
  const fs::path script =
      write("long.bolio",
            std::string(kSheet) + "simulate 5 -dt 0.05\nstate early\nsimulate -dt 0.001 -until 1e6\n");
  int code = 0;
  const double seconds = seconds_to_stop({"run", script.string(), "-samples", "1", "-o", out().string()},
                                         std::chrono::milliseconds(3000), code);
  EXPECT_EQ(code, 130);
  EXPECT_LT(seconds, 10);
  EXPECT_TRUE(is_there(out() / "start.png") && is_there(out() / "early.state"));
  const json result = json::parse(bytes_of(out() / "result.json"));
  EXPECT_TRUE(result.contains("error"));
  EXPECT_GT(result["final"]["time"].get<double>(), 0.25);
  EXPECT_NE(bytes_of(out() / "recording.turgor").find("-dt 0.001"), std::string::npos);
}

TEST_F(SceneProgram, AMovieOfAnyIntervalEnds) {
  const fs::path script = write("short.bolio", std::string(kSheet) + "simulate 2 -dt 0.05\n");
  const Outcome o = play(script, "-movie 1e-300");
  EXPECT_EQ(o.code, 0) << o.text;
  EXPECT_EQ(json::parse(bytes_of(out() / "result.json"))["movie_frames"],
            3);  // one at each frame of the loop
}

TEST_F(SceneProgram, TheShellAsksTakesAnswersAndEndsWithQuit) {
  const Outcome o = talk("instance_object sphere ball\nvisible\nball\nlist\nquit\nnonsense\n", "");
  EXPECT_EQ(o.code, 0) << o.text;
  EXPECT_NE(o.text.find("visible: OBJECT (name of an object)"), std::string::npos) << o.text;
  EXPECT_NE(o.text.find("hidden"), std::string::npos) << o.text;
  EXPECT_EQ(o.text.find("nonsense"), std::string::npos) << o.text;
}

TEST_F(SceneProgram, TheShellTellsMistakesAndGoesOn) {
  const Outcome o = talk(
      "nonsense\npost 'open\ndamping -1\nsimulate 3 -dt 0.1\nvisible nothing\ninstance_object cube box\nlist",
      "");
  EXPECT_EQ(o.code, 0) << o.text;
  for (const char* place : {"line 1:1:1: ", "line 2:1:6: ", "line 3:1:9: ", "line 5:1:"}) {
    EXPECT_NE(o.text.find(place), std::string::npos) << place << "\n" << o.text;
  }
  EXPECT_NE(o.text.find("box"), std::string::npos);
}

TEST_F(SceneProgram, WhatTheShellRecordsRunsToTheSameState) {
  const std::string record = (root_ / "session.turgor").string();
  const fs::path script = write("begin.bolio", kSheet);
  const Outcome o = talk(
      "simulate 7 -dt 0.05\nmuscle_set\npull\n-scale 0.5\ngrow sheet -by 1.1 -layer 2\n"
      "simulate 9 -dt 0.03 -skip 4 -runge_kutta\nstate said\n",
      script.string() + " -record " + record + " -o " + out().string());
  ASSERT_EQ(o.code, 0) << o.text;
  const Outcome again = play(record, "", "again");
  ASSERT_EQ(again.code, 0) << again.text;
  ASSERT_TRUE(is_there(out() / "said.state"));
  EXPECT_EQ(bytes_of(out() / "said.state"), bytes_of(out("again") / "said.state"));
}

}  // namespace
