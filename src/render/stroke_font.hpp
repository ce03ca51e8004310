// Letters as strokes of a round pen.
#pragma once

#include <string_view>
#include <vector>

namespace turgor::render_detail {

/// Coordinates in units of the design: baseline at 0, capitals 10 high, small letters 7, descenders to -3.
struct Stroke {
  float x0, y0, x1, y1;
};
struct Glyph {
  float width = 0;  ///< of the strokes' centre lines
  std::vector<Stroke> strokes;
};

inline constexpr float em_units = 15;          ///< the height of a line of text
inline constexpr float baseline_units = 3.9f;  ///< of the baseline above the bottom of the line
inline constexpr float pen_units = 1.25f;
inline constexpr float gap_units = 2.3f;  ///< between the centre lines of neighbours

/// A box for what the font does not hold.
const Glyph& glyph(char32_t letter);
/// Malformed bytes become U+FFFD.
std::u32string decode_utf8(std::string_view text);

}  // namespace turgor::render_detail
