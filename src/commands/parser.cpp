#include <fmt/format.h>

#include <algorithm>

#include "text.hpp"
#include "turgor/commands/help.hpp"
#include "turgor/commands/script.hpp"
#include "values.hpp"

namespace turgor {

using commands::shown;

/// One command from its words.
class InvocationParser {
 public:
  InvocationParser(std::span<const Word> words, const CommandTable& table, const Parameter** missing)
      : words_(words), table_(table), missing_(missing) {}

  Result<Invocation> run() {
    TURGOR_CHECK(find_command());
    TURGOR_CHECK(read_words());
    TURGOR_CHECK(place_positionals());
    TURGOR_CHECK(fill_defaults());
    TURGOR_CHECK(check_rules());
    return std::move(invocation_);
  }

 private:
  [[nodiscard]] const CommandDeclaration& command() const { return *invocation_.command_; }
  [[nodiscard]] std::string usage() const {
    constexpr std::size_t longest = 100;  // what still reads as a part of a sentence
    const std::string line = usage_line(command());
    if (line.size() <= longest) return fmt::format("Usage: {}{}", table_.prefix, line);
    return fmt::format("'{}help {}' explains it", program_commands().prefix, command().name);
  }
  static Error fault(const SourcePlace& place, std::string what, std::string remedy) {
    return {ErrorKind::bad_command, std::move(what), place.text(), std::move(remedy)};
  }
  static bool is_flag(const Word& word) {
    if (word.quoted || !word.text.starts_with('-')) return false;
    const std::size_t at = word.text.starts_with("--") ? 2 : 1;
    const char c = at < word.text.size() ? word.text[at] : '\0';
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z');
  }

  /// Two words are tried before one, so that "solver chain" is found before any "solver".
  Result<void> find_command() {
    const Word& first = words_.front();
    if (words_.size() > 1) {
      invocation_.command_ = table_.find(first.text + ' ' + words_[1].text);
      next_ = 2;
    }
    if (invocation_.command_ == nullptr) {
      invocation_.command_ = table_.find(first.text);
      next_ = 1;
    }
    if (invocation_.command_ == nullptr) return unknown_command();
    invocation_.place_ = first.place;
    invocation_.values_.resize(command().parameters.size());
    invocation_.given_.resize(command().parameters.size());
    return {};
  }

  [[nodiscard]] Error unknown_command() const {
    const Word& first = words_.front();
    if (is_flag(first)) {
      return fault(first.place, fmt::format("expected a command, found the flag {}", shown(first.text)),
                   fmt::format("Write the command first; '{}help' lists them", program_commands().prefix));
    }
    std::vector<std::string_view> names;
    std::vector<std::string_view> second_words;
    for (const CommandDeclaration& candidate : table_.commands) {
      names.push_back(candidate.name.substr(0, candidate.name.find(' ')));
      if (candidate.name.starts_with(first.text + ' ')) {
        second_words.push_back(candidate.name.substr(first.text.size() + 1));
      }
    }
    const std::string list = fmt::format("'{}help' lists the commands", program_commands().prefix);
    if (!second_words.empty()) {
      const Word& at = words_.size() > 1 ? words_[1] : first;
      return fault(at.place,
                   words_.size() > 1
                       ? fmt::format("'{}' cannot be followed by {}", first.text, shown(at.text))
                       : fmt::format("'{}' must be followed by a second word", first.text),
                   commands::suggestion("word", words_.size() > 1 ? at.text : "", second_words, list));
    }
    return fault(first.place, "unknown command " + shown(first.text),
                 commands::suggestion("command", first.text, names, list));
  }

  Result<void> read_words() {
    bool flags_over = false;
    while (next_ < words_.size()) {
      const Word& word = words_[next_];
      if (!flags_over && !word.quoted && word.text == "--") {
        flags_over = true;
        ++next_;
      } else if (!flags_over && is_flag(word)) {
        TURGOR_CHECK(read_flag());
      } else {
        positionals_.push_back(word);
        ++next_;
      }
    }
    return {};
  }

