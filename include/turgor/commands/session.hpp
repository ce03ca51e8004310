// A scene and the commands that move it: the frame loop of Pieper (1989, section 4.3).
//
//     ┌► sample devices ─► execute commands ─► simulate ─► draw ─┐
//     └──────────────────────────────────────────────────────────┘
//
// Scripts, console, menu and devices all put lines into one buffer. A command with missing arguments stays
// and asks for them; `simulate` stays until it is over, and the lines of scripts wait for it.
#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "turgor/commands/script.hpp"
#include "turgor/core/context.hpp"
#include "turgor/world/scene.hpp"

namespace turgor {

struct SessionOptions {
  /// Folders looked through for objects and includes, before the program's own library.
  std::vector<std::filesystem::path> search_paths;
  std::filesystem::path output;  ///< where `picture` and `state` write; empty: the working folder
  bool interactive = false;      ///< somebody can answer what a command asks for
  /// Draws the scene and writes it: for the command `picture`. Without one, that is an error.
  std::function<Result<void>(const Scene&, const std::filesystem::path&)> picture = {};
  /// After every frame of a simulation, and of the loop.
  std::function<Result<void>(const Scene&)> frame = {};
  std::function<void(std::string_view)> say = {};  ///< what commands print
};

struct SessionState;

class Session {
 public:
  Session(SessionOptions options, Context& context);
  Session(Session&&) noexcept;
  Session& operator=(Session&&) noexcept;
  ~Session();

  /// Puts all lines of a script, its includes followed, at the end of the buffer. Nothing on error.
  Result<void> enter_script(const std::filesystem::path& path);
  Result<void> enter_text(std::string_view text, const std::string& name);
  /// A line that does not wait for `simulate` to end: from a device, or from the console meanwhile.
  Result<void> enter_now(std::string_view line, const std::string& name);

  /// One turn of the loop. On error the command at fault, and all lines that wait, are dropped.
  Result<void> frame();
  /// Frames until nothing waits and nothing runs. Errors: those of commands; cancelled; a command that asks
  /// for arguments where nobody answers.
  Result<void> run();
  /// Ends `simulate`, and drops what asks and what waits.
  void interrupt();

  [[nodiscard]] bool idle() const;      ///< nothing waits, runs or asks
  [[nodiscard]] bool finished() const;  ///< somebody said `quit`
  /// What the resident command asks for: "visible: OBJECT (name of an object)".
  [[nodiscard]] std::optional<std::string> asks() const;
  /// A command asks, and no line is there to answer.
  [[nodiscard]] bool waits_for_answer() const;
  [[nodiscard]] const Scene& scene() const;
  /// Everything executed so far, as a script that does the same again, to the bit.
  [[nodiscard]] std::string recording() const;

 private:
  std::unique_ptr<SessionState> state_;
};

/// What a scene has come to, as JSON: time, tissue, muscles, collisions and their measures.
std::string scene_json(const Scene& scene);

/// Time, places and velocities of all samples, exactly (JSON); and the tissue as a mesh (.vtu beside it).
Result<void> write_state(const Scene& scene, const std::filesystem::path& path);
Result<void> read_state(Scene& scene, const std::filesystem::path& path);

}  // namespace turgor
