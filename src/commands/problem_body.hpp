// Commands of a problem: the body, what holds it, the loads on it.
#pragma once

#include "turgor/commands/declaration.hpp"

namespace turgor::commands {

// ---- regions ----

inline constexpr Parameter kInBox{
    .name = "box",
    .type = ValueType::box,
    .help = "within this box",
};
inline constexpr Parameter kInSphere{
    .name = "sphere",
    .type = ValueType::sphere,
    .help = "within this sphere",
};
inline constexpr Parameter kBeyondPlane{
    .name = "plane",
    .type = ValueType::plane,
    .help = "on this plane, and on the side that its normal points to",
};
inline constexpr Parameter kNearestPoint{
    .name = "nearest",
    .type = ValueType::point,
    .help = "the one point of the region that is nearest",
};
inline constexpr std::string_view kPlaces[] = {"box", "sphere", "plane", "nearest"};
inline constexpr Rule kPlaceRules[] = {{Rule::at_least_one, kPlaces}};
inline constexpr std::string_view kSideRegions[] = {"box", "sphere", "plane"};
inline constexpr Rule kSideRules[] = {{Rule::at_least_one, kSideRegions}};

// ---- the body ----

inline constexpr std::string_view kBodyFills[] = {"crossings", "winding"};
inline constexpr Parameter kBodyResolution{
    .name = "resolution",
    .type = ValueType::integer,
    .range = between(1, 1024),
    .fallback = "25",
    .help = "cubes along the longest axis, five tetrahedra each",
};
inline constexpr Parameter kBodyNoBorder{
    .name = "no_border",
    .type = ValueType::flag,
    .help = "only cubes whose centre lies inside, not all that the surface touches",
};
inline constexpr Parameter kSurfaceParameters[] = {
    {
        .name = "surface",
        .type = ValueType::path,
        .label = "SURFACE",
        .required = true,
        .positional = true,
        .help = "a closed surface: PLY, STL, OBJ, OFF, VTK or glTF",
    },
    {
        .name = "width",
        .unit = Unit::mm,
        .range = above_up_to(0, 1e6),
        .help = "length that the longest side is scaled to; else the file's numbers are mm",
    },
    kBodyResolution,
    kBodyNoBorder,
    {
        .name = "fill",
        .type = ValueType::choice,
        .choices = kBodyFills,
        .fallback = "crossings",
        .help = "how inside is told: crossings, or the winding number, which closes any opening",
    },
};
inline constexpr Example kSurfaceExamples[] = {
    {"body surface bunny.ply -resolution 30 -width 80mm", "2 mm to 3 mm cubes of a bunny of 8 cm"}};

inline constexpr std::string_view kBodyShapes[] = {"gear", "sphere"};
inline constexpr Parameter kShapeParameters[] = {
    {
        .name = "shape",
        .type = ValueType::choice,
        .choices = kBodyShapes,
        .label = "gear|sphere",
        .required = true,
        .positional = true,
        .help = "a toothed wheel about the z axis, or a ball",
    },
    {
        .name = "size",
        .unit = Unit::mm,
        .range = above_up_to(0, 1e6),
        .count = {3, 3},
        .label = "X Y Z",
        .required = true,
        .help = "lengths of its sides; the middle is at the origin",
    },
    kBodyResolution,
    kBodyNoBorder,
};
inline constexpr Example kShapeExamples[] = {
    {"body shape gear -size 60 60 16 -resolution 25", "the gear of Morris 2006, figure 6"}};

inline constexpr Parameter kBoxParameters[] = {
    {
        .name = "box",
        .type = ValueType::box,
        .required = true,
        .positional = true,
        .help = "lower and upper corner",
    },
    {
        .name = "spacing",
        .unit = Unit::mm,
        .range = above_up_to(0, 1e6),
        .required = true,
        .help = "edge of the cubes that fill it, five tetrahedra each",
    },
};
inline constexpr Example kBoxExamples[] = {{"body box 0 0 0 40 40 40 -spacing 5mm", "8 cubes each way"}};

inline constexpr std::string_view kFaceQualities[] = {"draft", "normal", "fine"};
inline constexpr Parameter kFaceParameters[] = {
    {
        .name = "scan",
        .type = ValueType::path,
        .label = "SCAN",
        .required = true,
        .positional = true,
        .help = "as predict takes it",
    },
    {
        .name = "quality",
        .type = ValueType::choice,
        .choices = kFaceQualities,
        .fallback = "normal",
        .help = "size of surfaces, tissue model and cubes, as of predict",
    },
};
inline constexpr Example kFaceExamples[] = {{"body face scans/patient -quality draft", "for a quick look"}};

inline constexpr Parameter kHoldParameters[] = {kInBox, kInSphere, kBeyondPlane, kNearestPoint};
inline constexpr Example kHoldExamples[] = {{"hold -plane 0 0 0 0 0 -1", "all points from the height 0 down"},
                                            {"hold -box 0 0 0 40 40 1", "the lowest layer of points"}};

// ---- loads ----

inline constexpr Parameter kLoadParameters[] = {
    {
        .name = "name",
        .type = ValueType::word,
        .required = true,
        .positional = true,
        .help = "as the report names it",
    },
    {
        .name = "held_out",
        .type = ValueType::flag,
        .help = "only measured, to see how the calibrated constants carry over to it",
    },
    {
        .name = "plan",
        .type = ValueType::path,
        .label = "PLAN",
        .help = "of a face: the move of its bones, a script of plan commands",
    },
};
inline constexpr Example kLoadExamples[] = {
    {"load larger -plan larger.turgor -held_out", "a move of the bones of a face"},
    {"load twist", "the forces that follow, up to the next load, act together"},
    {"load pull -held_out", "not calibrated with"}};

constexpr Parameter vector_of(std::string_view name, Unit unit, std::string_view help) {
  return {
      .name = name,
      .unit = unit,
      .range = between(-1e9, 1e9),
      .count = {3, 3},
      .label = "X Y Z",
      .required = true,
      .positional = true,
      .help = help,
  };
}
inline constexpr Parameter kForceParameters[] = {
    vector_of("force", Unit::newton, "of all its points together"), kInBox, kInSphere, kBeyondPlane,
    kNearestPoint};
inline constexpr Example kForceExamples[] = {
    {"force 0 -0.5N 0 -sphere 30 0 0 6", "half a newton on the points near one tooth"},
    {"force 0 0 20mN -nearest 0 0 8", "on a single point"}};
inline constexpr Parameter kTractionParameters[] = {vector_of("traction", Unit::mpa, "force over area"),
                                                    kInBox, kInSphere, kBeyondPlane};
inline constexpr Example kTractionExamples[] = {
    {"traction 2kPa 0 0 -plane 40 0 0 1 0 0", "shears or pulls the side at x = 40"}};
inline constexpr Parameter kPressureParameters[] = {
    {
        .name = "pressure",
        .unit = Unit::mpa,
        .range = between(-1e9, 1e9),
        .required = true,
        .positional = true,
        .help = "against the surface; below 0: suction",
    },
    kInBox,
    kInSphere,
    kBeyondPlane,
};
inline constexpr Example kPressureExamples[] = {
    {"pressure 5kPa -plane 0 0 40 0 0 1", "pushes on the upper side"}};
inline constexpr Parameter kDisplaceParameters[] = {vector_of("by", Unit::mm, "how far"), kInBox, kInSphere,
                                                    kBeyondPlane, kNearestPoint};
inline constexpr Example kDisplaceExamples[] = {
    {"displace 0 0 -3mm -plane 0 0 40 0 0 1", "presses the upper side down; its force can be measured"}};

inline constexpr Parameter kProbeParameters[] = {
    {
        .name = "loads",
        .type = ValueType::integer,
        .range = between(1, 1000),
        .required = true,
        .positional = true,
        .help = "how many to make up",
    },
    {
        .name = "held_out",
        .type = ValueType::flag,
        .help = "only measured, to see how the calibrated constants carry over to them",
    },
    {
        .name = "candidates",
        .type = ValueType::integer,
        .range = between(1, 10'000),
        .fallback = "48",
        .help = "places on the surface that are tried",
    },
    {
        .name = "depth",
        .unit = Unit::fraction,
        .range = above_up_to(0, 1),
        .fallback = "5%",
        .help = "how far each moves the body, as a part of its longest side",
    },
};
inline constexpr Example kProbeExamples[] = {
    {"probe 3", "three more loads to calibrate with"},
    {"probe 2 -held_out", "two loads that the calibrated body is tried on"}};

inline constexpr CommandDeclaration kProblemBodyCommands[] = {
    {
        .name = "body surface",
        .group = "The body",
        .summary = "Take the body from a closed surface",
        .description = "Filled with cubes as `turgor mesh` does (Morris 2006, section 2).",
        .parameters = kSurfaceParameters,
        .examples = kSurfaceExamples,
    },
    {
        .name = "body shape",
        .group = "The body",
        .summary = "Take a body that needs no file",
        .parameters = kShapeParameters,
        .examples = kShapeExamples,
    },
    {
        .name = "body box",
        .group = "The body",
        .summary = "Take a box of cubes",
        .parameters = kBoxParameters,
        .examples = kBoxExamples,
    },
    {
        .name = "body face",
        .group = "The body",
        .summary = "Take the face of a scan",
        .description = "Loads are plans, whose settings hold for all of them. The reference is what predict "
                       "says with the solver fem, the model is its layered network.",
        .parameters = kFaceParameters,
        .examples = kFaceExamples,
    },
    {
        .name = "hold",
        .group = "The body",
        .summary = "Say which points do not move",
        .description = "Of several flags all have to hold; several commands add up.",
        .parameters = kHoldParameters,
        .rules = kPlaceRules,
        .examples = kHoldExamples,
    },
    {
        .name = "load",
        .group = "Loads",
        .summary = "Begin a load",
        .parameters = kLoadParameters,
        .examples = kLoadExamples,
    },
    {
        .name = "force",
        .group = "Loads",
        .summary = "Pull at points of the surface",
        .description = "Shared evenly by the points of the surface in the region, and dead: it keeps its "
                       "direction.",
        .parameters = kForceParameters,
        .rules = kPlaceRules,
        .examples = kForceExamples,
    },
    {
        .name = "traction",
        .group = "Loads",
        .summary = "Pull at sides of the body",
        .description = "On those sides of cubes whose corners are all in the region, at rest.",
        .parameters = kTractionParameters,
        .rules = kSideRules,
        .examples = kTractionExamples,
    },
    {
        .name = "pressure",
        .group = "Loads",
        .summary = "Press on sides of the body",
        .description =
            "On those sides of cubes whose corners are all in the region, against them as they are "
            "at rest.",
        .parameters = kPressureParameters,
        .rules = kSideRules,
        .examples = kPressureExamples,
    },
    {
        .name = "displace",
        .group = "Loads",
        .summary = "Prescribe how far points move",
        .description = "Its force on the body can be what is measured.",
        .parameters = kDisplaceParameters,
        .rules = kPlaceRules,
        .examples = kDisplaceExamples,
    },
    {
        .name = "probe",
        .group = "Loads",
        .summary = "Have loads made up that probe what the others leave still",
        .description =
            "Forces on small patches of the free surface, into the body. Of candidates spread evenly over "
            "it, "
            "one after another is taken that adds most to the sum, over all points, of the greatest movement "
            "under any load so far, each load's scaled to 1 at its largest, in the reference under Hooke's "
            "law.",
        .parameters = kProbeParameters,
        .examples = kProbeExamples,
    },
};

}  // namespace turgor::commands
