// The command language: from text (or the program's arguments) to words, and from words to typed commands.
//
//   name value ... -flag value ...   ; comment
//   #include other.script            # included in place, relative to this file, then along the search paths
//
// The notation is that of the scripts in S. D. Pieper, "More Than Skin Deep" (MIT, 1989), sections 4.3
// and 6.1.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "turgor/commands/declaration.hpp"
#include "turgor/core/error.hpp"
#include "turgor/math/vec.hpp"

namespace turgor {

/// Where a word stands. Lines and columns count from 1, columns in characters. Line 0: `column` is the number
/// of an argument of the program.
struct SourcePlace {
  std::shared_ptr<const std::string> file;
  int line = 0;
  int column = 0;

  /// "plan.turgor:3:14", or "command line, argument 2".
  [[nodiscard]] std::string text() const;
};

struct Word {
  std::string text;
  bool quoted = false;  ///< some of it was quoted or escaped: never a flag
  SourcePlace place;
};

/// The words of one command; or of an include line (`include`), then the file's name alone.
struct ScriptLine {
  std::vector<Word> words;
  bool include = false;
};

/// Words by line, without blank lines and comments, includes not followed. Needs no declarations.
/// - Blanks part words. `;` starts a comment anywhere, `#` where a word could begin.
/// - 'single quotes' take everything as it stands; in "double quotes" \" and \\ stand for " and \, other
/// backslashes
///   for themselves; outside, a backslash takes the next character as it stands and, at the end of a line,
///   joins the next line to it. Quotes end on the line they began on. Quoted and plain parts side by side are
///   one word.
/// - Lines end with LF, CR LF or CR. A UTF-8 byte order mark is skipped; no-break spaces are blanks.
/// Errors (bad_command, with the place): a quote left open, a zero byte, a control character, text that is
/// not UTF-8 (within comments all but the zero byte is let through), UTF-16, #include without one file name.
Result<std::vector<ScriptLine>> lex(std::string_view text, std::string_view file_name);

struct ScriptOptions {
  std::vector<std::filesystem::path> search_paths =
      {};  ///< for includes, after the including file's own folder
  std::uint64_t max_bytes = std::uint64_t{64}
                            << 20;  ///< of all text, an included file counted as often as read
  /// Reads a file; nullopt: there is none. Empty: from the disk.
  std::function<Result<std::optional<std::string>>(const std::filesystem::path&)> read = {};
  /// The text of a script of the program's own, by the last part of a name that no file has; nullopt: none.
  std::function<std::optional<std::string>(const std::string&)> library = {};
};

/// lex(), with every include replaced by what it names, nested to any depth. Errors besides those of lex():
/// no such file, a cycle of includes (its chain is printed), more text than max_bytes.
Result<std::vector<ScriptLine>> load_script(const std::filesystem::path& path,
                                            const ScriptOptions& options = {});
/// The same for text that is in memory; `file_name` is its name in errors and its folder the one of its
/// includes.
Result<std::vector<ScriptLine>> load_script_text(std::string_view text,
                                                 const std::filesystem::path& file_name,
                                                 const ScriptOptions& options = {});

/// One value of a parameter. Which of the lists is filled follows from the declared type: words for word,
/// text, path, folder, choice and command; integers; numbers (in the declared unit) for all others.
struct Argument {
  std::vector<std::string> words;
  std::vector<std::int64_t> integers;
  std::vector<double> numbers;
  SourcePlace place;  ///< of the value's first word; without a file where it is the default
};

struct Axis {
  Vec3 point, direction;  ///< mm; `direction` has unit length
};
struct Sphere {
  Vec3 centre;  ///< mm
  double radius = 0;
};
Vec3 to_point(const Argument& argument);      ///< of point, offset
Vec3 to_direction(const Argument& argument);  ///< unit length
Plane to_plane(const Argument& argument);
Axis to_axis(const Argument& argument);
Box3 to_box(const Argument& argument);
Sphere to_sphere(const Argument& argument);

/// A command with its values, checked against its declaration. Asking for a parameter that is not declared,
/// or for the value of one that has none (optional, no default, not given: test it with given()), is a
/// mistake of the programmer and ends the program with a message.
class Invocation {
 public:
  [[nodiscard]] const CommandDeclaration& command() const { return *command_; }
  [[nodiscard]] std::string_view name() const { return command_->name; }
  [[nodiscard]] const SourcePlace& place() const { return place_; }

