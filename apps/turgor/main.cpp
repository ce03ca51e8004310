// turgor: from a head scan to the face after surgery. See `turgor help`.
#include <fcntl.h>
#include <fmt/format.h>

#include <cstdio>
#include <exception>
#include <string>
#include <system_error>
#include <vector>

#include "subcommands.hpp"
#include "terminal.hpp"
#include "turgor/commands/help.hpp"
#include "turgor/core/parallel.hpp"

namespace turgor {
namespace {

Result<void> print_commands(const Invocation& arguments) {
  const std::string& format = arguments.word("format");
  if (format == "md") {
    fmt::print("{}", commands_markdown());
  } else if (format == "json") {
    fmt::print("{}", commands_schema());
  } else {
    fmt::print("{}", completion_script(format == "bash"  ? Shell::bash
                                       : format == "zsh" ? Shell::zsh
                                                         : Shell::fish));
  }
  return {};
}

Result<void> print_help(const Invocation& arguments) {
  const std::vector<std::string> topic = arguments.words("topic");
  TURGOR_TRY(const std::string text, help_topic(topic));
  fmt::print("{}", text);
  return {};
}

Result<void> dispatch(const Invocation& arguments, const std::string& command_line, Context& context) {
  const std::string_view name = arguments.name();
  if (name == "help") return print_help(arguments);
  if (name == "commands") return print_commands(arguments);
  if (name == "info") return run_info(arguments, context);
  if (name == "phantom") return run_phantom(arguments, context);
  if (name == "build") return run_build(arguments, command_line, context);
  if (name == "run") return run_script(arguments, command_line, context);
  if (name == "skin") return run_skin(arguments, context);
  if (name == "mesh") return run_mesh(arguments, context);
  if (name == "shell") return run_shell(arguments, context);
  if (name == "calibrate") return run_calibrate(arguments, command_line, context);
  if (name == "predict") return run_predict(arguments, command_line, context);
  fmt::print("turgor {}\n", program_version);
  return {};
}

Error output_lost() {
  return {ErrorKind::system, "what the program prints cannot be written", "standard output",
          "Free some space, or send the output elsewhere"};
}

int run(const std::vector<std::string>& words) {
  std::string command_line = "turgor";
  for (const std::string& word : words) command_line += ' ' + quote_word(word);
  const auto arguments = parse_arguments(words, program_commands());
  if (!arguments) return fail(arguments.error());
  if (arguments->command().find("threads") != nullptr)
    set_thread_count(static_cast<int>(arguments->integer("threads")));
  const auto context = make_terminal_context();
  const auto done = dispatch(*arguments, command_line, *context);
  if (!done) return fail(done.error());
  // What is still in the buffer may yet meet a full disk.
  return std::fflush(stdout) == 0 ? 0 : fail(output_lost());
}

// A stream that the caller has closed gives its number to the next file opened, and words meant for the user
// would end in that file.
void open_closed_streams() {
  for (int stream = 0; stream < 3; ++stream) {
    if (::fcntl(stream, F_GETFD) < 0) ::open("/dev/null", O_RDWR);
  }
}

}  // namespace
}  // namespace turgor

int main(int argc, char** argv) {
  turgor::open_closed_streams();
  try {
    return turgor::run({argv + 1, argv + argc});
  } catch (const std::bad_alloc&) {
    return turgor::fail({turgor::ErrorKind::system, "not enough memory", "",
                         "Use -quality draft, or a machine with more memory"});
  } catch (const std::system_error& error) {
    if (std::ferror(stdout) != 0) return turgor::fail(turgor::output_lost());
    return turgor::fail({turgor::ErrorKind::system, std::string("the system refused: ") + error.what(), "",
                         "Check the paths and their permissions"});
  } catch (const std::exception& error) {
    return turgor::fail({turgor::ErrorKind::internal, std::string("a fault in the program: ") + error.what(),
                         "", "Please report it with the command and the input"});
  }
}