  Result<void> read_flag() {
    const Word& word = words_[next_++];
    std::string_view name = std::string_view(word.text).substr(word.text.starts_with("--") ? 2 : 1);
    std::vector<Word> values;
    const std::size_t equals = name.find('=');
    if (equals != std::string_view::npos) {
      values.push_back({std::string(name.substr(equals + 1)), true, word.place});
      name = name.substr(0, equals);
    }
    const Parameter* parameter = command().find(name);
    if (parameter == nullptr || parameter->positional) return unknown_flag(word, name);
    const std::size_t index = invocation_.index(parameter->name);
    if (invocation_.given_[index] && !parameter->repeatable) {
      return fault(word.place, fmt::format("-{} of '{}' is given twice", parameter->name, command().name),
                   "Keep one of them");
    }
    invocation_.given_[index] = true;
    const Count count = commands::word_count(*parameter);
    while (next_ < words_.size() && values.size() < static_cast<std::size_t>(count.high) &&
           !is_flag(words_[next_]) && (words_[next_].quoted || words_[next_].text != "--")) {
      values.push_back(words_[next_++]);
    }
    return add(*parameter, values, word.place);
  }

  [[nodiscard]] Error unknown_flag(const Word& word, std::string_view name) const {
    std::vector<std::string_view> names;
    for (const Parameter& parameter : command().parameters) {
      if (!parameter.positional) names.push_back(parameter.name);
    }
    const auto nearest = nearest_word(name, names);
    return fault(word.place, fmt::format("'{}' has no flag {}", command().name, shown(word.text)),
                 !nearest.empty() ? fmt::format("The nearest flag is '-{}'", nearest)
                 : names.empty()  ? fmt::format("It takes no flags. {}", usage())
                                  : usage());
  }

  /// Checks the number of words and converts them.
  Result<void> add(const Parameter& parameter, std::span<const Word> values, const SourcePlace& place) {
    const Count count = commands::word_count(parameter);
    if (parameter.type == ValueType::flag) {
      if (values.empty()) return {};
      return fault(place, fmt::format("-{} of '{}' takes no value", parameter.name, command().name),
                   fmt::format("Write -{} alone", parameter.name));
    }
    if (values.size() < static_cast<std::size_t>(count.low)) {
      const Word* after = next_ < words_.size() ? &words_[next_] : nullptr;
      const std::string found = !values.empty()                  ? fmt::format("{} of them", values.size())
                                : after && !parameter.positional ? "the flag " + shown(after->text)
                                                                 : "nothing";
      return fault(place,
                   fmt::format("{} of '{}' needs {}, found {}", commands::title(parameter), command().name,
                               commands::describe_value(parameter), found),
                   usage());
    }
    TURGOR_TRY(Argument argument, commands::convert(command(), parameter, values));
    invocation_.values_[invocation_.index(parameter.name)].push_back(std::move(argument));
    return {};
  }

  Result<void> place_positionals() {
    std::span<const Word> left = positionals_;
    for (std::size_t i = 0; i < command().parameters.size() && !left.empty(); ++i) {
      const Parameter& parameter = command().parameters[i];
      if (!parameter.positional) continue;
      const auto most = static_cast<std::size_t>(commands::word_count(parameter).high);
      const auto values = left.first(std::min(most, left.size()));
      next_ = words_.size();
      TURGOR_CHECK(add(parameter, values, values.front().place));
      invocation_.given_[i] = true;
      left = left.subspan(values.size());
    }
    if (left.empty()) return {};
    const bool none = std::ranges::none_of(command().parameters, &Parameter::positional);
    return fault(
        left.front().place,
        fmt::format("'{}' takes {}, found {}", command().name,
                    none ? "values behind flags only" : "no further value", shown(left.front().text)),
        usage());
  }

  [[nodiscard]] Error missing(const Parameter& parameter) const {
    std::string flag = commands::title(parameter);
    if (!parameter.positional) flag += ' ' + commands::value_label(parameter);
    return fault(invocation_.place_, fmt::format("'{}' lacks {}: {}", command().name, flag, parameter.help),
                 usage());
  }

  Result<void> fill_defaults() {
    for (std::size_t i = 0; i < command().parameters.size(); ++i) {
      const Parameter& parameter = command().parameters[i];
      if (invocation_.given_[i]) continue;
      if (parameter.required) {
        if (missing_ != nullptr) *missing_ = &parameter;
        return missing(parameter);
      }
      if (!parameter.fallback.empty()) TURGOR_CHECK(add_default(parameter));
    }
    return {};
  }

