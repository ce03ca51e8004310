#include "text.hpp"

#include <fmt/format.h>

#include <algorithm>

namespace turgor::commands {

Character decode(std::string_view text) {
  if (text.empty()) return {};
  const auto byte = [&](std::size_t i) { return static_cast<unsigned char>(text[i]); };
  const unsigned char lead = byte(0);
  if (lead < 0x80) return {lead, 1};
  const std::size_t bytes = lead >= 0xF0 ? 4 : lead >= 0xE0 ? 3 : 2;
  if (lead < 0xC2 || lead > 0xF4 || text.size() < bytes) return {};
  char32_t code = lead & (0x7Fu >> bytes);
  for (std::size_t i = 1; i < bytes; ++i) {
    if ((byte(i) & 0xC0) != 0x80) return {};
    code = code << 6 | (byte(i) & 0x3Fu);
  }
  constexpr char32_t least[] = {0, 0, 0x80, 0x800, 0x10000};
  if (code < least[bytes] || code > 0x10FFFF || (code >= 0xD800 && code <= 0xDFFF)) return {};
  return {code, bytes};
}

bool is_utf8(std::string_view text) {
  while (!text.empty()) {
    const Character c = decode(text);
    if (c.bytes == 0) return false;
    text.remove_prefix(c.bytes);
  }
  return true;
}

std::size_t character_count(std::string_view text) {
  std::size_t count = 0;
  for (; !text.empty(); ++count) text.remove_prefix(std::max<std::size_t>(decode(text).bytes, 1));
  return count;
}

std::string shown(std::string_view text) {
  constexpr std::size_t longest = 60;
  std::string out = "'";
  for (std::size_t count = 0; !text.empty(); ++count) {
    if (count == longest) return out + "...'";
    const Character c = decode(text);
    const bool control = c.code < 0x20 || (c.code >= 0x7F && c.code < 0xA0);
    if (c.bytes == 0 || control) {
      out += fmt::format("\\x{:02x}", static_cast<unsigned char>(text.front()));
      text.remove_prefix(1);
    } else {
      out += text.substr(0, c.bytes);
      text.remove_prefix(c.bytes);
    }
  }
  return out + "'";
}

std::string join_alternatives(const std::vector<std::string>& words, std::string_view last) {
  std::string out;
  for (std::size_t i = 0; i < words.size(); ++i) {
    if (i > 0) out += i + 1 == words.size() ? fmt::format(" {} ", last) : ", ";
    out += words[i];
  }
  return out;
}

std::string wrapped(std::string_view text, int indent, int width) {
  std::string out;
  std::size_t column = static_cast<std::size_t>(indent);
  bool first = true;
  while (!text.empty()) {
    const std::size_t end = std::min(text.find(' '), text.size());
    const std::string_view word = text.substr(0, end);
    const std::size_t size = character_count(word);
    if (!first && column + 1 + size > static_cast<std::size_t>(width)) {
      out += '\n' + std::string(static_cast<std::size_t>(indent), ' ');
      column = static_cast<std::size_t>(indent);
    } else if (!first) {
      out += ' ';
      ++column;
    }
    out += word;
    column += size;
    first = false;
    text.remove_prefix(std::min(end + 1, text.size()));
  }
  return out;
}

Error told_at(const SourcePlace& place, const Error& error) {
  const std::string line = place.line > 0 ? fmt::format("{}:{}:", *place.file, place.line) : place.text();
  if (error.where.starts_with(line)) return error;
  const std::string what = error.where.empty() ? error.what : error.where + ": " + error.what;
  return {error.kind, what, place.text(), error.remedy};
}

std::string format_number(double value) {
  return fmt::format("{}", value);
}

}  // namespace turgor::commands
