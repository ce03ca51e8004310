#include <gtest/gtest.h>

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
