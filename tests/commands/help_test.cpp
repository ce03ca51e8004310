#include <gtest/gtest.h>
#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>

#include "support/shell.hpp"
#include "turgor/commands/help.hpp"
#include "turgor/commands/script.hpp"
#include "turgor/core/file.hpp"

namespace turgor {
namespace {
namespace fs = std::filesystem;

template <class Visit>
void for_each_command(Visit&& visit) {
  for (const CommandTable* table : command_tables()) {
    for (const CommandDeclaration& command : table->commands) visit(*table, command);
  }
}

TEST(Documentation, IsWhatTheDeclarationsSay) {
  const fs::path path = fs::path(TURGOR_SOURCE_DIR) / "docs/commands.md";
  if (std::getenv("TURGOR_UPDATE_DOCS") != nullptr) {
    ASSERT_TRUE(write_file(path, commands_markdown()));
  }
  const auto text = read_text_file(path);
  ASSERT_TRUE(text) << text.error().message();
  EXPECT_EQ(*text, commands_markdown())
      << "run this test with TURGOR_UPDATE_DOCS=1 to write docs/commands.md anew";
}

TEST(Documentation, HasASectionAndALinkForEveryCommandAndParameter) {
  const std::string text = commands_markdown();
  for_each_command([&](const CommandTable& table, const CommandDeclaration& command) {
    const std::string title = std::string(table.prefix) + std::string(command.name);
    EXPECT_NE(text.find("\n### " + title + "\n"), std::string::npos) << title;
    EXPECT_NE(text.find("- [" + title + "](#"), std::string::npos) << title;
    for (const Parameter& parameter : command.parameters) {
      EXPECT_NE(text.find(parameter.help), std::string::npos) << parameter.name;
    }
  });
}

TEST(Help, ListsEveryCommand) {
  const std::string text = help_overview(command_tables());
  for_each_command([&](const CommandTable&, const CommandDeclaration& command) {
    EXPECT_NE(text.find("  " + std::string(command.name) + " "), std::string::npos) << command.name;
    EXPECT_NE(text.find(command.group), std::string::npos) << command.group;
  });
}

TEST(Help, OfACommandShowsUsageUnitRangeDefaultAndExamples) {
  const auto text = help_topic(std::vector<std::string>{"genioplasty"});
  ASSERT_TRUE(text) << text.error().message();
  EXPECT_EQ(*text,
            "genioplasty: Cut and move the chin\n"
            "\n"
            "Usage: genioplasty [-forward mm] [-up mm] [-left mm]\n"
            "\n"
            "The lower border of the chin becomes the segment chin.\n"
            "\n"
            "  -forward mm           advancement; below 0 setback (-15 to 20 mm; default 0)\n"
            "  -up mm                below 0 down (-15 to 15 mm; default 0)\n"
            "  -left mm              below 0 to the right (-15 to 15 mm; default 0)\n"
            "\n"
            "Give at least one of -forward, -up or -left.\n"
            "\n"
            "Examples:\n"
            "  genioplasty -forward 6 -up 2\n"
            "      a chin that is too low and too far back\n");
}

TEST(Help, KeepsToTheWidth) {
  for (const int width : {60, 80, 120}) {
    for_each_command([&](const CommandTable& table, const CommandDeclaration& command) {
      std::istringstream lines(help_command(table, command, width));
      bool examples = false;  // are shown as they are typed
      for (std::string line; std::getline(lines, line);) {
        examples = examples || line == "Examples:";
        if (!examples && line.find("  [-") == std::string::npos) {
          EXPECT_LE(line.size(), static_cast<std::size_t>(width)) << line;
        }
      }
    });
  }
}

TEST(Help, FindsTopicsOfTwoWordsAndTheNearest) {
  EXPECT_TRUE(help_topic(std::vector<std::string>{"solver", "chain"}));
  const auto both = help_topic(std::vector<std::string>{"solver"});
  ASSERT_TRUE(both);
  EXPECT_NE(both->find("solver chain:"), std::string::npos);
  EXPECT_NE(both->find("solver network:"), std::string::npos);
  EXPECT_TRUE(help_topic(std::vector<std::string>{"language"}));
  EXPECT_TRUE(help_topic({}));
  const auto wrong = help_topic(std::vector<std::string>{"setbak"});
  ASSERT_FALSE(wrong);
  EXPECT_EQ(wrong.error().message(), "no command 'setbak'. The nearest command is 'setback'.");
}

// ---- completion ----

class Completion : public ::testing::Test {
 protected:
  void SetUp() override {
    folder_ = fs::temp_directory_path() / ("turgor_completion_test_" + std::to_string(::getpid()));
    fs::create_directories(folder_);
  }
  void TearDown() override { fs::remove_all(folder_); }

