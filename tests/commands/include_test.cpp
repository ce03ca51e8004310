#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <map>

#include "turgor/commands/script.hpp"
#include "turgor/core/file.hpp"
#include "turgor/world/object_file.hpp"

namespace turgor {
namespace {
namespace fs = std::filesystem;

/// Files in memory.
ScriptOptions memory(std::map<std::string, std::string> files, std::vector<fs::path> search = {}) {
  ScriptOptions options;
  options.search_paths = std::move(search);
  options.read = [files = std::move(files)](const fs::path& path) -> Result<std::optional<std::string>> {
    const auto found = files.find(path.string());
    if (found == files.end()) return std::optional<std::string>();
    return std::optional<std::string>(found->second);
  };
  return options;
}

std::string first_words(const std::vector<ScriptLine>& lines) {
  std::string out;
  for (const ScriptLine& line : lines) {
    EXPECT_FALSE(line.include);
    out += (out.empty() ? "" : " ") + line.words.front().text;
  }
  return out;
}

TEST(Include, PutsTheFileInItsPlaceWithItsOwnPlaces) {
  const auto lines =
      load_script("case/main", memory({{"case/main", "a\n#include part\nd"}, {"case/part", "; x\n b\nc"}}));
  ASSERT_TRUE(lines) << lines.error().message();
  EXPECT_EQ(first_words(*lines), "a b c d");
  EXPECT_EQ((*lines)[1].words[0].place.text(), "case/part:2:2");
  EXPECT_EQ((*lines)[3].words[0].place.text(), "case/main:3:1");
}

TEST(Include, IsRelativeToTheIncludingFileThenToTheSearchPaths) {
  const auto options = memory({{"case/main", "#include sub/one\n#include two"},
                               {"case/sub/one", "#include two"},
                               {"case/sub/two", "sub_two"},
                               {"library/two", "library_two"}},
                              {"elsewhere", "library"});
  const auto lines = load_script("case/main", options);
  ASSERT_TRUE(lines) << lines.error().message();
  EXPECT_EQ(first_words(*lines), "sub_two library_two");
}

TEST(Include, OfAFileThatIsNotThereNamesWhereItWasSought) {
  const auto lines =
      load_script("case/main", memory({{"case/main", "a\n  #include lookat_wound"}}, {"library"}));
  ASSERT_FALSE(lines);
  EXPECT_EQ(
      lines.error().message(),
      "case/main:2:12: no file 'lookat_wound' to include. Correct its name; looked for case/lookat_wound and "
      "library/lookat_wound.");
}

TEST(Include, MayBeRepeatedButNotCircular) {
  const auto twice = load_script("m", memory({{"m", "#include p\n#include p"}, {"p", "x"}}));
  ASSERT_TRUE(twice);
  EXPECT_EQ(first_words(*twice), "x x");

  const auto cycle = load_script(
      "m", memory({{"m", "#include d/a"}, {"d/a", "y\n#include b"}, {"d/b", "#include ../d/./a"}}));
  ASSERT_FALSE(cycle);
  EXPECT_EQ(cycle.error().kind, ErrorKind::bad_command);
  EXPECT_EQ(cycle.error().message(),
            "d/b:1:10: includes itself: d/a -> d/b -> d/a. Remove one of these #include lines.");

  const auto self = load_script("m", memory({{"m", "#include m"}}));
  ASSERT_FALSE(self);
  EXPECT_EQ(self.error().message(), "m:1:10: includes itself: m -> m. Remove one of these #include lines.");
}

TEST(Include, NestsToAnyDepth) {
  constexpr int depth = 5'000;
  ScriptOptions options;
  options.read = [](const fs::path& path) -> Result<std::optional<std::string>> {
    const int n = std::stoi(path.string());
    const std::string text = "c" + std::to_string(n) + "\n";
    return std::optional<std::string>(n == depth ? text : text + "#include " + std::to_string(n + 1));
  };
  const auto lines = load_script("0", options);
  ASSERT_TRUE(lines) << lines.error().message();
  ASSERT_EQ(lines->size(), static_cast<std::size_t>(depth) + 1);
  EXPECT_EQ(lines->back().words[0].text, "c5000");
}

TEST(Include, StopsAtFilesThatMultiply) {
  // Each file includes the next one twice: 2^40 lines in 40 small files.
  ScriptOptions options;
  options.max_bytes = 1 << 20;
  options.read = [](const fs::path& path) -> Result<std::optional<std::string>> {
    const std::string next = "#include " + std::to_string(std::stoi(path.string()) + 1) + "\n";
    return std::optional<std::string>(path == "40" ? "x" : next + next);
  };
  const auto lines = load_script("0", options);
  ASSERT_FALSE(lines);
  EXPECT_EQ(lines.error().what, "the script and its includes hold more than 1 MiB");
}

class IncludeOnDisk : public ::testing::Test {
 protected:
  void SetUp() override {
    folder_ = fs::temp_directory_path() / ("turgor_include_test_" + std::to_string(::getpid()));
    fs::create_directories(folder_ / "sub");
  }
  void TearDown() override { fs::remove_all(folder_); }
  void put(const std::string& name, std::string_view text) { ASSERT_TRUE(write_file(folder_ / name, text)); }

