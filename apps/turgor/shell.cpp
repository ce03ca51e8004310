// turgor shell: a console with history, completion and help.
#include <editline/readline.h>
#include <fmt/format.h>
#include <unistd.h>

#include <cstdio>
#include <cstdlib>
#include <iostream>

#include "subcommands.hpp"
#include "terminal.hpp"
#include "turgor/commands/help.hpp"
#include "turgor/commands/session.hpp"
#include "turgor/core/file.hpp"
#include "turgor/render/scene_pictures.hpp"
#include "turgor/world/object_file.hpp"

namespace turgor {
namespace {

// ---- completion: libedit calls back without a place for data of ours ----

const Session* completing = nullptr;
std::vector<std::string> found;

bool first_word(int start) {
  return std::string_view(rl_line_buffer)
             .substr(0, static_cast<std::size_t>(start))
             .find_first_not_of(" \t") == std::string_view::npos;
}

// Words that may stand here: commands, the flags of the command, names of objects, muscles and primitives.
std::vector<std::string> candidates(std::string_view word, int start) {
  std::vector<std::string> all;
  if (first_word(start)) {
    for (const CommandDeclaration& c : scene_commands().commands)
      all.emplace_back(c.name.substr(0, c.name.find(' ')));
  } else if (word.starts_with('-')) {
    const std::string line = rl_line_buffer;
    const std::size_t begin = line.find_first_not_of(" \t"), end = line.find_first_of(" \t", begin);
    const std::size_t second = line.find_first_of(" \t", end + 1);
    const CommandDeclaration* command = scene_commands().find(line.substr(begin, second - begin));
    if (command == nullptr) command = scene_commands().find(line.substr(begin, end - begin));
    if (command != nullptr) {
      for (const Parameter& p : command->parameters) {
        if (!p.positional) all.push_back(fmt::format("-{}", p.name));
      }
    }
  } else {
    const Scene& scene = completing->scene();
    for (const auto& [id, object] : scene.objects()) all.push_back(object.name);
    for (const Muscle& muscle : scene.specimen.muscles()) all.push_back(muscle.name);
    for (const std::string& name : primitive_names()) all.push_back(name);
  }
  std::erase_if(all, [&](const std::string& c) { return !c.starts_with(word); });
  return all;
}

char* next_match(const char*, int state) {
  if (static_cast<std::size_t>(state) >= found.size()) return nullptr;
  return ::strdup(found[static_cast<std::size_t>(state)].c_str());
}

char** complete(const char* text, int start, int) {
  found = candidates(text, start);
  if (found.empty()) return nullptr;  // then names of files
  return rl_completion_matches(text, next_match);
}

// ---- the console ----

std::filesystem::path history_file() {
  const char* home = std::getenv("HOME");
  return home == nullptr ? std::filesystem::path() : std::filesystem::path(home) / ".turgor_history";
}

// A line from the terminal with editing, or from a pipe without; nullopt at the end.
std::optional<std::string> read_line(const std::string& prompt, bool terminal) {
  if (!terminal) {
    std::string line;
    return std::getline(std::cin, line) ? std::optional(line) : std::nullopt;
  }
  char* const read = ::readline(prompt.c_str());
  if (read == nullptr) return std::nullopt;
  std::string line(read);
  std::free(read);  // NOLINT: it was given by malloc
  if (!line.empty()) ::add_history(line.c_str());
  return line;
}

void show(const Error& error) {
  std::fflush(stdout);
  fail(error);
}

// Frames until nothing is left to do, or Ctrl-C.
void work(Session& session) {
  while (!session.idle() && !session.waits_for_answer()) {
    const auto done = session.frame();
    if (done) continue;
    if (done.error().kind == ErrorKind::cancelled) {
      take_stop_request();
      fmt::print("interrupted at the time {:g}\n", session.scene().time);
    } else {
      show(done.error());
    }
    return;
  }
}

void converse(Session& session, bool terminal) {
  for (int number = 1; !session.finished(); ++number) {
    const auto line = read_line(session.waits_for_answer() ? "? " : "turgor> ", terminal);
    take_stop_request();
    if (!line) break;
    if (session.waits_for_answer() && line->find_first_not_of(" \t") == std::string::npos)
      session.interrupt();
    const auto entered = session.enter_text(*line, fmt::format("line {}", number));
    if (!entered) show(entered.error());
    work(session);
  }
  if (terminal) fmt::print("\n");
}

SessionOptions session_options(const Invocation& arguments, Context& quiet) {
  SessionOptions options;
  for (const std::string& path : arguments.words("search")) options.search_paths.emplace_back(path);
  if (arguments.given("output")) options.output = arguments.path("output");
  options.interactive = true;
  ScenePictureOptions pictures;
  pictures.samples = static_cast<int>(arguments.integer("samples"));
  options.picture = [pictures, &quiet](const Scene& scene,
                                       const std::filesystem::path& path) -> Result<void> {
    TURGOR_TRY(const Image image, draw_screen(scene, pictures, quiet));
    return write_png(path, image);
  };
  options.say = [](std::string_view text) { fmt::print("{}\n", text); };
  return options;
}

}  // namespace

Result<void> run_shell(const Invocation& arguments, Context& context) {
  const bool terminal = ::isatty(STDIN_FILENO) != 0;
  if (arguments.given("output")) {
    TURGOR_CHECK(check_output_folder(arguments.path("output")));
    std::error_code ignored;
    std::filesystem::create_directories(arguments.path("output"), ignored);
  }
  Context quiet({}, {}, [&] { return context.cancelled(); });
  Session session(session_options(arguments, quiet), context);
  if (arguments.given("script")) {
    TURGOR_CHECK(session.enter_script(arguments.path("script")));
    work(session);
  }
  completing = &session;
  rl_attempted_completion_function = complete;
  const std::string history = history_file().string();
  if (terminal) {
    fmt::print("turgor {}: 'help' explains the commands, 'quit' or Ctrl-D ends.\n", program_version);
    ::using_history();
    if (!history.empty()) ::read_history(history.c_str());
  }
  converse(session, terminal);
  if (terminal && !history.empty()) ::write_history(history.c_str());
  if (!arguments.given("record")) return {};
  return write_file(arguments.path("record"), session.recording());
}

}  // namespace turgor
