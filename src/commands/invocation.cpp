#include <fmt/format.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>

#include "text.hpp"
#include "turgor/commands/script.hpp"

namespace turgor {
namespace {

[[noreturn]] void misuse(const CommandDeclaration& command, std::string_view parameter, const char* what) {
  std::fputs(
      fmt::format("turgor: internal error: '{}' of the command '{}' {}\n", parameter, command.name, what)
          .c_str(),
      stderr);
  std::abort();
}

Vec3 vector_at(const Argument& argument, std::size_t first) {
  const auto& n = argument.numbers;
  return {n.at(first), n.at(first + 1), n.at(first + 2)};
}

/// Unit vector, also for components so large or small that their squares leave the range of a double.
Vec3 unit_vector_at(const Argument& argument, std::size_t first) {
  const Vec3 v = vector_at(argument, first);
  const double largest = std::max({std::abs(v.x), std::abs(v.y), std::abs(v.z)});
  return normalized(Vec3{v.x / largest, v.y / largest, v.z / largest});
}

}  // namespace

Vec3 to_point(const Argument& argument) {
  return vector_at(argument, 0);
}
Vec3 to_direction(const Argument& argument) {
  return unit_vector_at(argument, 0);
}
Plane to_plane(const Argument& argument) {
  return Plane::through(vector_at(argument, 0), unit_vector_at(argument, 3));
}
Axis to_axis(const Argument& argument) {
  return {vector_at(argument, 0), unit_vector_at(argument, 3)};
}
Box3 to_box(const Argument& argument) {
  return {vector_at(argument, 0), vector_at(argument, 3)};
}
Sphere to_sphere(const Argument& argument) {
  return {vector_at(argument, 0), argument.numbers.at(3)};
}

std::size_t Invocation::index(std::string_view parameter) const {
  const Parameter* found = command_->find(parameter);
  if (found == nullptr) misuse(*command_, parameter, "is not declared");
  return static_cast<std::size_t>(found - command_->parameters.data());
}

const Argument& Invocation::one(std::string_view parameter) const {
  const auto& values = values_[index(parameter)];
  if (values.empty()) misuse(*command_, parameter, "has no value: test it with given()");
  return values.front();
}

bool Invocation::given(std::string_view parameter) const {
  return given_[index(parameter)];
}
std::span<const Argument> Invocation::all(std::string_view parameter) const {
  return values_[index(parameter)];
}

const std::string& Invocation::word(std::string_view parameter) const {
  const Argument& argument = one(parameter);
  if (argument.words.empty()) misuse(*command_, parameter, "is not a word");
  return argument.words.front();
}

std::filesystem::path Invocation::path(std::string_view parameter) const {
  return word(parameter);
}

std::int64_t Invocation::integer(std::string_view parameter) const {
  const Argument& argument = one(parameter);
  if (argument.integers.empty()) misuse(*command_, parameter, "is not a whole number");
  return argument.integers.front();
}

double Invocation::number(std::string_view parameter) const {
  const Argument& argument = one(parameter);
  if (argument.numbers.empty()) misuse(*command_, parameter, "is not a number");
  return argument.numbers.front();
}

std::vector<std::string> Invocation::words(std::string_view parameter) const {
  std::vector<std::string> out;
  for (const Argument& argument : all(parameter)) {
    out.insert(out.end(), argument.words.begin(), argument.words.end());
  }
  return out;
}

std::vector<double> Invocation::numbers(std::string_view parameter) const {
  std::vector<double> out;
  for (const Argument& argument : all(parameter)) {
    out.insert(out.end(), argument.numbers.begin(), argument.numbers.end());
  }
  return out;
}

std::string Invocation::text() const {
  std::string out(command_->name);
  const auto append = [&](const Argument& argument) {
    for (const std::string& word : argument.words) out += ' ' + quote_word(word);
    for (const std::int64_t value : argument.integers) out += ' ' + std::to_string(value);
    for (const double value : argument.numbers) out += ' ' + commands::format_number(value);
  };
  // Positional values first: a list behind a flag would swallow them.
  for (const bool positional : {true, false}) {
    for (std::size_t i = 0; i < command_->parameters.size(); ++i) {
      const Parameter& parameter = command_->parameters[i];
      if (!given_[i] || parameter.positional != positional) continue;
      if (parameter.type == ValueType::flag) out += fmt::format(" -{}", parameter.name);
      for (const Argument& argument : values_[i]) {
        if (!positional) out += fmt::format(" -{}", parameter.name);
        append(argument);
      }
    }
  }
  return out;
}

Error Invocation::error(std::string what, std::string remedy, std::string_view parameter) const {
  SourcePlace place = place_;
  if (!parameter.empty() && given(parameter) && !all(parameter).empty()) place = all(parameter).front().place;
  return {ErrorKind::bad_command, std::move(what), place.text(), std::move(remedy)};
}

std::string quote_word(std::string_view text) {
  // What neither this language nor a shell reads in another way.
  const auto plain = [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') ||
           std::string_view("_./:+,=@%-").find(c) != std::string_view::npos;
  };
  if (!text.empty() && text.front() != '-' && std::ranges::all_of(text, plain)) return std::string(text);
  if (text.find('\'') == std::string_view::npos) return fmt::format("'{}'", text);
  std::string out = "\"";
  for (const char c : text) {
    if (c == '"' || c == '\\') out += '\\';
    out += c;
  }
  return out + '"';
}

}  // namespace turgor
