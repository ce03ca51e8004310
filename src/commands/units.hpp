// Units and the suffixes that stand for them.
#pragma once

#include <span>
#include <string_view>

#include "turgor/commands/declaration.hpp"

namespace turgor::commands {

/// A number with this suffix, times `times` over `over`, is in the declared unit. (A quotient, so that 20% is
/// 0.2 to the last bit.)
struct Suffix {
  std::string_view text;
  double times = 1, over = 1;
};
/// The suffixes that a number of this unit may carry, the unit's own first.
std::span<const Suffix> suffixes(Unit unit);

}  // namespace turgor::commands
