// Scripts that complete the program's commands, flags and values in a shell.
#include <fmt/format.h>

#include <map>
#include <set>
#include <sstream>

#include "turgor/commands/help.hpp"
#include "values.hpp"

namespace turgor {
namespace {

/// `text` between single quotes; a quote within is written as the shell needs it.
std::string quoted(std::string_view text, std::string_view inner_quote) {
  std::string out = "'";
  for (const char c : text) out += c == '\'' ? std::string(inner_quote) : std::string(1, c);
  return out + "'";
}

std::string words(std::span<const std::string_view> all) {
  return fmt::format("{}", fmt::join(all, " "));
}

std::string names_of(const CommandTable& table) {
  std::string out;
  for (const auto& command : table.commands) out += (out.empty() ? "" : " ") + std::string(command.name);
  return out;
}

/// Every word that may follow `help`, once.
std::string help_words() {
  std::string all = "language";
  for (const CommandTable* table : command_tables()) all += ' ' + names_of(*table);
  std::istringstream stream(all);
  std::set<std::string> seen;
  std::string out;
  for (std::string word; stream >> word;) {
    if (seen.insert(word).second) out += (out.empty() ? "" : " ") + word;
  }
  return out;
}

/// `-name` and, where there is one, `-alias`.
std::vector<std::string> spellings(const Parameter& parameter) {
  std::vector<std::string> out{"-" + std::string(parameter.name)};
  if (!parameter.alias.empty()) out.push_back("-" + std::string(parameter.alias));
  return out;
}

std::string flags_of(const CommandDeclaration& command) {
  std::string out;
  for (const Parameter& parameter : command.parameters) {
    if (parameter.positional) continue;
    for (const auto& spelling : spellings(parameter)) out += (out.empty() ? "" : " ") + spelling;
  }
  return out;
}

// ---- bash ----

/// The bash statement that fills COMPREPLY with values of this parameter.
std::string bash_values(const Parameter& parameter) {
  switch (parameter.type) {
    case ValueType::path:
      return "_turgor_files -f";
    case ValueType::folder:
      return "_turgor_files -d";
    case ValueType::choice:
      return fmt::format("_turgor_words '{}'", words(parameter.choices));
    case ValueType::command:
      return fmt::format("_turgor_words '{}'", help_words());
    default:
      return "COMPREPLY=()";
  }
}

std::string bash_command(const CommandDeclaration& command) {
  std::map<std::string, std::string> pattern_of;  // by what is offered behind the flag
  std::string positional = "COMPREPLY=()";
  for (const Parameter& parameter : command.parameters) {
    if (parameter.positional) {
      positional = bash_values(parameter);
    } else if (parameter.type != ValueType::flag) {
      std::string& pattern = pattern_of[bash_values(parameter)];
      for (const auto& spelling : spellings(parameter)) {
        pattern += fmt::format("{}{}|-{}", pattern.empty() ? "" : "|", spelling, spelling);
      }
    }
  }
  std::string text = fmt::format("    {})\n", command.name);
  if (!pattern_of.empty()) {
    text += "      case $previous in\n";
    for (const auto& [values, pattern] : pattern_of) {
      text += fmt::format("        {})\n          {}; return ;;\n", pattern, values);
    }
    text += "      esac\n";
  }
  const std::string flags = flags_of(command);
  if (flags.empty()) return text + fmt::format("      {} ;;\n", positional);
  return text + fmt::format("      if [[ $current == -* ]]; then _turgor_words '{}'; else {}; fi ;;\n", flags,
                            positional);
}

std::string bash_script() {
  std::string text =
      "# Completion for turgor in bash. Made by `turgor commands -format bash`.\n"
      "_turgor_words() { mapfile -t COMPREPLY < <(compgen -W \"$1\" -- \"${COMP_WORDS[COMP_CWORD]}\"); }\n"
      "_turgor_files() {\n"
      "  compopt -o filenames 2>/dev/null\n"
      "  mapfile -t COMPREPLY < <(compgen \"$1\" -- \"${COMP_WORDS[COMP_CWORD]}\")\n"
      "}\n"
      "_turgor() {\n"
      "  local current=${COMP_WORDS[COMP_CWORD]} previous=${COMP_WORDS[COMP_CWORD-1]}\n";
  text += fmt::format("  if (( COMP_CWORD == 1 )); then _turgor_words '{}'; return; fi\n",
                      names_of(program_commands()));
  text += "  case ${COMP_WORDS[1]} in\n";
  for (const auto& command : program_commands().commands) text += bash_command(command);
  return text + "  esac\n}\ncomplete -F _turgor turgor\n";
}

// ---- zsh ----

std::string zsh_quoted(std::string_view text) {
  return quoted(text, "'\\''");
}

/// Within an _arguments specification, brackets and colons part the fields.
std::string zsh_escaped(std::string_view text) {
  std::string out;
  for (const char c : text) {
    if (c == '[' || c == ']' || c == ':' || c == '\\') out += '\\';
    out += c;
  }
  return out;
}

std::string zsh_action(const Parameter& parameter) {
  switch (parameter.type) {
    case ValueType::path:
      return "_files";
    case ValueType::folder:
      return "_files -/";
    case ValueType::choice:
      return fmt::format("({})", words(parameter.choices));
    case ValueType::command:
      return fmt::format("({})", help_words());
    default:
      return " ";
  }
}

std::string zsh_argument(const Parameter& parameter) {
  const std::string message = zsh_escaped(commands::describe_value(parameter));
  const Count count = commands::word_count(parameter);
  const std::string value = fmt::format(":{}:{}", message, zsh_action(parameter));
  if (parameter.positional) return zsh_quoted((count.high == 1 ? "" : "*") + value);
  std::string values;
  if (count.high == any_number) {
    values = ":*" + value;
  } else {
    for (int i = 0; i < count.high; ++i) values += value;
  }
  std::string text;
  for (const auto& spelling : spellings(parameter)) {
    text += fmt::format("{}{}", text.empty() ? "" : " ",
                        zsh_quoted(fmt::format("{}{}[{}]{}", parameter.repeatable ? "*" : "", spelling,
                                               zsh_escaped(parameter.help), values)));
  }
  return text;
}

std::string zsh_script() {
  std::string text =
      "#compdef turgor\n# Completion for turgor in zsh. Made by `turgor commands -format zsh`.\n"
      "_turgor() {\n  if (( CURRENT == 2 )); then\n    local -a names=(\n";
  for (const auto& command : program_commands().commands) {
    text += fmt::format("      {}\n", zsh_quoted(fmt::format("{}:{}", command.name, command.summary)));
  }
  text +=
      "    )\n    _describe command names\n    return\n  fi\n  shift words\n  (( CURRENT-- ))\n  case "
      "$words[1] in\n";
  for (const auto& command : program_commands().commands) {
    text += fmt::format("    {})\n", command.name);
    if (command.parameters.empty()) {
      text += "      _message 'no arguments' ;;\n";
      continue;
    }
    text += "      _arguments -S";
    for (const Parameter& parameter : command.parameters) text += " \\\n        " + zsh_argument(parameter);
    text += " ;;\n";
  }
  // Autoloaded from $fpath the file is the function's own body; sourced, it announces itself.
  return text +
         "  esac\n}\nif [[ $funcstack[1] == _turgor ]]; then _turgor \"$@\"; else compdef _turgor turgor; "
         "fi\n";
}

// ---- fish ----

std::string fish_quoted(std::string_view text) {
  return quoted(text, "\\'");
}

std::string fish_values(const Parameter& parameter) {
  switch (parameter.type) {
    case ValueType::path:
      return " -rF";
    case ValueType::folder:
      return " -xa '(__fish_complete_directories)'";
    case ValueType::choice:
      return fmt::format(" -xa {}", fish_quoted(words(parameter.choices)));
    case ValueType::command:
      return fmt::format(" -xa {}", fish_quoted(help_words()));
    case ValueType::flag:
      return "";
    default:
      return " -x";
  }
}

std::string fish_script() {
  std::string text =
      "# Completion for turgor in fish. Made by `turgor commands -format fish`.\ncomplete -c turgor -f\n";
  for (const auto& command : program_commands().commands) {
    text += fmt::format("complete -c turgor -n __fish_use_subcommand -a {} -d {}\n", command.name,
                        fish_quoted(command.summary));
  }
  for (const auto& command : program_commands().commands) {
    const std::string head =
        fmt::format("complete -c turgor -n '__fish_seen_subcommand_from {}'", command.name);
    for (const Parameter& parameter : command.parameters) {
      if (parameter.positional) {
        const std::string values = parameter.type == ValueType::path ? " -F" : fish_values(parameter);
        text += head + values + '\n';
        continue;
      }
      const std::string alias = parameter.alias.size() == 1 ? fmt::format(" -s {}", parameter.alias) : "";
      text += fmt::format("{} -o {}{}{} -d {}\n", head, parameter.name, alias, fish_values(parameter),
                          fish_quoted(parameter.help));
    }
  }
  return text;
}

}  // namespace

std::string completion_script(Shell shell) {
  switch (shell) {
    case Shell::bash:
      return bash_script();
    case Shell::zsh:
      return zsh_script();
    case Shell::fish:
      return fish_script();
  }
  return {};
}

}  // namespace turgor
