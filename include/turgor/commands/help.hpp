// Everything a person, a shell or another program is told about the commands, made from their declarations.
#pragma once

#include <span>
#include <string>
#include <string_view>

#include "turgor/commands/declaration.hpp"

namespace turgor {

/// "setback -amount MM"; optional parts in brackets.
std::string usage_line(const CommandDeclaration& command);

/// `turgor help`: every command by group with its summary. Lines of at most `width` characters.
std::string help_overview(std::span<const CommandTable* const> tables, int width = 80);
/// `turgor help COMMAND`: usage, description, each parameter with unit, range and default, examples.
std::string help_command(const CommandTable& table, const CommandDeclaration& command, int width = 80);
/// Either of them by topic: empty for the overview, else the words of a command's name, or "language" for the
/// rules of the command language. Error (bad_command): no such topic, with the nearest one.
Result<std::string> help_topic(std::span<const std::string> topic, int width = 80);

/// docs/commands.md. The same bytes on every machine.
std::string commands_markdown();
/// A JSON Schema (2020-12) of all commands as objects {"command": NAME, parameter: value ...}; what JSON
/// Schema has no word for (units, positional, repeatable, usage) stands under "x-" keys.
std::string commands_schema();

enum class Shell { bash, zsh, fish };
/// A script that completes `turgor`'s commands, flags and values in the shell.
std::string completion_script(Shell shell);

}  // namespace turgor
