#include "world/scene/name.hpp"

#include <fmt/format.h>

#include <algorithm>

namespace turgor {
namespace {

bool is_control(char c) {
  return static_cast<unsigned char>(c) < 0x20 || c == 0x7F;
}

}  // namespace

std::string shown_name(std::string_view name) {
  constexpr std::size_t longest = 60;
  std::string text = "'";
  for (const char c : name.substr(0, longest)) text += is_control(c) ? '?' : c;
  return text + (name.size() > longest ? "…'" : "'");
}

Result<void> check_name(std::string_view name) {
  const auto fail = [&](const char* what) {
    return Error{ErrorKind::bad_input,
                 fmt::format("the name {} {}", shown_name(name), what),
                 {},
                 "Use letters, digits, '_', '.' and '-'"};
  };
  if (name.empty()) return Error{ErrorKind::bad_input, "a name is empty", {}, "Give it a name"};
  if (name.find_first_of(" \t\r\n\v\f") != std::string_view::npos) return fail("holds a blank");
  if (std::any_of(name.begin(), name.end(), is_control)) return fail("holds a control character");
  if (name.find_first_of(";\"'\\") != std::string_view::npos) return fail("holds a quote, ';' or '\\'");
  if (name[0] == '#' || name[0] == '-') return fail("begins with '#' or '-'");
  return {};
}

}  // namespace turgor