  static bool has(const std::string& name) { return support::shell("command -v " + name).code == 0; }
  std::string put(const std::string& name, std::string_view text) {
    EXPECT_TRUE(write_file(folder_ / name, text));
    return (folder_ / name).string();
  }

  fs::path folder_;
};

TEST_F(Completion, NamesEveryCommandAndFlag) {
  for (const Shell shell : {Shell::bash, Shell::zsh, Shell::fish}) {
    const std::string script = completion_script(shell);
    for (const auto& command : program_commands().commands) {
      EXPECT_NE(script.find(command.name), std::string::npos) << command.name;
      for (const Parameter& parameter : command.parameters) {
        if (parameter.positional) continue;
        const std::string flag = (shell == Shell::fish ? "-o " : "-") + std::string(parameter.name);
        EXPECT_NE(script.find(flag), std::string::npos) << flag;
      }
    }
    for (const auto& command : plan_commands().commands) {  // as topics of help
      EXPECT_NE(script.find(command.name.substr(0, command.name.find(' '))), std::string::npos)
          << command.name;
    }
  }
}

TEST_F(Completion, IsSoundShell) {
  const std::pair<Shell, std::string> shells[] = {
      {Shell::bash, "bash"}, {Shell::zsh, "zsh"}, {Shell::fish, "fish"}};
  int checked = 0;
  for (const auto& [shell, name] : shells) {
    if (!has(name)) continue;
    const support::Outcome checking =
        support::shell(name + " -n " + put("completion." + name, completion_script(shell)) + " 2>&1");
    EXPECT_EQ(checking.code, 0) << checking.text;
    ++checked;
  }
  if (checked == 0) GTEST_SKIP() << "no shell to check with";
}

TEST_F(Completion, OfBashOffersCommandsFlagsAndChoices) {
  if (!has("bash")) GTEST_SKIP() << "bash is not installed";
  const std::string script = put("completion.bash", completion_script(Shell::bash));
  const auto offered = [&](const std::string& words, int current) {
    const std::string program = "source " + script + "; COMP_WORDS=(" + words +
                                "); COMP_CWORD=" + std::to_string(current) +
                                "; _turgor; echo \"${COMPREPLY[*]}\"";
    return support::shell("bash -c '" + program + "' 2>&1").text;
  };
  EXPECT_EQ(offered("turgor ph", 1), "phantom\n");
  EXPECT_EQ(offered("turgor predict -qu", 2), "-quality\n");
  EXPECT_EQ(offered("turgor predict scan -solver \"\"", 4), "chain network solid fem\n");
  EXPECT_EQ(offered("turgor predict --quality f", 3), "fine\n");
  EXPECT_EQ(offered("turgor help le_fort_3", 2), "le_fort_3\n");
  EXPECT_EQ(offered("turgor phantom -seed \"\"", 3), "\n");
}

// ---- schema ----

TEST(Schema, HoldsEveryCommandWithUnitRangeAndDefault) {
  const auto schema = nlohmann::json::parse(commands_schema());
  const auto& definitions = schema.at("$defs");
  std::size_t count = 0;
  for_each_command([&](const CommandTable& table, const CommandDeclaration& command) {
    std::string key = std::string(table.name) + "." + std::string(command.name);
    std::replace(key.begin(), key.end(), ' ', '_');
    const auto& definition = definitions.at(key);
    ++count;
    EXPECT_EQ(definition.at("properties").size(), command.parameters.size() + 1);
    EXPECT_EQ(definition.at("properties").at("command").at("const"), command.name);
    for (const Parameter& parameter : command.parameters) {
      const auto& property = definition.at("properties").at(std::string(parameter.name));
      EXPECT_EQ(property.at("description"), parameter.help);
      EXPECT_EQ(property.contains("default"),
                !parameter.fallback.empty() || parameter.type == ValueType::flag);
    }
  });
  EXPECT_EQ(definitions.size(), count);
  EXPECT_EQ(schema.at("oneOf").size(), count);

  const auto& angle = definitions.at("plan.open_mouth").at("properties").at("angle");
  EXPECT_EQ(angle.at("minimum"), 0);
  EXPECT_EQ(angle.at("maximum"), 40);
  EXPECT_EQ(angle.at("x-unit"), "deg");
  EXPECT_EQ(definitions.at("plan.open_mouth").at("required"), nlohmann::json::array({"command", "angle"}));
  const auto& plane = definitions.at("plan.osteotomy").at("properties").at("plane");
  EXPECT_EQ(plane.at("type"), "array");
  EXPECT_EQ(plane.at("items").at("minItems"), 6);
  EXPECT_EQ(definitions.at("program.predict").at("properties").at("solver").at("default"),
            nlohmann::json::array({"chain", "network"}));
}

}  // namespace
}  // namespace turgor
