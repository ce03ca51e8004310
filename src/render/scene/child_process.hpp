// Another program run to its end, without a shell.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "turgor/core/context.hpp"

namespace turgor::render_detail {

struct ChildResult {
  int exit_code = 0;           ///< 128 + signal where one ended it
  std::string last_complaint;  ///< last line on its error stream that is not empty
};
/// Looks the program up along PATH; nothing where it is not found. Its input is empty, its output dropped.
/// Errors: cancelled (the child is ended first), no process can be made.
Result<std::optional<ChildResult>> run_program(const std::vector<std::string>& arguments, Context& context);

}  // namespace turgor::render_detail
