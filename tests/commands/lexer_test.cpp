#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <map>

#include "turgor/commands/script.hpp"
#include "turgor/core/file.hpp"

namespace turgor {
namespace {

using Lines = std::vector<std::vector<std::string>>;

Lines words_of(const std::vector<ScriptLine>& lines) {
  Lines out;
  for (const ScriptLine& line : lines) {
    auto& words = out.emplace_back();
    if (line.include) words.push_back("#include");
    for (const Word& word : line.words) words.push_back(word.text);
  }
  return out;
}

Lines lexed(std::string_view text) {
  const auto lines = lex(text, "t");
  EXPECT_TRUE(lines) << lines.error().message();
  return lines ? words_of(*lines) : Lines{};
}

std::string message(std::string_view text) {
  const auto lines = lex(text, "t");
  EXPECT_FALSE(lines);
  if (lines) return "";
  EXPECT_EQ(lines.error().kind, ErrorKind::bad_command);
  return lines.error().message();
}

TEST(Lexer, PartsWordsAtBlanksAndDropsCommentsAndEmptyLines) {
  EXPECT_EQ(lexed("a b\tc\n\n  ; only a comment\nd;e f\n#another\ng h#i #j\n"),
            (Lines{{"a", "b", "c"}, {"d"}, {"g", "h#i"}}));
  EXPECT_EQ(lexed(""), Lines{});
  EXPECT_EQ(lexed("last"), (Lines{{"last"}}));
}

TEST(Lexer, EndsLinesAtLfCrLfAndCr) {
  EXPECT_EQ(lexed("a 1\r\nb 2\rc 3\nd"), (Lines{{"a", "1"}, {"b", "2"}, {"c", "3"}, {"d"}}));
  const auto lines = lex("a\r\n\r\nb", "t");
  ASSERT_TRUE(lines);
  EXPECT_EQ((*lines)[1].words[0].place.text(), "t:3:1");
}

TEST(Lexer, QuotesAsShellsDo) {
  EXPECT_EQ(lexed(R"(a "b c" 'd ; # "e' f\ g h"i"'j')"), (Lines{{"a", "b c", "d ; # \"e", "f g", "hij"}}));
  EXPECT_EQ(lexed(R"("\" \\ \n" '\n\' \" "")"), (Lines{{"\" \\ \\n", "\\n\\", "\"", ""}}));
  const auto lines = lex(R"(-a "-b" \-c -"d" '')", "t");
  ASSERT_TRUE(lines);
  std::vector<bool> quoted;
  for (const Word& word : lines->front().words) quoted.push_back(word.quoted);
  EXPECT_EQ(quoted, (std::vector<bool>{false, true, true, true, true}));
}

TEST(Lexer, JoinsLinesAfterABackslash) {
  EXPECT_EQ(lexed("a \\\n  b\\\r\nc \\\nd\ne"), (Lines{{"a", "bc", "d"}, {"e"}}));
  EXPECT_EQ(lexed("; a comment ends at its line \\\nb"), (Lines{{"b"}}));
  EXPECT_EQ(lexed("a\\"), (Lines{{"a"}}));
  const auto lines = lex("a \\\n  b\nc", "t");
  ASSERT_TRUE(lines);
  EXPECT_EQ((*lines)[0].words[1].place.text(), "t:2:3");
  EXPECT_EQ((*lines)[1].words[0].place.text(), "t:3:1");
}

TEST(Lexer, CountsColumnsInCharactersNotBytes) {
  const auto lines = lex("\xEF\xBB\xBFnähe \"größer als\" x", "t");
  ASSERT_TRUE(lines);
  const auto& words = lines->front().words;
  ASSERT_EQ(words.size(), 3u);
  EXPECT_EQ(words[0].place.text(), "t:1:1");
  EXPECT_EQ(words[1].place.text(), "t:1:6");
  EXPECT_EQ(words[2].place.text(), "t:1:19");
}

TEST(Lexer, TakesNoBreakSpacesForBlanks) {
  EXPECT_EQ(lexed("a\u00A0b\u2009c"), (Lines{{"a", "b", "c"}}));
}

TEST(Lexer, NamesThePlaceOfWhatIsNotText) {
  EXPECT_EQ(message("a b\nc 'd"), "t:2:3: the quote ' is not closed on its line. Add a closing '.");
  EXPECT_EQ(message("\"a\nb\""), "t:1:1: the quote \" is not closed on its line. Add a closing \".");
  EXPECT_EQ(message(std::string("a\nb \0 c", 7)),
            "t:2:3: a zero byte: this is not a text file. Name a script, or save it as UTF-8.");
  EXPECT_EQ(message("a \x1b[31m"), "t:1:3: control character '\\x1b'. Remove it.");
  EXPECT_EQ(message("a b\xE9t\xE9"), "t:1:4: byte '\\xe9' is not UTF-8. Save the script as UTF-8.");
  EXPECT_EQ(message("\xFF\xFE"
                    "a"),
            "t:1:1: the text is UTF-16. Save the script as UTF-8.");
  EXPECT_EQ(message("a \xC0\x80"), "t:1:3: byte '\\xc0' is not UTF-8. Save the script as UTF-8.");
  EXPECT_EQ(message("a \xED\xA0\x80"), "t:1:3: byte '\\xed' is not UTF-8. Save the script as UTF-8.");
}

TEST(Lexer, LetsOtherEncodingsThroughWithinComments) {
  EXPECT_EQ(lexed("; d\xE9j\xE0 \x1b vu\na"), (Lines{{"a"}}));
}

TEST(Lexer, KnowsIncludesFromComments) {
  EXPECT_EQ(lexed("#include a.b ; c\n  #include \"d e\"\n#included f\n# include g\nx #include h"),
            (Lines{{"#include", "a.b"}, {"#include", "d e"}, {"x"}}));
  EXPECT_EQ(message("a\n #include"),
            "t:2:2: #include must be followed by the name of one file. Write #include FILE, the name in "
            "quotes where "
            "it holds blanks.");
  EXPECT_NE(message("#include a b").find("t:1:1: #include"), std::string::npos);
  EXPECT_NE(message("#include ''").find("t:1:1: #include"), std::string::npos);
}

// ---- the scripts of the thesis ----

std::filesystem::path thesis_folder() {
  return std::filesystem::path(TURGOR_SOURCE_DIR).parent_path() / "shared/data/scripts";
}

std::vector<ScriptLine> thesis_script(const std::string& name) {
  const auto text = read_text_file(thesis_folder() / name);
  if (!text) return {};
  const auto lines = lex(*text, name);
  EXPECT_TRUE(lines) << lines.error().message();
  return lines ? *lines : std::vector<ScriptLine>{};
}

std::map<std::string, int> command_counts(const std::vector<ScriptLine>& lines) {
  std::map<std::string, int> counts;
  for (const ScriptLine& line : lines) ++counts[line.include ? "#include" : line.words.front().text];
  return counts;
}

TEST(ThesisScripts, LexIntoTheirCommands) {
  if (!std::filesystem::exists(thesis_folder())) GTEST_SKIP() << thesis_folder() << " is not there";
  using Counts = std::map<std::string, int>;
  EXPECT_EQ(command_counts(thesis_script("wound_closure.bolio")), (Counts{{"#include", 1},
                                                                          {"instance_object", 1},
                                                                          {"flesh_out", 1},
                                                                          {"triangulate", 1},
                                                                          {"visible", 1},
                                                                          {"add_muscle", 12},
                                                                          {"setup", 3},
                                                                          {"damping", 1},
                                                                          {"simulate", 1}}));
  EXPECT_EQ(command_counts(thesis_script("balldrape.bolio")), (Counts{{"#include", 1},
                                                                      {"instance_object", 4},
                                                                      {"edit_xform", 2},
                                                                      {"colors", 3},
                                                                      {"flesh_out", 1},
                                                                      {"triangulate", 1},
                                                                      {"visible", 1},
                                                                      {"gravity_face", 1},
                                                                      {"drape", 2},
                                                                      {"damping", 1},
                                                                      {"simulate", 1}}));
  EXPECT_EQ(command_counts(thesis_script("twitch.bolio")), (Counts{{"#include", 1},
                                                                   {"instance_object", 3},
                                                                   {"edit_xform", 3},
                                                                   {"harden", 1},
                                                                   {"colors", 2},
                                                                   {"flesh_out", 1},
                                                                   {"triangulate", 1},
                                                                   {"visible", 1},
                                                                   {"gravity_face", 1},
                                                                   {"drape", 1},
                                                                   {"add_muscle", 6},
                                                                   {"setup", 1},
                                                                   {"damping", 1},
                                                                   {"simulate", 1}}));
}

TEST(ThesisScripts, KeepFlagsNumbersAndPlaces) {
  if (!std::filesystem::exists(thesis_folder())) GTEST_SKIP() << thesis_folder() << " is not there";
  const auto wound = thesis_script("wound_closure.bolio");
  ASSERT_FALSE(wound.empty());
  EXPECT_EQ(words_of(wound).front(), (std::vector<std::string>{"#include", "lookat_wound"}));
  EXPECT_EQ(words_of(wound).back(), (std::vector<std::string>{"simulate", "-dt", "0.01", "-skip", "5",
                                                              "-runge_kutta", "-until", "100"}));
  const auto ball = thesis_script("balldrape.bolio");
  ASSERT_GT(ball.size(), 5u);
  EXPECT_EQ(words_of(ball)[5], (std::vector<std::string>{"edit_xform", "floor", "-t", "0", "0", "-0.2501",
                                                         "-s", "4", "4", "1"}));
  EXPECT_EQ(ball[5].words[5].place.text(), "balldrape.bolio:15:25");
}

// The thesis's notation under declarations such as its commands will have.
TEST(ThesisScripts, ParseUnderDeclarationsOfTheirCommands) {
  constexpr Parameter drape[] = {{.name = "c", .help = "constant"},
                                 {.name = "s", .type = ValueType::word, .help = "sphere"},
                                 {.name = "p", .type = ValueType::word, .help = "plane"}};
  constexpr Parameter edit[] = {
      {.name = "object", .type = ValueType::word, .required = true, .positional = true, .help = "which"},
      {.name = "t", .type = ValueType::offset, .help = "translate"},
      {.name = "s", .count = {3, 3}, .help = "scale"}};
  constexpr Parameter setup[] = {
      {.name = "muscle", .type = ValueType::word, .required = true, .positional = true, .help = "which"},
      {.name = "keys",
       .count = {2, any_number},
       .required = true,
       .positional = true,
       .help = "times and scales"},
      {.name = "start", .help = "time"}};
  constexpr Parameter simulate[] = {{.name = "dt", .range = above(0), .help = "step"},
                                    {.name = "skip", .type = ValueType::integer, .help = "steps"},
                                    {.name = "runge_kutta", .type = ValueType::flag, .help = "order 2"},
                                    {.name = "until", .help = "time"}};
  const CommandDeclaration commands[] = {{.name = "drape", .parameters = drape},
                                         {.name = "edit_xform", .parameters = edit},
                                         {.name = "setup twitch", .parameters = setup},
                                         {.name = "simulate", .parameters = simulate}};
  const CommandTable table{.name = "world", .title = "", .prefix = "", .commands = commands};
  const auto parsed = parse_script_text(
      "edit_xform floor -t 0 0 -0.2501 -s 4 4 1\n"
      "drape -c 1000 -s ball\n"
      "setup twitch skinsuture 0 1 5 0.1 10 0.01 40 0.01 50 .5 -start 0.5\n"
      "simulate -dt 0.05 -skip 2 -runge_kutta -until 50\n",
      "t", table);
  ASSERT_TRUE(parsed) << parsed.error().message();
  EXPECT_EQ((*parsed)[0].offset("t"), (Vec3{0, 0, -0.2501}));
  EXPECT_EQ((*parsed)[0].numbers("s"), (std::vector<double>{4, 4, 1}));
  EXPECT_EQ((*parsed)[1].word("s"), "ball");
  EXPECT_EQ((*parsed)[2].name(), "setup twitch");
  EXPECT_EQ((*parsed)[2].numbers("keys"), (std::vector<double>{0, 1, 5, 0.1, 10, 0.01, 40, 0.01, 50, 0.5}));
  EXPECT_EQ((*parsed)[2].number("start"), 0.5);
  EXPECT_TRUE((*parsed)[3].flag("runge_kutta"));
  EXPECT_EQ((*parsed)[3].integer("skip"), 2);
}

}  // namespace
}  // namespace turgor