  fs::path folder_;
};

TEST_F(IncludeOnDisk, SeesCyclesThroughLinks) {
  put("a", "#include sub/link");
  fs::create_symlink(folder_ / "a", folder_ / "sub/link");
  const auto lines = load_script(folder_ / "a");
  ASSERT_FALSE(lines);
  EXPECT_NE(lines.error().what.find("includes itself"), std::string::npos) << lines.error().message();
}

TEST_F(IncludeOnDisk, SaysWhatIsNotAFile) {
  put("a", "\n#include sub");
  const auto folder = load_script(folder_ / "a");
  ASSERT_FALSE(folder);
  EXPECT_EQ(folder.error().where, (folder_ / "a").string() + ":2:10");
  EXPECT_NE(folder.error().what.find("is a folder"), std::string::npos) << folder.error().message();

  const auto missing = load_script(folder_ / "none");
  ASSERT_FALSE(missing);
  EXPECT_EQ(missing.error().where, (folder_ / "none").string());
}

TEST_F(IncludeOnDisk, ReadsAPlanFromSeveralFiles) {
  put("plan", "#include sub/jaw\nopen_mouth -angle 10\n");
  put("sub/jaw", "setback -amount 6\n");
  const auto plan = parse_script(folder_ / "plan", plan_commands());
  ASSERT_TRUE(plan) << plan.error().message();
  ASSERT_EQ(plan->size(), 2u);
  EXPECT_EQ((*plan)[0].name(), "setback");
  EXPECT_EQ((*plan)[0].place().text(), (folder_ / "sub/jaw").string() + ":1:1");
}

TEST(ExampleScripts, ArePlansOrScenes) {
  int plans = 0, scenes = 0;
  ScriptOptions with_library;
  with_library.library = [](const std::string& name) -> std::optional<std::string> {
    const std::string* text = library_script(name);
    return text == nullptr ? std::nullopt : std::optional(*text);
  };
  for (const auto& entry : fs::directory_iterator(fs::path(TURGOR_SOURCE_DIR) / "examples")) {
    if (entry.path().extension() != ".turgor") continue;
    const auto plan = parse_script(entry.path(), plan_commands());
    const auto scene = parse_script(entry.path(), scene_commands(), with_library);
    EXPECT_TRUE(plan || scene) << plan.error().message() << "\n" << scene.error().message();
    if (plan) EXPECT_FALSE(plan->empty()) << entry.path();
    plans += plan ? 1 : 0, scenes += scene ? 1 : 0;
  }
  EXPECT_GT(plans, 0);
  EXPECT_GT(scenes, 0);
}

}  // namespace
}  // namespace turgor
