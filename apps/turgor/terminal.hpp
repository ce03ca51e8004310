// What the user sees while the program works, and how they stop it.
#pragma once

#include <memory>

#include "turgor/core/context.hpp"

namespace turgor {

/// A context that draws a progress line with the time left on a terminal, plain lines elsewhere (both on
/// standard error), and is cancelled by Ctrl-C, SIGTERM, or the terminal's end. A second Ctrl-C ends the
/// program at once.
std::unique_ptr<Context> make_terminal_context();

/// Prints an error as one line on standard error and returns the exit code.
int fail(const Error& error);

}  // namespace turgor
