#include <fmt/format.h>

#include <cmath>

#include "text.hpp"
#include "values.hpp"

namespace turgor::commands {

int words_per_value(ValueType type) {
  switch (type) {
    case ValueType::flag:
      return 0;
    case ValueType::point:
    case ValueType::offset:
    case ValueType::direction:
      return 3;
    case ValueType::sphere:
      return 4;
    case ValueType::plane:
    case ValueType::axis:
    case ValueType::box:
      return 6;
    default:
      return 1;
  }
}

Count word_count(const Parameter& parameter) {
  const int per = words_per_value(parameter.type);
  const int high = parameter.count.high == any_number ? any_number : parameter.count.high * per;
  return {parameter.count.low * per, high};
}

bool is_numeric(ValueType type) {
  return type == ValueType::integer || type >= ValueType::number;
}

std::string value_label(const Parameter& parameter) {
  const auto one = [&]() -> std::string {
    if (!parameter.label.empty()) return std::string(parameter.label);
    if (parameter.positional) {
      std::string name(parameter.name);
      for (char& c : name) c = c >= 'a' && c <= 'z' ? static_cast<char>(c - 'a' + 'A') : c;
      return name;
    }
    switch (parameter.type) {
      case ValueType::flag:
        return "";
      case ValueType::integer:
        return "N";
      case ValueType::number:
        return parameter.unit == Unit::none ? "NUMBER" : fmt::format("{}", symbol(parameter.unit));
      case ValueType::choice: {
        std::string all;
        for (const auto choice : parameter.choices) all += (all.empty() ? "" : "|") + std::string(choice);
        return all;
      }
      case ValueType::point:
        return "X Y Z";
      case ValueType::offset:
        return "DX DY DZ";
      case ValueType::direction:
        return "NX NY NZ";
      case ValueType::plane:
        return "X Y Z NX NY NZ";
      case ValueType::axis:
        return "X Y Z DX DY DZ";
      case ValueType::box:
        return "X0 Y0 Z0 X1 Y1 Z1";
      case ValueType::sphere:
        return "X Y Z RADIUS";
      case ValueType::path:
        return "FILE";
      case ValueType::folder:
        return "DIR";
      case ValueType::command:
        return "COMMAND";
      case ValueType::word:
      case ValueType::text:
        return "NAME";
    }
    return "";
  };
  std::string label = one();
  if (parameter.count.high == any_number) return label + "...";
  if (!parameter.label.empty()) return label;
  const std::string single = label;
  for (int i = 1; i < parameter.count.high; ++i) label += " " + single;
  return label;
}

std::string title(const Parameter& parameter) {
  return parameter.positional ? value_label(parameter) : "-" + std::string(parameter.name);
}

namespace {

std::string describe_one(const Parameter& parameter) {
  switch (parameter.type) {
    case ValueType::flag:
      return "no value";
    case ValueType::word:
      return "a name";
    case ValueType::text:
      return "a text";
    case ValueType::path:
      return "a path";
    case ValueType::folder:
      return "a folder";
    case ValueType::command:
      return "the name of a command";
    case ValueType::choice: {
      const std::vector<std::string> choices(parameter.choices.begin(), parameter.choices.end());
      return choices.size() <= 6 ? join_alternatives(choices)
                                 : fmt::format("one of {} words", choices.size());
    }
    case ValueType::integer:
      return "a whole number";
    case ValueType::number:
      return "a number";
    case ValueType::point:
      return "3 numbers (a point x y z)";
    case ValueType::offset:
      return "3 numbers (a displacement x y z)";
    case ValueType::direction:
      return "3 numbers (a direction x y z)";
    case ValueType::plane:
      return "6 numbers (a point x y z, then the normal x y z)";
    case ValueType::axis:
      return "6 numbers (a point x y z, then the direction x y z)";
    case ValueType::box:
      return "6 numbers (the lower corner x y z, then the upper corner)";
    case ValueType::sphere:
      return "4 numbers (the centre x y z, then the radius)";
  }
  return "";
}

}  // namespace

std::string describe_value(const Parameter& parameter) {
  const auto [low, high] = parameter.count;
  std::string text = describe_one(parameter);
  if (high != 1) {
    const std::string_view what = parameter.type == ValueType::number && parameter.unit == Unit::fraction
                                      ? "fractions"
                                  : parameter.type == ValueType::number  ? "numbers"
                                  : parameter.type == ValueType::integer ? "whole numbers"
                                                                         : "words";
    text = low == high          ? fmt::format("{} {}", low, what)
           : high == any_number ? fmt::format("{} or more {}", low, what)
                                : fmt::format("{} to {} {}", low, high, what);
  }
  if (parameter.unit == Unit::fraction && high == 1) return "a fraction, such as 0.2 or 20%";
  if (parameter.type == ValueType::number || parameter.type == ValueType::integer) {
    return parameter.unit == Unit::none || parameter.unit == Unit::fraction
               ? text
               : fmt::format("{} in {}", text, symbol(parameter.unit));
  }
  return is_numeric(parameter.type) && parameter.type != ValueType::direction ? text + " in mm" : text;
}

std::string describe_range(const Parameter& parameter) {
  const Range& range = parameter.range;
  const std::string low = format_number(range.low), high = format_number(range.high);
  if (!range.bounded()) return "";
  if (std::isinf(range.high)) return (range.low_open ? "above " : "at least ") + low;
  if (std::isinf(range.low)) return (range.high_open ? "below " : "at most ") + high;
  return (range.low_open ? "above " : "") + low + " to " + (range.high_open ? "below " : "") + high;
}

std::string describe_rule(const Rule& rule) {
  std::vector<std::string> flags;
  for (const auto name : rule.names) flags.push_back("-" + std::string(name));
  switch (rule.kind) {
    case Rule::at_least_one:
      return "Give at least one of " + join_alternatives(flags) + ".";
    case Rule::at_most_one:
      return "Give only one of " + join_alternatives(flags) + ".";
    case Rule::exactly_one:
      return "Give one of " + join_alternatives(flags) + ".";
    case Rule::together:
      return "Give " + join_alternatives(flags, "and") + " together or not at all.";
  }
  return "";
}

}  // namespace turgor::commands
