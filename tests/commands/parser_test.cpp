#include <gtest/gtest.h>

#include <cmath>

#include "turgor/commands/script.hpp"

namespace turgor {
namespace {

Result<Invocation> plan_line(std::string_view text) {
  auto parsed = parse_script_text(text, "plan", plan_commands());
  if (!parsed) return parsed.error();
  EXPECT_EQ(parsed->size(), 1u);
  return std::move(parsed->front());
}

Invocation good(std::string_view text) {
  auto parsed = plan_line(text);
  EXPECT_TRUE(parsed) << parsed.error().message();
  return parsed ? *parsed : Invocation{};
}

std::string message(std::string_view text) {
  const auto parsed = plan_line(text);
  EXPECT_FALSE(parsed) << text;
  if (parsed) return "";
  EXPECT_EQ(parsed.error().kind, ErrorKind::bad_command);
  EXPECT_EQ(parsed.error().exit_code(), 2);
  return parsed.error().message();
}

Result<Invocation> arguments(std::vector<std::string> words) {
  return parse_arguments(words, program_commands());
}

std::string argument_message(std::vector<std::string> words) {
  const auto parsed = arguments(std::move(words));
  EXPECT_FALSE(parsed);
  return parsed ? "" : parsed.error().message();
}

TEST(Parser, GivesTypedValues) {
  const Invocation landmark = good("landmark pogonion 0.4 -92.1 -.5");
  EXPECT_EQ(landmark.name(), "landmark");
  EXPECT_EQ(landmark.word("name"), "pogonion");
  EXPECT_EQ(landmark.point("point"), (Vec3{0.4, -92.1, -0.5}));
  EXPECT_EQ(landmark.place().text(), "plan:1:1");

  const Invocation osteotomy =
      good("osteotomy chin -of mandible -plane 0 0 -10 0 0 -2 -box -1 -2 -3 4 5 6 -plane 1 2 3 1 0 0");
  ASSERT_EQ(osteotomy.all("plane").size(), 2u);
  EXPECT_EQ(to_plane(osteotomy.all("plane")[0]).normal, (Vec3{0, 0, -1}));
  EXPECT_EQ(to_plane(osteotomy.all("plane")[0]).offset, 10);
  EXPECT_EQ(to_plane(osteotomy.all("plane")[1]).offset, 1);
  EXPECT_EQ(osteotomy.all("plane")[1].place.text(), "plan:1:78");
  EXPECT_EQ(osteotomy.box("box").lower, (Vec3{-1, -2, -3}));
  EXPECT_EQ(osteotomy.box("box").upper, (Vec3{4, 5, 6}));

  const Invocation rotate = good("rotate chin -axis 1 2 3 0 3 4 -angle -30");
  EXPECT_EQ(rotate.axis("axis").point, (Vec3{1, 2, 3}));
  EXPECT_DOUBLE_EQ(rotate.axis("axis").direction.y, 0.6);
  EXPECT_EQ(rotate.number("angle"), -30);

  const Invocation release = good("release chin -sphere 1 2 3 4");
  EXPECT_EQ(release.sphere("sphere").centre, (Vec3{1, 2, 3}));
  EXPECT_EQ(release.sphere("sphere").radius, 4);
  EXPECT_EQ(good("solver network -max_steps 12").integer("max_steps"), 12);
  EXPECT_TRUE(good("bone_threshold 300 -fixed").flag("fixed"));
}

TEST(Parser, FillsInDefaultsAndTellsThemFromWhatWasGiven) {
  const Invocation chain = good("solver chain -alpha 0.5");
  EXPECT_TRUE(chain.given("alpha"));
  EXPECT_FALSE(chain.given("max_stretch"));
  EXPECT_EQ(chain.number("max_stretch"), 0.5);
  EXPECT_FALSE(good("bone_threshold 300").flag("fixed"));
  EXPECT_TRUE(good("release chin").all("box").empty());

  const auto predict = arguments({"predict", "scan", "-plan", "p", "-o", "d"});
  ASSERT_TRUE(predict) << predict.error().message();
  EXPECT_EQ(predict->words("solver"), (std::vector<std::string>{"chain", "network"}));
  EXPECT_FALSE(predict->given("solver"));
}

TEST(Parser, ConvertsUnits) {
  EXPECT_EQ(good("setback -amount 0.6cm").number("amount"), 6);
  EXPECT_EQ(good("setback -amount 6mm").number("amount"), 6);
  EXPECT_DOUBLE_EQ(good("open_mouth -angle 0.5rad").number("angle"), 28.64788975654116);
  EXPECT_EQ(good("open_mouth -angle 20°").number("angle"), 20);
  EXPECT_EQ(good("material skin -modulus 35kPa").number("modulus"), 0.035);
  EXPECT_EQ(good("solver chain -max_stretch 7%").number("max_stretch"), 0.07);
  EXPECT_EQ(good("bone_threshold 226HU").number("level"), 226);
  EXPECT_EQ(good("move chin -by 1cm -2mm +.5").offset("by"), (Vec3{10, -2, 0.5}));
  EXPECT_EQ(message("open_mouth -angle 20mm"),
            "plan:1:19: -angle of 'open_mouth' must be a number in deg, found '20mm'. Write it without a "
            "unit, or with "
            "deg, ° or rad.");
  EXPECT_NE(message("osteotomy s -of skull -plane 1mm 2mm 3mm 0 0 1mm").find("plan:1:46: "),
            std::string::npos);
}

TEST(Parser, TakesFlagsInAnyOrderAndSpelling) {
  for (const char* line : {"bone_threshold 300 -fixed", "bone_threshold -fixed 300",
                           "bone_threshold --fixed 300", "bone_threshold -fixed -- 300"}) {
    EXPECT_EQ(good(line).text(), "bone_threshold 300 -fixed") << line;
  }
  EXPECT_EQ(good("setback -amount=6").number("amount"), 6);
  EXPECT_EQ(good("setback --amount=6").number("amount"), 6);
  EXPECT_EQ(good("move \"-x\" -by 1 2 3").word("segment"), "-x");
}

TEST(Parser, NamesPlaceFaultAndNearestWord) {
  EXPECT_EQ(message("\n  setbck -amount 6"),
            "plan:2:3: unknown command 'setbck'. The nearest command is 'setback'.");
  EXPECT_EQ(message("setback -amont 6"),
            "plan:1:9: 'setback' has no flag '-amont'. The nearest flag is '-amount'.");
  EXPECT_EQ(message("landmark pogonoin 1 2 3"),
            "plan:1:10: NAME of 'landmark' must be one of 30 words, found 'pogonoin'. The nearest word is "
            "'pogonion'.");
  EXPECT_EQ(message("zygoma -side links -up 3"),
            "plan:1:14: -side of 'zygoma' must be left or right, found 'links'. Write left or right.");
  EXPECT_EQ(message("solver chian -alpha 1"),
            "plan:1:8: 'solver' cannot be followed by 'chian'. The nearest word is 'chain'.");
  EXPECT_EQ(message("solvr chain"), "plan:1:1: unknown command 'solvr'. The nearest command is 'solver'.");
  EXPECT_EQ(message("solver"),
            "plan:1:1: 'solver' must be followed by a second word. Write chain, network or fem.");
  EXPECT_EQ(
      message("-amount 6"),
      "plan:1:1: expected a command, found the flag '-amount'. Write the command first; 'turgor help' lists "
      "them.");
  EXPECT_EQ(message("xyzzy"), "plan:1:1: unknown command 'xyzzy'. 'turgor help' lists the commands.");
}

TEST(Parser, SaysRangeAndUnitOfNumbersBeyondThem) {
  EXPECT_EQ(
      message("open_mouth -angle 55"),
      "plan:1:19: -angle of 'open_mouth' must be 0 to 40 deg, found '55'. Choose a value in that range.");
  EXPECT_EQ(
      message("layers -thickness 1 0 1"),
      "plan:1:21: -thickness of 'layers' must be above 0 to 50 mm, found '0'. Choose a value in that range.");
  EXPECT_EQ(
      message("open_mouth -angle 1e3"),
      "plan:1:19: -angle of 'open_mouth' must be 0 to 40 deg, found '1e3'. Choose a value in that range.");
}

TEST(Parser, RefusesWhatIsNotANumber) {
  for (const char* word :
       {"ten", "nan", "inf", "1e", "0x10", "1.2.3", "--5", "+-5", ".", "''", "1e999", "5e-324e"}) {
    EXPECT_NE(message("setback -amount " + std::string(word)), "") << word;
  }
  EXPECT_NE(message("setback -amount 6,5").find("Write a decimal point"), std::string::npos);
  EXPECT_NE(message("setback -amount \u22126").find("Write the minus sign as -"), std::string::npos);
  EXPECT_NE(message("solver network -max_steps 3.5").find("must be a whole number, found '3.5'"),
            std::string::npos);
  EXPECT_NE(message("solver network -max_steps 99999999999999999999").find("Write a smaller number"),
            std::string::npos);
}

TEST(Parser, SaysWhatIsMissingOrTooMuch) {
  EXPECT_EQ(
      message("setback"),
      "plan:1:1: 'setback' lacks -amount mm: way of the tooth-bearing segment. Usage: setback -amount mm.");
  EXPECT_EQ(message("setback 6"),
            "plan:1:9: 'setback' takes values behind flags only, found '6'. Usage: setback -amount mm.");
  EXPECT_EQ(message("setback -amount"),
            "plan:1:9: -amount of 'setback' needs a number in mm, found nothing. Usage: setback -amount mm.");
  EXPECT_EQ(message("setback -amount 1 -amount 2"),
            "plan:1:19: -amount of 'setback' is given twice. Keep one of them.");
  EXPECT_EQ(message("landmark pogonion 1 2"),
            "plan:1:19: X Y Z of 'landmark' needs 3 numbers (a point x y z) in mm, found 2 of them. Usage: "
            "landmark "
            "NAME X Y Z.");
  EXPECT_EQ(message("landmark pogonion 1 2 3 4"),
            "plan:1:25: 'landmark' takes no further value, found '4'. Usage: landmark NAME X Y Z.");
  EXPECT_EQ(message("bone_threshold 300 -fixed=1"),
            "plan:1:20: -fixed of 'bone_threshold' takes no value. Write -fixed alone.");
}

TEST(Parser, ChecksTheShapeOfShapes) {
  EXPECT_NE(message("occlusal_plane 0 0 0 0 0 0").find("plane's normal is zero"), std::string::npos);
  EXPECT_NE(message("release chin -box 0 0 0 1 -1 1").find("lower y (0) is not below its upper y (-1)"),
            std::string::npos);
  EXPECT_NE(message("release chin -sphere 0 0 0 0").find("radius is not above 0"), std::string::npos);
  EXPECT_NE(message("rotate chin -angle 3 -axis 1 2 3 0 0 -0").find("direction is zero"), std::string::npos);
  const Plane plane = good("occlusal_plane 0 0 0 1e300 0 1e300").plane("plane");
  EXPECT_NEAR(length(plane.normal), 1, 1e-12);
}

TEST(Parser, KeepsCoordinatesWithinReach) {
  EXPECT_EQ(message("move chin -by 0 2000m 0"),
            "plan:1:17: -by of 'move': 2000000 mm is farther than 1000000 mm from the origin. Write "
            "millimetres in the "
            "scan's patient coordinates.");
  EXPECT_NE(message("landmark pogonion 1e300 0 0"), "");
  EXPECT_NE(message("lip_level 1e300"), "");
}

TEST(Parser, HoldsFlagsToTheirRules) {
  EXPECT_EQ(message("osteotomy chin -of mandible").substr(0, 43),
            "plan:1:1: 'osteotomy' needs -plane or -box.");
  EXPECT_NE(
      message("layers -fractions .2 .3 .5 -thickness 1 1 1").find("only one of -fractions or -thickness"),
      std::string::npos);
  EXPECT_NE(message("rotate chin -angle 5").find("takes -angle and -axis together only"), std::string::npos);
  EXPECT_NE(message("rotate chin -about 1 2 3").find("needs -angle, -pitch, -roll or -yaw"),
            std::string::npos);
}

TEST(Parser, PrintsUntrustedTextSafely) {
  const std::string text = argument_message({"predict", "a\x1b[31m\xff"});
  EXPECT_EQ(
      text,
      "command line, argument 2: control character in 'a\\x1b[31m\\xff'. Remove it, or rename the file.");
  const std::string longest(1000, 'x');
  EXPECT_LT(argument_message({longest}).size(), 250u);
}

TEST(Invocation, TextParsesToTheSameCommand) {
  for (const char* line : {"landmark pogonion 0.1 -92.1 1e-7", "move \"a;b\" -by 1cm -2 3",
                           "bone_threshold -fixed 300", "layers -fractions 20% 0.3 0.5", "solver chain",
                           "osteotomy '\"q\\' -of skull -plane 0 0 1 0 0 1 -plane 1 1 1 1 1 1",
                           "move -by 1 2 3 '-segment'", "move '#x' -by 0.1 0.2 0.30000000000000004"}) {
    const std::string text = good(line).text();
    EXPECT_EQ(good(text).text(), text);
    EXPECT_EQ(good(text).command().name, good(line).command().name);
  }
  EXPECT_EQ(good("move -by 1cm -2 3 '#x;y'").text(), "move '#x;y' -by 10 -2 3");
}

TEST(Invocation, MakesErrorsAtThePlaceOfAParameter) {
  const Invocation move = good("move chin -by 1 2 3");
  EXPECT_EQ(move.error("there is no segment 'chin'", "Cut it first", "segment").message(),
            "plan:1:6: there is no segment 'chin'. Cut it first.");
  EXPECT_EQ(move.error("fails", "").message(), "plan:1:1: fails.");
}

TEST(InvocationDeathTest, EndsTheProgramWhenAskedForWhatIsNotDeclared) {
  const Invocation move = good("move chin -by 1 2 3");
  EXPECT_DEATH((void)move.number("amount"), "'amount' of the command 'move' is not declared");
  EXPECT_DEATH((void)good("release chin").box("box"), "has no value: test it with given");
}

TEST(Arguments, AreParsedAsTheProgramGotThem) {
  const auto predict = arguments(
      {"predict", "--plan", "my plan; 1", "scan folder", "-o", "out", "--solver", "chain", "-alpha=0.5"});
  ASSERT_TRUE(predict) << predict.error().message();
  EXPECT_EQ(predict->path("scan"), "scan folder");
  EXPECT_EQ(predict->path("plan"), "my plan; 1");
  EXPECT_EQ(predict->path("output"), "out");
  EXPECT_EQ(predict->words("solver"), (std::vector<std::string>{"chain"}));
  EXPECT_EQ(predict->number("alpha"), 0.5);
  const auto dash = arguments({"info", "--", "-scan"});
  ASSERT_TRUE(dash) << dash.error().message();
  EXPECT_EQ(dash->path("scan"), "-scan");
}

TEST(Arguments, AreNamedByTheirNumberInErrors) {
  EXPECT_EQ(argument_message({"predct"}),
            "command line, argument 1: unknown command 'predct'. The nearest command is 'predict'.");
  EXPECT_EQ(argument_message({"info", "a", "-jsn"}),
            "command line, argument 3: 'info' has no flag '-jsn'. The nearest flag is '-json'.");
  EXPECT_EQ(
      argument_message({"phantom", "-o", "-seed", "3"}),
      "command line, argument 2: -output of 'phantom' needs a folder, found the flag '-seed'. 'turgor help "
      "phantom' explains it.");
}

TEST(Arguments, UnderstandTheCustomaryWaysToAskForHelp) {
  const auto topic = [](std::vector<std::string> words) {
    const auto parsed = arguments(std::move(words));
    EXPECT_TRUE(parsed);
    return parsed ? parsed->text() : "";
  };
  EXPECT_EQ(topic({}), "help");
  EXPECT_EQ(topic({"--help"}), "help");
  EXPECT_EQ(topic({"-h", "predict"}), "help predict");
  EXPECT_EQ(topic({"predict", "scan", "-help"}), "help predict");
  EXPECT_EQ(topic({"help", "solver", "chain"}), "help solver chain");
  EXPECT_EQ(topic({"--version"}), "version");
  EXPECT_EQ(topic({"info", "--", "-h"}), "info '-h'");
}

TEST(NearestWord, FindsSlipsOfTheFingerAndNothingFarther) {
  constexpr std::string_view words[] = {"setback", "le_fort_1", "le_fort_2", "move", "predict"};
  EXPECT_EQ(nearest_word("setbcak", words), "setback");
  EXPECT_EQ(nearest_word("SETBACK", words), "setback");
  EXPECT_EQ(nearest_word("le-fort-2", words), "le_fort_2");
  EXPECT_EQ(nearest_word("lefort1", words), "le_fort_1");
  EXPECT_EQ(nearest_word("pred", words), "predict");
  EXPECT_EQ(nearest_word("rotate", words), "");
  EXPECT_EQ(nearest_word("", words), "");
  EXPECT_EQ(nearest_word(std::string(100'000, 'x'), words), "");
  EXPECT_EQ(nearest_word("x", std::array<std::string_view, 1>{"y"}), "");
}

}  // namespace
}  // namespace turgor
