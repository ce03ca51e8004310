// Plan commands that cut and move bone, and the operations made of them.
#pragma once

#include "turgor/commands/declaration.hpp"

namespace turgor::commands {

constexpr Parameter millimetres(std::string_view name, double low, double high, std::string_view help,
                                std::string_view fallback = "0") {
  return {
      .name = name,
      .unit = Unit::mm,
      .range = between(low, high),
      .fallback = fallback,
      .help = help,
  };
}
constexpr Parameter degrees_of(std::string_view name, std::string_view help) {
  return {
      .name = name,
      .unit = Unit::deg,
      .range = between(-45, 45),
      .fallback = "0",
      .help = help,
  };
}
inline constexpr std::string_view kPitchHelp =
    "turn about the axis to the patient's left; above 0 the front goes down";
inline constexpr std::string_view kRollHelp = "turn about the forward axis; above 0 the left side goes up";
inline constexpr std::string_view kYawHelp =
    "turn about the axis upwards; above 0 the front goes to the left";

inline constexpr Parameter kNewSegment{
    .name = "segment",
    .type = ValueType::word,
    .required = true,
    .positional = true,
    .help = "name of the new segment",
};
inline constexpr Parameter kSegment{
    .name = "segment",
    .type = ValueType::word,
    .required = true,
    .positional = true,
    .help = "a segment of an osteotomy or of a named operation, or mandible",
};
inline constexpr std::string_view kCutFlags[] = {"plane", "box"};
inline constexpr Rule kOsteotomyRules[] = {{Rule::at_least_one, kCutFlags}};
inline constexpr Parameter kOsteotomyParameters[] = {
    kNewSegment,
    {
        .name = "of",
        .type = ValueType::word,
        .label = "skull|mandible|SEGMENT",
        .required = true,
        .help = "the bone that is cut",
    },
    {
        .name = "plane",
        .type = ValueType::plane,
        .repeatable = true,
        .help = "the segment is what lies on the side the normal points to, of every plane given",
    },
    {
        .name = "box",
        .type = ValueType::box,
        .help = "and within this box",
    },
};
inline constexpr Example kOsteotomyExamples[] = {
    {"osteotomy chin -of mandible -plane 0 -80 -55 0 -0.3 -1", "the chin below a slanting plane"},
    {"osteotomy midface -of skull -plane 0 0 -20 0 0 -1 -box -60 -120 -60 60 -20 0",
     "a part of the midface"}};

inline constexpr Parameter kMoveParameters[] = {
    kSegment,
    {
        .name = "by",
        .type = ValueType::offset,
        .required = true,
        .help = "displacement to the left, to the back, upwards",
    },
};
inline constexpr Example kMoveExamples[] = {{"move chin -by 0 -5 0", "5 mm forwards"}};

inline constexpr std::string_view kTurns[] = {"angle", "pitch", "roll", "yaw"};
inline constexpr std::string_view kAngleAxis[] = {"angle", "axis"};
inline constexpr std::string_view kAboutAxis[] = {"about", "axis"};
inline constexpr Rule kRotateRules[] = {
    {Rule::at_least_one, kTurns}, {Rule::together, kAngleAxis}, {Rule::at_most_one, kAboutAxis}};
inline constexpr Parameter kRotateParameters[] = {
    kSegment,
    {
        .name = "angle",
        .unit = Unit::deg,
        .range = between(-180, 180),
        .help = "right-handed turn about -axis",
    },
    {
        .name = "axis",
        .type = ValueType::axis,
        .help = "a point of the axis, and its direction",
    },
    degrees_of("pitch", kPitchHelp),
    degrees_of("roll", kRollHelp),
    degrees_of("yaw", kYawHelp),
    {
        .name = "about",
        .type = ValueType::point,
        .help = "the point that stays, for pitch, roll and yaw; the segment's centre where not given",
    },
};
inline constexpr Example kRotateExamples[] = {
    {"rotate chin -pitch -8", "the chin's front up by 8 degrees"},
    {"rotate mandible -angle 4 -axis 0 10 -20 0 0 1", "about an axis upwards"}};

inline constexpr std::string_view kRegionFlags[] = {"box", "sphere"};
inline constexpr Rule kRegionRules[] = {{Rule::at_most_one, kRegionFlags}};
inline constexpr Parameter kRegionParameters[] = {
    {
        .name = "bone",
        .type = ValueType::word,
        .label = "skull|mandible|SEGMENT",
        .required = true,
        .positional = true,
        .help = "the bone or segment",
    },
    {
        .name = "box",
        .type = ValueType::box,
        .help = "only within this box",
    },
    {
        .name = "sphere",
        .type = ValueType::sphere,
        .help = "only within this sphere",
    },
};
inline constexpr Example kReleaseExamples[] = {
    {"release mandible -sphere 0 -85 -60 25", "undermine the chin"}, {"release chin", "all of a segment"}};
inline constexpr Example kAttachExamples[] = {
    {"attach mandible -box -20 -100 -70 20 -60 -50", "hold the tissue of the chin"}};

inline constexpr Parameter kOpenMouthParameters[] = {
    {
        .name = "angle",
        .unit = Unit::deg,
        .range = between(0, 40),
        .required = true,
        .help = "turn of the mandible about the axis through both condyles",
    },
};
inline constexpr Example kOpenMouthExamples[] = {{"open_mouth -angle 20", "wide open"}};

inline constexpr Parameter kSetbackParameters[] = {
    {
        .name = "amount",
        .unit = Unit::mm,
        .range = between(0, 20),
        .required = true,
        .help = "way of the tooth-bearing segment",
    },
};
inline constexpr Parameter kAdvanceParameters[] = {
    {
        .name = "amount",
        .unit = Unit::mm,
        .range = between(0, 25),
        .required = true,
        .help = "way of the tooth-bearing segment",
    },
};
inline constexpr Example kSetbackExamples[] = {{"setback -amount 6", "6 mm to the back"}};
inline constexpr Example kAdvanceExamples[] = {{"advance -amount 0.5cm", "5 mm forwards"}};

inline constexpr std::string_view kGenioplastyFlags[] = {"forward", "up", "left"};
inline constexpr Rule kGenioplastyRules[] = {{Rule::at_least_one, kGenioplastyFlags}};
inline constexpr Parameter kGenioplastyParameters[] = {
    millimetres("forward", -15, 20, "advancement; below 0 setback"),
    millimetres("up", -15, 15, "below 0 down"), millimetres("left", -15, 15, "below 0 to the right")};
inline constexpr Example kGenioplastyExamples[] = {
    {"genioplasty -forward 6 -up 2", "a chin that is too low and too far back"}};

inline constexpr std::string_view kLeFortFlags[] = {"forward", "up", "left", "pitch", "roll", "yaw"};
inline constexpr Rule kLeFortRules[] = {{Rule::at_least_one, kLeFortFlags}};
inline constexpr Parameter kLeFortParameters[] = {
    millimetres("forward", -15, 30, "advancement; below 0 setback"),
    millimetres("up", -20, 20, "impaction; below 0 down"),
    millimetres("left", -15, 15, "below 0 to the right"),
    degrees_of("pitch", kPitchHelp),
    degrees_of("roll", kRollHelp),
    degrees_of("yaw", kYawHelp)};
inline constexpr Example kLeFort1Examples[] = {{"le_fort_1 -forward 5 -up 2", "advancement with impaction"}};
inline constexpr Example kLeFort2Examples[] = {{"le_fort_2 -forward 8", "nose and maxilla forwards"}};
inline constexpr Example kLeFort3Examples[] = {{"le_fort_3 -forward 10", "the whole midface forwards"}};

inline constexpr std::string_view kSides[] = {"left", "right"};
inline constexpr std::string_view kZygomaFlags[] = {"forward", "out", "up"};
inline constexpr Rule kZygomaRules[] = {{Rule::at_least_one, kZygomaFlags}};
inline constexpr Parameter kZygomaParameters[] = {
    {
        .name = "side",
        .type = ValueType::choice,
        .choices = kSides,
        .required = true,
        .help = "of the patient",
    },
    millimetres("forward", -15, 15, "below 0 back"),
    millimetres("out", -15, 15, "away from the midline; below 0 towards it"),
    millimetres("up", -15, 15, "below 0 down")};
inline constexpr Example kZygomaExamples[] = {{"zygoma -side left -forward 3 -out 2", "a flat cheekbone"}};

inline constexpr CommandDeclaration kBoneCommands[] = {
    {
        .name = "osteotomy",
        .group = "Bone segments",
        .summary = "Cut a bone and name the segment",
        .description = "The segment may be moved, and cut again. What is left of the bone keeps its name.",
        .parameters = kOsteotomyParameters,
        .rules = kOsteotomyRules,
        .examples = kOsteotomyExamples,
    },
    {
        .name = "move",
        .group = "Bone segments",
        .summary = "Move a segment",
        .parameters = kMoveParameters,
        .examples = kMoveExamples,
    },
    {
        .name = "rotate",
        .group = "Bone segments",
        .summary = "Turn a segment about a point or an axis",
        .description =
            "Either by -roll, -pitch and -yaw, in this order, about a point, or by -angle about -axis. "
            "Turns are right-handed.",
        .parameters = kRotateParameters,
        .rules = kRotateRules,
        .examples = kRotateExamples,
    },
    {
        .name = "release",
        .group = "Bone segments",
        .summary = "Free soft tissue from bone",
        .description = "Tissue that is released no longer follows the bone under it; it finds its place.",
        .parameters = kRegionParameters,
        .rules = kRegionRules,
        .examples = kReleaseExamples,
    },
    {
        .name = "attach",
        .group = "Bone segments",
        .summary = "Fasten soft tissue to bone",
        .description =
            "Tissue that is attached follows the bone under it. All tissue is, until it is released.",
        .parameters = kRegionParameters,
        .rules = kRegionRules,
        .examples = kAttachExamples,
    },
    {
        .name = "open_mouth",
        .group = "Named operations",
        .summary = "Turn the mandible about its condyles",
        .description = "The whole mandible turns, cut or not.",
        .parameters = kOpenMouthParameters,
        .examples = kOpenMouthExamples,
    },
    {
        .name = "setback",
        .group = "Named operations",
        .summary = "Set the mandible back (sagittal split)",
        .description = "Cuts both rami from the landmarks, keeps the condyles in place and moves the "
                       "tooth-bearing part, which "
                       "becomes the segment distal.",
        .parameters = kSetbackParameters,
        .examples = kSetbackExamples,
    },
    {
        .name = "advance",
        .group = "Named operations",
        .summary = "Advance the mandible (sagittal split)",
        .description = "Cuts both rami from the landmarks, keeps the condyles in place and moves the "
                       "tooth-bearing part, which "
                       "becomes the segment distal.",
        .parameters = kAdvanceParameters,
        .examples = kAdvanceExamples,
    },
    {
        .name = "genioplasty",
        .group = "Named operations",
        .summary = "Cut and move the chin",
        .description = "The lower border of the chin becomes the segment chin.",
        .parameters = kGenioplastyParameters,
        .rules = kGenioplastyRules,
        .examples = kGenioplastyExamples,
    },
    {
        .name = "le_fort_1",
        .group = "Named operations",
        .summary = "Cut the maxilla above the teeth and move it",
        .description = "The cut runs above the roots of the teeth at the level of the nasal floor. What "
                       "moves becomes the segment maxilla.",
        .parameters = kLeFortParameters,
        .rules = kLeFortRules,
        .examples = kLeFort1Examples,
    },
    {
        .name = "le_fort_2",
        .group = "Named operations",
        .summary = "Cut the maxilla with the nose and move it",
        .description =
            "The pyramid of nose and maxilla below the nasofrontal suture becomes the segment midface_2.",
        .parameters = kLeFortParameters,
        .rules = kLeFortRules,
        .examples = kLeFort2Examples,
    },
    {
        .name = "le_fort_3",
        .group = "Named operations",
        .summary = "Cut the midface with the cheekbones and move it",
        .description =
            "The face below the nasofrontal and zygomaticofrontal sutures becomes the segment midface_3.",
        .parameters = kLeFortParameters,
        .rules = kLeFortRules,
        .examples = kLeFort3Examples,
    },
    {
        .name = "zygoma",
        .group = "Named operations",
        .summary = "Cut a cheekbone and move it",
        .description = "What moves becomes the segment zygoma_left or zygoma_right.",
        .parameters = kZygomaParameters,
        .rules = kZygomaRules,
        .examples = kZygomaExamples,
    },
};

}  // namespace turgor::commands
