#include <fmt/format.h>

#include <algorithm>
#include <set>
#include <string>

#include "turgor/commands/declaration.hpp"
#include "turgor/commands/script.hpp"
#include "values.hpp"

namespace turgor {

const Parameter* CommandDeclaration::find(std::string_view parameter) const {
  for (const Parameter& p : parameters) {
    if (p.name == parameter || (!p.alias.empty() && p.alias == parameter)) return &p;
  }
  return nullptr;
}

const CommandDeclaration* CommandTable::find(std::string_view command) const {
  const auto found = std::ranges::find(commands, command, &CommandDeclaration::name);
  return found == commands.end() ? nullptr : &*found;
}

std::span<const CommandTable* const> command_tables() {
  static const CommandTable* const tables[] = {&program_commands(), &plan_commands(), &scene_commands(),
                                               &problem_commands()};
  return tables;
}

namespace {

bool is_name(std::string_view text) {
  const auto letter = [](char c) { return c >= 'a' && c <= 'z'; };
  return !text.empty() && letter(text.front()) &&
         std::ranges::all_of(text, [&](char c) { return letter(c) || c == '_' || (c >= '0' && c <= '9'); });
}

bool is_command_name(std::string_view text) {
  const std::size_t blank = text.find(' ');
  if (blank == std::string_view::npos) return is_name(text);
  return is_name(text.substr(0, blank)) && is_name(text.substr(blank + 1));
}

/// Collects what is wrong with one declaration; the first fault counts.
class Validator {
 public:
  Validator(const CommandTable& table, const CommandDeclaration& command)
      : table_(table), command_(command) {}

  Result<void> run() {
    if (!is_command_name(command_.name)) fail("the name is not one or two words of a-z, 0-9 and _");
    if (command_.summary.empty() || command_.summary.ends_with('.'))
      fail("the summary is empty or ends with a stop");
    if (command_.group.empty()) fail("there is no group");
    if (command_.examples.empty()) fail("there is no example");
    for (const Parameter& parameter : command_.parameters) check(parameter);
    check_order();
    for (const Rule& rule : command_.rules) check(rule);
    if (fault_.empty()) check_examples();
    if (fault_.empty()) return {};
    return Error{ErrorKind::internal, fault_, fmt::format("{}{}", table_.prefix, command_.name),
                 "Correct the declaration"};
  }

 private:
  void fail(std::string what) {
    if (fault_.empty()) fault_ = std::move(what);
  }

  void check(const Parameter& p) {
    const auto bad = [&](std::string_view what) { fail(fmt::format("{}: {}", p.name, what)); };
    const bool flag = p.type == ValueType::flag, number = p.type == ValueType::number,
               integer = p.type == ValueType::integer;
    if (!is_name(p.name)) bad("not a name of a-z, 0-9 and _");
    if (!names_.insert(p.name).second) bad("declared twice");
    if (!p.alias.empty() && (!is_name(p.alias) || !names_.insert(p.alias).second)) bad("bad alias");
    if (p.help.empty() || p.help.ends_with('.')) bad("the help text is empty or ends with a stop");
    if (flag && (p.required || p.positional || p.repeatable || !p.fallback.empty()))
      bad("a flag is only on or off");
    if (p.required && !p.fallback.empty()) bad("required, so its default never counts");
    if ((p.type == ValueType::choice) == p.choices.empty()) bad("choices go with the type choice");
    if (!number && !integer && (p.range.bounded() || p.unit != Unit::none))
      bad("range or unit without a number");
    if (p.range.bounded() && !(p.range.low <= p.range.high)) bad("the range is empty");
    if (p.count.low < 1 || p.count.high < p.count.low) bad("the count is empty");
    if (p.count.high != 1 && !number && !integer && p.type > ValueType::command) bad("a list of shapes");
    if (p.positional && (p.repeatable || !p.alias.empty()))
      bad("positional, so neither repeatable nor with an alias");
    if (fault_.empty() && !p.fallback.empty()) check_default(p);
  }

  void check_default(const Parameter& p) {
    const auto lines = lex(p.fallback, "default");
    const auto bad = [&](std::string_view what) { fail(fmt::format("default of {}: {}", p.name, what)); };
    if (!lines || lines->size() != 1) return bad("is not one line");
    std::span<const Word> words = lines->front().words;
    const Count count = commands::word_count(p);
    const std::size_t each = p.repeatable ? static_cast<std::size_t>(count.high) : words.size();
    for (; !words.empty(); words = words.subspan(std::min(each, words.size()))) {
      const auto value = words.first(std::min(each, words.size()));
      if (std::ssize(value) < count.low || std::ssize(value) > count.high)
        return bad("has the wrong number of words");
      if (const auto converted = commands::convert(command_, p, value); !converted) {
        return bad(converted.error().message());
      }
    }
  }

  /// Optional positionals stand last, and only the last may be of open length.
  void check_order() {
    bool optional = false, open = false;
    for (const Parameter& p : command_.parameters) {
      if (!p.positional) continue;
      if (open) fail(fmt::format("{}: stands behind a list", p.name));
      if (optional && p.required) fail(fmt::format("{}: required behind an optional one", p.name));
      optional = optional || !p.required;
      open = open || p.count.high != p.count.low;
    }
  }

  void check(const Rule& rule) {
    if (rule.names.size() < 2) fail("a rule of fewer than two flags");
    for (const auto name : rule.names) {
      const Parameter* p = command_.find(name);
      if (p == nullptr || p->required || p->positional)
        fail(fmt::format("rule about {}: not an optional flag", name));
    }
  }

  void check_examples() {
    for (const Example& example : command_.examples) {
      const auto parsed = parse_script_text(example.line, "example", table_);
      if (!parsed) return fail(parsed.error().message());
      if (parsed->size() != 1 || &parsed->front().command() != &command_)
        fail("an example of something else");
      if (example.meaning.empty() || example.meaning.ends_with('.')) fail("an example without a meaning");
    }
  }

  const CommandTable& table_;
  const CommandDeclaration& command_;
  std::set<std::string_view> names_;
  std::string fault_;
};

}  // namespace

Result<void> validate(const CommandTable& table) {
  std::set<std::string_view> names;
  for (const CommandDeclaration& command : table.commands) {
    TURGOR_CHECK(Validator(table, command).run());
    if (!names.insert(command.name).second) {
      return Error{ErrorKind::internal, "declared twice", std::string(command.name),
                   "Correct the declaration"};
    }
  }
  return {};
}

}  // namespace turgor
