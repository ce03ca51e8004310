// Parameters that several of the program's commands share.
#pragma once

#include "turgor/commands/declaration.hpp"

namespace turgor::commands {

inline constexpr Parameter kThreads{
    .name = "threads",
    .type = ValueType::integer,
    .range = between(0, 1024),
    .fallback = "0",
    .help = "threads to work with; 0 is one per core. The results do not depend on it",
};

constexpr Parameter output(std::string_view help) {
  return {
      .name = "output",
      .alias = "o",
      .type = ValueType::folder,
      .label = "DIR",
      .required = true,
      .help = help,
  };
}

}  // namespace turgor::commands
