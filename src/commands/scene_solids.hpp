// Commands of a scene about solids: made of surfaces, held, pulled, in contact, at rest.
#pragma once

#include "scene_tissue.hpp"

namespace turgor::commands {

inline constexpr std::string_view kSolidFills[] = {"crossings", "winding"};
inline constexpr std::string_view kSkinBindings[] = {"frames", "barycentric"};
inline constexpr Parameter kVoxelize[] = {
    named("object", "polyhedron whose closed surface is filled"),
    whole("resolution", "30", between(1, 1024), "cubes along its longest axis, five tetrahedra each"),
    on_off("no_border", "only cubes whose centre lies inside, not all that the surface touches"),
    {
        .name = "fill",
        .type = ValueType::choice,
        .choices = kSolidFills,
        .fallback = "crossings",
        .help = "how inside is told: crossings, or the winding number, which closes any opening",
    },
    number("young", "0.015", above_up_to(0, 1e9), "Young's modulus: stress, MPa where lengths are mm"),
    number("poisson", "0.45", Range{0, 0.4999}, "Poisson's ratio"),
    number("density", "1.04e-3", above_up_to(0, 1e9), "mass over volume, g/mm^3 where lengths are mm"),
    {
        .name = "skin",
        .type = ValueType::choice,
        .choices = kSkinBindings,
        .fallback = "barycentric",
        .help = "how the shown surface follows: by the tetrahedra that hold its points, or by frames at the "
                "nearest "
                "points of the solid's surface (Morris 2006, section 4.2)",
    },
    whole("neighbours", "5", between(1, 64),
          "nearest points of the solid that carry a point of the skin, by frames"),
};
inline constexpr Example kVoxelizeExamples[] = {
    {"voxelize bunny -resolution 30 -young 0.02", "the object becomes a soft solid"},
    {"voxelize head -skin frames -neighbours 8", "its skin follows frames at eight points each"}};

inline constexpr Parameter kConstants[] = {
    named("solid", "name of a solid"),
    {
        .name = "file",
        .type = ValueType::path,
        .required = true,
        .positional = true,
        .help = "constants.vtu of a calibration",
    },
};
inline constexpr Example kConstantsExamples[] = {
    {"constants bar out/bar/constants.vtu", "what turgor calibrate has found for the bar"}};

inline constexpr Parameter kTie[] = {
    kTissueName,   named("object", "object that the samples move with, such as bone"),
    kRegionBox,    kRegionSphere,
    kRegionInside, kRegionLayer};
inline constexpr Example kTieExamples[] = {
    {"tie head skull -inside skull", "tissue that grows on bone goes with it"},
    {"tie gear plate -box -1000 -1000 300 1000 1000 400", "its upper end is held by a plate"}};

inline constexpr Parameter kGrab[] = {
    named("grab", "name; one of that name is moved or changed"),
    {
        .name = "at",
        .range = between(-1e9, 1e9),
        .count = {3, 3},
        .label = "X Y Z",
        .help = "takes hold of the tissue there",
    },
    number("radius", "0", between(0, 1e9), "holds all samples of that body so near; 0: the nearest one"),
    {
        .name = "to",
        .range = between(-1e9, 1e9),
        .count = {3, 3},
        .label = "X Y Z",
        .help = "pulls to this point; else to where it took hold",
    },
    word_flag("with", "OBJECT", "the target moves with this object"),
    {
        .name = "c",
        .alias = "constant",
        .range = kModulus,
        .help = "force over distance, N/mm where lengths are mm; else 1",
    },
    {
        .name = "limit",
        .range = above_up_to(0, 1e12),
        .help = "greatest force, N; else none",
    },
};
inline constexpr Example kGrabExamples[] = {
    {"grab nose -at 0 -110 40 -radius 6 -to 0 -130 40 -c 2 -limit 5", "pulls the nose, with 5 N at most"},
    {"grab nose -to 0 -120 40", "eases off"}};
inline constexpr Parameter kLetGo[] = {named("grab", "name of a grab")};
inline constexpr Example kLetGoExamples[] = {{"let_go nose", "lets go"}};

inline constexpr Parameter kContact[] = {
    number("thickness", "0", between(0, 1e6),
           "distance at which surfaces meet; 0: a quarter of the smallest cube"),
    number("c", "0", kModulus,
           "force over depth; 0: twice the largest Young's modulus times that cube's edge", "constant"),
    number("friction", "0.3", between(0, 100), "friction over pressure"),
    on_off("no_self", "no body meets itself"),
    on_off("off", "bodies pass through each other again"),
};
inline constexpr Example kContactExamples[] = {{"contact -friction 0.5", "all solids, and each with itself"}};

inline constexpr Parameter kRemesh[] = {
    named("solid", "name of a solid"),
    whole("resolution", "30", between(1, 1024), "cubes along its longest axis as it stands now"),
    whole("frames", "0", between(0, 1000000), "made in the background, and put in after so many frames"),
};
inline constexpr Example kRemeshExamples[] = {
    {"remesh bunny -resolution 45 -frames 10", "finer cubes about the bunny as it is now"}};

inline constexpr Parameter kSettle[] = {
    number("residual", "1e-4", above_up_to(0, 1), "forces that may be left, over the reactions"),
    whole("steps", "200", between(1, 100000), "Newton steps at most"),
};
inline constexpr Example kSettleExamples[] = {{"settle", "straight to rest, without the way there"}};

inline constexpr CommandDeclaration kSceneSolidCommands[] = {
    {
        .name = "voxelize",
        .group = "Solids and holds",
        .summary = "Fill an object with soft tetrahedra",
        .description =
            "The closed surface becomes a solid that keeps lengths, areas and volumes (Morris 2006, sections "
            "2 and "
            "4). The object is hidden; skin.solid.NAME shows its surface as the solid carries it, and "
            "mesh.solid.NAME, hidden at first, that of the tetrahedra.",
        .parameters = kVoxelize,
        .examples = kVoxelizeExamples,
    },
    {
        .name = "constants",
        .group = "Solids and holds",
        .summary = "Give a solid calibrated constants",
        .description =
            "Stiffness of each edge, triangle and tetrahedron, as `turgor calibrate` has written it, in "
            "place "
            "of that of -young and -poisson. The solid has the mesh of the calibrated body: voxelize the "
            "same "
            "surface with the same -resolution, -no_border and -fill, or a cube with as many cubes as the "
            "calibrated box; it may lie elsewhere. `stiffen` scales them; a new mesh by `remesh` takes over "
            "means, and is not calibrated itself.",
        .parameters = kConstants,
        .examples = kConstantsExamples,
    },
    {
        .name = "tie",
        .group = "Solids and holds",
        .summary = "Let tissue move with an object",
        .description = "The samples of the region are held, and go where the object goes.",
        .parameters = kTie,
        .examples = kTieExamples,
    },
    {
        .name = "grab",
        .group = "Solids and holds",
        .summary = "Pull tissue by a spring, with a limit to its force",
        .description = "`list grabs` tells the force; so does result.json.",
        .parameters = kGrab,
        .examples = kGrabExamples,
    },
    {
        .name = "let_go",
        .group = "Solids and holds",
        .summary = "Let go of a grab",
        .parameters = kLetGo,
        .examples = kLetGoExamples,
    },
    {
        .name = "contact",
        .group = "Solids and holds",
        .summary = "Keep solids out of each other and of themselves",
        .description = "Points of the surfaces against faces, with friction.",
        .parameters = kContact,
        .examples = kContactExamples,
    },
    {
        .name = "remesh",
        .group = "Solids and holds",
        .summary = "Give a deformed solid a new mesh",
        .description =
            "Cubes about the surface as it stands; each new point knows where it was at rest, so that forces "
            "go on, and takes its motion from the old mesh.",
        .parameters = kRemesh,
        .examples = kRemeshExamples,
    },
    {
        .name = "settle",
        .group = "Solids and holds",
        .summary = "Go to static equilibrium",
        .description = "Newton's method from the present state; time stands still, velocities become zero.",
        .parameters = kSettle,
        .examples = kSettleExamples,
    },
};

}  // namespace turgor::commands
