// Line plots: curves against axes with ticks, units and a legend.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "turgor/render/image.hpp"

namespace turgor {

struct Curve {
  std::string name;                 ///< for the legend; empty: not listed
  std::vector<double> x, y;         ///< of the same length; points that are not finite break the line
  Vec3f colour{0.1f, 0.25f, 0.6f};  ///< linear RGB
  bool dots = false;                ///< dots at the points in place of a line
};
struct Axis2 {
  std::string title;                ///< with its unit: "Strain", "Tension, N/cm"
  std::optional<double> low, high;  ///< else from the data, rounded outwards to ticks
  bool logarithmic = false;  ///< ticks at 1, 2 and 5 times powers of ten; numbers not above 0 break lines
};
struct Plot {
  std::string title;
  Axis2 x, y;
  std::vector<Curve> curves;
  int width = 900, height = 640;
};
/// The y axis' title stands above the axis; the legend in the corner where the fewest curves run. An axis
/// whose numbers would be long leaves out a power of ten, which its title names. Errors: no curves, lengths
/// that differ, nothing finite to draw, an axis that ends before it begins, a logarithmic one that begins at
/// 0 or below, sides outside 160 to 8192 pixels.
Result<Image> draw_plot(const Plot& plot);

}  // namespace turgor
