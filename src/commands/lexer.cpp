#include <algorithm>

#include "text.hpp"
#include "turgor/commands/script.hpp"

namespace turgor {
namespace {

using commands::Character;
using commands::decode;
using commands::shown;

constexpr std::string_view kIncludeWord = "#include";

/// Blanks that come along when text is copied from pages and word processors.
bool is_wide_blank(char32_t c) {
  return c == 0xA0 || c == 0x2009 || c == 0x202F || c == 0x3000 || c == 0xFEFF;
}
bool is_blank(char32_t c) {
  return c == ' ' || c == '\t' || c == '\v' || c == '\f' || is_wide_blank(c);
}
bool is_line_end(char c) {
  return c == '\n' || c == '\r';
}

class Lexer {
 public:
  Lexer(std::string_view text, std::string_view file_name)
      : rest_(text), file_(std::make_shared<const std::string>(file_name)) {}

  Result<std::vector<ScriptLine>> run() {
    TURGOR_CHECK(check_encoding());
    std::vector<ScriptLine> lines;
    while (!rest_.empty()) {
      TURGOR_TRY(ScriptLine line, read_line());
      if (!line.words.empty()) lines.push_back(std::move(line));
    }
    return lines;
  }

 private:
  [[nodiscard]] SourcePlace place() const { return {file_, line_, column_}; }
  [[nodiscard]] Error fault(const SourcePlace& at, std::string what, std::string remedy) const {
    return {ErrorKind::bad_command, std::move(what), at.text(), std::move(remedy)};
  }

  Result<void> check_encoding() {
    if (rest_.starts_with("\xFF\xFE") || rest_.starts_with("\xFE\xFF")) {
      return fault(place(), "the text is UTF-16", "Save the script as UTF-8");
    }
    if (rest_.starts_with("\xEF\xBB\xBF")) rest_.remove_prefix(3);
    const std::size_t zero = rest_.find('\0');
    if (zero == std::string_view::npos) return {};
    const std::size_t left_at_zero = rest_.size() - zero;
    while (rest_.size() > left_at_zero) skip_character();
    return fault(place(), "a zero byte: this is not a text file", "Name a script, or save it as UTF-8");
  }

  /// Moves past one character (or one malformed byte), counting lines.
  void skip_character() {
    if (rest_.starts_with("\r\n")) rest_.remove_prefix(1);
    const bool ends_line = is_line_end(rest_.front());
    rest_.remove_prefix(std::max<std::size_t>(decode(rest_).bytes, 1));
    column_ = ends_line ? 1 : column_ + 1;
    if (ends_line) ++line_;
  }
  [[nodiscard]] bool at_line_end() const { return rest_.empty() || is_line_end(rest_.front()); }
  void skip_comment() {
    while (!at_line_end()) skip_character();
  }
  /// A backslash that joins the next line; moves past both.
  bool skip_continuation() {
    if (rest_.size() < 2 || rest_[0] != '\\' || !is_line_end(rest_[1])) return false;
    skip_character();
    skip_character();
    return true;
  }
  void skip_blanks() {
    while (!at_line_end()) {
      if (skip_continuation()) continue;
      if (!is_blank(decode(rest_).code)) return;
      skip_character();
    }
  }

  /// The character here, or why it may not stand in a script.
  Result<Character> checked_character() const {
    const Character c = decode(rest_);
    if (c.bytes == 0) {
      return fault(place(), "byte " + shown(rest_.substr(0, 1)) + " is not UTF-8",
                   "Save the script as UTF-8");
    }
    if ((c.code < 0x20 && c.code != '\t') || c.code == 0x7F) {
      return fault(place(), "control character " + shown(rest_.substr(0, 1)), "Remove it");
    }
    return c;
  }
  Result<void> take_character(std::string& text) {
    TURGOR_TRY(const Character c, checked_character());
    text += rest_.substr(0, c.bytes);
    skip_character();
    return {};
  }

  Result<void> read_quoted(std::string& text) {
    const SourcePlace start = place();
    const char quote = rest_.front();
    skip_character();
    while (!at_line_end() && rest_.front() != quote) {
      const bool escape =
          quote == '"' && rest_.front() == '\\' && rest_.size() > 1 && (rest_[1] == '"' || rest_[1] == '\\');
      if (escape) skip_character();
      TURGOR_CHECK(take_character(text));
    }
    if (at_line_end()) {
      return fault(start, std::string("the quote ") + quote + " is not closed on its line",
                   std::string("Add a closing ") + quote);
    }
    skip_character();
    return {};
  }

  Result<Word> read_word() {
    Word word{{}, false, place()};
    while (!at_line_end() && rest_.front() != ';' && !is_blank(decode(rest_).code)) {
      if (rest_.front() == '"' || rest_.front() == '\'') {
        word.quoted = true;
        TURGOR_CHECK(read_quoted(word.text));
      } else if (skip_continuation()) {
        continue;
      } else {
        if (rest_.front() == '\\') {
          word.quoted = true;
          skip_character();
          if (rest_.empty()) break;
        }
        TURGOR_CHECK(take_character(word.text));
      }
    }
    return word;
  }

  [[nodiscard]] bool at_include() const {
    if (!rest_.starts_with(kIncludeWord)) return false;
    const std::string_view after = rest_.substr(kIncludeWord.size());
    return after.empty() || is_line_end(after.front()) || is_blank(decode(after).code);
  }

  Result<ScriptLine> read_line() {
    ScriptLine line;
    skip_blanks();
    const SourcePlace start = place();
    if (at_include()) {
      line.include = true;
      for (std::size_t i = 0; i < kIncludeWord.size(); ++i) skip_character();
    }
    for (skip_blanks(); !at_line_end(); skip_blanks()) {
      if (rest_.front() == ';' || rest_.front() == '#') {
        skip_comment();
        break;
      }
      TURGOR_TRY(Word word, read_word());
      line.words.push_back(std::move(word));
    }
    if (!rest_.empty()) skip_character();
    if (line.include && (line.words.size() != 1 || line.words[0].text.empty())) {
      return fault(start, "#include must be followed by the name of one file",
                   "Write #include FILE, the name in quotes where it holds blanks");
    }
    return line;
  }

  std::string_view rest_;
  std::shared_ptr<const std::string> file_;
  int line_ = 1, column_ = 1;
};

}  // namespace

std::string SourcePlace::text() const {
  const std::string name = file && !file->empty() ? *file : "command line";
  if (line == 0) return column == 0 ? name : name + ", argument " + std::to_string(column);
  return name + ":" + std::to_string(line) + ":" + std::to_string(column);
}

Result<std::vector<ScriptLine>> lex(std::string_view text, std::string_view file_name) {
  return Lexer(text, file_name).run();
}

}  // namespace turgor
