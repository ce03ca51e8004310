#include <algorithm>
#include <set>
#include <system_error>

#include "text.hpp"
#include "turgor/commands/script.hpp"
#include "turgor/core/file.hpp"

namespace turgor {
namespace fs = std::filesystem;
namespace {

using commands::shown;

Result<std::optional<std::string>> read_from_disk(const fs::path& path) {
  std::error_code code;
  if (!fs::exists(path, code)) return std::optional<std::string>();
  TURGOR_TRY(std::string text, read_text_file(path));
  return std::optional<std::string>(std::move(text));
}

/// The same for every path to one file, through links and dots.
fs::path identity(const fs::path& path) {
  std::error_code code;
  const fs::path canonical = fs::weakly_canonical(path, code);
  return code ? path.lexically_normal() : canonical;
}

/// Follows includes with a stack of its own, so that depth is bounded by memory alone.
class Loader {
 public:
  explicit Loader(const ScriptOptions& options) : options_(options) {}

  Result<std::vector<ScriptLine>> run(std::string_view text, const fs::path& path) {
    TURGOR_CHECK(open(text, path, identity(path)));
    std::vector<ScriptLine> lines;
    while (!stack_.empty()) {
      Frame& frame = stack_.back();
      if (frame.next == frame.lines.size()) {
        open_.erase(frame.identity);
        stack_.pop_back();
        continue;
      }
      ScriptLine& line = frame.lines[frame.next++];
      if (line.include) {
        const Word file = std::move(line.words.front());
        TURGOR_CHECK(include(file));
      } else {
        lines.push_back(std::move(line));
      }
    }
    return lines;
  }

 private:
  struct Frame {
    fs::path path, identity;
    std::vector<ScriptLine> lines;
    std::size_t next = 0;
  };

  Result<void> open(std::string_view text, const fs::path& path, const fs::path& id) {
    bytes_ += text.size();
    if (bytes_ > options_.max_bytes) {
      return Error{
          ErrorKind::bad_command,
          "the script and its includes hold more than " + std::to_string(options_.max_bytes >> 20) + " MiB",
          path.string(), "Check for files that are included many times over"};
    }
    TURGOR_TRY(auto lines, lex(text, path.string()));
    open_.insert(id);
    stack_.push_back({path, id, std::move(lines)});
    return {};
  }

  [[nodiscard]] std::vector<fs::path> candidates(const fs::path& name) const {
    std::vector<fs::path> paths{stack_.back().path.parent_path() / name};
    for (const fs::path& folder : options_.search_paths) {
      paths.push_back(folder / (name.is_relative() ? name : name.filename()));
    }
    for (fs::path& path : paths) path = path.lexically_normal();
    return paths;
  }

  Result<void> include(const Word& file) {
    const auto paths = candidates(file.text);
    for (const fs::path& path : paths) {
      const fs::path id = identity(path);
      if (open_.contains(id)) return cycle(id, file.place);
      auto text = options_.read ? options_.read(path) : read_from_disk(path);
      if (!text) return commands::told_at(file.place, text.error());
      if (text->has_value()) return open(**text, path, id);
    }
    if (options_.library) {
      const fs::path own = fs::path(file.text).filename();
      if (const auto text = options_.library(own.string())) return open(*text, own, own);
    }
    std::vector<std::string> tried;
    tried.reserve(paths.size());
    for (const fs::path& path : paths) tried.push_back(path.string());
    return Error{ErrorKind::bad_command, "no file " + shown(file.text) + " to include", file.place.text(),
                 "Correct its name; looked for " + commands::join_alternatives(tried, "and")};
  }

  Error cycle(const fs::path& id, const SourcePlace& place) const {
    const auto first =
        std::find_if(stack_.begin(), stack_.end(), [&](const Frame& f) { return f.identity == id; });
    std::string chain;
    for (auto frame = first; frame != stack_.end(); ++frame) chain += frame->path.string() + " -> ";
    return {ErrorKind::bad_command, "includes itself: " + chain + first->path.string(), place.text(),
            "Remove one of these #include lines"};
  }

  const ScriptOptions& options_;
  std::vector<Frame> stack_;
  std::set<fs::path> open_;  ///< identities of the files on the stack
  std::uint64_t bytes_ = 0;
};

}  // namespace

Result<std::vector<ScriptLine>> load_script_text(std::string_view text, const fs::path& file_name,
                                                 const ScriptOptions& options) {
  return Loader(options).run(text, file_name);
}

Result<std::vector<ScriptLine>> load_script(const fs::path& path, const ScriptOptions& options) {
  if (!options.read) {
    TURGOR_TRY(const std::string text, read_text_file(path, options.max_bytes));
    return load_script_text(text, path, options);
  }
  TURGOR_TRY(const std::optional<std::string> text, options.read(path));
  if (!text)
    return Error{ErrorKind::bad_command, "no such file", path.string(), "Check the spelling of the path"};
  return load_script_text(*text, path, options);
}

Result<std::vector<Invocation>> parse_script(const fs::path& path, const CommandTable& table,
                                             const ScriptOptions& options) {
  TURGOR_TRY(const auto lines, load_script(path, options));
  return parse_lines(lines, table);
}

Result<std::vector<Invocation>> parse_script_text(std::string_view text, const fs::path& file_name,
                                                  const CommandTable& table, const ScriptOptions& options) {
  TURGOR_TRY(const auto lines, load_script_text(text, file_name, options));
  return parse_lines(lines, table);
}

}  // namespace turgor
