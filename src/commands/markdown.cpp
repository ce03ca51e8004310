// docs/commands.md.
#include <fmt/format.h>

#include <algorithm>

#include "language.hpp"
#include "turgor/commands/help.hpp"
#include "values.hpp"

namespace turgor {
namespace {

std::string code(std::string_view text) {
  return fmt::format("`{}`", text);
}

/// Text within a table's cell.
std::string cell(std::string_view text) {
  std::string out;
  for (const char c : text) out += c == '|' ? "\\|" : std::string(1, c);
  return out;
}

std::string anchor(const CommandTable& table, const CommandDeclaration& command) {
  std::string id = fmt::format("{}-{}", table.name, command.name);
  std::ranges::replace(id, ' ', '-');
  return id;
}

std::string parameter_row(const Parameter& parameter) {
  std::string name = code(commands::title(parameter));
  if (!parameter.positional && !parameter.alias.empty())
    name += ", " + code(fmt::format("-{}", parameter.alias));
  std::string value = commands::describe_value(parameter);
  if (parameter.type == ValueType::choice) {
    value.clear();
    for (const auto choice : parameter.choices) value += (value.empty() ? "" : ", ") + code(choice);
  }
  const std::string fallback = parameter.required           ? "required"
                               : parameter.fallback.empty() ? ""
                                                            : code(parameter.fallback);
  return fmt::format("| {} | {} | {} | {} | {}{} |\n", cell(name), cell(value),
                     cell(commands::describe_range(parameter)), cell(fallback), cell(parameter.help),
                     parameter.repeatable ? "; may be repeated" : "");
}

std::string command_section(const CommandTable& table, const CommandDeclaration& command) {
  std::string text = fmt::format("<a id=\"{}\"></a>\n### {}{}\n\n{}.\n\n", anchor(table, command),
                                 table.prefix, command.name, command.summary);
  text += fmt::format("```\n{}{}\n```\n\n", table.prefix, usage_line(command));
  if (!command.description.empty()) text += fmt::format("{}\n\n", command.description);
  if (!command.parameters.empty()) {
    text += "| parameter | value | range | default | meaning |\n| --- | --- | --- | --- | --- |\n";
    for (const Parameter& parameter : command.parameters) text += parameter_row(parameter);
    text += '\n';
  }
  for (const Rule& rule : command.rules) text += commands::describe_rule(rule) + "\n\n";
  for (const Example& example : command.examples) {
    text += fmt::format("- {}: {}\n", code(fmt::format("{}{}", table.prefix, example.line)), example.meaning);
  }
  return text + '\n';
}

std::string overview(const CommandTable& table) {
  std::string text;
  std::string_view group;
  for (const auto& command : table.commands) {
    if (command.group != group) {
      group = command.group;
      text += fmt::format("{}**{}**\n\n", text.empty() ? "" : "\n", group);
    }
    text += fmt::format("- [{}{}](#{}): {}\n", table.prefix, command.name, anchor(table, command),
                        command.summary);
  }
  return text + '\n';
}

}  // namespace

std::string commands_markdown() {
  std::string text =
      "# Commands\n\n"
      "<!-- Made by `turgor commands -format md` from the declarations in src/commands; do not edit. -->\n\n";
  text += fmt::format("## The language\n\n{}\n", commands::kLanguage);
  for (const CommandTable* table : command_tables()) {
    text += fmt::format("## {}\n\n{}", table->title, overview(*table));
    for (const auto& command : table->commands) text += command_section(*table, command);
  }
  text.pop_back();
  return text;
}

}  // namespace turgor
