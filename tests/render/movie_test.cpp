#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <atomic>
#include <cstdlib>
#include <filesystem>
#include <fstream>

#include "support.hpp"
#include "turgor/core/file.hpp"
#include "turgor/render/scene_pictures.hpp"

namespace turgor::render_tests {
namespace {

namespace fs = std::filesystem;

/// A folder for the test, and PATH as the test wants it.
class MovieTest : public ::testing::Test {
 protected:
  void SetUp() override {
    folder_ = fs::temp_directory_path() / ("turgor_movie_" + std::to_string(::getpid()));
    fs::remove_all(folder_);
    fs::create_directories(folder_);
    if (const char* path = std::getenv("PATH")) path_ = path;
  }
  void TearDown() override {
    ::setenv("PATH", path_.c_str(), 1);
    fs::remove_all(folder_);
  }

  /// A movie of red turning blue, of odd sides.
  Movie two_frames(const fs::path& frames) {
    auto movie = Movie::create(frames);
    EXPECT_TRUE(movie) << movie.error().message();
    EXPECT_TRUE(movie->add(filled_image(63, 41, red)));
    EXPECT_TRUE(movie->add(filled_image(63, 41, blue)));
    return *movie;
  }

  /// Puts a program of that name and text at the front of PATH.
  void pretend(const std::string& script) {
    const fs::path bin = folder_ / "bin";
    fs::create_directories(bin);
    std::ofstream(bin / "ffmpeg") << "#!/bin/sh\n" << script;
    ::chmod((bin / "ffmpeg").c_str(), 0755);
    ::setenv("PATH", (bin.string() + ":" + path_).c_str(), 1);
  }

  fs::path folder_;
  std::string path_;
  Context context_;
};

TEST_F(MovieTest, WritesNumberedFrames) {
  const Movie movie = two_frames(folder_ / "frames");
  EXPECT_EQ(movie.frames(), 2);
  EXPECT_TRUE(fs::exists(folder_ / "frames/frame_0000.png"));
  EXPECT_TRUE(fs::exists(folder_ / "frames/frame_0001.png"));
  EXPECT_FALSE(fs::exists(folder_ / "frames/frame_0002.png"));
}

TEST_F(MovieTest, FramesHaveOneSize) {
  Movie movie = two_frames(folder_);
  const auto added = movie.add(filled_image(10, 10, red));
  ASSERT_FALSE(added);
  EXPECT_NE(added.error().message().find("10 by 10"), std::string::npos);
  EXPECT_EQ(movie.frames(), 2);
}

TEST_F(MovieTest, EncodesTheSameBytesTwice) {
  const Movie movie = two_frames(folder_ / "100% done, 'quoted' %04d");
  const fs::path file = folder_ / "movie.mp4";
  const auto made = movie.encode(file, 25, context_);
  ASSERT_TRUE(made) << made.error().message();
  if (!*made) GTEST_SKIP() << "ffmpeg is not installed";
  const auto first = read_file(file);
  ASSERT_TRUE(first);
  ASSERT_GT(first->size(), 500u);
  ASSERT_TRUE(movie.encode(file, 25, context_));
  EXPECT_EQ(*read_file(file), *first);
  int files = 0;
  for (const auto& entry : fs::directory_iterator(folder_)) files += entry.is_regular_file() ? 1 : 0;
  EXPECT_EQ(files, 1);
}

TEST_F(MovieTest, WithoutTheProgramThereIsNoMovie) {
  const Movie movie = two_frames(folder_);
  ::setenv("PATH", (folder_ / "nowhere").c_str(), 1);
  const auto made = movie.encode(folder_ / "movie.mp4", 25, context_);
  ASSERT_TRUE(made) << made.error().message();
  EXPECT_FALSE(*made);
}

TEST_F(MovieTest, AFailureNamesTheLastLine) {
  const Movie movie = two_frames(folder_);
  pretend("echo first >&2; echo 'no codec' >&2; echo >&2; exit 3\n");
  const auto made = movie.encode(folder_ / "movie.mp4", 25, context_);
  ASSERT_FALSE(made);
  EXPECT_NE(made.error().message().find("'no codec'"), std::string::npos) << made.error().message();
  pretend("exit 3\n");
  const auto silent = movie.encode(folder_ / "movie.mp4", 25, context_);
  ASSERT_FALSE(silent);
  EXPECT_NE(silent.error().message().find("code 3"), std::string::npos) << silent.error().message();
}

TEST_F(MovieTest, PassesPathsAsTheyAre) {
  // The program sees its arguments unchanged: no shell stands between.
  const Movie movie = two_frames(folder_ / "a b;c $HOME");
  pretend("for a; do last=$a; done; printf '%s\\n' \"$@\" > '" + (folder_ / "seen").string() +
          "'; : > \"$last\"\n");
  const auto made = movie.encode(folder_ / "m `x`.mp4", 12, context_);
  ASSERT_TRUE(made) << made.error().message();
  EXPECT_TRUE(*made);
  EXPECT_TRUE(fs::exists(folder_ / "m `x`.mp4"));
  const auto seen = read_text_file(folder_ / "seen");
  ASSERT_TRUE(seen);
  EXPECT_NE(seen->find("a b;c $HOME/frame_%04d.png\n"), std::string::npos) << *seen;
  EXPECT_NE(seen->find("-framerate\n12\n"), std::string::npos);
  EXPECT_NE(seen->find("yuv420p"), std::string::npos);
  EXPECT_NE(seen->find("-frames:v\n2\n"), std::string::npos);  // whatever else the folder holds
  EXPECT_NE(seen->find("-movflags\n+faststart\n"), std::string::npos);
}

TEST_F(MovieTest, APlaceThatCannotBeWrittenIsAnError) {
  const Movie movie = two_frames(folder_);
  const fs::path file = folder_ / "missing/movie.mp4";
  const auto made = movie.encode(file, 25, context_);
  if (made && !*made) GTEST_SKIP() << "ffmpeg is not installed";
  ASSERT_FALSE(made);
  EXPECT_NE(made.error().message().find("missing/movie.mp4"), std::string::npos) << made.error().message();
  pretend("exit 0\n");  // claims success, yet leaves no file
  EXPECT_FALSE(movie.encode(file, 25, context_));
}

TEST_F(MovieTest, StopsWhenCancelled) {
  const Movie movie = two_frames(folder_);
  pretend("exec sleep 600\n");
  std::atomic<int> asked{0};
  Context context({}, {}, [&] { return ++asked > 2; });
  const auto made = movie.encode(folder_ / "movie.mp4", 25, context);
  ASSERT_FALSE(made);
  EXPECT_EQ(made.error().kind, ErrorKind::cancelled);
}

TEST_F(MovieTest, BadInputIsNamed) {
  const auto empty = Movie::create(folder_);
  ASSERT_TRUE(empty);
  EXPECT_FALSE(empty->encode(folder_ / "movie.mp4", 25, context_));
  const Movie movie = two_frames(folder_);
  for (const int rate : {0, -1, 1'000'000}) EXPECT_FALSE(movie.encode(folder_ / "movie.mp4", rate, context_));
  std::ofstream(folder_ / "file") << "x";
  EXPECT_FALSE(Movie::create(folder_ / "file/frames"));
}

}  // namespace
}  // namespace turgor::render_tests
