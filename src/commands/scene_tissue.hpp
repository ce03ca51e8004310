// Commands of a scene that make tissue, the forces on it, and its motion.
#pragma once

#include "scene_objects.hpp"

namespace turgor::commands {

inline constexpr Parameter kFleshOut[] = {
    named("object", "polyhedron that becomes the bone layer"),
    number("dfth", "0.1", above_up_to(0, 1e6), "thickness of the deep fascia, from bone to SMAS"),
    number("sfth", "0.1", above_up_to(0, 1e6), "thickness of the superficial fascia, from SMAS to skin"),
    {
        .name = "thickness",
        .range = above_up_to(0, 1e6),
        .count = {1, any_number},
        .label = "T",
        .help = "thickness of each layer of any number, from bone outwards, in place of -dfth and -sfth",
    },
    {
        .name = "map",
        .type = ValueType::path,
        .count = {1, any_number},
        .label = "FILE",
        .help = "for each layer a file of factors of the thickness, one number for each vertex",
    },
    number("me", "1", above_up_to(0, 1e9), "mass of each point sample"),
    number("sc", "1", kModulus, "material constant of its springs"),
    kSpringLaw,
    kViscosity,
    {
        .name = "volume",
        .range = kModulus,
        .help = "modulus of the volume-preserving prisms between layers; else 2 constants over the mean edge "
                "squared",
    },
    {
        .name = "guard",
        .range = kModulus,
        .help = "pressure against inversion of these prisms; else ten times the modulus",
    },
    on_off("springs_only", "no volume-preserving prisms, as in the thesis"),
    on_off("fix_bone", "the bone layer does not move"),
};
inline constexpr std::string_view kVolumes[] = {"volume", "springs_only"};
inline constexpr std::string_view kGuards[] = {"guard", "springs_only"};
inline constexpr Rule kFleshOutRules[] = {{Rule::at_most_one, kVolumes}, {Rule::at_most_one, kGuards}};
inline constexpr Example kFleshOutExamples[] = {
    {"flesh_out sheet -dfth 0.1 -sfth 0.1 -me 1", "three layers over a sheet"},
    {"flesh_out sheet -thickness 0.05 0.05 0.1 -fix_bone", "four layers on bone"}};

inline constexpr Parameter kBlot[] = {
    named("sample", "name of the new point sample"),
    {
        .name = "at",
        .range = between(-1e9, 1e9),
        .count = {3, 3},
        .label = "X Y Z",
        .required = true,
        .positional = true,
        .help = "its place",
    },
    number("mass", "1", above_up_to(0, 1e9), "its mass"),
    on_off("fixed", "it does not move"),
};
inline constexpr Example kBlotExamples[] = {{"blot tip 0 0 1 -mass 2", "a point sample by hand"}};
inline constexpr Parameter kShock[] = {named("from", "point sample: a name, or FLESH:LAYER:NUMBER"),
                                       named("to", "another one"),
                                       kConstant,
                                       kSpringLaw,
                                       kViscosity,
                                       kCutoff};
inline constexpr Example kShockExamples[] = {
    {"shock tip hook -c 5 -m linear -v 0.1", "a spring between two samples"}};

inline constexpr Parameter kGravity[] = {
    number("g", "0.1", between(-1e6, 1e6), "acceleration"),
    numbers("towards", 3, "X Y Z", "direction to the centre of the earth", "0 0 -1"),
};
inline constexpr Example kGravityFaceExamples[] = {{"gravity_face -g 0.1", "downwards"}};
inline constexpr Example kGravityExamples[] = {
    {"gravity -g 9.81 -towards 0 -1 0", "the same for every sample"}};

inline constexpr Parameter kDrape[] = {
    number("c", "1000", kModulus, "material constant", "constant"),
    word_flag("s", "OBJECT", "the bounding sphere of this object"),
    word_flag("p", "OBJECT", "the plane through this object's origin, its normal to the free side"),
    word_flag("d", "OBJECT", "the surface of this depth map"),
    word_flag("b", "OBJECT", "the closed surface of this object, such as bone"),
    kSpringLaw,
    number("threshold", "0", kModulus, "depth beyond which it lets go; 0: never"),
    number("distance", "0", kModulus, "how far outside a clinging sample still feels it; 0: at any distance"),
    word_flag("flesh", "NAME", "acts on this flesh alone"),
    whole("layer", "-1", between(-1, 1000), "acts on this layer alone, 0 being bone; -1: on all"),
};
inline constexpr std::string_view kShapes[] = {"s", "p", "d", "b"};
inline constexpr Rule kDrapeRules[] = {{Rule::exactly_one, kShapes}};
inline constexpr Example kDrapeExamples[] = {{"drape -c 1000 -s ball", "nothing enters the ball"},
                                             {"drape -p floor", "nothing falls through the floor"}};
inline constexpr Example kClingExamples[] = {
    {"cling -c 50 -b skull -flesh face -layer 0", "tissue stays on the bone"}};
inline constexpr Parameter kDamping[] = {{
    .name = "constant",
    .range = kModulus,
    .required = true,
    .positional = true,
    .help = "force against the velocity of each sample",
}};
inline constexpr Example kDampingExamples[] = {{"damping 0.2", "quells oscillation"}};

inline constexpr Parameter kAddMuscle[] = {
    named("muscle", "name; a new one is made"),
    {
        .name = "samples",
        .type = ValueType::integer,
        .range = between(0, 1e9),
        .count = {2, 4},
        .label = "FROM TO LAYER LAYER",
        .positional = true,
        .help = "numbers of the two samples in their layers, then the layers of both: 0 bone, 1 SMAS, 2 skin",
    },
    numbers("near", 6, "X Y Z X Y Z", "the samples nearest to two points instead"),
    number("c", "1", kModulus, "material constant", "constant"),
    kSpringLaw,
    kViscosity,
    kCutoff,
    word_flag("flesh", "NAME", "of the samples; else the flesh built last"),
};
inline constexpr Example kAddMuscleExamples[] = {
    {"add_muscle brow 13 83 1 1 -c 20 -m linear", "a fibre in the SMAS"},
    {"add_muscle stitch -near 0 0 1 0.2 0 1 -c 5", "a suture"}};
inline constexpr Parameter kTwitch[] = {
    named("muscle", "name of a muscle"),
    {
        .name = "keys",
        .range = between(0, 1e9),
        .count = {2, any_number},
        .label = "TIME SCALE...",
        .required = true,
        .positional = true,
        .help = "pairs of time and scale of the rest length",
    },
    {
        .name = "start",
        .range = between(-1e9, 1e9),
        .help = "what the times count from; else the present time",
    },
};
inline constexpr Example kTwitchExamples[] = {
    {"setup twitch brow 0 1 10 0.3 30 0.3 40 1 -start 2", "contracts, holds, relaxes"}};
inline constexpr Parameter kMuscleSet[] = {
    named("muscle", "name of a muscle"),
    {
        .name = "length",
        .range = above_up_to(0, 1e9),
        .help = "rest length of each of its fibres",
    },
    {
        .name = "scale",
        .range = above_up_to(0, 1e9),
        .help = "rest length over the present one",
    },
};
inline constexpr std::string_view kLengthScale[] = {"length", "scale"};
inline constexpr Rule kMuscleSetRules[] = {{Rule::exactly_one, kLengthScale}};
inline constexpr Example kMuscleSetExamples[] = {
    {"muscle_set brow -scale 0.8", "shorter by a fifth, at once"}};

inline constexpr Parameter kSimulate[] = {
    {
        .name = "count",
        .type = ValueType::integer,
        .range = between(-1, 1e12),
        .label = "STEPS",
        .positional = true,
        .help = "steps to take; -1: until interrupted",
    },
    {
        .name = "dt",
        .range = above_up_to(0, 1e6),
        .required = true,
        .help = "time step; taken in parts where it is more than is stable",
    },
    {
        .name = "until",
        .range = between(-1e12, 1e12),
        .label = "TIME",
        .help = "ends when the simulation's time is there",
    },
    whole("skip", "1", between(1, 1000000), "steps between two drawings"),
    on_off("resume", "begins with steps, not by showing what it begins with; recordings say so"),
    on_off("runge_kutta", "second order (Heun) in place of Euler's first"),
    on_off("verlet", "Verlet's method: second order at the price of the first, for what hardly damps"),
    on_off("implicit", "implicit Euler: any step is stable, motion fades the more the longer it is"),
    {
        .name = "adaptive",
        .range = above_up_to(0, 1e6),
        .label = "TOLERANCE",
        .help = "steps chosen by the error of each, in length, none longer than dt",
    },
};
inline constexpr std::string_view kSchemes[] = {"runge_kutta", "adaptive", "verlet", "implicit"};
inline constexpr std::string_view kEnds[] = {"count", "until"};
inline constexpr Rule kSimulateRules[] = {{Rule::at_most_one, kSchemes}};
inline constexpr Example kSimulateExamples[] = {
    {"simulate -dt 0.05 -skip 2 -runge_kutta -until 50", "to the time 50"},
    {"simulate 100 -dt 0.1 -adaptive 1e-4", "a hundred steps, parted by error"}};

inline constexpr Parameter kFrame[] = {{
    .name = "count",
    .type = ValueType::integer,
    .range = between(1, 1e9),
    .fallback = "1",
    .positional = true,
    .help = "frames to let pass",
}};
inline constexpr Example kFrameExamples[] = {{"frame 50", "moves along paths go on for fifty frames"}};

inline constexpr Parameter kGrow[] = {
    kFlesh,        number("by", "1.1", kFactor, "factor of the rest lengths"),
    kRegionBox,    kRegionSphere,
    kRegionInside, kRegionLayer,
};
inline constexpr Example kGrowExamples[] = {
    {"grow sheet -by 1.2 -sphere 0 0 0 0.3", "swells within the sphere"}};
inline constexpr Parameter kShrink[] = {
    kFlesh,        number("by", "1.1", kFactor, "divisor of the rest lengths"),
    kRegionBox,    kRegionSphere,
    kRegionInside, kRegionLayer,
};
inline constexpr Example kShrinkExamples[] = {
    {"shrink sheet -by 1.1 -layer 2", "skin under tension at rest"}};
inline constexpr Parameter kTissueName =
    named("tissue", "name of a flesh or a solid: that of the object it was made of");
inline constexpr Parameter kStiffen[] = {
    kTissueName,   number("by", "2", Range{0, 1e6}, "factor of the stiffness"),
    kRegionBox,    kRegionSphere,
    kRegionInside, kRegionLayer,
};
inline constexpr Example kStiffenExamples[] = {{"stiffen sheet -by 10 -box 0 0 -1 1 1 1", "a scar"}};
inline constexpr Parameter kRemove[] = {kFlesh, kRegionBox, kRegionSphere, kRegionInside, kRegionLayer};
inline constexpr std::string_view kRegions[] = {"box", "sphere", "inside"};
inline constexpr Rule kRemoveRules[] = {{Rule::at_least_one, kRegions}};
inline constexpr Example kRemoveExamples[] = {
    {"remove sheet -sphere 0 0 0 0.1", "an excision through all layers"}};
inline constexpr Parameter kFix[] = {kTissueName,   kRegionBox,   kRegionSphere,
                                     kRegionInside, kRegionLayer, on_off("free", "let them move again")};
inline constexpr Example kFixExamples[] = {{"fix sheet -layer 0", "tied to bone"}};
inline constexpr Parameter kVolume[] = {
    kFlesh,
    {
        .name = "modulus",
        .range = kModulus,
        .required = true,
        .help = "pressure at twice the volume",
    },
    {
        .name = "guard",
        .range = kModulus,
        .help = "pressure against inversion; else ten times the modulus",
    },
};
inline constexpr Example kVolumeExamples[] = {{"volume sheet -modulus 50", "nearly incompressible"}};
inline constexpr Parameter kSkin[] = {
    kFlesh,
    number("collagen", "0", kModulus, "material constant of taut collagen along Langer's lines"),
    number("transition", "0.35", between(0, 5), "strain from which collagen acts along the lines"),
    number("transition_across", "0.55", between(0, 5), "the same across them"),
    number("anisotropy", "2", above_up_to(0, 1e6), "of the constant along over across the lines"),
    numbers("langer", 3, "X Y Z", "direction of the lines", "1 0 0"),
    {
        .name = "langer_map",
        .type = ValueType::path,
        .help = "directions of the lines instead: three numbers for each vertex",
    },
    number("rest_strain", "0", between(0, 5), "strain of the layer at rest"),
    {
        .name = "relaxation",
        .range = between(0, 1e9),
        .count = {2, 6},
        .label = "SHARE TIME...",
        .help =
            "up to three shares of the tension that fade, each with its time constant; for the whole scene",
    },
};
inline constexpr Example kSkinCommandExamples[] = {
    {"make_skin sheet -collagen 20 -langer 0 1 0 -rest_strain 0.1",
     "under tension, stiff along y when stretched"}};
inline constexpr Parameter kRefine[] = {
    kFlesh,
    number("above", "0.5", Range{0, 1e6}, "strain of a polygon at which it is split"),
    number("below", "0.25", Range{0, 1e6}, "strain under which its parts are joined again"),
    whole("levels", "1", between(0, 4), "how often"),
    on_off("off", "join all again, and stop"),
};
inline constexpr Example kRefineExamples[] = {
    {"refine sheet -above 0.4 -below 0.2", "finer where it deforms, from now on"}};

inline constexpr CommandDeclaration kSceneTissueCommands[] = {
    {
        .name = "flesh_out",
        .group = "Tissue",
        .summary = "Build layered tissue outward from an object",
        .description = "The object's vertices and edges become the bone layer; SMAS and skin lie along its "
                       "vertex normals "
                       "(Pieper 1989, section 5.6). Drawn by the objects skin.face.NAME, smas.face.NAME and "
                       "bone.face.NAME.",
        .parameters = kFleshOut,
        .rules = kFleshOutRules,
        .examples = kFleshOutExamples,
    },
    {
        .name = "blot",
        .group = "Tissue",
        .summary = "Make a point sample",
        .parameters = kBlot,
        .examples = kBlotExamples,
    },
    {
        .name = "shock",
        .group = "Tissue",
        .summary = "Join two point samples by a spring",
        .parameters = kShock,
        .examples = kShockExamples,
    },
    {
        .name = "gravity_face",
        .group = "Forces",
        .summary = "Let gravity act on the tissue",
        .parameters = kGravity,
        .examples = kGravityFaceExamples,
    },
    {
        .name = "gravity",
        .group = "Forces",
        .summary = "Let gravity act on all point samples",
        .parameters = kGravity,
        .examples = kGravityExamples,
    },
    {
        .name = "drape",
        .group = "Forces",
        .summary = "Keep tissue out of an object",
        .description = "A force pushes samples out of the region (Pieper 1989, sections 3.2.1 and 5.2.3). It "
                       "follows the object.",
        .parameters = kDrape,
        .rules = kDrapeRules,
        .examples = kDrapeExamples,
    },
    {
        .name = "cling",
        .group = "Forces",
        .summary = "Hold tissue to an object's surface",
        .description = "As drape, but samples outside are drawn to the surface too (section 5.2.4).",
        .parameters = kDrape,
        .rules = kDrapeRules,
        .examples = kClingExamples,
    },
    {
        .name = "damping",
        .group = "Forces",
        .summary = "Set the force against velocity",
        .parameters = kDamping,
        .examples = kDampingExamples,
    },
    {
        .name = "add_muscle",
        .group = "Muscles",
        .summary = "Add a fibre to a muscle, or a suture",
        .parameters = kAddMuscle,
        .examples = kAddMuscleExamples,
    },
    {
        .name = "setup twitch",
        .group = "Muscles",
        .summary = "Set a muscle's length over time",
        .description = "Between the keys the scale follows half a cosine (section 5.4.1).",
        .parameters = kTwitch,
        .examples = kTwitchExamples,
    },
    {
        .name = "muscle_set",
        .group = "Muscles",
        .summary = "Set a muscle's length at once",
        .description = "Has no effect on a muscle that twitches (section 5.4.2).",
        .parameters = kMuscleSet,
        .rules = kMuscleSetRules,
        .examples = kMuscleSetExamples,
    },
    {
        .name = "simulate",
        .group = "Motion",
        .summary = "Step through time",
        .description = "Without -until it takes as many steps as given.",
        .parameters = kSimulate,
        .rules = kSimulateRules,
        .examples = kSimulateExamples,
    },
    {
        .name = "frame",
        .group = "Motion",
        .summary = "Let frames pass",
        .description = "What follows waits for them; constraints that go by frames go on.",
        .parameters = kFrame,
        .examples = kFrameExamples,
    },
    {
        .name = "grow",
        .group = "Edits",
        .summary = "Lengthen the rest lengths of a region",
        .parameters = kGrow,
        .examples = kGrowExamples,
    },
    {
        .name = "shrink",
        .group = "Edits",
        .summary = "Shorten the rest lengths of a region",
        .parameters = kShrink,
        .examples = kShrinkExamples,
    },
    {
        .name = "stiffen",
        .group = "Edits",
        .summary = "Change the stiffness of a region",
        .parameters = kStiffen,
        .examples = kStiffenExamples,
    },
    {
        .name = "remove",
        .group = "Edits",
        .summary = "Remove the tissue of a region",
        .description = "Columns whose skin, or sample of the layer given, lies within, with all their "
                       "springs, prisms and fibres. Refinement ends: the present resolution stays.",
        .parameters = kRemove,
        .rules = kRemoveRules,
        .examples = kRemoveExamples,
    },
    {
        .name = "fix",
        .group = "Edits",
        .summary = "Hold samples of a region where they are",
        .parameters = kFix,
        .examples = kFixExamples,
    },
    {
        .name = "volume",
        .group = "Edits",
        .summary = "Set the volume-preserving prisms between layers",
        .parameters = kVolume,
        .examples = kVolumeExamples,
    },
    {
        .name = "make_skin",
        .group = "Edits",
        .summary = "Make the outermost layer skin",
        .description =
            "Collagen beside its springs, slack until they are stretched; Langer's lines; tension at rest; "
            "tension that fades (Pieper 1989, section 2.1.2).",
        .parameters = kSkin,
        .examples = kSkinCommandExamples,
    },
    {
        .name = "refine",
        .group = "Edits",
        .summary = "Let the resolution follow the deformation",
        .parameters = kRefine,
        .examples = kRefineExamples,
    },
};

}  // namespace turgor::commands
