#include "turgor/commands/help.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "language.hpp"
#include "text.hpp"
#include "values.hpp"

namespace turgor {

using commands::character_count;
using commands::wrapped;

namespace {

/// The command's name and, one string each, its parameters.
std::vector<std::string> usage_parts(const CommandDeclaration& command) {
  std::vector<std::string> parts{std::string(command.name)};
  const auto append = [&](const Parameter& parameter) {
    std::string part = commands::value_label(parameter);
    if (!parameter.positional) {
      const std::string flag = fmt::format("-{}", parameter.alias.empty() ? parameter.name : parameter.alias);
      part = part.empty() ? flag : flag + ' ' + part;
    }
    if (!parameter.required) part = '[' + part + ']';
    if (parameter.repeatable) part += "...";
    parts.push_back(std::move(part));
  };
  for (const Parameter& parameter : command.parameters) {
    if (parameter.positional) append(parameter);
  }
  for (const bool required : {true, false}) {
    for (const Parameter& parameter : command.parameters) {
      if (!parameter.positional && parameter.required == required) append(parameter);
    }
  }
  return parts;
}

/// "Usage: ...", broken between parameters.
std::string wrapped_usage(const CommandTable& table, const CommandDeclaration& command, int width) {
  constexpr std::string_view head = "Usage: ";
  constexpr char joint = '\x1f';  // stands for a blank that does not break
  std::string line(table.prefix);
  for (std::string& part : usage_parts(command)) {
    std::ranges::replace(part, ' ', joint);
    line += (line.empty() || line.ends_with(' ') ? "" : " ") + part;
  }
  std::string text = wrapped(std::string(head) + line, static_cast<int>(head.size()), width);
  std::ranges::replace(text, joint, ' ');
  return text + '\n';
}

}  // namespace

std::string usage_line(const CommandDeclaration& command) {
  return fmt::format("{}", fmt::join(usage_parts(command), " "));
}

namespace {

constexpr int kIndent = 2;

/// "  name   text text", the text wrapped behind a column.
std::string entry(std::string_view name, std::string_view text, int column, int width) {
  std::string line = std::string(kIndent, ' ') + std::string(name);
  const int used = static_cast<int>(character_count(line));
  if (used + 2 > column) {
    line += '\n' + std::string(static_cast<std::size_t>(column), ' ');
  } else {
    line.append(static_cast<std::size_t>(column - used), ' ');
  }
  return line + wrapped(text, column, width) + '\n';
}

std::string flag_title(const Parameter& parameter) {
  std::string name = commands::title(parameter);
  if (!parameter.positional) {
    if (!parameter.alias.empty()) name = fmt::format("-{}, {}", parameter.alias, name);
    if (const auto value = commands::value_label(parameter); !value.empty()) name += ' ' + value;
  }
  return name;
}

/// "whole number", "0 to 20 mm", "mm": what the numbers of a value may be.
std::string number_details(const Parameter& parameter) {
  const bool shape = parameter.type != ValueType::number && parameter.type != ValueType::integer;
  const std::string_view unit = shape ? "mm" : parameter.unit == Unit::fraction ? "" : symbol(parameter.unit);
  const std::string range = commands::describe_range(parameter);
  std::string text = parameter.type == ValueType::integer ? "whole number" : "";
  if (!range.empty()) text += (text.empty() ? "" : ", ") + range;
  if (!unit.empty() && parameter.type != ValueType::direction)
    text += fmt::format("{}{}", text.empty() ? "" : " ", unit);
  return text;
}

/// What follows the help text: choices, range and unit, default.
std::string details(const Parameter& parameter) {
  std::vector<std::string> parts;
  constexpr std::size_t few = 5;  // so many stand in the usage line already
  if (parameter.type == ValueType::choice && parameter.choices.size() > few) {
    const std::vector<std::string> choices(parameter.choices.begin(), parameter.choices.end());
    parts.push_back(commands::join_alternatives(choices));
  }
  if (commands::is_numeric(parameter.type)) parts.push_back(number_details(parameter));
  if (!parameter.fallback.empty()) parts.push_back(fmt::format("default {}", parameter.fallback));
  if (parameter.required && !parameter.positional) parts.emplace_back("required");
  if (parameter.repeatable) parts.emplace_back("may be repeated");
  std::erase(parts, "");
  return parts.empty() ? "" : fmt::format(" ({})", fmt::join(parts, "; "));
}

}  // namespace

std::string help_overview(std::span<const CommandTable* const> tables, int width) {
  std::size_t longest = 0;
  for (const CommandTable* table : tables) {
    for (const auto& command : table->commands) longest = std::max(longest, command.name.size());
  }
  const int column = kIndent + static_cast<int>(longest) + 2;
  std::string text = "turgor: from a head CT to the predicted face after surgery\n";
  for (const CommandTable* table : tables) {
    text += fmt::format("\n{}{}\n", table->title,
                        table->prefix.empty() ? ", in a script" : fmt::format(": {}COMMAND", table->prefix));
    std::string_view group;
    for (const auto& command : table->commands) {
      if (command.group != group) text += fmt::format("\n {}\n", group = command.group);
      text += entry(command.name, command.summary, column, width);
    }
  }
  text += "\n'turgor help COMMAND' explains one of them, 'turgor help language' the notation of scripts.\n";
  return text;
}

std::string help_command(const CommandTable& table, const CommandDeclaration& command, int width) {
  constexpr int column = 24;
  std::string text =
      wrapped(fmt::format("{}{}: {}", table.prefix, command.name, command.summary), 0, width) + "\n\n";
  text += wrapped_usage(table, command, width);
  if (!command.description.empty()) text += '\n' + wrapped(command.description, 0, width) + '\n';
  if (!command.parameters.empty()) text += '\n';
  for (const Parameter& parameter : command.parameters) {
    text += entry(flag_title(parameter), std::string(parameter.help) + details(parameter), column, width);
  }
  if (!command.rules.empty()) text += '\n';
  for (const Rule& rule : command.rules) text += wrapped(commands::describe_rule(rule), 0, width) + '\n';
  text += "\nExamples:\n";
  for (const Example& example : command.examples) {
    text += fmt::format("  {}{}\n      {}\n", table.prefix, example.line, wrapped(example.meaning, 6, width));
  }
  return text;
}

Result<std::string> help_topic(std::span<const std::string> topic, int width) {
  if (topic.empty()) return help_overview(command_tables(), width);
  const std::string name = fmt::format("{}", fmt::join(topic, " "));
  if (name == "language") return std::string(commands::kLanguage);
  std::vector<std::string_view> names{"language"};
  std::string with_first_word;
  for (const CommandTable* table : command_tables()) {
    if (const auto* command = table->find(name)) return help_command(*table, *command, width);
    for (const auto& command : table->commands) {
      names.push_back(command.name);
      if (!command.name.starts_with(name + ' ')) continue;
      with_first_word += (with_first_word.empty() ? "" : "\n\n") + help_command(*table, command, width);
    }
  }
  if (!with_first_word.empty()) return with_first_word;
  return Error{ErrorKind::bad_command, "no command " + commands::shown(name), "",
               commands::suggestion("command", name, names, "'turgor help' lists the commands")};
}

}  // namespace turgor
