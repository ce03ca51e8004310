// Any bytes as a script, as files that include each other, and as arguments of the program: no crash, no
// hang, every error whole and printable, and what parses is printed as a line that parses to the same.
//
// Input: files parted by lines "%%%"; the first is the script, the others are called 1, 2 ...
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <map>
#include <string>
#include <vector>

#include "turgor/commands/help.hpp"
#include "turgor/commands/script.hpp"

namespace {
using namespace turgor;

void demand(bool holds, const char* what, const std::string& shown) {
  if (holds) return;
  std::fprintf(stderr, "violated: %s\n%s\n", what, shown.c_str());
  std::abort();
}

void check(const Error& error) {
  const std::string message = error.message();
  demand(error.kind == ErrorKind::bad_command, "errors are of kind bad_command", message);
  demand(!error.what.empty() && !error.remedy.empty(), "errors say what is wrong and what to do", message);
  for (const char c : message) {
    demand(static_cast<unsigned char>(c) >= 0x20, "errors hold no control characters", message);
  }
}

void check(const Invocation& invocation, const CommandTable& table) {
  const std::string text = invocation.text();
  const auto again = parse_script_text(text, "again", table);
  demand(static_cast<bool>(again), "a command's text parses", text);
  demand(again->size() == 1 && again->front().text() == text, "to the same command", text);
}

std::vector<std::string> split_files(std::string_view data) {
  constexpr std::string_view mark = "\n%%%\n";
  std::vector<std::string> files;
  for (std::size_t end = data.find(mark); end != std::string_view::npos; end = data.find(mark)) {
    files.emplace_back(data.substr(0, end));
    data.remove_prefix(end + mark.size());
  }
  files.emplace_back(data);
  return files;
}

void run_script(const std::vector<std::string>& files) {
  ScriptOptions options;
  options.max_bytes = 1 << 16;
  options.search_paths = {"library"};
  options.read = [&](const std::filesystem::path& path) -> Result<std::optional<std::string>> {
    for (std::size_t i = 1; i < files.size(); ++i) {
      if (path.filename() == std::to_string(i)) return std::optional<std::string>(files[i]);
    }
    return std::optional<std::string>();
  };
  const auto lines = load_script_text(files.front(), "case/0", options);
  if (!lines) return check(lines.error());
  for (const ScriptLine& line : *lines) {
    for (const CommandTable* table : {&plan_commands(), &problem_commands()}) {
      const auto invocation = parse_line(line, *table);
      if (invocation) {
        check(*invocation, *table);
      } else {
        check(invocation.error());
      }
    }
  }
}

void run_arguments(const std::string& text) {
  const auto lines = lex(text, "arguments");
  if (!lines) return;
  for (const ScriptLine& line : *lines) {
    std::vector<std::string> words;
    for (const Word& word : line.words) words.push_back(word.text);
    const auto invocation = parse_arguments(words, program_commands());
    if (invocation) {
      check(*invocation, program_commands());
    } else {
      check(invocation.error());
    }
    if (const auto help = help_topic(words); !help) check(help.error());
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string_view bytes(reinterpret_cast<const char*>(data), size);
  const auto files = split_files(bytes);
  run_script(files);
  run_arguments(files.front());
  return 0;
}