  /// The user typed it (for flags without a value: it is on).
  [[nodiscard]] bool given(std::string_view parameter) const;
  /// Every value: as typed, else the default, else empty.
  [[nodiscard]] std::span<const Argument> all(std::string_view parameter) const;

  [[nodiscard]] bool flag(std::string_view parameter) const { return given(parameter); }
  [[nodiscard]] const std::string& word(std::string_view parameter) const;  ///< also text, choice, command
  [[nodiscard]] std::filesystem::path path(std::string_view parameter) const;
  [[nodiscard]] std::int64_t integer(std::string_view parameter) const;
  [[nodiscard]] double number(std::string_view parameter) const;
  [[nodiscard]] Vec3 point(std::string_view parameter) const { return to_point(one(parameter)); }
  [[nodiscard]] Vec3 offset(std::string_view parameter) const { return to_point(one(parameter)); }
  [[nodiscard]] Vec3 direction(std::string_view parameter) const { return to_direction(one(parameter)); }
  [[nodiscard]] Plane plane(std::string_view parameter) const { return to_plane(one(parameter)); }
  [[nodiscard]] Axis axis(std::string_view parameter) const { return to_axis(one(parameter)); }
  [[nodiscard]] Box3 box(std::string_view parameter) const { return to_box(one(parameter)); }
  [[nodiscard]] Sphere sphere(std::string_view parameter) const { return to_sphere(one(parameter)); }
  /// Of lists, and of all occurrences of repeatable ones, in order; empty where there are none.
  [[nodiscard]] std::vector<std::string> words(std::string_view parameter) const;
  [[nodiscard]] std::vector<double> numbers(std::string_view parameter) const;

  /// One line that parses to the same command: name, then what was given, in order of declaration, in
  /// declared units.
  [[nodiscard]] std::string text() const;
  /// An error about this command, at its place; for handlers. `parameter`, where given, moves the place to
  /// its value.
  [[nodiscard]] Error error(std::string what, std::string remedy, std::string_view parameter = {}) const;

 private:
  friend class InvocationParser;
  [[nodiscard]] std::size_t index(std::string_view parameter) const;
  [[nodiscard]] const Argument& one(std::string_view parameter) const;

  const CommandDeclaration* command_ = nullptr;
  SourcePlace place_;
  std::vector<std::vector<Argument>> values_;  ///< by parameter, in order of declaration
  std::vector<bool> given_;
};

/// One command. Flags are `-name` or `--name`, also `-name=value`; a word that starts with a minus and a
/// digit is a number; after `--` nothing is a flag. Flags may stand before, between and after positional
/// values. Errors are of kind bad_command; `where` is the place, `remedy` names the nearest valid word, or
/// the usage.
/// `missing` (optional) receives the required parameter that is not given, where that alone is the fault.
Result<Invocation> parse_line(const ScriptLine& line, const CommandTable& table,
                              const Parameter** missing = nullptr);
Result<std::vector<Invocation>> parse_lines(std::span<const ScriptLine> lines, const CommandTable& table);

/// load_script(), then parse_lines().
Result<std::vector<Invocation>> parse_script(const std::filesystem::path& path, const CommandTable& table,
                                             const ScriptOptions& options = {});
Result<std::vector<Invocation>> parse_script_text(std::string_view text,
                                                  const std::filesystem::path& file_name,
                                                  const CommandTable& table,
                                                  const ScriptOptions& options = {});

/// The program's arguments, its own name left out. None, or -h, -help or --help anywhere, becomes `help` (of
/// the command named first, if any); --version alone becomes `version`.
Result<Invocation> parse_arguments(std::span<const std::string> arguments, const CommandTable& table);

/// `text` as one word of a script: quoted where it has to be.
std::string quote_word(std::string_view text);

}  // namespace turgor