  Result<void> add_default(const Parameter& parameter) {
    TURGOR_TRY(auto lines, lex(parameter.fallback, ""));
    for (Word& word : lines.at(0).words) word.place = {};
    std::span<const Word> left = lines.at(0).words;
    while (!left.empty()) {
      const auto most = static_cast<std::size_t>(commands::word_count(parameter).high);
      const auto values = left.first(std::min(most, left.size()));
      TURGOR_CHECK(add(parameter, values, {}));
      left = left.subspan(values.size());
    }
    return {};
  }

  Result<void> check_rules() const {
    for (const Rule& rule : command().rules) {
      const auto given =
          std::ranges::count_if(rule.names, [&](auto name) { return invocation_.given(name); });
      std::vector<std::string> names;
      for (const auto name : rule.names) names.push_back("-" + std::string(name));
      const bool few = (rule.kind == Rule::at_least_one || rule.kind == Rule::exactly_one) && given == 0;
      const bool many = (rule.kind == Rule::at_most_one || rule.kind == Rule::exactly_one) && given > 1;
      const bool torn = rule.kind == Rule::together && given != 0 && given != std::ssize(rule.names);
      const std::string all = commands::join_alternatives(names, torn ? "and" : "or");
      if (few) return fault(invocation_.place_, fmt::format("'{}' needs {}", command().name, all), usage());
      if (many) {
        return fault(invocation_.place_, fmt::format("'{}' takes only one of {}", command().name, all),
                     "Keep one of them");
      }
      if (torn) {
        return fault(invocation_.place_, fmt::format("'{}' takes {} together only", command().name, all),
                     usage());
      }
    }
    return {};
  }

  std::span<const Word> words_;
  const CommandTable& table_;
  const Parameter** missing_;
  std::size_t next_ = 0;
  std::vector<Word> positionals_;
  Invocation invocation_;
};

Result<Invocation> parse_line(const ScriptLine& line, const CommandTable& table, const Parameter** missing) {
  if (line.words.empty()) {
    return Error{ErrorKind::bad_command, "expected a command, found nothing", "",
                 fmt::format("'{}help' lists the commands", program_commands().prefix)};
  }
  if (line.include) {
    return Error{ErrorKind::bad_command, "#include cannot be followed here", line.words.front().place.text(),
                 "Put the included commands in its place"};
  }
  return InvocationParser(line.words, table, missing).run();
}

Result<std::vector<Invocation>> parse_lines(std::span<const ScriptLine> lines, const CommandTable& table) {
  std::vector<Invocation> invocations;
  invocations.reserve(lines.size());
  for (const ScriptLine& line : lines) {
    TURGOR_TRY(Invocation invocation, parse_line(line, table));
    invocations.push_back(std::move(invocation));
  }
  return invocations;
}

namespace {

bool is_one_of(std::string_view word, std::initializer_list<std::string_view> words) {
  return std::ranges::find(words, word) != words.end();
}

/// What stands for `help` and `version` in other programs stands for them here.
std::vector<std::string> with_customary_flags(std::span<const std::string> arguments,
                                              const CommandTable& table) {
  std::vector<std::string> words(arguments.begin(), arguments.end());
  const auto end = std::ranges::find(words, "--");
  const bool wants_help = words.empty() || std::any_of(words.begin(), end, [](const std::string& word) {
                            return is_one_of(word, {"-h", "-help", "--help"});
                          });
  if (wants_help) {
    const auto command = std::find_if(words.begin(), end, [&](const std::string& word) {
      return word != "help" && table.find(word) != nullptr;
    });
    if (command == end) return {"help"};
    return {"help", *command};
  }
  if (words.size() == 1 && is_one_of(words.front(), {"--version", "-version", "-V"})) return {"version"};
  return words;
}

}  // namespace

Result<Invocation> parse_arguments(std::span<const std::string> arguments, const CommandTable& table) {
  ScriptLine line;
  const auto file = std::make_shared<const std::string>();
  for (const std::string& text : with_customary_flags(arguments, table)) {
    const int number = static_cast<int>(line.words.size()) + 1;
    line.words.push_back({text, false, {file, 0, number}});
    if (std::ranges::any_of(text, [](char c) { return static_cast<unsigned char>(c) < 0x20 || c == 0x7F; })) {
      return Error{ErrorKind::bad_command, "control character in " + shown(text),
                   line.words.back().place.text(), "Remove it, or rename the file"};
    }
  }
  return parse_line(line, table);
}

}  // namespace turgor
