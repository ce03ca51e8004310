// Words to typed values, and the phrases that describe values to people.
#pragma once

#include <algorithm>
#include <array>
#include <span>
#include <string>
#include <string_view>

#include "turgor/commands/script.hpp"
#include "turgor/tissue/network.hpp"

namespace turgor::commands {

/// Words that one value of this type takes: 3 for a point, 0 for a flag.
int words_per_value(ValueType type);
/// Fewest and most words after the flag (or at the position); any_number stays any_number.
Count word_count(const Parameter& parameter);
bool is_numeric(ValueType type);

/// "-angle" or "NAME", as a user sees it.
std::string title(const Parameter& parameter);
/// "NAME", "X Y Z", "MM MM MM", "WORD...", the value part of a usage line.
std::string value_label(const Parameter& parameter);
/// "3 numbers (x y z) in mm", "draft, normal or fine".
std::string describe_value(const Parameter& parameter);
/// "0 to 40", "above 0", "at least 1", "from above 0 to 1"; empty where all numbers are allowed.
std::string describe_range(const Parameter& parameter);

/// A spring law by its name, or by its number in the thesis's scripts (scene_parameters.hpp).
SpringLaw law_named(std::string_view word);

/// The one of `values` that name_of() calls `word`: a choice of the declaration, so that there is one.
template <class Value, std::size_t count>
Value value_named(std::string_view word, const std::array<Value, count>& values) {
  return *std::ranges::find_if(values, [&](Value v) { return name_of(v) == word; });
}

/// "Give at least one of -box or -sphere."
std::string describe_rule(const Rule& rule);

/// The value that `words` spell; their number fits word_count(). Errors name the place of the word at fault.
Result<Argument> convert(const CommandDeclaration& command, const Parameter& parameter,
                         std::span<const Word> words);

/// The remedy of an unknown word: the nearest of the candidates, else all of them where they are few, else
/// `otherwise`.
std::string suggestion(std::string_view kind, std::string_view word,
                       std::span<const std::string_view> candidates, std::string_view otherwise);

}  // namespace turgor::commands
