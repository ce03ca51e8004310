// Commands declared once as data. The parser, help, docs/commands.md, shell completion and the schema are all
// made from these tables.
#pragma once

#include <cstdint>
#include <limits>
#include <span>
#include <string>
#include <string_view>

#include "turgor/core/error.hpp"
#include "turgor/core/nearest.hpp"

namespace turgor {

/// What one value of a parameter is, and how many words it takes in a script.
enum class ValueType : std::uint8_t {
  flag,       ///< no words: given or not
  word,       ///< a name: not empty, no blanks
  text,       ///< any text, quoted where it holds blanks
  path,       ///< a file or folder; relative to the working folder
  folder,     ///< a path that names a folder (told apart for completion only)
  choice,     ///< one of `choices`
  command,    ///< the name of a command (told apart for completion only)
  integer,    ///< a whole number within int64
  number,     ///< a finite number
  point,      ///< 3 numbers: x y z, mm, LPS
  offset,     ///< 3 numbers: a displacement, mm, LPS
  direction,  ///< 3 numbers, not all zero; any length
  plane,      ///< 6 numbers: a point (mm), then a normal (not zero; any length)
  axis,       ///< 6 numbers: a point (mm), then a direction (not zero; any length)
  box,        ///< 6 numbers: lower corner, then upper corner, mm; lower < upper along each axis
  sphere,     ///< 4 numbers: centre, then radius > 0, mm
};

/// Unit of a number without a suffix. A suffix of the same dimension is converted: `0.6cm` is 6 mm, `20%` is
/// 0.2.
enum class Unit : std::uint8_t { none, mm, deg, hu, fraction, mpa, newton };
/// As printed: "mm", "deg", "HU", "fraction", "MPa", "N"; empty for none.
std::string_view symbol(Unit unit);

/// Interval of the numbers allowed. Default: all.
struct Range {
  double low = -std::numeric_limits<double>::infinity();
  double high = std::numeric_limits<double>::infinity();
  bool low_open = false, high_open = false;

  [[nodiscard]] constexpr bool contains(double v) const {
    return (low_open ? v > low : v >= low) && (high_open ? v < high : v <= high);
  }
  [[nodiscard]] constexpr bool bounded() const {
    return low > -std::numeric_limits<double>::infinity() || high < std::numeric_limits<double>::infinity();
  }
};
constexpr Range between(double low, double high) {
  return {low, high};
}
constexpr Range at_least(double low) {
  return {.low = low};
}
constexpr Range above(double low) {
  return {.low = low, .low_open = true};
}
constexpr Range above_up_to(double low, double high) {
  return {low, high, true, false};
}

/// How many values follow: {1, 1} one, {3, 3} three, {1, any_number} a list.
struct Count {
  int low = 1, high = 1;
};
constexpr int any_number = std::numeric_limits<int>::max();

/// One parameter of a command. Positional ones take the words that belong to no flag, in order of
/// declaration; the others are written `-name value...`.
struct Parameter {
  std::string_view name = {};
  std::string_view alias = {};  ///< a second spelling of the flag, such as "o"
  ValueType type = ValueType::number;
  Unit unit = Unit::none;  ///< integer and number only
  Range range = {};        ///< integer and number only; of each value
  Count count = {};
  std::span<const std::string_view> choices = {};
  std::string_view label = {};  ///< of the value in usage lines ("DIR"); empty: made from name and type
  std::string_view fallback =
      {};  ///< the default, as it would be typed; empty: none. Of a repeatable: one or more
  bool required = false;
  bool positional = false;
  bool repeatable = false;  ///< the flag may be given several times
  std::string_view help = {};
};

/// How many of a command's optional flags belong together.
struct Rule {
  enum Kind : std::uint8_t { at_least_one, at_most_one, exactly_one, together } kind = at_least_one;
  std::span<const std::string_view> names = {};
};

struct Example {
  std::string_view line = {};  ///< as typed, without the "turgor " of program commands
  std::string_view meaning = {};
};

struct CommandDeclaration {
  std::string_view name = {};         ///< one word, or two ("solver chain")
  std::string_view group = {};        ///< heading in overviews
  std::string_view summary = {};      ///< half a line, no full stop
  std::string_view description = {};  ///< sentences; may be empty
  std::span<const Parameter> parameters = {};
  std::span<const Rule> rules = {};
  std::span<const Example> examples = {};

  /// By name or alias; null where there is none.
  [[nodiscard]] const Parameter* find(std::string_view parameter) const;
};

/// The commands that may stand in one kind of place.
struct CommandTable {
  std::string_view name = {};    ///< "program", "plan"
  std::string_view title = {};   ///< heading
  std::string_view prefix = {};  ///< what goes before a command's name when typed: "turgor "
  std::span<const CommandDeclaration> commands = {};

  [[nodiscard]] const CommandDeclaration* find(std::string_view command) const;
};

/// `turgor info`, `phantom`, `predict` …: the program's own sub-commands.
const CommandTable& program_commands();
/// What a surgical plan may say: corrections of the head, tissue, osteotomies, movements, solvers.
const CommandTable& plan_commands();
/// What a script, the console, a menu or a device may say to a scene: objects, tissue, views, constraints.
const CommandTable& scene_commands();
/// What a problem of calibration may say: body, loads, reference, model, method.
const CommandTable& problem_commands();
/// All tables, for help and documentation.
std::span<const CommandTable* const> command_tables();

/// Names well formed and unique, defaults within range, rules and examples that hold. Error kind: internal.
Result<void> validate(const CommandTable& table);

}  // namespace turgor
