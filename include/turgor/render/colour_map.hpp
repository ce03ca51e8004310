// Numbers as colours.
#pragma once

#include "turgor/math/vec.hpp"

namespace turgor {

/// A perceptually uniform colour map (viridis), t in [0, 1] (clamped; NaN gives grey), linear RGB.
/// Smith and van der Walt 2015, by 20 control points of the published table, linear between them in sRGB.
Vec3f colour_map(double t);
/// For values that are zero over most of a surface, whose form then stays light and readable: near white at
/// 0, dark red at 1 (clamped; NaN gives grey), linear RGB. YlOrRd with 9 classes of Harrower and Brewer 2003
/// (colorbrewer2.org), its first two classes turned from yellow to grey; linear between classes in sRGB.
Vec3f light_colour_map(double t);
/// For signed values: blue at 0, neutral grey at 1/2, red at 1 (clamped; NaN gives grey), linear RGB.
/// Moreland, Diverging Color Maps for Scientific Visualization, ISVC 2009, the "cool to warm" map.
Vec3f diverging_colour_map(double t);

using ColourMap = Vec3f (*)(double);

}  // namespace turgor
