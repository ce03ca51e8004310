// What the commands do that talk to whoever sits at the console: help, the menu, the recording.
#include <fmt/format.h>

#include <algorithm>

#include "session_state.hpp"
#include "turgor/commands/help.hpp"
#include "turgor/core/file.hpp"

namespace turgor::commands {
namespace {

Result<void> help(SessionState& s, const Invocation& c) {
  const std::vector<std::string> topic = c.words("topic");
  if (topic.empty()) {
    const CommandTable* const table[] = {&scene_commands()};
    s.say(help_overview(table));
    return {};
  }
  TURGOR_TRY(const std::string text, help_topic(topic));
  s.say(text);
  return {};
}

// The menu puts the command it names into the buffer, where it asks for what it needs.
Result<void> menu(SessionState& s, const Invocation& c) {
  const auto all = scene_commands().commands;
  if (!c.given("number")) {
    std::string_view group;
    for (std::size_t i = 0; i < all.size(); ++i) {
      if (all[i].group != group) s.say(fmt::format("{}", group = all[i].group));
      s.say(fmt::format("  {:3} {:<18} {}", i + 1, all[i].name, all[i].summary));
    }
    return {};
  }
  const std::int64_t number = c.integer("number");
  if (number > std::ssize(all)) {
    return c.error(fmt::format("the menu has no entry {}", number), fmt::format("It has 1 to {}", all.size()),
                   "number");
  }
  TURGOR_TRY(auto lines, lex(all[static_cast<std::size_t>(number) - 1].name, "menu"));
  for (ScriptLine& line : lines) s.waiting.push_front(std::move(line));
  return {};
}

Result<void> record(SessionState& s, const Invocation& c) {
  return write_file(c.path("file"), recording_of(s));
}

Result<void> quit(SessionState& s, const Invocation&) {
  s.finished = true;
  s.waiting.clear();
  s.at_once.clear();
  return {};
}

}  // namespace

std::string recording_of(const SessionState& s) {
  std::string text = "; everything executed, to be run again with the same bits\n";
  for (const std::string& line : s.recording) text += line + '\n';
  // One frame follows the last line by itself.
  if (s.frames_since > 1) text += fmt::format("frame {}\n", s.frames_since - 1);
  return text;
}

bool is_recorded(std::string_view command) {
  constexpr std::string_view silent[] = {"simulate", "frame", "help", "menu", "record", "quit", "list"};
  return std::ranges::find(silent, command) == std::end(silent);
}

std::span<const NamedHandler> talk_handlers() {
  static constexpr NamedHandler table[] = {
      {"help", help}, {"menu", menu}, {"record", record}, {"quit", quit}};
  return table;
}

}  // namespace turgor::commands
