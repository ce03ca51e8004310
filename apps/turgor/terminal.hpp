// What the user sees while the program works, and how they stop it.
#pragma once

#include <memory>

#include "turgor/core/context.hpp"

namespace turgor {

/// A context that draws a progress line with the time left on a terminal, plain lines elsewhere (both on
/// standard error), and is cancelled by Ctrl-C, SIGTERM, or the terminal's end. A second Ctrl-C ends the
/// program at once.
std::unique_ptr<Context> make_terminal_context();

/// Whether the user asked to stop; from then on as if they had not. For a console, which goes on.
bool take_stop_request();

/// While it lives, Ctrl-C ends the program there and then: for work that writes nothing and has steps too
/// long to wait for.
class StopAtOnce {
 public:
  StopAtOnce();
  StopAtOnce(const StopAtOnce&) = delete;
  StopAtOnce& operator=(const StopAtOnce&) = delete;
  ~StopAtOnce();
};

/// Prints an error as one line on standard error and returns the exit code.
int fail(const Error& error);

}  // namespace turgor
