// `turgor calibrate` as a user meets it.
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "program/run_program.hpp"

namespace {
using namespace turgor_program;
using nlohmann::json;

constexpr const char* kBar =
    "body box 0 0 0 20 10 10 -spacing 5\nhold -plane 0 0 0 -1 0 0\nreference -modulus 50kPa -poisson 0.4\n"
    "guess -modulus 20kPa -poisson 0.4\nload pull\nforce 0.2N 0 0 -plane 20 0 0 1 0 0\n";

class CalibrateProgram : public ::testing::Test {
 protected:
  void SetUp() override {
    root_ = fs::temp_directory_path() / ("turgor_calibrate_program_" + std::to_string(::getpid()));
    fs::create_directories(root_);
  }
  void TearDown() override { fs::remove_all(root_); }

  fs::path write(const std::string& text) const {
    std::ofstream(root_ / "bar.problem", std::ios::binary) << text;
    return root_ / "bar.problem";
  }
  fs::path out() const { return root_ / "out"; }
  Outcome calibrate(const std::string& text, const std::string& more) const {
    return run("calibrate " + write(text).string() + " -o " + out().string() + " " + more);
  }

  fs::path root_;
};

/// Runs the program, asks it to stop once its errors hold `word`, and returns its exit code.
int stopped_at(const std::vector<std::string>& arguments, const std::string& word) {
  std::array<int, 2> ends{};
  if (::pipe(ends.data()) != 0) return -1;
  const pid_t child = ::fork();
  if (child == 0) {
    ::dup2(ends[1], 2);
    ::close(ends[0]), ::close(ends[1]);
    std::freopen("/dev/null", "w", stdout);
    std::vector<char*> words{const_cast<char*>(TURGOR_PROGRAM)};
    for (const std::string& a : arguments) words.push_back(const_cast<char*>(a.c_str()));
    words.push_back(nullptr);
    ::execv(TURGOR_PROGRAM, words.data());
    ::_exit(99);
  }
  ::close(ends[1]);
  std::string text;
  std::array<char, 256> buffer;
  bool asked = false;
  for (ssize_t n; (n = ::read(ends[0], buffer.data(), buffer.size())) > 0;) {
    text.append(buffer.data(), static_cast<std::size_t>(n));
    if (asked || text.find(word) == std::string::npos) continue;
    ::kill(child, SIGINT), asked = true;
  }
  ::close(ends[0]);
  int status = 0;
  ::waitpid(child, &status, 0);
  return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
}

TEST_F(CalibrateProgram, FitsABarAndWritesEverything) {
  const Outcome o = calibrate(std::string(kBar) + "load bend -held_out\nforce 0 0 9mN -plane 20 0 0 1 0 0\n",
                              "-budget 12 -coarse 4 -seed 3");
  ASSERT_EQ(o.code, 0) << o.text;
  EXPECT_NE(o.text.find("best error"), std::string::npos) << o.text;
  EXPECT_NE(o.text.find("held out"), std::string::npos) << o.text;
  for (const char* file : {"report.html", "calibration.json", "constants.vtu", "load_1.vtu", "load_2.vtu",
                           "load_1_reference.ply", "load_1_uncalibrated.ply", "load_1_calibrated.ply",
                           "pictures/load_1.png", "pictures/constants.png", "pictures/search.png"})
    EXPECT_GT(fs::exists(out() / file) ? fs::file_size(out() / file) : 0, 100U) << file;
  const json result = json::parse(bytes_of(out() / "calibration.json"));
  EXPECT_LT(result["error_after"].get<double>(), 0.2 * result["error_before"].get<double>());
  EXPECT_EQ(result["search"]["seed"], 3);
  EXPECT_EQ(result["search"]["stopped_by_user"], false);
  EXPECT_EQ(result["loads"][1]["calibrated_with"], false);
}

TEST_F(CalibrateProgram, AskedToStopItKeepsTheBest) {
  const fs::path problem = write(kBar);
  const int code = stopped_at({"calibrate", problem.string(), "-o", out().string(), "-method", "annealing",
                               "-budget", "5000000", "-coarse", "10"},
                              "best error");
  EXPECT_EQ(code, 0);
  ASSERT_TRUE(fs::exists(out() / "report.html"));
  EXPECT_NE(bytes_of(out() / "report.html").find("stopped by the user"), std::string::npos);
  const json result = json::parse(bytes_of(out() / "calibration.json"));
  EXPECT_EQ(result["search"]["stopped_by_user"], true);
  EXPECT_LE(result["error_after"].get<double>(), result["error_before"].get<double>());
}

TEST_F(CalibrateProgram, MistakesAreNamedAndLeaveNothing) {
  const auto refuses = [&](const std::string& text, const std::string& part) {
    const Outcome o = calibrate(text, "-budget 3");
    EXPECT_EQ(o.code, 2) << o.text;
    EXPECT_NE(o.text.find(part), std::string::npos) << o.text;
    EXPECT_FALSE(fs::exists(out())) << part;
  };
  refuses("", "bar.problem: the problem has no body");
  refuses("body\n", "bar.problem:1:1");
  refuses(std::string("\xff\xfe\x00", 3), "bar.problem");
  refuses(std::string(kBar) + "hold -box 90 90 90 99 99 99\n",
          "bar.problem:7:11: the region holds no points");
  refuses(std::string(kBar) + "load empty\n", "bar.problem:7:1: the load 'empty' has no force");
  refuses("body surface none.ply\n", "bar.problem:1:14: none.ply");
  refuses("body box 0 0 0 1 1 1 -spacing 1e-5\nreference -modulus 1 -poisson 0\n", "cubes");
  const Outcome none = run("calibrate " + (root_ / "none.problem").string() + " -o " + out().string());
  EXPECT_EQ(none.code, 2);
  EXPECT_NE(none.text.find("none.problem"), std::string::npos) << none.text;
}

}  // namespace
