// The program's sub-commands: each takes its parsed arguments and returns the exit code.
#pragma once

#include <string>

#include "turgor/commands/script.hpp"
#include "turgor/core/context.hpp"

namespace turgor {

inline constexpr const char* program_version = TURGOR_VERSION;

Result<void> run_info(const Invocation& arguments, Context& context);
Result<void> run_phantom(const Invocation& arguments, Context& context);
/// `build` and `predict`; `command_line` is recorded in the results.
Result<void> run_build(const Invocation& arguments, const std::string& command_line, Context& context);
Result<void> run_predict(const Invocation& arguments, const std::string& command_line, Context& context);

/// `command_line` is recorded in the results.
Result<void> run_calibrate(const Invocation& arguments, const std::string& command_line, Context& context);

Result<void> run_script(const Invocation& arguments, const std::string& command_line, Context& context);
Result<void> run_skin(const Invocation& arguments, Context& context);
Result<void> run_mesh(const Invocation& arguments, Context& context);
Result<void> run_shell(const Invocation& arguments, Context& context);

}  // namespace turgor
