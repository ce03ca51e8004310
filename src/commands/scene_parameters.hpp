// Parameters that several commands of a scene share.
#pragma once

#include "short_forms.hpp"

namespace turgor::commands {

inline constexpr Range kColour = between(0, 1);
inline constexpr Range kModulus = between(0, 1e12);
inline constexpr Range kFactor = above_up_to(0, 1e6);

/// The thesis's numbers stand beside the names: its scripts say `-m 4` and mean linear.
inline constexpr std::string_view kSpringLaws[] = {
    "linear", "exponential", "logarithmic", "square", "collagen", "hookean", "0", "1", "2", "3", "4"};
inline constexpr Parameter kSpringLaw{
    .name = "m",
    .alias = "material",
    .type = ValueType::choice,
    .choices = kSpringLaws,
    .label = "LAW",
    .fallback = "linear",
    .help =
        "law of the force over strain: by name, or 0 linear, 1 exponential, 2 logarithmic, 3 square, 4 "
        "linear",
};
inline constexpr Parameter kConstant =
    number("c", "1", kModulus, "material constant: force at strain 1", "constant");
inline constexpr Parameter kViscosity =
    number("v", "0", kModulus, "viscosity: force over the rate of change of length", "viscosity");
inline constexpr Parameter kCutoff =
    number("cutoff", "0", kModulus, "length beyond which the spring lets go; 0: it never does");

inline constexpr Parameter kRegionBox{
    .name = "box",
    .type = ValueType::box,
    .help = "only samples within this box, where they lie now",
};
inline constexpr Parameter kRegionSphere{
    .name = "sphere",
    .type = ValueType::sphere,
    .help = "only samples within this sphere, where they lie now",
};
inline constexpr Parameter kRegionInside = word_flag(
    "inside", "OBJECT", "only samples inside the closed surface of this object, where both are now");
inline constexpr Parameter kRegionLayer =
    whole("layer", "-1", between(-1, 1000), "only samples of this layer, 0 being bone; -1: of all");
inline constexpr Parameter kFlesh = named("flesh", "name of a flesh: that of the object it was built on");

}  // namespace turgor::commands
