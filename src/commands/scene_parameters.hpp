// Parameters that several commands of a scene share, and short forms to declare the others.
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

inline constexpr Range kColour = between(0, 1);
inline constexpr Range kModulus = between(0, 1e12);
inline constexpr Range kFactor = above_up_to(0, 1e6);

/// The thesis's numbers stand beside the names: its scripts say `-m 4` and mean linear.
inline constexpr std::string_view kSpringLaws[] = {
    "linear", "exponential", "logarithmic", "square", "collagen", "hookean", "0", "1", "2", "3", "4"};
inline constexpr Parameter kSpringLaw{
    .name = "m",
    .alias = "material",
    .type = ValueType::choice,
    .choices = kSpringLaws,
    .label = "LAW",
    .fallback = "linear",
    .help =
        "law of the force over strain: by name, or 0 linear, 1 exponential, 2 logarithmic, 3 square, 4 "
        "linear",
};
inline constexpr Parameter kConstant =
    number("c", "1", kModulus, "material constant: force at strain 1", "constant");
inline constexpr Parameter kViscosity =
    number("v", "0", kModulus, "viscosity: force over the rate of change of length", "viscosity");
inline constexpr Parameter kCutoff =
    number("cutoff", "0", kModulus, "length beyond which the spring lets go; 0: it never does");

inline constexpr Parameter kRegionBox{
    .name = "box",
    .type = ValueType::box,
    .help = "only samples within this box, where they lie now",
};
inline constexpr Parameter kRegionSphere{
    .name = "sphere",
    .type = ValueType::sphere,
    .help = "only samples within this sphere, where they lie now",
};
inline constexpr Parameter kRegionInside = word_flag(
    "inside", "OBJECT", "only samples inside the closed surface of this object, where both are now");
inline constexpr Parameter kRegionLayer =
    whole("layer", "-1", between(-1, 1000), "only samples of this layer, 0 being bone; -1: of all");
inline constexpr Parameter kFlesh = named("flesh", "name of a flesh: that of the object it was built on");

}  // namespace turgor::commands
