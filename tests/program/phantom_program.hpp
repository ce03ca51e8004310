// A folder with a scan of the phantom and a plan, to run the program on.
#pragma once

#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include "program/run_program.hpp"

namespace turgor_program {

inline std::vector<fs::path> files_of(const fs::path& folder) {
  std::vector<fs::path> files;
  for (const auto& entry : fs::directory_iterator(folder)) files.push_back(entry.path());
  std::sort(files.begin(), files.end());
  return files;
}

class Program : public ::testing::Test {
 public:
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

  static inline fs::path* root_ = nullptr;
  static inline Outcome phantom_{};
};

}  // namespace turgor_program
