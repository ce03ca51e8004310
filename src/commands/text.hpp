// Characters and words, shared by the lexer, the parser and help.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

#include "turgor/commands/script.hpp"

namespace turgor::commands {

/// The UTF-8 character at the start of `text`: its code point and length in bytes; length 0 where it is
/// malformed (overlong, surrogate, beyond U+10FFFF, cut short) or `text` is empty.
struct Character {
  char32_t code = 0;
  std::size_t bytes = 0;
};
Character decode(std::string_view text);
bool is_utf8(std::string_view text);
/// Characters in `text`; a malformed byte counts as one.
std::size_t character_count(std::string_view text);

/// `text` in single quotes, safe to print: control and malformed bytes as \xNN, long text shortened.
std::string shown(std::string_view text);

/// "a, b or c".
std::string join_alternatives(const std::vector<std::string>& words, std::string_view last = "or");

/// `text` broken at blanks into lines of at most `width` characters, each after the first behind `indent`
/// blanks.
std::string wrapped(std::string_view text, int indent, int width);

/// An error met while something was done for `place`, told from there; as it is where it names a place in
/// that line already.
Error told_at(const SourcePlace& place, const Error& error);

/// The shortest text that reads back as the same number.
std::string format_number(double value);

}  // namespace turgor::commands
