// Round numbers along a scale, and how they are written.
#pragma once

#include <string>

namespace turgor::render_detail {

/// 1, 2 or 5 times a power of ten, so that about `count` steps cover `range` (above 0).
double round_step(double range, int count);
/// Places after the point that tell multiples of `step` apart, at most 9.
int decimals_of(double step);
/// Minus zero and the hyphen are typographer's sins on a scale.
std::string number(double value, int decimals);

}  // namespace turgor::render_detail
