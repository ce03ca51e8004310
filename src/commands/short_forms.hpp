// Short forms to declare parameters of the commonest kinds.
#pragma once

#include "turgor/commands/declaration.hpp"

namespace turgor::commands {

constexpr Parameter named(std::string_view name, std::string_view help, bool required = true) {
  return {
      .name = name,
      .type = ValueType::word,
      .required = required,
      .positional = true,
      .help = help,
  };
}
constexpr Parameter word_flag(std::string_view name, std::string_view label, std::string_view help) {
  return {
      .name = name,
      .type = ValueType::word,
      .label = label,
      .help = help,
  };
}
constexpr Parameter on_off(std::string_view name, std::string_view help) {
  return {
      .name = name,
      .type = ValueType::flag,
      .help = help,
  };
}
constexpr Parameter number(std::string_view name, std::string_view fallback, Range range,
                           std::string_view help, std::string_view alias = {}) {
  return {
      .name = name,
      .alias = alias,
      .range = range,
      .fallback = fallback,
      .help = help,
  };
}
constexpr Parameter numbers(std::string_view name, int count, std::string_view label, std::string_view help,
                            std::string_view fallback = {}, Range range = {}) {
  return {
      .name = name,
      .range = range,
      .count = {count, count},
      .label = label,
      .fallback = fallback,
      .help = help,
  };
}
constexpr Parameter whole(std::string_view name, std::string_view fallback, Range range,
                          std::string_view help, std::string_view alias = {}) {
  return {
      .name = name,
      .alias = alias,
      .type = ValueType::integer,
      .range = range,
      .fallback = fallback,
      .help = help,
  };
}

}  // namespace turgor::commands
