// The commands as a JSON Schema.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "turgor/commands/help.hpp"
#include "turgor/commands/script.hpp"
#include "values.hpp"

namespace turgor {
namespace {

using Json = nlohmann::ordered_json;

Json number_bound(double value, ValueType type) {
  if (type == ValueType::integer) return static_cast<std::int64_t>(value);
  return value;
}

/// One word-sized value: a string, an integer or a number.
Json scalar(const Parameter& parameter) {
  Json schema;
  const Range& range = parameter.range;
  if (!commands::is_numeric(parameter.type)) {
    schema["type"] = "string";
    if (parameter.type == ValueType::choice) {
      schema["enum"] = Json::array();
      for (const auto choice : parameter.choices) schema["enum"].push_back(std::string(choice));
    }
    return schema;
  }
  schema["type"] = parameter.type == ValueType::integer ? "integer" : "number";
  if (std::isfinite(range.low)) {
    schema[range.low_open ? "exclusiveMinimum" : "minimum"] = number_bound(range.low, parameter.type);
  }
  if (std::isfinite(range.high)) {
    schema[range.high_open ? "exclusiveMaximum" : "maximum"] = number_bound(range.high, parameter.type);
  }
  return schema;
}

Json list_of(Json items, int low, int high) {
  Json schema{{"type", "array"}, {"items", std::move(items)}, {"minItems", low}};
  if (high != any_number) schema["maxItems"] = high;
  return schema;
}

/// All words of one value: a scalar, or an array where it takes several.
Json value_schema(const Parameter& parameter) {
  if (parameter.type == ValueType::flag) return {{"type", "boolean"}};
  const Count count = commands::word_count(parameter);
  return count.high == 1 ? scalar(parameter) : list_of(scalar(parameter), count.low, count.high);
}

Json default_value(const CommandDeclaration& command, const Parameter& parameter) {
  if (parameter.type == ValueType::flag) return false;
  const auto lines = lex(parameter.fallback, "default");
  const auto converted = commands::convert(command, parameter, lines->front().words);
  Json values = Json::array();
  for (const auto& word : converted->words) values.push_back(word);
  for (const auto number : converted->integers) values.push_back(number);
  for (const auto number : converted->numbers) values.push_back(number);
  const bool single = !parameter.repeatable && commands::word_count(parameter).high == 1;
  return single ? values.front() : values;
}

std::string_view type_name(ValueType type) {
  constexpr std::string_view names[] = {"flag",    "word",    "text",   "path",  "folder", "choice",
                                        "command", "integer", "number", "point", "offset", "direction",
                                        "plane",   "axis",    "box",    "sphere"};
  static_assert(std::size(names) == static_cast<std::size_t>(ValueType::sphere) + 1);
  return names[static_cast<std::size_t>(type)];
}

Json parameter_schema(const CommandDeclaration& command, const Parameter& parameter) {
  Json schema = value_schema(parameter);
  if (parameter.repeatable) schema = list_of(std::move(schema), 1, any_number);
  schema["description"] = std::string(parameter.help);
  if (!parameter.fallback.empty() || parameter.type == ValueType::flag) {
    schema["default"] = default_value(command, parameter);
  }
  schema["x-type"] = std::string(type_name(parameter.type));
  if (parameter.unit != Unit::none) schema["x-unit"] = std::string(symbol(parameter.unit));
  if (!parameter.alias.empty()) schema["x-alias"] = std::string(parameter.alias);
  if (parameter.positional) schema["x-positional"] = true;
  if (parameter.repeatable) schema["x-repeatable"] = true;
  return schema;
}

Json rule_schema(const Rule& rule) {
  Json each = Json::array();
  for (const auto name : rule.names) each.push_back({{"required", {std::string(name)}}});
  Json pairs = Json::array();
  switch (rule.kind) {
    case Rule::at_least_one:
      return {{"anyOf", each}};
    case Rule::exactly_one:
      return {{"oneOf", each}};
    case Rule::at_most_one:
      for (std::size_t i = 0; i < rule.names.size(); ++i) {
        for (std::size_t j = i + 1; j < rule.names.size(); ++j) {
          pairs.push_back({{"required", {std::string(rule.names[i]), std::string(rule.names[j])}}});
        }
      }
      return {{"not", {{"anyOf", pairs}}}};
    case Rule::together: {
      Json all = Json::array();
      for (const auto name : rule.names) all.push_back(std::string(name));
      return {{"anyOf", {{{"required", all}}, {{"not", {{"anyOf", each}}}}}}};
    }
  }
  return {};
}

Json command_schema(const CommandTable& table, const CommandDeclaration& command) {
  Json properties{{"command", {{"const", std::string(command.name)}}}};
  Json required = Json::array({"command"});
  for (const Parameter& parameter : command.parameters) {
    properties[std::string(parameter.name)] = parameter_schema(command, parameter);
    if (parameter.required) required.push_back(std::string(parameter.name));
  }
  std::string description = fmt::format("{}.", command.summary);
  if (!command.description.empty()) description += fmt::format(" {}", command.description);
  Json schema{{"title", std::string(command.name)}, {"description", description}};
  schema["type"] = "object";
  schema["properties"] = std::move(properties);
  schema["required"] = std::move(required);
  schema["additionalProperties"] = false;
  for (const Rule& rule : command.rules) schema["allOf"].push_back(rule_schema(rule));
  schema["x-table"] = std::string(table.name);
  schema["x-group"] = std::string(command.group);
  schema["x-usage"] = fmt::format("{}{}", table.prefix, usage_line(command));
  for (const Example& example : command.examples) {
    schema["x-examples"].push_back(fmt::format("{}{}", table.prefix, example.line));
  }
  return schema;
}

}  // namespace

std::string commands_schema() {
  Json schema{{"$schema", "https://json-schema.org/draft/2020-12/schema"}, {"title", "Commands of Turgor"}};
  schema["oneOf"] = Json::array();
  Json& definitions = schema["$defs"] = Json::object();
  for (const CommandTable* table : command_tables()) {
    for (const auto& command : table->commands) {
      std::string key = fmt::format("{}.{}", table->name, command.name);
      std::ranges::replace(key, ' ', '_');
      definitions[key] = command_schema(*table, command);
    }
  }
  for (const auto& [key, definition] : definitions.items())
    schema["oneOf"].push_back({{"$ref", "#/$defs/" + key}});
  return schema.dump(2) + '\n';
}

}  // namespace turgor
