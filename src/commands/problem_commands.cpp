// What a problem of calibration may say: the table of all its commands.
#include <algorithm>
#include <array>

#include "problem_model.hpp"
#include "turgor/commands/declaration.hpp"

namespace turgor {
namespace {

constexpr auto kProblemCommands = [] {
  using commands::kProblemBodyCommands;
  using commands::kProblemModelCommands;
  std::array<CommandDeclaration, std::size(kProblemBodyCommands) + std::size(kProblemModelCommands)> all;
  std::ranges::copy(kProblemModelCommands, std::ranges::copy(kProblemBodyCommands, all.begin()).out);
  return all;
}();

}  // namespace

const CommandTable& problem_commands() {
  static constexpr CommandTable table{
      .name = "problem", .title = "Commands of a problem", .prefix = "", .commands = kProblemCommands};
  return table;
}

}  // namespace turgor
