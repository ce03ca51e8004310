// Numbers of points, springs and cells are ints, with -1 for none; containers count in std::size_t.
#pragma once

#include <cstddef>

namespace turgor {

/// A number that is not negative, as an index into a container.
constexpr std::size_t at(int number) {
  return static_cast<std::size_t>(number);
}

}  // namespace turgor
