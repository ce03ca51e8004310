#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <filesystem>
#include <numeric>

#include "turgor/core/context.hpp"
#include "turgor/core/error.hpp"
#include "turgor/core/file.hpp"
#include "turgor/core/parallel.hpp"
#include "turgor/core/random.hpp"

namespace turgor {
namespace {

TEST(Error, SaysPlaceFaultAndRemedyInOneLine) {
  const Error error{ErrorKind::bad_input, "is cut short", "head.nrrd", "Copy the file again"};
  EXPECT_EQ(error.message(), "head.nrrd: is cut short. Copy the file again.");
  EXPECT_EQ(error.exit_code(), 2);
}

TEST(Parallel, SumsGiveTheSameBitsOnOneAndTwoThreads) {
  const RandomStream random(7);
  const auto sum = [&] {
    return parallel_reduce<double>(
        1'000'003, 4096, 0.0,
        [&](std::size_t begin, std::size_t end) {
          double part = 0;
          for (std::size_t i = begin; i < end; ++i) part += random.normal(i);
          return part;
        },
        std::plus<>());
  };
  set_thread_count(1);
  const double one = sum();
  set_thread_count(2);
  const double two = sum();
  set_thread_count(0);
  EXPECT_EQ(one, two);
}

TEST(RandomStream, HasTheMomentsOfItsDistributions) {
  const RandomStream random(1);
  constexpr int n = 200'000;
  double mean = 0, square = 0, uniform = 0;
  for (int i = 0; i < n; ++i) {
    const double v = random.normal(static_cast<std::uint64_t>(i));
    mean += v / n;
    square += v * v / n;
    uniform += random.uniform(static_cast<std::uint64_t>(i)) / n;
  }
  EXPECT_NEAR(mean, 0.0, 0.01);
  EXPECT_NEAR(square, 1.0, 0.02);
  EXPECT_NEAR(uniform, 0.5, 0.005);
}

TEST(Context, RecordsStagesAndStopsOnRequest) {
  bool stop = false;
  Context context({}, {}, [&] { return stop; });
  { const Stage stage(context, "outer"); }
  EXPECT_EQ(context.stage_times().at(0).stage, "outer");
  EXPECT_TRUE(static_cast<bool>(context.check()));
  stop = true;
  EXPECT_EQ(context.check().error().kind, ErrorKind::cancelled);
}

class FileTest : public ::testing::Test {
 protected:
  void SetUp() override {
    folder_ = std::filesystem::temp_directory_path() / ("turgor_core_" + std::to_string(::getpid()));
    std::filesystem::create_directories(folder_);
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }
  std::filesystem::path folder_;
};

TEST_F(FileTest, AStagedFolderThatIsNotCommittedLeavesNothing) {
  {
    auto staged = StagedFolder::create(folder_ / "result");
    ASSERT_TRUE(static_cast<bool>(staged));
    ASSERT_TRUE(static_cast<bool>(write_file(staged->path() / "a.txt", "half")));
  }
  EXPECT_TRUE(std::filesystem::is_empty(folder_));
}

TEST_F(FileTest, ACommittedFolderHoldsItsFilesAndKeepsOthers) {
  for (const char* name : {"a.txt", "b.txt"}) {
    auto staged = StagedFolder::create(folder_ / "result/");
    ASSERT_TRUE(static_cast<bool>(staged));
    ASSERT_TRUE(static_cast<bool>(write_file(staged->path() / name, name)));
    ASSERT_TRUE(static_cast<bool>(staged->commit()));
  }
  EXPECT_EQ(*read_text_file(folder_ / "result/a.txt"), "a.txt");
  EXPECT_EQ(*read_text_file(folder_ / "result/b.txt"), "b.txt");
}

TEST_F(FileTest, ParentsMadeForAStagedFolderGoWithIt) {
  std::filesystem::create_directory(folder_ / "kept");
  for (const char* target : {"a/b/c", "kept/b"}) {
    auto staged = StagedFolder::create(folder_ / target);
    ASSERT_TRUE(static_cast<bool>(staged));
  }
  EXPECT_FALSE(std::filesystem::exists(folder_ / "a"));
  EXPECT_TRUE(std::filesystem::is_empty(folder_ / "kept"));
  const auto write_one = [](const std::filesystem::path& path) { return write_file(path / "f", "x"); };
  ASSERT_TRUE(static_cast<bool>(write_folder(folder_ / "a/b/c", write_one)));
  EXPECT_EQ(*read_text_file(folder_ / "a/b/c/f"), "x");
}

TEST_F(FileTest, AFolderInTheWayOfAFileIsFoundBeforeAnythingIsMoved) {
  std::filesystem::create_directories(folder_ / "result/b");
  const auto write_two = [](const std::filesystem::path& path) -> Result<void> {
    TURGOR_CHECK(write_file(path / "a", "x"));
    return write_file(path / "b", "x");
  };
  const auto written = write_folder(folder_ / "result", write_two);
  ASSERT_FALSE(static_cast<bool>(written));
  EXPECT_EQ(written.error().where, (folder_ / "result/b").string());
  EXPECT_FALSE(std::filesystem::exists(folder_ / "result/a"));
  EXPECT_EQ(std::distance(std::filesystem::directory_iterator(folder_ / "result"), {}), 1);
}

TEST_F(FileTest, ErrorsWhileStagingNameThePlaceThatTheUserKnows) {
  const auto broken = [](const std::filesystem::path& path) { return write_file(path / "none/a", "x"); };
  const auto written = write_folder(folder_ / "result", broken);
  ASSERT_FALSE(static_cast<bool>(written));
  EXPECT_EQ(written.error().where, (folder_ / "result/none/a").string());
  EXPECT_TRUE(std::filesystem::is_empty(folder_));
}

TEST_F(FileTest, WhatCannotBeAnOutputFolderIsToldBeforeTheWork) {
  ASSERT_TRUE(static_cast<bool>(write_file(folder_ / "file", "x")));
  std::filesystem::create_symlink(folder_ / "nowhere", folder_ / "link");
  EXPECT_NE(check_output_folder(folder_ / "file").error().what.find("not a folder"), std::string::npos);
  EXPECT_FALSE(static_cast<bool>(check_output_folder(folder_ / "file/below")));
  EXPECT_NE(check_output_folder(folder_ / "link").error().what.find("link to nothing"), std::string::npos);
  EXPECT_FALSE(static_cast<bool>(check_output_folder(folder_ / std::string(300, 'a'))));
  EXPECT_TRUE(static_cast<bool>(check_output_folder(folder_ / "new/result")));
  EXPECT_FALSE(std::filesystem::exists(folder_ / "new"));
}

TEST_F(FileTest, APipeIsRefusedAndNotWaitedFor) {
  const auto pipe = folder_ / "pipe";
  ASSERT_EQ(::mkfifo(pipe.c_str(), 0600), 0);
  const auto read = read_file(pipe);
  ASSERT_FALSE(static_cast<bool>(read));
  EXPECT_NE(read.error().what.find("a pipe or a device"), std::string::npos);
}

TEST_F(FileTest, AFullDiskIsAnErrorThatSaysSo) {
  if (!std::filesystem::exists("/dev/full")) GTEST_SKIP() << "this system has no /dev/full";
  // /dev/full cannot be renamed over, so the write itself is what must fail: a link stands for the temporary
  // file.
  const auto path = folder_ / "x";
  std::filesystem::create_symlink("/dev/full", path.string() + ".part" + std::to_string(::getpid()));
  const auto written = write_file(path, "content");
  ASSERT_FALSE(static_cast<bool>(written));
  EXPECT_NE(written.error().message().find("disk is full"), std::string::npos);
  EXPECT_FALSE(std::filesystem::exists(path));
}

TEST_F(FileTest, AMissingFileNamesThePathAndTheRemedy) {
  const auto missing = read_file(folder_ / "nothing");
  ASSERT_FALSE(static_cast<bool>(missing));
  EXPECT_NE(missing.error().message().find("no such file"), std::string::npos);
}

}  // namespace
}  // namespace turgor
