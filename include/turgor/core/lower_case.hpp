// Small letters for comparing words of files.
#pragma once

#include <string>
#include <string_view>

namespace turgor {

/// A to Z of ASCII alone; all other bytes stay.
inline std::string lower_case(std::string_view text) {
  std::string lower(text);
  for (char& c : lower) c = c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
  return lower;
}

}  // namespace turgor
